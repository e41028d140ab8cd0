"""The reference of a study, and its stability limit."""

import json
import os
import sys

sys.path.insert(0, f"{sys.path[0]}/..")
from support.program import BEAM, main
from support.scenes import plane, tables
from support.study import PROBES, StudyTest


class Reference(StudyTest):
    def test_says_how_many_steps_the_reference_takes(self):
        result = self.study("--integrators", "midpoint", "--steps", "2e-2", "--reference-step", "1e-3",
                            "--set", "time.end=0.1")  # fmt: skip
        self.assertIn("note: reference: midpoint with steps of 0.001 s, which makes 100 steps",
                      result.stderr)  # fmt: skip


class StabilityLimit(StudyTest):
    def test_of_a_body_that_cannot_move(self):
        held = self.write("held.toml", BEAM.replace('plane = { axis = "x", at = 0.0 }',
                                                    "all = true"))  # fmt: skip
        for rule in ("midpoint", "verlet"):
            told = self.run_program("study", held, "--steps", "0.05", "--integrators", rule,
                                    "--no-plots", "--all", "--out", rule)  # fmt: skip
            self.assertIn("Stability limit: none.", told.stdout)
            page = self.read(rule, "study.html")
            for text in (told.stdout, page):
                self.assertNotRegex(text, r"h_crit = *([.,;<]|nan|inf)")


