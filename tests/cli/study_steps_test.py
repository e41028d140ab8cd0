"""tetraction study: the steps that it is given, and those that it chooses."""

import math
import re
import sys

sys.path.insert(0, f"{sys.path[0]}/..")
from support.program import main
from support.scenes import tables
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

    def test_periods_of_a_body_on_the_spring_of_a_pull(self):
        """A spring at the centre of mass: T = 2 pi sqrt(m/k), for all vertices together."""
        beam = dict(kind="beam", size=[0.4, 0.1, 0.1], cells=[1, 1, 1])
        self.write("beam.toml", tables(
            mesh=dict(generate=beam), material=dict(youngs_modulus=1e6, poissons_ratio=0.3, density=1000.0),
            pull=dict(vertices=list(range(8)), stiffness=50.0, target=[0.3, 0.05, 0.05]),
            time=dict(integrator="midpoint", step=1e-2, end=2.0)))  # fmt: skip
        self.study("--steps midpoint=0.01T,0.02T")
        period = 2 * math.pi * math.sqrt(4.0 / 50.0)
        for step, share in zip(self.steps()["midpoint"], (0.01, 0.02)):
            self.assertAlmostEqual(step / (share * period), 1, delta=0.02)

    def test_messages(self):
        for arguments, says in (
            (("--steps", "fast"), ('"fast" is no step', "0.02T", "auto")),
            (("--steps", "-1e-3"), ('"-1e-3" is not positive',)),
            (("--steps", "midpoint=0x10"), ('"0x10" is no step',)),
            (("--steps", "1e-3", "--reference-step", "0x1p-9"), ("--reference-step", "no decimal number")),
            (("--steps", "1e-3", "--also-solver", "ceres@0x1p-9"), ("SOLVER@STEP",)),
            (("--budget", "0x10s"), ("--budget", "10s, 2min or 1h")),
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

    def test_a_target_that_no_step_can_meet(self):
        for target in ("1e-300%", "1e-320"):
            self.study("--integrators verlet,midpoint --budget 1s --quiet --target", target)
            (answer,) = self.result()["answer"]["targets"]
            self.assertEqual([rule["verdict"] for rule in answer["rules"]], ["not met"] * 2)
            self.assertEqual([rule["target"]["is_met"] for rule in self.result()["searched"]], [False] * 2)

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
            self.assertRegex(said.stdout, rf"(?m) {rule} .* met$")
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
        self.assertIn("no step of backward-euler that meets 1e-4 %", said.stdout)

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
            self.assertAlmostEqual(float(row["probe_value"]), {**peaks, "midpoint-0.0002": exact}[folder], places=9)
        self.refused(2, "study", scene, "--out", "t", "--steps", "2e-3", "--error", "peak.probe.tip",
                     "--reference", "richardson", says="has no peaks and frequencies")  # fmt: skip


    def test_a_probe_without_two_periods_has_no_frequency(self):
        scene = self.write("probes.toml", PROBES)
        said = self.run_program("study", scene, "--out", "s", "--no-plots", "--integrators", "midpoint", "--steps",
                                "2e-3,4e-3", "--error", "frequency.probe.tip", "--set", "time.end=0.1")  # fmt: skip
        self.assertIn("there are no errors of the frequency of the probe tip, because it has no vibration with at "
                      "least two periods up to the end at 0.1 s: make time.end longer", said.stderr)  # fmt: skip
        self.assertEqual({row["probe_error"] for row in self.rows()}, {""})

    def test_a_plan_says_what_the_runs_of_the_reference_are_for(self):
        said = self.study("--plan --integrators verlet --steps 2e-3 --reference-step 1e-3 "
                          "--reference-integrator midpoint").stdout  # fmt: skip
        self.assertRegex(said, r"(?m)^midpoint \(reference\) +0\.001 ")
        self.assertRegex(said, r"(?m)^midpoint \(second run of the reference, for its error\) +0\.002 ")

    def test_a_target_takes_the_cheapest_run_that_was_made(self):
        """Trial runs that meet it count as well."""
        self.study("--integrators verlet,midpoint --budget 5s --set time.end=0.2")
        rows = {row["directory"]: row for row in self.result()["runs"]}
        for target in self.result()["answer"]["targets"]:
            for rule in target["rules"]:
                if rule["verdict"] != "met":
                    continue
                own = [row for row in rows.values() if row["integrator"] == rule["rule"] and row["status"] == "ok"
                       and row["role"] in ("run", "trial") and row["position_error"] > 0.0]  # fmt: skip
                error = self.result()["reference"]["estimated_error"] or 0.0
                meeting = [row["step"] for row in own if row["position_error"] + error <= target["target"]]
                self.assertEqual(rule["step"], max(meeting))


class Rules(StudyTest):
    """Rules with settings of their own: --rule."""

    STEPS = ("--integrators", "midpoint,verlet", "--steps", "verlet=5e-4", "--steps", "midpoint=2e-3,4e-3")

    def of(self, settings, **keys):
        return [row for row in self.rows() if row["settings"] == settings
                and all(row[key] == value for key, value in keys.items())]  # fmt: skip

    def test_are_compared_with_the_reference_of_the_study(self):
        said = self.study(*self.STEPS, "--rule", "midpoint:solver.tolerance=1e-2",
                          "--rule", "midpoint:time.tolerance=1e-3,time.adapt=error")  # fmt: skip
        rough = self.of("solver.tolerance=1e-2")
        adaptive = self.of("time.adapt=error, time.tolerance=1e-3")
        self.assertEqual([float(row["step"]) for row in rough], [2e-3, 4e-3])
        self.assertEqual([float(row["step"]) for row in adaptive], [2e-3, 4e-3])
        for row in rough + adaptive:
            self.assertEqual((row["integrator"], row["role"], row["status"]), ("midpoint", "run", "ok"))
            self.assertGreater(float(row["position_error"]), 0)
        plain = self.of("", integrator="midpoint", role="run")
        self.assertEqual(len(plain), 2)
        for own, other in zip(rough, plain):
            self.assertNotEqual(own["position_error"], other["position_error"])
            self.assertLess(float(own["iterations_per_step"]), float(other["iterations_per_step"]))
        # The first step is that of the row, and the tolerance chooses the others.
        for row in adaptive:
            self.assertNotEqual(int(row["steps"]), round(0.1 / float(row["step"])))
            self.assertEqual(row["observed_order"], "")
        self.assertNotIn(":", self.result()["reference"]["directory"])
        self.assertEqual(self.result()["reference"]["integrator"], "midpoint")
        self.assertIn("midpoint:solver.tolerance=1e-2 h = ", said.stderr)
        summary = self.read_json("s", "midpoint-solver.tolerance=1e-2-0.002", "summary.json")
        self.assertEqual(summary["scene"]["solver"]["tolerance"], 1e-2)
        self.assertTrue(self.exists("s", "midpoint-time.adapt=error_time.tolerance=1e-3-0.004"))

    def test_never_take_over_the_runs_of_others(self):
        command = ("--integrators", "midpoint", "--steps", "2e-3,4e-3", "--rule", "midpoint:solver.tolerance=1e-2")
        self.study(*command)
        before = self.rows()
        self.assertIn("no run was made", self.study(*command).stderr)
        self.assertEqual([row["position_error"] for row in self.rows()], [row["position_error"] for row in before])
        said = self.study(*command[:-1], "midpoint:solver.tolerance=1e-3").stderr
        self.assertIn("midpoint:solver.tolerance=1e-3 h = 0.002", said)
        self.assertNotIn("midpoint h = ", said)
        planned = self.study(*command, "--plan").stdout
        self.assertRegex(planned, r"(?m)^midpoint:solver.tolerance=1e-2 +0\.002 +50 +kept$")

    def test_with_variants_solvers_jobs_and_own_steps(self):
        rule = "midpoint:solver.tolerance=1e-3"
        self.study("--integrators", "midpoint", "--steps", "midpoint=2e-3", "--steps", f"{rule}=4e-3,5e-3",
                   "--rule", rule, "--vary", "material.density=900,1800", "--also-solver", "ceres@4e-3",
                   "--jobs", "2", "--frames", "900-midpoint-solver.tolerance=1e-3-0.004")  # fmt: skip
        for variant in ("900", "1800"):
            own = self.of("solver.tolerance=1e-3", variant=variant)
            self.assertEqual([float(row["step"]) for row in own], [4e-3, 5e-3])
            self.assertTrue(all(row["role"] == "run" and float(row["position_error"]) > 0 for row in own))
        [ceres] = [row for row in self.rows() if row["solver"] == "ceres" and row["variant"] == "900"]
        self.assertEqual(ceres["settings"], "")
        self.assertTrue(self.exists("s", "900-midpoint-solver.tolerance=1e-3-0.004", "frames.pvd"))

    def test_have_ladders_and_targets(self):
        rule = "midpoint:solver.tolerance=1e-6"
        self.study("--integrators", "midpoint", "--rule", rule, "--rule", "midpoint:time.adapt=error", "--budget", "20s")
        self.assertGreaterEqual(len(self.of("solver.tolerance=1e-6", role="run")), 2)
        self.assertEqual(len(self.of("time.adapt=error", role="run")), 1)
        plan = self.result()["choice"]
        self.assertEqual([(each["rule"], each["how"]) for each in plan["rules"]],
                         [("midpoint", "chosen"), (rule, "chosen"), ("midpoint:time.adapt=error", "chosen")])  # fmt: skip
        self.assertEqual(plan["budget"], 20)
        # The same command has the same plan, also the times that were measured for it.
        self.study("--integrators", "midpoint", "--rule", rule, "--rule", "midpoint:time.adapt=error", "--budget", "20s")
        self.assertEqual(self.result()["choice"], plan)
        self.study("--fresh --integrators verlet --target 2% --budget 20s --rule", rule)
        found = {each["rule"]: each["target"] for each in self.result()["searched"]}
        self.assertTrue(found[rule]["is_met"])

    def test_messages(self):
        for rule, says in (
            ("midpoint:material.density=900", ("--vary material.density=VALUE",)),
            ("midpoint:time.step=1e-3", ("without time.integrator, time.step",)),
            ("midpoint:adapt=error", ("adapt is a key of [time]. Write time.adapt.",)),
            ("midpoint:tolerance=1e-6,retry=3", ("Write time.retry.",)),
            ("midpoint:solver={tolerance=1e-6,linear=cg}", ("solver is a section. Give its keys one by one",)),
            ("midpoint:solver.tolerence=1e-3", ("did you mean tolerance?",)),
            ("midpoint:solver.tolerance=wide", ("--rule", "solver.tolerance")),
            ("midpoint:solver.tolerance=7", ("--rule", "solver.tolerance", "1e-8 is usual")),
            ("midpoint:time.tolerance=1e-3", ("no effect with the other settings",)),
            ("energy-momentum:time.adapt=energy", ("time.adapt", "discrete action")),
            ("verlet:solver.tolerance=1e-3", ("explicit and solves no equations",)),
            ("midpoint:solver.tolerance=1e-3,solver.tolerance=1e-4", ("solver.tolerance is there twice",)),
            ("midpoint", ("INTEGRATOR:KEY=VALUE",)),
        ):
            with self.subTest(rule):
                self.refused_study("--steps", "2e-3", "--integrators", "midpoint", "--rule", rule, says=says)

    def test_two_spellings_of_a_value_are_one_rule(self):
        for one, other in (("solver.tolerance=1e-6", "solver.tolerance=0.000001"), ("time.retry=3", "time.retry=3.0")):
            self.refused_study("--steps", "2e-3", "--integrators", "midpoint", "--rule", f"midpoint:{one}",
                               "--rule", f"midpoint:{other}", says=(f"midpoint:{other} is there twice",))  # fmt: skip


class EnergyErrors(StudyTest):
    STEPS = ("--integrators", "midpoint,verlet", "--steps", "verlet=5e-4", "--steps", "midpoint=2e-3,4e-3",
             "--reference-step", "2.5e-4")  # fmt: skip

    def energy(self, run, column):
        return [(float(row["time"]), float(row[column])) for row in self.table("s", run, "history.csv")]

    def test_are_those_of_history(self):
        """Steps are multiples of that of the reference, so that nothing is interpolated."""
        for column in ("kinetic_energy", "elastic_energy"):
            with self.subTest(column):
                self.study(*self.STEPS, "--error", f"energy.{column}")
                self.assertEqual(self.result()["error"], f"energy.{column}")
                self.assertEqual(self.result()["answer"]["error"], f"error of the {column.replace('_', ' ')}")
                exact = self.energy("midpoint-0.00025", column)
                scale = max(abs(value - exact[0][1]) for _, value in exact)
                for row in self.rows():
                    if row["integrator"] != "midpoint" or row["role"] != "run":
                        continue
                    every = round(float(row["step"]) / 2.5e-4)
                    own = self.energy(f"midpoint-{float(row['step']):.10g}", column)
                    error = max(abs(value - exact[i * every][1]) for i, (_, value) in enumerate(own)) / scale
                    self.assertAlmostEqual(float(row["probe_error"]) / error, 1, places=6)
        # All energies are kept with each run.
        self.assertIn("no run was made", self.study(*self.STEPS, "--error", "energy.total_energy").stderr)
        errors = [float(row["probe_error"]) for row in self.rows() if row["role"] == "run"]
        self.assertTrue(all(0 < error < 1 for error in errors), errors)

    def test_unknown_columns(self):
        self.refused_study(*self.STEPS, "--error", "energy.kinetic",
                           says=("no energy of that name", "kinetic_energy"))  # fmt: skip


if __name__ == "__main__":
    main()
