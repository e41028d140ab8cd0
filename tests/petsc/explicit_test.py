"""Explicit rules and steps that adapt, in several processes."""

import os
import sys
import time

sys.path.insert(0, f"{sys.path[0]}/..")
from support.parallel import (BODY, LOADS, OUTPUT, PROBES, PROCESSES, ParallelTest, points_of,
    time_of)
from support.program import DATA, main
from support.scenes import tables


class Explicit(ParallelTest):
    def compare(self, scene, tolerance=1e-12):
        serial, _ = self.run_scene(scene)
        expected, expected_elements = points_of(self.path(serial, "final.vtu"), "displacement")
        size = max(max(abs(x) for x in values[0]) for values in expected.values())
        for processes in PROCESSES:
            with self.subTest(processes=processes):
                out, _ = self.run_scene(scene, processes)
                self.assert_like(serial, out, tolerance)
                found, elements = points_of(self.path(out, "final.pvtu"), "displacement")
                self.assertEqual(elements, expected_elements)
                self.assertEqual(found.keys(), expected.keys())
                for vertex, copies in found.items():
                    for copy in copies:
                        # All processes have the same bits.
                        self.assertEqual(list(copy), list(copies[0]))
                        for a, b in zip(copy, expected[vertex][0]):
                            self.assertLessEqual(abs(a - b), tolerance * size)
                if self.exists(serial, "probes.csv"):
                    self.assert_like(serial, out, tolerance, "probes.csv")
        return serial

    def test_loads_and_probes(self):
        for rule in ("explicit", "verlet"):
            with self.subTest(rule=rule):
                self.compare(self.write(
                    f"{rule}.toml", BODY + LOADS + PROBES + time_of(rule, 2e-4, 100) + OUTPUT))

    def test_damping(self):
        damping = "[damping]\nmass_damping = 3.0\nviscosity = 40.0\ndrag = 0.02\n"
        for rule in ("explicit", "verlet"):
            with self.subTest(rule=rule):
                self.compare(self.write(
                    f"{rule}.toml", BODY + LOADS + damping + time_of(rule, 1e-4, 60) + OUTPUT))

    def test_free_body_in_a_central_field(self):
        self.compare(self.write("orbit.toml", BODY.replace("gravity", "attraction").replace(
            'kind = "attraction"',
            'kind = "attraction"\nstrength = 0.02\nsoftening = 0.05') +
            "[initial]\nvelocity = [0.3, 0.2, 0.0]\nangular_velocity = [0.0, 3.0, 5.0]\n"
            "stretch = [1.05, 1.0, 0.97]\n" + time_of("verlet", 2e-4, 100) + OUTPUT))

    def test_mesh_file_with_groups(self):
        self.compare(self.write("fork.toml", f"""
[mesh]
file = "{os.path.join(DATA, "tuning_fork.msh")}"
unit = "mm"
[material]
model = "stvk"
youngs_modulus = 2.0e9
poissons_ratio = 0.3
density = 7800.0
[damping]
mass_damping = 10.0
[[fix]]
select = {{ group = "stem" }}
[[traction]]
select = {{ group = "left" }}
vector = [2000.0, 0.0, 0.0]
[[force]]
select = {{ group = "right" }}
total = [-0.02, 0.0, 0.01]
[[body_force]]
select = {{ group = "body" }}
acceleration = [0.0, 0.0, -20.0]
""" + time_of("verlet", 1e-7, 100) + OUTPUT))

    def test_events(self):
        events = """
[[event]]
at = 0.005
set = { "damping.mass_damping" = 2.0, "material.youngs_modulus" = 8.0e5 }
[[event]]
at = 0.008
force = { select = { nearest = [0.4, 0.0, 0.0] }, vector = [0.0, 0.3, 0.0] }
[[event]]
at = 0.01
unfix = { select = { plane = { axis = "x", at = 0.0 } } }
"""
        self.compare(self.write("events.toml",
                                BODY + LOADS + events + time_of("verlet", 2e-4, 100) + OUTPUT))

    def test_automatic_step_is_stable(self):
        scene = self.write("auto.toml", BODY + LOADS + tables(time=dict(integrator="verlet",
                                                                step="auto", end=0.01)) + OUTPUT)
        serial, _ = self.run_scene(scene)
        expected = self.summary(serial)
        for processes in PROCESSES:
            out, _ = self.run_scene(scene, processes)
            summary = self.summary(out)
            # Both estimates of the stability limit have the tolerance 1e-4 of their iterations.
            self.assertAlmostEqual(summary["stable_step"] / expected["stable_step"], 1.0, delta=1e-3)
            self.assertAlmostEqual(summary["time_steps"]["smallest"] /
                                   expected["time_steps"]["smallest"], 1.0, delta=1e-2)
            self.assertEqual(summary["processes"], processes)
            for key in ("vertices", "tetrahedra"):
                self.assertEqual(summary["mesh"][key], expected["mesh"][key])
            self.assertEqual(summary["degrees_of_freedom"], expected["degrees_of_freedom"])


class AdaptiveSteps(ParallelTest):
    def compare(self, scene, tolerance, control):
        serial, _ = self.run_scene(scene)
        self.assertGreater(control(self.summary(serial)), 0)
        for processes in (2, 3):
            with self.subTest(processes=processes):
                out, _ = self.run_scene(scene, processes)
                self.assert_like(serial, out, tolerance)
                self.assertEqual(control(self.summary(out)), control(self.summary(serial)))

    def test_adapt_to_an_error(self):
        # The steps of verlet are far below the stability limit, which parts find in iterations of their own. The
        # estimated error is a difference of positions, so that their round-off changes it by 1e-7 of its size.
        for rule, largest_error, tolerance in (("verlet", 1e-9, 1e-5), ("midpoint", 1e-5, 1e-6)):
            with self.subTest(rule=rule):
                time = f"""
[time]
integrator = "{rule}"
adapt = "error"
tolerance = {largest_error}
step = 1e-4
end = 0.02
[solver]
tolerance = 1e-11
"""
                scene = self.write(f"{rule}.toml", BODY + LOADS + time + OUTPUT)
                self.compare(scene, tolerance, lambda summary: summary["steps"])

    def test_adapt_to_the_energy(self):
        time = tables(time=dict(integrator="midpoint", adapt="energy", step=2e-3, end=0.03),
                      initial=dict(stretch=[1.3, 0.9, 0.95], angular_velocity=[0.0, 0.0, 20.0]),
                      solver=dict(tolerance=1e-11))
        self.compare(self.write("energy.toml", BODY + time + OUTPUT), 1e-6,
                     lambda summary: summary["steps"])

    def test_retry(self):
        """A sudden load that the steps do not resolve."""
        for rule, tolerance in (("verlet", 1e-9), ("midpoint", 1e-6)):
            with self.subTest(rule=rule):
                time = f"""
[[force]]
select = {{ plane = {{ axis = "x", at = 0.4 }} }}
total = [-1.0e5, 0.0, 0.0]
from = 0.002
until = 0.0024
[time]
integrator = "{rule}"
step = 2e-4
end = 0.004
retry = 6
[solver]
tolerance = 1e-11
"""
                self.compare(self.write(f"retry_{rule}.toml", BODY + time + OUTPUT), tolerance,
                             lambda summary: summary["time_steps"]["retried"])


if __name__ == "__main__":
    main(3)
