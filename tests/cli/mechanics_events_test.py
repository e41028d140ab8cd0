"""Events of a run."""

import json
import math
import sys

sys.path.insert(0, f"{sys.path[0]}/..")
from support.mechanics import SceneTest
from support.program import BEAM, CUBE, INTEGRATORS, main
from support.scenes import plane, tables

# A beam to which everything happens: the numbers of its events' steps are in STEPS.
EVENTS = BEAM.replace("end = 0.1", "end = 0.1\n[damping]\nviscosity = 20.0").replace(
    "step = 0.01", "step = 0.002"
) + tables(event=[dict(at=0.02, set={"time.step": 1e-3, "material.youngs_modulus": 2e6}),
           dict(at=0.03,
             set={"environment.kind": "none", "damping.drag": 0.5, "damping.mass_damping": 1}),
           dict(at=0.04, momentum={"select": plane("x", 4.0), "value": [0, 0, 30]}),
           dict(at=0.05, fix={"select": plane("x", 4.0), "velocity": [0, 0, 0.5]}),
           dict(at=0.06, unfix=plane("x", 0.0)),
           dict(at=0.07, force=[{"select": {"nearest": [0, 0, 0]}, "vector": [0, 5000, 0]}],
             constraint={"kind": "distance", "vertices": [0, 80]}),
           dict(at=0.08, set={"time.integrator": "verlet", "time.step": "auto"})])
STEPS = [10, 20, 30, 40, 50, 60, 70]


