"""Implicit rules in several processes."""

import os
import sys

sys.path.insert(0, f"{sys.path[0]}/..")
from support.parallel import (BODY, LOADS, OUTPUT, PROBES, PROCESSES, ParallelTest, points_of,
    symmetric_column, time_of)
from support.program import main
from support.scenes import plane, tables


class Implicit(ParallelTest):
    def assert_ends_like(self, expected, column, delta, scene, *cases):
        """The last value of a column, with numbers of processes and linear solvers. Returns the folders."""
        outs = []
        for processes, linear in cases:
            with self.subTest(processes=processes, linear=linear):
                out, _ = self.run_scene(scene, processes, "--set", f'solver.linear="{linear}"',
                                        out=self.path(f"{linear}{processes}"))
                outs.append(out)
                self.assertAlmostEqual(self.last_value(out, column) / expected, 1.0, delta=delta)
        return outs

    def test_rules_to_the_tolerance(self):
        for rule in ("midpoint", "backward-euler"):
            scene = self.write(f"{rule}.toml", BODY + LOADS + PROBES + time_of(rule, 2e-3, 10) +
                               "[solver]\ntolerance = 1e-10\n" + OUTPUT)
            serial, _ = self.run_scene(scene)
            for processes in PROCESSES:
                with self.subTest(rule=rule, processes=processes):
                    out, _ = self.run_scene(scene, processes)
                    # Ten steps that are each solved to 1e-10 of their forces.
                    self.assert_like(serial, out, 1e-8)

    def test_damping_and_linear_solvers(self):
        damping = "[damping]\nmass_damping = 3.0\nviscosity = 40.0\n"
        scene = self.write("damped.toml", BODY + LOADS + damping + time_of("midpoint", 2e-3, 8) +
                           "[solver]\ntolerance = 1e-10\n" + OUTPUT)
        serial, _ = self.run_scene(scene)
        for linear in ("auto", "matrix-free", "cg", "factor"):
            with self.subTest(linear=linear):
                out, _ = self.run_scene(scene, 2, "--set", f'solver.linear="{linear}"')
                self.assert_like(serial, out, 1e-8)

    def test_auto_changes_to_a_factor(self):
        """A column that bends under a dead load in steps that meet negative curvature many times."""
        self.write("column.msh", symmetric_column(20))
        scene = self.write("dead_load.toml", tables(mesh=dict(file="column.msh"),
                                                    material=dict(youngs_modulus=1.0e5,
                                                      poissons_ratio=0.3),
                                                    fix=[dict(select=plane("x", 0.0))],
                                                    force=[dict(select=plane("x", 20.0),
                                                      total=[-1000.0, 0.0, 0.0], amplitude="ramp")],
                                                    amplitude=[dict(name="ramp",
                                                      points=[[0.0, 0.0], [20.0, 1.0]])],
                                                    solver=dict(max_iterations=400))
                                             + time_of("backward-euler", 10.0, 6) + OUTPUT)

        elastic = self.last_value(self.run_scene(scene)[0], "elastic_energy")
        self.assertGreater(elastic, 5e3)  # 100 J where it stays straight
        outs = self.assert_ends_like(elastic, "elastic_energy", 1e-4, scene, (1, "auto"), (3, "auto"),
                                     (1, "factor"), (3, "factor"))
        for out in outs:
            self.assertGreater(self.summary(out)["solver"]["factorizations"], 0)

    def test_crushed_beam(self):
        """Steps that meet negative curvature in much deformed elements many times."""
        scene = self.write("crushed.toml", """
[mesh]
generate = { kind = "beam", size = [4, 1, 1], cells = [8, 2, 2] }
[material]
youngs_modulus = 1.0e6
poissons_ratio = 0.4
[[fix]]
select = { plane = { axis = "x", at = 0.0 } }
[[force]]
select = { plane = { axis = "x", at = 4.0 } }
total = [-2.0e7, 0.0, 0.0]
""" + time_of("backward-euler", 0.1, 3) + OUTPUT)
        serial = self.last_value(self.run_scene(scene)[0], "total_energy")
        self.assert_ends_like(serial, "total_energy", 1e-4, scene, (2, "auto"), (1, "factor"), (3, "factor"))

    def test_free_body_under_a_large_load(self):
        """Steps that meet negative curvature end where one process ends them."""
        scene = self.write("free.toml", """
[mesh]
generate = { kind = "beam", size = [2.5, 1.0, 1.0], cells = [6, 2, 2] }
[material]
model = "mooney-rivlin"
youngs_modulus = 1.6e5
poissons_ratio = 0.45
ratio = 0.2
[[force]]
select = { plane = { axis = "x", at = 2.5 } }
total = [-900.0, 40.0, 4.0]
""" + time_of("backward-euler", 3.3, 8) + OUTPUT)

        serial = self.last_value(self.run_scene(scene)[0], "total_energy")
        self.assert_ends_like(serial, "total_energy", 1e-5, scene, (1, "factor"), (3, "factor"), (3, "cg"))

    def test_one_process_of_the_engine_is_the_same_run(self):
        scene = self.write("same.toml", BODY + LOADS + time_of("midpoint", 2e-3, 8) + OUTPUT)
        serial, _ = self.run_scene(scene)
        out, _ = self.run_scene(scene, 1)
        rows, own_rows = self.history(serial, "history.csv"), self.history(out, "history.csv")
        for column in ("iterations", "elastic_energy", "px", "lz"):
            self.assertEqual([row[column] for row in rows], [row[column] for row in own_rows], column)

    def test_copies_have_the_same_bits(self):
        """So have repeated runs with the same parts."""
        scene = self.write("bits.toml", BODY + LOADS + time_of("backward-euler", 5e-3, 5) + OUTPUT)
        out, _ = self.run_scene(scene, 3)
        again, _ = self.run_scene(scene, 3, out=self.path("again"))
        first, _ = points_of(self.path(out, "final.pvtu"), "displacement")
        second, _ = points_of(self.path(again, "final.pvtu"), "displacement")
        self.assertGreater(max(len(copies) for copies in first.values()), 1)
        for copies in [*first.values(), *second.values()]:
            self.assertEqual(len({tuple(copy) for copy in copies}), 1)
        shared = [{v for v, copies in points.items() if len(copies) > 1} for points in (first, second)]
        if shared[0] == shared[1]:
            for vertex, copies in first.items():
                self.assertEqual(tuple(copies[0]), tuple(second[vertex][0]))

    def test_coarse_space_of_all_parts(self):
        """A long beam with large steps needs hundreds of iterations without a coarse space."""
        scene = self.write(
            "long.toml",
            BODY.replace("[0.4, 0.1, 0.1]", "[4.0, 0.1, 0.1]").replace("[8, 3, 3]", "[80, 2, 2]") +
            '[[fix]]\nselect = { plane = { axis = "x", at = 0.0 } }\n' +
            time_of("backward-euler", 0.05, 10) + '[solver]\nlinear = "matrix-free"\n' + OUTPUT)

        def iterations(out):
            return self.summary(out)["solver"]["cg_iterations"]

        serial = iterations(self.run_scene(scene)[0])
        for processes in (2, 4):
            with self.subTest(processes=processes):
                own = iterations(self.run_scene(scene, processes)[0])
                self.assertLess(own, 1.5 * serial)

    def test_saddle_points_are_left(self):
        """A symmetric column under its buckling load does not move sideways by itself."""
        self.write("column.msh", symmetric_column(20))
        scene = self.write("column.toml", tables(mesh=dict(file="column.msh"),
                                                 material=dict(model="neo-hookean",
                                                   youngs_modulus=1.0e6, poissons_ratio=0.3,
                                                   density=1000.0),
                                                 fix=[dict(select=plane("x", 0.0)),
                                                 dict(select=plane("x", 20.0),
                                                   velocity=[-0.5, 0.0, 0.0])],
                                                 time=dict(integrator="backward-euler", step=0.5,
                                                   end=4.0), output=dict(every=8)))
        for processes, linear in ((None, "auto"), (2, "auto"), (3, "auto"), (1, "factor"), (3, "factor"),
                                  (1, "cg"), (3, "cg")):
            with self.subTest(processes=processes, linear=linear):
                out, _ = self.run_scene(scene, processes, "--set", f'solver.linear="{linear}"')
                final = os.path.join(out, "final.vtu" if processes is None else "final.pvtu")
                moved, _ = points_of(final, "displacement")
                sideways = max(max(abs(x[1]), abs(x[2])) for copies in moved.values() for x in copies)
                self.assertGreater(sideways, 1.0)


if __name__ == "__main__":
    main(3)
