"""The command `tetraction study` as a whole."""

import os
import re
import sys

sys.path.insert(0, f"{sys.path[0]}/..")
from support.program import DATA, BEAM, BeamTest, main, own_lines, read_grid


class Study(BeamTest):
    def test_table_files_and_plots(self):
        result = self.run_program("study beam.toml --steps 0.0025,0.005,0.05 --out s "
                                  "--reference-step 0.00125")  # fmt: skip
        self.assertIn("unstable", result.stdout)
        rows = self.table("s", "study.csv")
        self.assertEqual(
            list(rows[0])[:10],
            ["integrator", "step", "status", "steps", "wall_seconds", "processor_seconds",
             "seconds_per_simulated_second", "iterations_per_step", "max_relative_energy_drift",
             "linear_momentum_drift"],
        )  # fmt: skip
        self.assertEqual([r["role"] for r in rows].count("run"), 15)
        self.assertEqual([(r["integrator"], float(r["step"])) for r in rows if r["role"] == "reference"],
                         [("midpoint", 0.00125)])  # fmt: skip
        by = {(r["integrator"], float(r["step"])): r for r in rows}
        self.assertEqual(by["explicit", 0.05]["status"], "unstable")
        self.assertEqual(by["verlet", 0.05]["status"], "unstable")
        self.assertEqual(by["backward-euler", 0.05]["status"], "ok")
        self.assertAlmostEqual(float(by["explicit", 0.005]["observed_order"]), 1, delta=0.1)
        self.assertAlmostEqual(float(by["midpoint", 0.005]["observed_order"]), 2, delta=0.15)
        self.assertAlmostEqual(float(by["backward-euler", 0.005]["observed_order"]), 1, delta=0.1)
        self.assertAlmostEqual(float(by["energy-momentum", 0.05]["observed_order"]), 2, delta=0.15)
        study = self.read_json("s", "study.json")
        for run in study["runs"]:
            self.assertTrue(self.exists("s", run["directory"], "final.vtu"))
        for name in ("energy_over_time", "error_over_step", "rms_error_over_step", "work_precision",
                     "energy_drift_over_step", "momentum_drift_over_step"):  # fmt: skip
            for ending in ("png", "svg", "pdf"):
                self.assertGreater(os.path.getsize(self.path("s", f"{name}.{ending}")), 5000)

    def test_the_answer(self):
        """A line for each rule and error in at most 40 lines; --all and --table print other tables."""
        study = ("study beam.toml --steps 0.0025,0.005,0.05 --out s --reference-step 0.00125 "
                 "--no-plots --quiet")  # fmt: skip
        said = self.run_program(study.replace(" --quiet", "")).stdout
        self.assertLessEqual(len(said.splitlines()), 40)
        self.assertRegex(said, r"(?m)^error below +rule +step")
        self.assertRegex(said, r"(?m)^10 %.* explicit ")
        self.assertRegex(said, r"(?m)verlet .* met$")
        self.assertRegex(said, r"Runs with .*verlet.* unstable above 5e-3 s \(0\.\d+ h_crit\)\.")
        self.assertIn("For a position error of ", said)
        self.assertIn("whose own error is estimated at", said)
        answer = self.read_json("s", "study.json")["answer"]
        self.assertEqual([target["target"] for target in answer["targets"]], [0.1, 0.01, 0.001])
        rows = {r["directory"]: r for r in self.read_json("s", "study.json")["runs"]}
        for target in answer["targets"]:
            costs = [rule["cost_seconds"] for rule in target["rules"] if rule["verdict"] == "met"]
            for rule in target["rules"]:
                row = rows[rule["directory"]]
                self.assertEqual((rule["rule"], rule["step"], rule["error"]),
                                 (row["integrator"], row["step"], row["position_error"]))  # fmt: skip
                met = rule["error"] + answer["reference_error"] <= target["target"]
                self.assertEqual(rule["verdict"] == "met", met)
                if met:
                    self.assertAlmostEqual(rule["relative_cost"], rule["cost_seconds"] / min(costs))
        self.assertGreater(len(answer["orders"]), 3)
        said = self.run_program(study.replace("--quiet", "--all")).stdout
        # With the second run of the reference, which tells its error.
        rows = re.findall(r"(?m)^(?:explicit|verlet|midpoint|backward-euler|energy-momentum) ", said)
        self.assertEqual(len(rows), 16)
        latex = self.run_program(study + " --table latex").stdout
        self.assertTrue(latex.startswith("\\begin{tabular}{"))
        self.assertTrue(latex.endswith("\\end{tabular}\n"))
        for line in latex.splitlines()[2:-2]:
            if line != "\\hline":
                self.assertEqual(len(re.findall(r"(?<!\\)&", line)), 7)
        markdown = self.run_program(study + " --table markdown").stdout
        self.assertEqual({len(re.findall(r"(?<!\\)\|", line)) for line in markdown.splitlines()}, {9})
        self.refused(2, study + " --table html", says="there are markdown and latex")

    def test_matplotlib_does_not_speak(self):
        # Of a folder for its settings that it cannot make, matplotlib warns.
        result = self.run_program("study beam.toml --steps 0.05 --integrators midpoint --out s "
                                  "--quiet", env={"MPLCONFIGDIR": "/dev/null/settings"})  # fmt: skip
        self.assertEqual(own_lines(result.stderr), [])
        self.assertTrue(self.exists("s", "energy_over_time.png"))

    def test_python_files_of_the_working_folder_do_not_run(self):
        for module in ("csv", "json", "math", "matplotlib", "numpy", "os", "sitecustomize"):
            self.write(module + ".py", f"open({self.path('ran')!r}, 'w')\nraise SystemExit\n")
        self.write("matplotlibrc", "backend: module://csv\n")
        result = self.run_program("study", "beam.toml", "--steps", "0.05", "--integrators", "midpoint",
                                  "--out", "s", env={"PYTHONPATH": self.folder})  # fmt: skip
        self.assertFalse(self.exists("ran"))
        self.assertNotIn("plots are missing", result.stderr)
        self.assertTrue(self.exists("s", "energy_over_time.png"))

    def test_errors_are_relative_to_the_displacement(self):
        """As anybody works them out from the results. The reference is one of the runs."""
        result = self.run_program("study beam.toml --steps 0.005,0.02 --integrators "
                                  "midpoint,backward-euler --out s --no-plots --all")  # fmt: skip

        def displacement(directory):
            return read_grid(self.path("s", directory, "final.vtu"))[1]["displacement"]

        rows = {(r["integrator"], r["step"][:4]): r for r in self.table("s", "study.csv")}
        reference = displacement("midpoint-0.005")
        for (integrator, step), row in rows.items():
            self.assertEqual(row["role"], "run")
            if (integrator, float(row["step"])) == ("midpoint", 0.005):
                self.assertEqual(float(row["position_error"]), 0)
                self.assertEqual(float(row["position_error_rms"]), 0)
                continue
            difference = displacement(f"{integrator}-{float(row['step']):.10g}") - reference
            expected = (difference**2).sum() ** 0.5 / (reference**2).sum() ** 0.5
            self.assertAlmostEqual(float(row["position_error"]) / expected, 1, delta=1e-8)
            self.assertGreater(float(row["position_error_rms"]), 0)
        self.assertEqual(len(rows), 4)
        self.assertRegex(result.stdout, r"midpoint +newton +0\.005 .* reference")

    def test_the_table_names_the_rules_of_its_stability_limits(self):
        """With damping the limits of the explicit rules differ; rules that do not take part have none."""

        def closing_line(integrators, *overrides):
            result = self.run_program(
                "study", "beam.toml", "--integrators", integrators, "--steps", "1e-3", "--set",
                "time.end=2e-3", "--no-plots", "--all", "--out", self.path("s"), *overrides,
            )  # fmt: skip
            line = re.search(r"Stability limit: (.*)\. Reference", result.stdout).group(1)
            limits = {r["integrator"]: float(r["stable_step"]) for r in self.table("s", "study.csv")}
            return line, limits

        damped = ("--set", "damping.viscosity=1000")
        line, limits = closing_line("explicit,verlet")
        self.assertEqual(line, f"h_crit = {limits['explicit']:.4g} s (explicit and verlet)")
        line, limits = closing_line("explicit,verlet", *damped)
        self.assertLess(limits["explicit"], 0.9 * limits["verlet"])
        self.assertEqual(line, f"h_crit = {limits['explicit']:.4g} s (explicit), "
                               f"{limits['verlet']:.4g} s (verlet)")  # fmt: skip
        line, limits = closing_line("verlet,midpoint", *damped)
        self.assertEqual(line, f"h_crit = {limits['verlet']:.4g} s (verlet)")
        line, limits = closing_line("midpoint", *damped)
        self.assertEqual(line, f"h_crit = {limits['midpoint']:.4g} s (explicit)")

    def test_variants_show_that_the_penalty_blows_up(self):
        """The shipped scene, as its header says: at one step the exact constraint runs."""
        scene = os.path.join(os.path.dirname(DATA), "examples", "scenes",
                             "penalty_versus_exact.toml")  # fmt: skip
        result = self.run_program(f"study {scene} --vary fix.0.mode=exact,penalty --integrators "
                                  "verlet --steps 5e-4 --reference-integrator verlet --out s "
                                  "--set time.end=0.05 --no-plots --all")  # fmt: skip
        self.assert_parts(result.stdout, ("exact: h_crit", "penalty: h_crit"))
        rows = {row["variant"]: row for row in self.table("s", "study.csv") if row["role"] == "run"}
        self.assertEqual(rows["exact"]["status"], "ok")
        self.assertEqual(rows["penalty"]["status"], "unstable")
        self.assertLess(float(rows["penalty"]["stable_step"]), 5e-4)
        self.assertGreater(float(rows["exact"]["stable_step"]), 5e-4)
        self.assertEqual(float(rows["exact"]["position_error"]), 0)
        # It has a reference of its own, which blows up, too.
        self.assertIn("Reference of penalty: verlet with h = 5e-4 s (unstable)", result.stdout)
        self.assertIn("the reference run of penalty did not reach the end", result.stderr)
        for key in ("time.end=1,2", "output.every=1,2", "time.step=1e-3,1e-4"):
            self.assertIn("one end time", self.refused(2, f"study {scene} --vary", key))
        for bad in ("fix.0.mode", "fix.0.mode=", "fix.0.mode=exact,soft"):
            self.assertIn("fix.0.mode", self.refused(2, f"study {scene} --vary", bad))

    def test_solvers_side_by_side(self):
        """They minimise the same potential: positions agree to the tolerance."""
        self.run_program("study beam.toml --vary solver.kind=ceres,newton --integrators "
                         "midpoint,backward-euler --steps 0.01 --out s --no-plots")  # fmt: skip
        rows = {(r["variant"], r["integrator"]): r for r in self.table("s", "study.csv")
                if r["role"] != "reference"}  # fmt: skip
        self.assertEqual(len(rows), 4)
        for row in rows.values():
            self.assertEqual(row["status"], "ok")
            self.assertGreaterEqual(float(row["iterations_per_step"]), 1)
        self.assertEqual(float(rows["ceres", "midpoint"]["position_error"]), 0)
        self.assertLess(float(rows["newton", "midpoint"]["position_error"]), 1e-8)
        errors = [float(rows[kind, "backward-euler"]["position_error"]) for kind in ("ceres", "newton")]
        self.assertGreater(errors[0], 1e-6)
        self.assertAlmostEqual(errors[1] / errors[0], 1, delta=1e-4)
        for kind in ("ceres", "newton"):
            self.assertEqual(self.read_json("s", f"{kind}-midpoint-0.01", "summary.json")["solver"]["kind"], kind)
        message = self.refused(2, "study beam.toml --vary solver.kind=ceres,newtn")
        self.assertIn("did you mean newton?", message)

    def test_a_study_does_not_take_events_that_change_its_steps(self):
        scene = self.write(
            "beam.toml", BEAM + '[[event]]\nat = 0.01\nset = { "time.step" = 1e-3 }\n'
        )
        self.refused(2, f"study {scene} --out s", says=("event.0", "[time]"))


if __name__ == "__main__":
    main()