class Events(SceneTest):
    """Edits that a scene makes while it runs."""

    def test_events_happen_and_the_books_close(self):
        for integrator in INTEGRATORS:
            with self.subTest(integrator):
                rows = self.simulate(EVENTS, f"time.integrator={integrator}")
                largest = self.assert_books_close(rows)
                summary = self.summary("out")
                self.assertEqual(summary["status"], "ok")
                events = summary["events"]
                self.assertEqual([e["what"]["at"] for e in events],
                                 [0.02, 0.03, 0.04, 0.05, 0.06, 0.07, 0.08])  # fmt: skip
                self.assertEqual([e["step"] for e in events], STEPS)
                for event in events:
                    self.assertAlmostEqual(event["time"], event["at"], places=14)
                self.assertEqual(events[0]["what"]["set"]["time.step"], 1e-3)
                self.assertEqual(events[2]["what"]["momentum"]["value"], [0, 0, 30])
                # The history's column moves at the events and nowhere else, by what they report.
                for before, after in zip(rows, rows[1:]):
                    jump = sum(e["energy_jump"] for e in events if e["step"] == before["step"])
                    self.assertAlmostEqual(
                        after["edit_work"] - before["edit_work"], jump, delta=1e-12 * largest
                    )
                # Twice Young's modulus is twice the elastic energy (neo-Hookean).
                self.assertAlmostEqual(
                    events[0]["energy_jump"], rows[10]["elastic_energy"], delta=1e-12 * largest
                )
                self.assertAlmostEqual(
                    events[1]["energy_jump"], -rows[20]["environment_energy"], delta=1e-12 * largest
                )
                self.assertGreater(events[2]["energy_jump"], 0)  # the kick
                self.assertEqual(events[4]["energy_jump"], 0)  # releasing does no work
                self.assertEqual(rows[-1]["environment_energy"], 0)
                # The step changes where it should.
                self.assertAlmostEqual(rows[10]["time"] - rows[9]["time"], 2e-3, places=15)
                self.assertAlmostEqual(rows[11]["time"] - rows[10]["time"], 1e-3, places=15)
                self.assertEqual(summary["integrator"], "verlet")
                self.assertAlmostEqual(rows[-1]["time"], 0.1, delta=summary["time_step"])
                # Every kind of work is there.
                for name in ("external_work", "dissipated_energy", "constraint_work", "edit_work"):
                    self.assertGreater(abs(rows[-1][name]), 1e-6 * largest, name)
                self.assertLess(max(r["max_constraint_error"] for r in rows), 1e-9)

    def test_same_bits_again_and_with_other_threads(self):
        scene = self.write("scene.toml", EVENTS)
        for name, threads in (("a", "1"), ("b", "2")):
            out = self.path(name)
            self.run_program("--threads", threads, "run", scene, "--out", out, "--quiet")
        self.assertEqual(self.history("a", "history.csv"), self.history("b", "history.csv"))

    def test_fix_and_unfix_move_what_they_should(self):
        self.simulate(EVENTS, "time.end=0.06")  # clamped at both ends
        fields, points = self.fields("out", "final.vtu")
        clamp, tip = points[:, 0] == 0, points[:, 0] == 4
        self.assertTrue((fields["displacement"][clamp] == 0).all())
        self.assertTrue((fields["fixed"] == (clamp | tip)).all())
        self.assertLess(abs(fields["velocity"][tip] - [0, 0, 0.5]).max(), 1e-12)
        self.simulate(EVENTS, out="released")  # to the end
        fields, points = self.fields("released", "final.vtu")
        self.assertGreater(abs(fields["displacement"][clamp]).max(), 1e-4)
        self.assertEqual(fields["fixed"][clamp].sum(), 1)  # the end of the rod
        self.assertLess(abs(fields["velocity"][tip] - [0, 0, 0.5]).max(), 1e-12)

    def test_events_come_at_the_first_step_that_starts_then(self):
        # Multiples of the step carry round-off.
        text = CUBE + "".join(
            f'[[event]]\nat = {k * 1e-3:.17g}\nset = {{ "damping.drag" = {k} }}\n'
            for k in range(20)
        )
        self.simulate(text)
        self.assertEqual([e["step"] for e in self.summary("out")["events"]], list(range(20)))
        self.assertEqual(self.messages(), [])
        text = CUBE + '[[event]]\nat = 4.5e-3\nset = { "damping.drag" = 1 }\n'
        self.simulate(text)
        event = self.summary("out")["events"][0]
        self.assertEqual((event["at"], event["step"]), (4.5e-3, 5))

    def test_events_outside_the_run_are_warned_of(self):
        event = '[[event]]\nat = {}\nset = {{ "damping.drag" = 1 }}\n'
        self.simulate(CUBE + event.format(-1))
        self.assertEqual(len(self.warnings_of()), 1)
        for part in ("scene.toml:11:1", "event.0", "-1 s", "before the start"):
            self.assertIn(part, self.result.stderr)
        done = self.summary("out")["events"][0]
        self.assertEqual((done["at"], done["time"], done["step"]), (-1, 0, 0))
        # No step starts at 0.0195 s or later, either.
        for at in (0.02, 7, 0.0195):
            with self.subTest(at):
                self.simulate(CUBE + event.format(at))
                self.assertEqual(self.summary("out")["events"], [])
                self.assertEqual(len(self.warnings_of()), 1)
                for part in ("scene.toml:11:1", "event.0", f"{at} s", "does not happen"):
                    self.assertIn(part, self.result.stderr)
        self.simulate(CUBE + event.format(0))
        self.assertEqual(self.messages(), [])

    def test_events_may_move_the_end(self):
        longer = CUBE + '[[event]]\nat = 0.01\nset = { "time.end" = 0.05 }\n'
        rows = self.simulate(longer)
        self.assertAlmostEqual(rows[-1]["time"], 0.05, places=14)
        self.assertEqual(self.summary("out")["steps_planned"], 50)
        # What comes after the first end happens and is not warned of.
        self.simulate(longer + '[[event]]\nat = 0.04\nset = { "damping.drag" = 1 }\n')
        self.assertEqual(len(self.summary("out")["events"]), 2)
        self.assertEqual(self.messages(), [])
        shorter = CUBE + '[[event]]\nat = 0.01\nset = { "time.end" = 0.015 }\n'
        self.assertAlmostEqual(self.simulate(shorter)[-1]["time"], 0.015, places=14)
        # What the new end leaves out is warned of; the end may be in the past.
        self.simulate(shorter + '[[event]]\nat = 0.017\nset = { "damping.drag" = 1 }\n')
        self.assertEqual(len(self.warnings_of()), 1)
        self.assertIn("event.1", self.result.stderr)
        rows = self.simulate(CUBE + '[[event]]\nat = 0.01\nset = { "time.end" = 0.001 }\n')
        self.assertEqual(len(rows), 11)

    def test_an_event_lets_go_before_it_holds(self):
        """A clamp is moved by unfix and fix in one event."""
        text = CUBE + tables(fix=[dict(select=plane("x", 0))],
                             event=[dict(at=0.005, unfix=plane("x", 0),
                               fix={"select": plane("x", 0), "offset": [0, 0, 0.01]})])
        self.assert_books_close(self.simulate(text))
        fields, points = self.fields("out", "final.vtu")
        clamp = points[:, 0] == 0
        self.assertTrue((fields["fixed"] == clamp).all())
        self.assertLess(abs(fields["displacement"][clamp] - [0, 0, 0.01]).max(), 1e-15)

    def test_an_event_moves_a_fix(self):
        text = CUBE + tables(fix=[dict(select=plane("x", 0))],
                             event=[dict(at=0.005, set={"fix.0.velocity": [-0.5, 0, 0]}),
                             dict(at=0.015, set={"fix.0.velocity": [0, 0, 0]})])
        rows = self.simulate(text)
        self.assert_books_close(rows)
        fields, points = self.fields("out", "final.vtu")
        clamp = points[:, 0] == 0
        self.assertLess(abs(fields["displacement"][clamp] - [-0.005, 0, 0]).max(), 1e-15)
        self.assertGreater(rows[-1]["constraint_work"], 0)
        self.assertEqual(rows[-1]["constraint_work"], rows[16]["constraint_work"])

    def test_an_event_changes_a_rod(self):
        text = CUBE + tables(constraint=[dict(kind="distance", vertices=[0, 2])],
                             event=[dict(at=0.01, set={"constraint.0.length": 1.1})])
        for integrator in INTEGRATORS:
            with self.subTest(integrator):
                rows = self.simulate(text, f"time.integrator={integrator}")
                self.assert_books_close(rows)
                self.assertLess(max(r["max_constraint_error"] for r in rows), 1e-9)
                self.assertGreater(self.summary("out")["events"][0]["energy_jump"], 1)
                fields, points = self.fields("out", "final.vtu")
                ends = points + fields["displacement"]
                length = math.dist(ends[0], ends[2])
                self.assertAlmostEqual(length, 1.1, delta=1e-9)
                self.assertEqual(rows[10]["constraint_0_tension"], 0)
                self.assertLess(rows[11]["constraint_0_tension"], -1)  # it pushes

    def test_events_that_cannot_be_made(self):
        """Known before the start: nothing is run."""
        event = CUBE + "[[event]]\nat = 0.01\n"
        for lines, parts in {
            "momentum = { select = { nearest = [0, 0, 0] } }": ("event.0.momentum.value",),
            'set = { "time.step" = -1 }': ("time.step", "event at 0.01 s", "above 0"),
            'set = { "material.density" = 1 }': ("density", "mass"),
            'set = { "material_region.3.mu" = 1 }': ("material_region",),
            "": ("changes nothing",),
        }.items():
            with self.subTest(lines):
                message = self.refused_scene(event + lines + "\n")
                self.assertIn("scene.toml:", message)
                for part in parts:
                    self.assertIn(part, message)

    def test_events_that_select_nothing(self):
        """Selections are of the undeformed body: known before the start, too."""
        event = CUBE + "[[event]]\nat = 0.01\n"
        for lines, parts in {
            "unfix = { vertices = [1000] }": ("event.0.unfix", "1000"),
            'fix = { select = { group = "lid" } }': ("event.0.fix", "group"),
            'force = { select = { box = { min = [9, 9, 9], max = [9, 9, 9] } }, '
            "vector = [0, 0, 1] }": ("event.0.force", "selects no vertex"),
        }.items():
            with self.subTest(lines):
                self.refused_scene(event + lines + "\n", says=parts)

    def test_events_that_fail_in_the_run_keep_what_was_computed(self):
        text = CUBE + tables(initial=dict(velocity=[1, 0, 0]), fix=[dict(select={"vertices": [0]})],
                             event=[dict(at=0.01,
                               fix={"select": {"vertices": [0]}, "offset": [0, 0, 0.1]})])
        rows = self.simulate(text, code=1)
        self.assertEqual(len(rows), 11)
        self.assertEqual(len(self.messages()), 1)
        for part in ("event at 0.01 s", "event.0.fix", "fix.0", "vertex 0"):
            self.assertIn(part, self.result.stderr)
        self.assertEqual(self.summary("out")["status"], "failed")
        self.run_program("mesh info out/final.vtu")

    def test_events_that_make_the_step_too_large_are_warned_of(self):
        text = CUBE.replace("end = 0.02", "end = 2")
        event = '[[event]]\nat = 0.01\nset = { "time.step" = 0.1 }\n[initial]\nstretch=[1.01,1,1]\n'
        self.simulate(text + event, code=1)
        self.assertEqual(len(self.warnings_of()), 1)
        for part in ("event at 0.01 s", "h_crit", "verlet"):
            self.assertIn(part, self.warnings_of()[0])
        self.assertIn("h_crit", self.summary("out")["events"][0]["warning"])

    def test_the_other_commands_take_such_scenes(self):
        scene = self.write("scene.toml", EVENTS)
        self.run_program(f"check {scene}")
        report = self.json_of(f"check {scene}")
        self.assertAlmostEqual(report["mass"], 4000, delta=1e-9)
        echo = self.run_program(f"run {scene} --json --out out")
        self.assertEqual(len(json.loads(echo.stdout)["scene"]["event"]), 7)


if __name__ == "__main__":
    main()
