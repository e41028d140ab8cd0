"""Constraints and their reactions."""

import math
import sys

sys.path.insert(0, f"{sys.path[0]}/..")
from support.mechanics import SceneTest
from support.program import BEAM, CUBE, INTEGRATORS, main
from support.scenes import plane, tables


class Constraints(SceneTest):
    """Fixed vertices, handles, rods, planes and lines."""

    def test_contradictions_are_refused(self):
        rod = '[[constraint]]\nkind = "distance"\nvertices = [0, 2]\nlength = {}\n'
        fix = "[[fix]]\nselect = {{ vertices = [0] }}\noffset = [0, 0, {}]\n"
        self.refused_scene(CUBE + fix.format(0) + fix.format(0.1),
                           says=("scene.toml:11:1: fix.0", "scene.toml:14:1: fix.1", "vertex 0"))
        message = self.refused_scene(CUBE + rod.format(1) + rod.format(1.1))
        self.assertRegex(message, r"scene\.toml:1[15]:1: constraint\.[01]")
        # A rod between two fixed vertices that is too long.
        ends = "[[fix]]\nselect = { vertices = [0, 2] }\n"
        self.assertIn("constraint.0", self.refused_scene(CUBE + ends + rod.format(1.1)))
        # A handle and a rod of another length in it.
        handle = '[[constraint]]\nkind = "rigid"\nselect = { plane = { axis = "y", at = 0 } }\n'
        self.assertIn("constraint.", self.refused_scene(CUBE + handle + rod.format(1.1)))
        # A fixed vertex in a free handle.
        self.refused_scene(CUBE + handle + fix.format(0), says=("constraint.0", "vertex 0"))
        # A fixed vertex off its plane; parallel planes.
        plane = ('[[constraint]]\nkind = "plane"\nselect = {{ vertices = [0] }}\n'
                 "point = [0, 0, {}]\nnormal = [0, 0, 1]\n")  # fmt: skip
        message = self.refused_scene(CUBE + fix.format(0) + plane.format(0.1))
        self.assertRegex(message, r"constraint\.0|fix\.0")
        self.assertIn("vertex 0", message)
        message = self.refused_scene(CUBE + plane.format(0) + plane.format(0.1))
        self.assertRegex(message, r"constraint\.[01]")
        # Vertices and selections that are not there.
        self.refused_scene(
            CUBE + '[[constraint]]\nkind = "distance"\nvertices = [0, 1000]\n', says="1000")  # fmt: skip
        self.refused_scene(
            CUBE + '[[constraint]]\nkind = "rigid"\nselect = { group = "lid" }\n', says="constraint.0")  # fmt: skip

    def test_a_body_of_which_every_vertex_is_held(self):
        scene = self.write(
            "held.toml",
            BEAM.replace('{ plane = { axis = "x", at = 0.0 } }', "{ all = true }"),
        )
        report = self.json_of(f"check {scene}")
        self.assertEqual(report["free_degrees_of_freedom"], 0)
        self.assertIsNone(report["stable_step"])
        self.assertIn("every vertex is held", self.run_program(f"check {scene}").stdout)
        for rule in ("explicit", "verlet", "midpoint", "backward-euler"):
            for solver in ("newton", "ceres"):
                with self.subTest(rule=rule, solver=solver):
                    self.run_program(f"run {scene} --out out --set time.integrator={rule} --set "
                                     f"solver.kind={solver}")  # fmt: skip
                    # Held against gravity: 4000 kg.
                    last = self.history("out", "history.csv")[-1]
                    self.assertAlmostEqual(last["reaction_y"], 39240.0, delta=1e-6)
        message = self.refused(
            2, "run", scene, "--set", "time.integrator=verlet", "--set", 'time.step="auto"'
        )
        self.assertIn("no stability limit", message)

    def test_fixes_that_agree_are_not_refused(self):
        fixes = """velocity = [0.1, 0, 0]
[[fix]]
select = { plane = { axis = "x", at = 0.0 } }
components = "yz"
[output]"""
        scene = self.write("agree.toml", BEAM.replace("[output]", fixes))
        self.run_program(f"run {scene} --out out")
        scene = self.write("differ.toml", BEAM.replace("[output]", fixes.replace("yz", "xz")))
        self.assertIn("different targets", self.refused(2, f"run {scene}"))

    def test_a_force_that_acts_for_less_than_a_step(self):
        scene = self.write(
            "push.toml",
            tables(mesh=dict(generate={"kind": "cube", "size": 1.0, "cells": 2}),
                   material=dict(model="neo-hookean", youngs_modulus=1.0e4, poissons_ratio=0.3,
                     density=10.0), time=dict(integrator="explicit", step=0.002, end=0.1),
                   force=[{"select": {"all": True}, "vector": [10.0, 0, 0], "from": 0.012,
                     "until": 0.013}]),
        )
        for step in (0.0004, 0.002, 0.05):
            rule = "explicit" if step < 0.01 else "midpoint"
            self.run_program(f"run {scene} --out out --set time.step={step} --set "
                             f"time.integrator={rule}")  # fmt: skip
            self.assertAlmostEqual(self.history("out", "history.csv")[-1]["px"], 0.27, places=12)

    def test_redundant_constraints_run(self):
        spin = "[initial]\nangular_velocity = [1, 2, 3]\n"
        rod = '[[constraint]]\nkind = "distance"\nvertices = [{}, {}]\nlength = 1\n'
        fix = "[[fix]]\nselect = { vertices = [0] }\n"
        plane = '[[constraint]]\nkind = "plane"\nselect = { vertices = [26] }\nnormal = [0, 0, 1]\n'
        line = ('[[constraint]]\nkind = "line"\nselect = { vertices = [26] }\n'
                "direction = [1, 0, 0]\n")  # fmt: skip
        handle = '[[constraint]]\nkind = "rigid"\nselect = { plane = { axis = "y", at = 0 } }\n'
        for name, lines in {
            "two rods": rod.format(0, 2) + rod.format(2, 0),
            "two fixes": fix + fix,
            "planes": plane + plane,
            "plane and line": plane + line,
            "rod between fixed": "[[fix]]\nselect = { vertices = [0, 2] }\n" + rod.format(0, 2),
            "rod in a handle": handle + rod.format(0, 2),
            "ten rods of five vertices": "".join(
                f'[[constraint]]\nkind = "distance"\nvertices = [{a}, {b}]\n'
                for a in (0, 2, 6, 18, 26) for b in (0, 2, 6, 18, 26) if a < b
            ),
        }.items():
            for integrator in INTEGRATORS:
                with self.subTest(name, integrator=integrator):
                    rows = self.simulate(CUBE + spin + lines, f"time.integrator={integrator}")
                    self.assert_books_close(rows)
                    self.assertLess(max(r["max_constraint_error"] for r in rows), 1e-9)

    def test_handles(self):
        handle = '[[constraint]]\nkind = "rigid"\nselect = { vertices = [0, 1, 2] }\n'
        self.refused_scene(CUBE + handle + "angular_velocity = [0, 0, 1]\n",
                           says=("scene.toml:11:1: constraint.0", "line"))
        self.simulate(CUBE + handle + "velocity = [0, 0, 1]\n")
        fields, _ = self.fields("out", "final.vtu")
        self.assertLess(abs(fields["displacement"][:3] - [0, 0, 0.02]).max(), 1e-15)
        self.simulate(CUBE + handle + "[initial]\nangular_velocity = [0, 0, 20]\n")
        # Driven and turned by 3 rad/s for 0.02 s: as one rigid body.
        face = '[[constraint]]\nkind = "rigid"\nselect = { plane = { axis = "x", at = 0 } }\n'
        rows = self.simulate(CUBE + face + "angular_velocity = [3, 0, 0]\nvelocity = [1, 0, 0]\n")
        self.assert_books_close(rows)
        self.assertGreater(rows[-1]["constraint_work"], 0)
        self.assertLess(max(r["max_constraint_error"] for r in rows), 1e-14)
        fields, points = self.fields("out", "final.vtu")
        c, s = math.cos(0.06), math.sin(0.06)
        for point, displacement in zip(points, fields["displacement"] - fields["displacement"][0]):
            if point[0] == 0:
                y, z = point[1], point[2]
                expected = [0, c * y - s * z - y, s * y + c * z - z]
                self.assertLess(max(abs(displacement - expected)), 1e-14)
        self.assertAlmostEqual(fields["displacement"][0][0], 0.02, places=14)

    def test_columns_of_handles_and_rods(self):
        """What holds a body up carries its weight; each constraint reports its own share."""
        weight = 1000 * 9.81
        text = CUBE.replace("1.0e5", "1.0e6").replace("end = 0.02", "end = 1") + """
[environment]
kind = "gravity"
[damping]
mass_damping = 30
[[constraint]]
kind = "rigid"
select = { plane = { axis = "x", at = 0 } }
velocity = [0, 0, 0]
[[constraint]]
kind = "distance"
vertices = [2, 26]
"""
        rows = self.simulate(text)
        self.assertEqual(
            list(rows[0])[19:],
            ["reaction_x", "reaction_y", "reaction_z", "time_step", "constraint_0_fx", "constraint_0_fy",
             "constraint_0_fz", "constraint_0_mx", "constraint_0_my", "constraint_0_mz",
             "constraint_1_tension"],
        )  # fmt: skip
        last = rows[-1]
        self.assertAlmostEqual(last["constraint_0_fy"], weight, delta=1e-4 * weight)
        self.assertAlmostEqual(last["reaction_y"], weight, delta=1e-4 * weight)
        for name in ("constraint_0_fx", "constraint_0_fz"):
            self.assertAlmostEqual(last[name], 0, delta=1e-4 * weight)
        # The weight acts half a metre away, give or take the deflection.
        self.assertAlmostEqual(last["constraint_0_mz"], 0.5 * weight, delta=0.02 * weight)
        # Pulled apart by equal forces, a rod carries them.
        pulled = CUBE + tables(constraint=[dict(kind="distance", vertices=[0, 2])],
                               force=[dict(select={"vertices": [0]}, vector=[-300, 0, 0]),
                               dict(select={"vertices": [2]}, vector=[300, 0, 0])])
        for integrator in INTEGRATORS:
            rows = self.simulate(pulled, f"time.integrator={integrator}")
            self.assertEqual(list(rows[0])[-1], "constraint_0_tension")
            self.assertAlmostEqual(rows[1]["constraint_0_tension"], 300, delta=1e-5)

    def test_torque_of_a_turning_handle(self):
        """A body that is one handle and turns about a principal axis needs no torque, a faster one I dω/dt."""
        rules = INTEGRATORS

        def rows_of(rule, start, motion):
            scene = CUBE.replace("end = 0.02", "end = 0.3") + f"""
[initial]
{start}
[[constraint]]
kind = "rigid"
select = {{ all = true }}
{motion}
"""
            return self.simulate(scene, f"time.integrator={rule}", "time.step=0.01")[2:]

        turning = "velocity = [3, 0, 1]\nangular_velocity = [0, 0, 6]"
        for rule in rules:
            # The end of a step of backward-euler is not where its secant leads, which takes a torque ∝ h.
            for motion in ("", turning) if rule != "backward-euler" else ("",):
                with self.subTest(rule, motion=motion):
                    for row in rows_of(rule, turning, motion):
                        # The lumped masses have products of inertia, for which a guide has torques across.
                        for name in ("mx", "my", "mz") if not motion else ("mz",):
                            self.assertAlmostEqual(row["constraint_0_" + name], 0, delta=1e-6)
        faster = """angular_velocity = [0, 0, 6]
amplitude = "ramp"
[[amplitude]]
name = "ramp"
points = [[0, 0], [1, 1]]
"""
        for rule in rules[:3] + rules[4:]:
            with self.subTest(rule):
                rows = rows_of(rule, "", faster)
                for before, row in zip(rows, rows[1:]):
                    torque = (row["lz"] - before["lz"]) / row["time_step"]
                    self.assertGreater(torque, 100)
                    self.assertAlmostEqual(row["constraint_0_mz"], torque, delta=1e-6 * torque)

    def test_planes_and_lines(self):
        text = CUBE + tables(initial=dict(velocity=[1, 2, 3]),
                             constraint=[dict(kind="plane", select=plane("z", 0),
                               normal=[0, 0, -5]),
                             dict(kind="line", select={"vertices": [26]}, direction=[1, 1, 0])])
        for integrator in INTEGRATORS:
            with self.subTest(integrator):
                rows = self.simulate(text, f"time.integrator={integrator}")
                self.assert_books_close(rows)
                self.assertLess(max(r["max_constraint_error"] for r in rows), 1e-12)
                fields, points = self.fields("out", "final.vtu")
                moved = fields["displacement"]
                bottom = points[:, 2] == 0
                self.assertLess(abs(moved[bottom][:, 2]).max(), 1e-14)
                self.assertGreater(moved[bottom][:, 0].min(), 0.01)
                self.assertLess(abs(moved[26][2]), 1e-14)
                self.assertAlmostEqual(moved[26][0], moved[26][1], delta=1e-14)
                self.assertGreater(moved[26][0], 0.01)
                self.assertEqual(fields["fixed"].sum(), 10)
        # Onto a plane elsewhere: there from the first moment.
        self.simulate(CUBE + '[[constraint]]\nkind = "plane"\nselect = { vertices = [0] }\n'
                      "normal = [0, 0, 1]\npoint = [0, 0, -0.1]\n")  # fmt: skip
        fields, _ = self.fields("out", "frames", "frame_000000.vtu")
        self.assertLess(abs(fields["displacement"][0] - [0, 0, -0.1]).max(), 1e-7)

    def test_reactions(self):
        """Reactions are what changes the momentum beside the loads; VTU and CSV agree."""
        text = CUBE + tables(output=dict(every=1), environment=dict(kind="gravity"),
                             fix=[dict(select=plane("x", 0))],
                             constraint=[dict(kind="distance", vertices=[2, 26]),
                             dict(kind="plane", select={"vertices": [20]}, normal=[0, 1, 1])],
                             force=[dict(select={"nearest": [1, 1, 0]}, vector=[10, 300, -20])])
        weight = [0, -1000 * 9.81, 0]
        for integrator in INTEGRATORS:
            rows = self.simulate(text, f"time.integrator={integrator}")
            largest = max(abs(r["reaction_y"]) for r in rows)
            self.assertGreater(largest, 100)
            for row in rows:
                name = f"frame_{int(row['step']):06d}.vtu"
                fields, _ = self.fields("out", "frames", name)
                total = fields["reaction_force"].sum(axis=0)
                for value, axis in zip(total, "xyz"):
                    self.assertAlmostEqual(value, row[f"reaction_{axis}"], delta=1e-5 * largest)
                self.assertTrue((fields["reaction_force"][fields["fixed"] == 0] == 0).all())
            with self.subTest(integrator):
                for k in range(1, len(rows)):
                    for axis, g, f in zip("xyz", weight, (10, 300, -20)):
                        change = (rows[k]["p" + axis] - rows[k - 1]["p" + axis]) / 1e-3
                        self.assertAlmostEqual(
                            change, rows[k]["reaction_" + axis] + g + f, delta=1e-3 * largest,
                            msg=f"{axis} in step {k}",
                        )  # fmt: skip
        fields, _ = self.fields("out", "final.vtu")  # double precision
        total = fields["reaction_force"].sum(axis=0)
        for value, axis in zip(total, "xyz"):
            self.assertAlmostEqual(value, rows[-1][f"reaction_{axis}"], delta=1e-10 * largest)

    def test_penalty_against_exact(self):
        """Stiff springs lower the stability limit; exact constraints do not."""
        text = BEAM.replace('"midpoint"', '"verlet"').replace("step = 0.01", "step = 0.003")
        rows = self.simulate(text)
        self.assertEqual(self.messages(), [])
        self.assertEqual(max(r["max_constraint_error"] for r in rows), 0)
        penalty = ('fix.0.mode="penalty"', "fix.0.penalty=1e10", "time.end=0.5")
        self.simulate(text, *penalty, code=1)
        self.assertEqual(len(self.warnings_of()), 1)
        self.assertIn("h_crit", self.warnings_of()[0])
        self.assertIn("penalty", self.warnings_of()[0])
        self.assertIn(self.summary("out")["status"], ("unstable", "failed"))
        # A soft one runs, and its balance closes with the springs' energy in them.
        for integrator in INTEGRATORS:
            with self.subTest(integrator):
                rows = self.simulate(text, penalty[0], "fix.0.penalty=1e5", "time.step=1e-3",
                                     f"time.integrator={integrator}")  # fmt: skip
                largest = self.assert_books_close(rows)
                bound = 1e-2 if integrator in ("explicit", "backward-euler") else 1e-4
                self.assertLess(max(abs(r["energy_error"]) for r in rows), bound * largest)
        # An implicit rule takes the stiff one.
        self.simulate(text, *penalty, "time.integrator=midpoint", "time.step=0.01")


if __name__ == "__main__":
    main()