class ExtrapolatedReference(StudyTest):
    """The row with h = 2e-5 s is far finer than the three runs of the reference, so that its difference from
    the extrapolation is the error of the extrapolation, up to its own error of 7e-9."""

    GRID = ("--integrators", "midpoint,verlet", "--steps", "2e-5,2e-3,4e-3", "--reference",
            "richardson", "--reference-step", "2e-3")  # fmt: skip

    def runs_of(self, result):
        return {(r["integrator"], r["step"]): r for r in result["runs"]}

    def test_the_estimated_error_is_about_the_real_one(self):
        said = self.study(*self.GRID, "--all")
        self.assertIn("midpoint with steps of 0.004, 0.002, 0.001 s, which makes 175 steps together",
                      said.stderr)  # fmt: skip
        self.assertRegex(said.stdout, r"Reference: Richardson extrapolation of midpoint with h = "
                                      r"2e-3 s and 1e-3 s \(ok\), whose own error")  # fmt: skip
        result = self.result()
        found, rows = result["reference"]["extrapolation"], self.runs_of(result)
        self.assertTrue(found["valid"])
        self.assertEqual(found["step"], 2e-3)
        self.assertEqual(result["reference"]["estimated_error"], found["estimated_error_at_end"])
        fine = rows["midpoint", 2e-5]
        for error, estimate in ((fine["position_error"], found["estimated_error_at_end"]),
                                (fine["position_error_rms"], found["estimated_error_over_time"])):  # fmt: skip
            self.assertGreater(error, 0.2 * estimate)
            self.assertLess(error, 1.5 * estimate)
            self.assertLess(error, 0.05 * found["finest_error_at_end"])
        for order in ("order_at_end", "order_over_time"):
            self.assertAlmostEqual(found[order], 2.0, delta=0.05)
        # No run is the reference. Those that it is extrapolated from have errors as well, which
        # are those of their positions.
        self.assertEqual([(r["integrator"], r["step"]) for r in result["runs"] if r["role"] != "run"],
                         [("midpoint", 1e-3)])  # fmt: skip
        self.assertGreater(rows["midpoint", 1e-3]["position_error"], 0.0)
        self.assertAlmostEqual(rows["midpoint", 2e-3]["position_error"]
                               / (4 * found["finest_error_at_end"]), 1.0, delta=0.02)  # fmt: skip
        self.assertAlmostEqual(rows["midpoint", 4e-3]["observed_order"], 2.0, delta=0.1)
        for row in self.table("s", "study.csv"):
            self.assertIn("Richardson extrapolation of midpoint", row["reference"])
            self.assertAlmostEqual(float(row["reference_error"])
                                   / found["estimated_error_at_end"], 1.0, places=6)  # fmt: skip
        page = self.read("s", "study.html")
        self.assertIn("differences from the reference, the Richardson extrapolation of", page)
        self.assertIn("The three runs show the order", page)
        self.assertEqual(set(self.runs()), {r["directory"] for r in result["runs"]})

    def test_a_kept_study_has_the_same_reference(self):
        self.study(*self.GRID)
        before = self.result()
        said = self.study(*self.GRID)
        self.assertIn("the study was complete, and no run was made", said.stderr)
        after = self.result()
        for key in ("reference", "runs", "conclusions"):
            self.assertEqual(before[key], after[key])
        os.remove(self.path("s", "verlet-0.002", "final.vtu"))
        self.assertIn("6 of 7 runs were kept", self.study(*self.GRID).stderr)
        self.assertEqual(before["reference"], self.result()["reference"])

    def test_orders_that_do_not_fit_leave_the_finest_run(self):
        # The step 8e-3 s is above the stability limit of 7e-3 s, and the time too short to diverge.
        said = self.study("--integrators", "verlet", "--steps", "1e-3,4e-3", "--reference-integrator",
                          "verlet", "--reference", "richardson", "--reference-step", "4e-3", "--all")  # fmt: skip
        self.assertIn("note: the reference is not extrapolated: the observed order over time is",
                      said.stderr)  # fmt: skip
        self.assertIn("while the theoretical order is 2. It is the run with a step of 0.002 s",
                      said.stderr)  # fmt: skip
        result = self.result()
        found = result["reference"]["extrapolation"]
        self.assertFalse(found["valid"])
        self.assertIsNone(found["finest_error_at_end"])
        self.assertEqual(result["reference"]["directory"], "verlet-0.002")
        # Its estimate is that of a single run: the difference between h and h/2, divided by 2^2 - 1.
        coarse = self.runs_of(result)["verlet", 4e-3]["position_error"]
        self.assertAlmostEqual(result["reference"]["estimated_error"] / (coarse / 3), 1.0, places=6)
        self.assertIn("not extrapolated", " ".join(result["remarks"]))
        self.assertIn("uncertain", json.dumps(result["conclusions"]))
        self.assertIn("Reference: verlet with h = 2e-3 s (ok)", said.stdout)

    def test_a_run_that_is_unstable_leaves_the_finest_run(self):
        said = self.study("--integrators verlet --steps 5e-3,1e-2 --reference-integrator verlet "
                          "--reference richardson --reference-step 5e-3 --set time.end=1")  # fmt: skip
        self.assertIn("not extrapolated: the run with a step of 0.01 s did not reach the end",
                      said.stderr)  # fmt: skip
        rows = self.runs_of(self.result())
        self.assertEqual(rows["verlet", 1e-2]["status"], "unstable")
        self.assertGreater(rows["verlet", 5e-3]["position_error"], 0.0)

    def test_of_a_probe(self):
        scene = self.write("probes.toml", PROBES + tables(probe=[dict(name="speed",
                                                            select=plane("x", 4.0),
                                                            quantity="velocity")]))  # fmt: skip
        study = ["study", scene, "--out", "s", "--no-plots", "--integrators", "midpoint", "--steps",
                 "1e-3,2e-3,4e-3", "--reference", "richardson", "--reference-step", "2e-3"]  # fmt: skip
        self.run_program(*study, "--error", "probe.tip")
        found, rows = self.result()["reference"], self.runs_of(self.result())
        self.assertTrue(found["extrapolation"]["valid"])
        self.assertAlmostEqual(found["extrapolation"]["order_of_probe"], 2.0, delta=0.1)
        self.assertLess(found["estimated_error"], 0.05 * rows["midpoint", 1e-3]["probe_error"])
        self.assertAlmostEqual(rows["midpoint", 2e-3]["observed_order"], 2.0, delta=0.05)
        # With a step that is no multiple of 1e-3 s the probe is interpolated, which is far less accurate.
        self.run_program(*study, "--error", "probe.tip", "--also-solver", "ceres@0.0016")
        self.assertGreater(self.result()["reference"]["estimated_error"],
                           20 * found["estimated_error"])  # fmt: skip
        # A velocity belongs to the middle of its step, so that its error is of order 1.
        said = self.run_program(*study, "--error", "probe.speed")
        self.assertIn("the reference of the probe speed is not extrapolated: the observed order of the "
                      "probe is", said.stderr)  # fmt: skip
        # That of the positions is, all the same.
        extrapolation = self.result()["reference"]["extrapolation"]
        self.assertTrue(extrapolation["valid"])
        self.assertFalse(extrapolation["probe_valid"])
        self.assertFalse(extrapolation["probe_exact"])
        self.assertLess(extrapolation["estimated_error_at_end"],
                        0.05 * extrapolation["finest_error_at_end"])  # fmt: skip

    def test_differences_of_round_off_show_no_order(self):
        """A body that falls freely: all these rules are exact but for rounding."""
        scene = self.write("fall.toml", BEAM[: BEAM.index("[[fix]]")])
        for rule in ("midpoint", "verlet"):
            said = self.run_program(
                "study", scene, "--out", "s", "--no-plots", "--integrators", rule, "--steps",
                "1e-3,2e-3", "--reference", "richardson", "--reference-integrator", rule,
                "--reference-step", "1e-3", "--set", "time.end=0.02")  # fmt: skip
            self.assertIn("which the tolerance of the solver and round-off explain", said.stderr)
            self.assertNotIn("theoretical order", said.stderr)
            reference = self.result()["reference"]
            self.assertFalse(reference["extrapolation"]["valid"])
            self.assertTrue(reference["extrapolation"]["exact"])
            self.assertLess(reference["estimated_error"], 1e-8)
            self.assertNotIn("uncertain", json.dumps(self.result()["conclusions"]))

    def test_a_probe_of_round_off_leaves_the_positions(self):
        """The linear momentum along x of a free body is conserved to round-off."""
        scene = self.write("free.toml", BEAM[: BEAM.index("[environment]")] + """
[initial]
velocity = { formula = ["1.0", "0.2*X*X", "0.0"] }
[[probe]]
name = "push"
select = { all = true }
quantity = "momentum"
""")  # fmt: skip
        said = self.run_program(f"study {scene} --out s --no-plots --integrators midpoint --steps "
                                "5e-4,1e-3,2e-3 --reference richardson --reference-step 1e-3 "
                                "--set time.end=0.02 --error probe.push")  # fmt: skip
        self.assertIn("the reference of the probe push is not extrapolated: the runs differ by",
                      said.stderr)  # fmt: skip
        found = self.result()["reference"]["extrapolation"]
        self.assertTrue(found["valid"])
        self.assertTrue(found["probe_exact"])
        self.assertLess(found["estimated_error_of_probe"], 1e-8)
        self.assertAlmostEqual(found["order_at_end"], 2.0, delta=0.4)

    def test_steps_that_are_too_long(self):
        self.refused_study("--steps", "0.08", "--reference", "richardson", says="Twice the reference step must be positive and at most the end time")
        self.assertIn("there are run, richardson", self.refused_study("--reference fine"))


if __name__ == "__main__":
    main()
