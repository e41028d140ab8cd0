"""tetraction study: the steps that it is given, and those that it chooses."""

import re
import sys

sys.path.insert(0, f"{sys.path[0]}/..")
from support.program import main
from support.study import PROBES, StudyTest


class Steps(StudyTest):
    def steps(self, role="run"):
        """The steps of each rule, in s."""
        found = {}
        for row in self.rows():
            if row["role"] == role:
                found.setdefault(row["integrator"], []).append(float(row["step"]))
        return found

    def test_of_each_rule_in_every_unit(self):
        """Steps that are given are run as they are, without any trial. Other units divide the end of 0.1 s."""
        said = self.study("--steps verlet=1x,auto --steps midpoint=4x,2e-3,0.01T --steps verlet=1e-3")
        self.assertNotIn("[trial]", said.stderr)
        critical = self.result()["stable_step"]
        steps = self.steps()
        self.assertEqual(set(steps), {"verlet", "midpoint"})
        self.assertEqual(len(steps["verlet"]), 3)
        self.assertEqual(steps["verlet"][0], 1e-3)
        for step, wanted in ((steps["verlet"][1], 0.5 * critical), (steps["verlet"][2], critical)):
            self.assertLessEqual(step, wanted)
            self.assertAlmostEqual(step / wanted, 1, delta=0.1)
            self.assertAlmostEqual(0.1 / step, round(0.1 / step), places=6)
        self.assertIn(2e-3, steps["midpoint"])
        self.assertEqual(len(steps["midpoint"]), 3)
        self.assertTrue(any(abs(step / (4 * critical) - 1) < 0.3 for step in steps["midpoint"]))
        self.assertEqual(self.steps("trial"), {})

    def test_messages(self):
        for arguments, says in (
            (("--steps", "fast"), ('"fast" is no step', "0.02T", "auto")),
            (("--steps", "-1e-3"), ('"-1e-3" is not positive',)),
            (("--steps", "verlett=1e-3", "--integrators", "verlet"), ("did you mean verlet?",)),
            (("--steps", "midpoint=7"), ("at most the end time 0.1 s",)),
            (("--budget", "10"), ("--budget", "10s, 2min or 1h")),
            (("--target", "2"), ("--target", "1% or 0.01")),
            (("--target", "1%", "--steps", "1e-3"), ("--target searches for the steps itself",)),
            (("--error", "peak.tip"), ("peak.probe.NAME",)),
            (("--frames", "midpoint-0.01"), ("the steps are not chosen yet",)),
            (("--integrators", "verlet", "--also-solver", "ceres@1e-3"), ("an integrator that minimises",)),
        ):  # fmt: skip
            with self.subTest(arguments):
                self.refused_study(*arguments, says=says)

    def test_a_ladder_for_each_rule(self):
        """Its runs are announced, and made once: the same command again makes none."""
        command = "--integrators verlet,midpoint,backward-euler --budget 30s"
        said = self.study(command)
        self.assertIn("[trial]", said.stderr)
        self.assertIn("note: reference: ", said.stderr)
        steps = self.steps()
        for rule in ("verlet", "midpoint"):
            self.assertGreaterEqual(len(steps[rule]), 2, rule)
        errors = [float(row["position_error"]) for row in self.rows()
                  if row["role"] == "run" and row["integrator"] == "midpoint" and row["position_error"]]  # fmt: skip
        self.assertGreater(max(errors), 10 * min(errors))
        self.assertLess(self.result()["reference"]["estimated_error"], min(e for e in errors if e > 0))
        self.assertIn("no run was made", self.study(command).stderr)
        self.assertEqual(self.steps(), steps)

    def test_a_small_budget(self):
        """Two rules keep two steps, and what is not resolved is said."""
        said = self.study("--integrators midpoint,backward-euler --budget 0.01s --set mesh.generate.cells=[16,4,4]")
        self.assertEqual([len(steps) >= 2 for steps in self.steps().values()], [True, True])
        self.assertIn("not resolved within the budget", said.stderr)

    def test_auto_of_an_implicit_rule_is_its_ladder(self):
        self.study("--steps verlet=1e-3 --steps midpoint=5e-3,auto --budget 20s")
        steps = self.steps()
        self.assertEqual(steps["verlet"], [1e-3])
        self.assertIn(5e-3, steps["midpoint"])
        self.assertGreaterEqual(len(steps["midpoint"]), 3)

    def test_a_plan_writes_nothing(self):
        for command in ("--steps 2e-3,5e-3 --integrators verlet,midpoint", "--budget 5s --integrators verlet,midpoint"):
            with self.subTest(command):
                said = self.study("--plan", *command.split())
                self.assertFalse(self.exists("s"))
                lines = said.stdout.splitlines()
                self.assertEqual(lines[0].split(), ["rule", "step", "[s]", "steps", "about"])
                self.assertRegex(lines[-1], r"^\d+ runs to make, which take about \S+ (s|min)$")
        self.assertEqual(len(re.findall(r"(?m)^(?:verlet|midpoint) +(?:0\.002|0\.005) ",
                                        self.study("--plan --steps 2e-3,5e-3 --integrators verlet,midpoint").stdout)),
                         4)  # fmt: skip
        self.study("--steps 2e-3 --integrators verlet")
        planned = self.study("--plan --steps 2e-3,5e-3 --integrators verlet").stdout
        self.assertRegex(planned, r"(?m)^verlet +0\.002 +50 +kept$")

    def test_a_target(self):
        """The largest step of each rule that meets it, and the largest stable one."""
        said = self.study("--integrators verlet,midpoint,backward-euler --target 2% --budget 1min")
        found = {each["rule"]: each for each in self.result()["searched"]}
        self.assertEqual(set(found), {"verlet", "midpoint", "backward-euler"})
        rows = self.rows()
        for rule, each in found.items():
            target = each["target"]
            self.assertEqual(target["target"], 0.02)
            self.assertLessEqual(target["runs"], 8)
            if not target["is_met"]:
                continue
            self.assertLessEqual(target["error"], 0.02)
            [row] = [r for r in rows if r["integrator"] == rule
                     and abs(float(r["step"]) / target["step"] - 1) < 1e-9]  # fmt: skip
            self.assertEqual(row["role"], "run")
            self.assertIn(f"{rule.capitalize()} meets 2 % with h = ", said.stdout)
        self.assertTrue(found["midpoint"]["target"]["is_met"])
        stable = found["verlet"]["stability"]
        critical = self.result()["stable_step"]
        self.assertAlmostEqual(stable["stable_step"] / critical, 1, delta=0.2)
        self.assertLess(stable["stable_step"], stable["unstable_step"])
        self.assertIn("The largest stable step of verlet is ", said.stdout)
        answer = self.result()["answer"]
        self.assertEqual([target["target"] for target in answer["targets"]], [0.02])
        self.assertLessEqual(len(said.stdout.splitlines()), 40)

    def test_a_target_that_is_not_met_is_a_result(self):
        said = self.study("--integrators backward-euler,midpoint --target 0.0001% --budget 1s")
        found = {each["rule"]: each["target"] for each in self.result()["searched"]}
        self.assertFalse(found["backward-euler"]["is_met"])
        self.assertIn("Backward-euler: 1e-4 % is not", said.stdout)

    def test_errors_of_peaks_and_frequencies(self):
        scene = self.write("probes.toml", PROBES)
        for error, name in (("peak.probe.tip", "error of the peak of the probe tip"),
                            ("frequency.probe.tip", "error of the frequency of the probe tip")):  # fmt: skip
            with self.subTest(error):
                self.run_program("study", scene, "--out", "s", "--no-plots", "--integrators", "midpoint,verlet",
                                 "--steps", "2e-3,4e-3", "--reference-step", "2e-4", "--error", error)  # fmt: skip
                self.assertEqual(self.result()["error"], error)
                self.assertEqual(self.result()["answer"]["error"], name)
                self.assertFalse(self.result()["answer"]["compares_phase"])
        self.run_program("study", scene, "--out", "s", "--no-plots", "--integrators", "midpoint", "--steps",
                         "2e-3,4e-3", "--reference-step", "2e-4", "--error", "peak.probe.tip")  # fmt: skip
        peaks = {}
        for run in ("midpoint-0.0002", "midpoint-0.002", "midpoint-0.004"):
            rows = self.table("s", run, "probes.csv")
            peaks[run] = max(sum(float(row[f"tip_{axis}"]) ** 2 for axis in "xyz") ** 0.5 for row in rows)
        exact = peaks.pop("midpoint-0.0002")
        for row in self.rows():
            folder = f"midpoint-{float(row['step']):.10g}"
            if folder in peaks:
                self.assertAlmostEqual(float(row["probe_error"]), abs(peaks[folder] - exact) / exact, places=9)
        self.refused(2, "study", scene, "--out", "t", "--steps", "2e-3", "--error", "peak.probe.tip",
                     "--reference", "richardson", says="has no peaks and frequencies")  # fmt: skip


if __name__ == "__main__":
    main()
