"""Sizes of steps, and what is told of results."""

import sys

sys.path.insert(0, f"{sys.path[0]}/..")
from support.mechanics import SceneTest
from support.program import BEAM, CUBE, INTEGRATORS, main
from support.scenes import plane, tables


class Steps(SceneTest):
    """Steps of a fixed size, of an automatic one, and steps that adapt or are repeated."""

    def test_the_end_is_met_by_a_shorter_step(self):
        for integrator in INTEGRATORS:
            with self.subTest(integrator):
                rows = self.simulate(CUBE, f"time.integrator={integrator}", "time.end=0.0105")
                self.assertEqual(rows[-1]["time"], 0.0105)
                self.assertEqual(len(rows), 12)
                self.assertEqual([rows[i]["time_step"] for i in (0, 1, 10)], [0, 1e-3, 1e-3])
                self.assertAlmostEqual(rows[11]["time_step"], 5e-4, places=15)
                steps = self.summary("out")["time_steps"]
                self.assertEqual((steps["smallest"], steps["largest"]), (1e-3, 1e-3))
                self.assertEqual(steps["changes"], 0)
                self.assertEqual(self.messages(), [])
        scene = self.write("scene.toml", CUBE)
        result = self.run_program(f"run {scene} --out out --set time.end=4e-4")
        self.assertIn("1 steps of 0.001 s, the last of 0.0004 s to t = 0.0004 s", result.stdout)
        # An event that moves the end moves it exactly.
        rows = self.simulate(CUBE + '[[event]]\nat = 0.005\nset = { "time.end" = 0.0077 }\n')
        self.assertEqual(rows[-1]["time"], 0.0077)
        # The last step starts at 0.01 s.
        late = '[[event]]\nat = {}\nset = {{ "damping.drag" = 1 }}\n'
        self.simulate(CUBE + late.format(0.01), "time.end=0.0105")
        self.assertEqual(self.messages(), [])
        self.simulate(CUBE + late.format(0.0102), "time.end=0.0105")
        self.assertEqual(len(self.warnings_of()), 1)

    PRESS = tables(mesh=dict(generate={"kind": "cube", "cells": 2}),
                   material=dict(youngs_modulus=1e6, poissons_ratio=0.4),
                   time=dict(integrator="verlet", step="auto", end=3), damping=dict(viscosity=100),
                   fix=[dict(select=plane("x", 0)),
                   dict(select=plane("x", 1), velocity=[-0.5, 0, 0])])

    def test_an_automatic_step_follows_the_limit(self):
        rows = self.simulate(self.PRESS, code=1)
        self.assertGreater(rows[-1]["time"], 1.5)
        self.assertLess(rows[-1]["time_step"], 1e-3 * rows[1]["time_step"])
        summary = self.summary("out")
        self.assertEqual(summary["status"], "unstable")
        self.assertGreater(summary["time_steps"]["changes"], 5)
        for part in ("crushed", "element", "half of the stability limit"):
            self.assertIn(part, self.result.stderr)
        self.assertNotIn("auto", self.result.stderr)  # which is in force
        # Smaller or larger after an event that says so, and no warning.
        event = '[[event]]\nat = 0.05\nset = { "material.youngs_modulus" = 1e8 }\n'
        rows = self.simulate(self.PRESS + event, "time.end=0.1")
        self.assertAlmostEqual(rows[-2]["time_step"] / rows[1]["time_step"], 0.1, delta=0.02)
        self.assertEqual(self.messages(), [])

    def test_the_same_bits_with_an_automatic_step(self):
        scene = self.write("scene.toml", self.PRESS)
        for name, threads in (("a", "1"), ("b", "2")):
            self.run_program("--threads", threads, "run", scene, "--out", self.path(name),
                             "--quiet", "--set", "time.end=1.3")  # fmt: skip
        self.assertEqual(self.history("a", "history.csv"), self.history("b", "history.csv"))

    # Steps that adapt or are repeated.

    STRETCHED = CUBE + "[initial]\nstretch = [1.2, 0.9, 1]\n"

    def test_steps_adapt_to_a_tolerance(self):
        event = '[[event]]\nat = 0.0123\nset = { "material.youngs_modulus" = 1e7 }\n'
        for integrator in INTEGRATORS:
            with self.subTest(integrator):
                rows = self.simulate(self.STRETCHED + event, f"time.integrator={integrator}",
                                     "time.adapt=error", "time.tolerance=1e-5")  # fmt: skip
                self.assertEqual(rows[-1]["time"], 0.02)
                self.assertEqual(len([r for r in rows if r["time"] == 0.0123]), 1)
                for row in rows[1:]:
                    self.assertEqual(row["substeps"], 2)
                    self.assertLessEqual(row["step_error"], 1e-5)
                steps = self.summary("out")["time_steps"]
                self.assertEqual(steps["adapt"], "error")
                self.assertEqual(steps["rejected"], sum(r["rejected"] for r in rows))
                self.assertEqual(steps["above_tolerance"], 0)
                self.assertGreater(steps["changes"], 0)
                echo = self.summary("out")["scene"]["time"]
                self.assertEqual((echo["adapt"], echo["tolerance"]), ("error", 1e-5))
                self.assertEqual([e["time"] for e in self.summary("out")["events"]], [0.0123])
                self.assert_books_close(rows)
        scene = self.write("scene.toml", self.STRETCHED)
        result = self.run_program(f"run {scene} --out out --set time.adapt=error")
        self.assertIn("step control: errors of at most 0.0001", result.stdout)
        self.assertIn("the energy may drift", result.stdout)

    def test_steps_adapt_to_the_discrete_energy(self):
        rows = self.simulate(self.STRETCHED, "time.integrator=midpoint", "time.adapt=energy",
                             "time.end=0.2")  # fmt: skip
        self.assertEqual(rows[-1]["time"], 0.2)
        first = rows[1]["discrete_energy"]
        for row in rows[1:-1]:
            self.assertAlmostEqual(row["discrete_energy"], first, delta=1e-8 * first)
            self.assertAlmostEqual(row["energy_residual"], 0, delta=1e-8 * first)
        self.assertEqual(self.summary("out")["time_steps"]["without_solution"], 0)
        self.assertNotIn("step_error", rows[0])

    def test_a_step_that_fails_is_made_in_smaller_ones(self):
        force = "[[force]]\nselect = { plane = { axis = \"x\", at = 1 } }\nvector = [0, 1e4, 0]\n"
        fix = "[[fix]]\nselect = { plane = { axis = \"x\", at = 0 } }\n"
        hard = ("time.integrator=midpoint", "time.step=0.02", "time.end=0.1",
                "solver.max_iterations=3")  # fmt: skip
        self.simulate(CUBE + fix + force, *hard, code=1)
        rows = self.simulate(CUBE + fix + force, *hard, "time.retry=8")
        self.assertEqual(len(rows), 6)
        self.assertEqual([round(r["time"], 12) for r in rows], [0, 0.02, 0.04, 0.06, 0.08, 0.1])
        steps = self.summary("out")["time_steps"]
        self.assertGreater(steps["retried"], 0)
        self.assertEqual(steps["retried"], len([r for r in rows if r["substeps"] > 1]))
        self.assertEqual(steps["failed"], sum(r["rejected"] for r in rows))
        self.assertIn("time.retry", self.warnings_of()[0])
        self.assertNotIn("step_error", rows[0])

    def test_the_first_step_lies_within_the_bounds(self):
        for overrides, first in (
            (("time.max_step=5e-4",), 5e-4),
            (("time.min_step=2e-3",), 2e-3),
            (("time.max_step=1e-10", "time.end=2e-9"), 1e-10),
        ):
            with self.subTest(overrides):
                rows = self.simulate(CUBE, "time.integrator=midpoint", "time.step=1e-3",
                                     "time.adapt=error", *overrides)  # fmt: skip
                self.assertAlmostEqual(rows[1]["time_step"], first, delta=1e-9 * first)
        event = '[[event]]\nat = 0.01\nset = { "time.max_step" = 2.5e-4 }\n'
        rows = self.simulate(CUBE + event, "time.integrator=midpoint", "time.adapt=error")
        self.assertTrue(any(r["time"] < 0.01 and r["time_step"] > 5e-4 for r in rows))
        for row in rows:
            if row["time"] > 0.01:
                self.assertLessEqual(row["time_step"], 2.5e-4 * (1 + 1e-5))

    def test_contradictory_ways_of_adapting_are_refused(self):
        for overrides, part in (
            (("time.adapt=fast",), "none, error or energy"),
            (("time.adapt=error", "time.tolerance=0"), "1e-12 or more"),
            (("time.adapt=error", "time.tolerance=1e-14"), "1e-12 or more"),
            (("time.adapt=error", "time.min_step=1e-2", "time.max_step=1e-3"),
             "time.max_step = 0.001 s is below min_step = 0.01 s"),
            (("time.adapt=error", "time.min_step=-1"), "above 0"),
            (("time.adapt=energy",), 'time.adapt = "energy" is for implicit rules'),
            (("time.adapt=energy", "time.integrator=backward-euler"),
             'time.adapt = "energy" is for implicit rules'),
            (("time.adapt=energy", "time.integrator=energy-momentum"),
             'time.adapt = "energy" is for implicit rules'),
            (("time.adapt=error", "time.retry=2"), "Leave one of them out"),
            (("time.step=auto", "time.retry=2"), "Leave one of them out"),
            (("time.retry=-1",), "0"),
            (("time.retry=1000",), "30"),
        ):
            with self.subTest(overrides):
                self.refused_scene(CUBE, *overrides, says=("time.", part))
        scene = self.write("scene.toml", CUBE)
        self.refused(2, "study", scene, "--steps", "1e-3", "--out",
                                                 self.path("study"), "--set", "time.adapt=error", says="time.adapt")  # fmt: skip
        event = '[[event]]\nat = 0.01\nset = { "time.integrator" = "verlet" }\n'
        message = self.refused_scene(CUBE + event, "time.integrator=midpoint", "time.adapt=energy")
        self.assertIn('adapt = "energy" is for implicit rules', message)
        # What has no effect is said.
        self.simulate(CUBE, "time.tolerance=1e-3")
        self.assertIn("time.adapt", self.warnings_of()[0])
        self.simulate(CUBE, "time.integrator=midpoint", "time.adapt=energy", "time.tolerance=1e-3")
        self.assertIn("time.tolerance has no effect", self.warnings_of()[0])
        event = '[[event]]\nat = 0.01\nset = { "time.max_step" = 1e-3 }\n'
        self.simulate(CUBE + event)
        self.assertRegex(self.warnings_of()[0], r"event\.0: .*time.max_step have no effect")
        adapt = event.replace("0.01", "0.015").replace('max_step" = 1e-3', 'adapt" = "error"')
        self.simulate(CUBE + event + adapt)
        self.assertEqual(self.warnings_of(), [])

    def test_inverted_elements_are_counted(self):
        twisted = CUBE.replace("youngs_modulus", 'model = "stvk"\nyoungs_modulus') + """
[damping]
viscosity = 200
[[fix]]
select = { plane = { axis = "x", at = 0 } }
[[constraint]]
kind = "rigid"
select = { plane = { axis = "x", at = 1 } }
angular_velocity = [12, 0, 0]
"""
        rows = self.simulate(twisted, "time.integrator=backward-euler", "time.step=0.01",
                             "time.end=0.4")  # fmt: skip
        counts = [row["inverted_elements"] for row in rows]
        self.assertGreater(max(counts), 0)
        first = next(row for row in rows if row["inverted_elements"] > 0)
        told = self.summary("out")["inverted_elements"]
        self.assertEqual(told["most"], max(counts))
        self.assertEqual(rows[told["most_at_step"]]["inverted_elements"], max(counts))
        self.assertEqual((told["now"], told["first_time"]), (counts[-1], first["time"]))
        warnings = [w for w in self.warnings_of() if "turned inside out" in w]
        self.assertEqual(len(warnings), 1)
        self.assertIn(f"element {told['first']} ", warnings[0])
        # Not where no material allows it.
        rows = self.simulate(CUBE)
        self.assertNotIn("inverted_elements", rows[0])
        self.assertNotIn("inverted_elements", self.summary("out"))

    def test_warnings_of_results_that_mislead(self):
        beam = BEAM.replace("every = 4", "every = 100")
        self.simulate(beam, "time.end=4", "time.integrator=backward-euler", "time.step=0.1")
        self.assertEqual(len(self.warnings_of()), 1)
        self.assertIn("energy error", self.result.stderr)
        self.assertIn("0.025 Hz", self.result.stderr)
        told = [w for w in self.summary("out")["warnings"] if "OpenBLAS" not in w]
        self.assertEqual(len(told), 1)
        self.simulate(beam, "material.poissons_ratio=0.45")
        self.assertEqual(len(self.warnings_of()), 1)
        self.assertIn("lock", self.result.stderr)
        self.simulate(beam, "material.poissons_ratio=0.44")
        self.assertEqual(self.messages(), [])
        expanding = ["material.poissons_ratio=-0.3", "material.volumetric=quadratic"]
        self.simulate(beam, *expanding)
        self.assertEqual(len(self.warnings_of()), 1)
        self.assertIn("no lower bound", self.result.stderr)
        # The same words before the run.
        overrides = [word for change in expanding for word in ("--set", change)]
        checked = self.run_program("check", self.write("beam.toml", beam), *overrides)
        self.assertIn(self.warnings_of()[0], checked.stderr)


if __name__ == "__main__":
    main()
