"""Regions, environments and damping."""

import os
import sys

sys.path.insert(0, f"{sys.path[0]}/..")
from support.mechanics import SceneTest
from support.program import BEAM, CUBE, INTEGRATORS, main, own_lines
from support.scenes import tables


class Environments(SceneTest):
    """Regions of materials, attraction and damping."""

    def test_region_energies_sum_to_the_totals(self):
        text = BEAM + """
[[material_region]]
select = { box = { min = [2, 0, 0], max = [4, 1, 1] } }
model = "stvk"
youngs_modulus = 1e7
poissons_ratio = 0.3
density = 500
[[material_region]]
select = { box = { min = [0, 0, 0], max = [0.5, 1, 1] } }
youngs_modulus = 1e5
poissons_ratio = 0.3
[[event]]
at = 0.05
set = { "material_region.0.youngs_modulus" = 2e7 }
"""
        rows = self.simulate(text)
        self.assertEqual(
            list(rows[0])[22:],
            ["time_step", "inverted_elements", "kinetic_energy_0", "elastic_energy_0",
             "kinetic_energy_1", "elastic_energy_1", "kinetic_energy_2", "elastic_energy_2"],
        )  # fmt: skip
        for row in rows:
            for kind in ("kinetic_energy", "elastic_energy"):
                parts = [row[f"{kind}_{r}"] for r in range(3)]
                self.assertAlmostEqual(sum(parts), row[kind], delta=1e-12 * max(row[kind], 1e-9))
                if row["step"] > 1:
                    self.assertGreater(min(parts), 0)
        self.assert_books_close(rows)
        summary = self.summary("out")
        self.assertAlmostEqual(summary["mass"], 3000, delta=1e-9)
        event = summary["events"][0]
        self.assertAlmostEqual(
            event["energy_jump"], rows[5]["elastic_energy_1"], delta=1e-9 * event["energy_jump"]
        )
        region = self.fields("out", "final.vtu")[0]["region"]
        self.assertEqual([(region == r).sum() for r in range(3)], [72, 96, 24])
        # A region that selects no element is an error.
        nowhere = "material_region.0.select={box={min=[9,9,9],max=[9,9,9]}}"
        self.refused_scene(text, nowhere, says="material_region.0")
        # What mass appears from nowhere is refused, in an event too.
        self.refused_scene(text, 'event.0.set={"material_region.1.density"=10}', says="density")

    def falling_body(self):
        """A tetrahedron on the x axis, one vertex towards the origin."""
        self.write("fall.node", "4 3 0 0\n0 1 0 0\n1 2 1 0\n2 2 -0.5 0.8660254037844386\n"
                   "3 2 -0.5 -0.8660254037844386\n")  # fmt: skip
        self.write("fall.ele", "1 4 0\n0 0 1 2 3\n")
        return tables(mesh=dict(file="fall.node"),
                      material=dict(youngs_modulus=1e6, poissons_ratio=0.3),
                      time=dict(step=1e-3, end=2), output=dict(every=1000),
                      environment=dict(kind="attraction", strength=1e3))

    def test_attraction_through_the_origin(self):
        text = self.falling_body()
        for integrator in INTEGRATORS:
            for step in ("1e-3", "3e-3"):
                with self.subTest(integrator, step=step):
                    overrides = (f"time.integrator={integrator}", f"time.step={step}")
                    rows = self.simulate(text, *overrides, code=(0, 1))
                    result = self.result
                    self.assert_books_close(rows)
                    # It does reach the centre, and says so when that is the end of it.
                    self.assertGreater(rows[-1]["kinetic_energy"], 100)
                    if result.returncode == 1:
                        lines = [l for l in result.stderr.splitlines() if "warning" not in l]
                        self.assertEqual(len(lines), 1)
                        for part in ("centre of attraction", "environment.softening", "step "):
                            self.assertIn(part, lines[0])
                        self.assertIn(self.summary("out")["status"], ("unstable", "failed"))
                    soft = self.simulate(text, *overrides, "environment.softening=0.5", out="soft")
                    largest = self.assert_books_close(soft)
                    self.assertAlmostEqual(soft[-1]["time"], 2, delta=float(step))
                    if integrator in ("verlet", "midpoint"):
                        self.assertLess(abs(soft[-1]["energy_error"]), 1e-2 * largest)

    def test_attraction_with_a_vertex_at_the_origin(self):
        """The energy has no bound from the start."""
        text = CUBE + '[environment]\nkind = "attraction"\nstrength = 1e3\n'
        for integrator in INTEGRATORS:
            self.simulate(text, f"time.integrator={integrator}", code=1)
            errors = [l for l in self.messages() if "warning" not in l]
            self.assertEqual(len(errors), 1)
            self.assertIn("environment.softening", errors[0])
        self.assert_books_close(self.simulate(text, "environment.softening=0.5"))

    def test_attraction_that_overflows(self):
        """What is not finite at the start is refused, or ends the run; it is never written."""
        self.write("scene.toml", CUBE)
        result = self.run_program(
            "run scene.toml --out out --quiet --set",
            'environment={kind="attraction",strength=1e300,softening=1e-200}', code=(1, 2))  # fmt: skip
        self.assertEqual(len([l for l in result.stderr.splitlines() if "warning" not in l]), 1)
        if os.path.exists(self.path("out", "history.csv")):
            self.finite_history()

    def test_more_steps_than_can_be_counted(self):
        for override in ("time.step=1e-300", "time.step=1e-22", "time.end=1e300"):
            with self.subTest(override):
                message = self.refused_scene(CUBE, override)
                self.assertIn("time.step", message)
                self.assertNotIn("less than half", message)
        for setting in ('"time.step" = 1e-300', '"time.end" = 1e300'):
            with self.subTest(setting):  # not a run that ends well at 0.01 s
                text = CUBE + f"[[event]]\nat = 0.01\nset = {{ {setting} }}\n"
                self.write("scene.toml", text)
                result = self.run_program("run scene.toml --out out --quiet", code=(1, 2))
                self.assertEqual(len(own_lines(result.stderr)), 1)
                self.assertIn("event", result.stderr)

    def test_damping(self):
        spin = "[initial]\nstretch = [1.1, 1, 1]\nangular_velocity = [0, 0, 3]\n"
        for key, value in (("drag", 5), ("mass_damping", 20), ("viscosity", 200)):
            for integrator in INTEGRATORS:
                with self.subTest(key, integrator=integrator):
                    rows = self.simulate(CUBE + spin, f"damping.{key}={value}",
                                         f"time.integrator={integrator}")  # fmt: skip
                    largest = self.assert_books_close(rows)
                    losses = [r["dissipated_energy"] for r in rows]
                    self.assertEqual(losses, sorted(losses))
                    self.assertGreater(losses[-1], 1e-3 * largest)
                    if key != "viscosity":
                        self.assertLess(rows[-1]["lz"], 0.999 * rows[0]["lz"])
                    elif integrator != "backward-euler":  # internal: takes no momentum away
                        self.assertAlmostEqual(rows[-1]["lz"], rows[0]["lz"],
                                               delta=1e-9 * rows[0]["lz"])  # fmt: skip


if __name__ == "__main__":
    main()
