"""The same problem in other units: every command must find the same dimensionless numbers.

Lengths are times L, moduli times E, the density is D; then times are times L √(D/E). Small and stiff bodies
have frequencies of 10¹² Hz, large and soft ones of 10⁻¹¹ Hz."""

import json
import math
import sys

sys.path.insert(0, f"{sys.path[0]}/..")
from support.program import ProgramTest, main

RULES = ("explicit", "verlet", "midpoint", "backward-euler", "energy-momentum")


class Units:
    """Units of the mechanics in SI units."""

    def __init__(self, length, stress, density):
        self.length, self.stress, self.density = length, stress, density
        self.time = length * math.sqrt(density / stress)
        self.force = stress * length**2
        self.energy = stress * length**3
        self.mass = density * length**3
        self.momentum = self.mass * length / self.time

    def __repr__(self):
        return f"{self.length:g} m, {self.stress:g} Pa, {self.density:g} kg/m³"


METRE = Units(1.0, 1e6, 1000.0)
OTHERS = [
    Units(1e-6, 1e12, 2330.0),
    Units(1e-6, 1e-10, 1000.0),
    Units(1e-3, 2.1e11, 7850.0),
    Units(1e3, 1e12, 1000.0),
    Units(1e3, 1e-10, 3.7),
]

CLAMPED_BEAM = """
[mesh]
generate = {{ kind = "box", size = [{l4!r}, {l!r}, {l!r}], cells = [4, 1, 1] }}
element = "quadratic"
[material]
model = "neo-hookean"
youngs_modulus = {e!r}
poissons_ratio = 0.3
density = {d!r}
[time]
integrator = "midpoint"
step = {step!r}
end = {end!r}
[solver]
tolerance = 1e-12
[damping]
viscosity = {viscosity!r}
mass_damping = {mass_damping!r}
[environment]
kind = "gravity"
strength = {gravity!r}
direction = [0, -1, 0.3]
[[fix]]
select = {{ plane = {{ axis = "x", at = 0.0 }} }}
[[traction]]
select = {{ plane = {{ axis = "z", at = {l!r} }} }}
vector = [0, {p2!r}, {p1!r}]
[[pressure]]
select = {{ plane = {{ axis = "y", at = {l!r} }} }}
value = {p5!r}
[output]
every = 1000
"""
# A rod along an edge, and a stiff plate at the free end.
MULTIPLIERS = """
[[constraint]]
kind = "distance"
vertices = [5, 3]
[[constraint]]
kind = "rigid"
select = {{ plane = {{ axis = "x", at = {l4!r} }} }}
"""


def scene_in(units, text):
    u = units
    return text.format(l=u.length, l4=4 * u.length, e=u.stress, d=u.density, step=0.05 * u.time,
                       end=0.5 * u.time, viscosity=0.03 * u.stress * u.time,
                       mass_damping=0.02 / u.time, gravity=1e-3 * u.stress / (u.density * u.length),
                       p1=1e-3 * u.stress, p2=2e-3 * u.stress, p5=5e-3 * u.stress)  # fmt: skip


def column_unit(name, u):
    """The unit of a column of history.csv."""
    if name.endswith("energy") or name.endswith("work") or name == "energy_error":
        return u.energy
    if name.startswith("reaction"):
        return u.force
    units = {"time": u.time, "time_step": u.time, "max_displacement": u.length,
             "max_constraint_error": u.length}  # fmt: skip
    for axis in "xyz":
        units["p" + axis] = u.momentum
        units["l" + axis] = u.momentum * u.length
    return units[name]


class SameProblem(ProgramTest):
    def scene(self, units, more=""):
        return self.write("scene.toml", scene_in(units, CLAMPED_BEAM + more))

    def expect_same(self, expected, found, tolerance, message):
        """Both are {name: list}; the largest entry of a list is the measure of its errors."""
        self.assertEqual(list(expected), list(found), message)
        for name, values in expected.items():
            self.assertEqual(len(values), len(found[name]), f"{message}: {name}")
            size = max(abs(v) for v in values)
            for a, b in zip(values, found[name]):
                self.assertLessEqual(abs(a - b), tolerance * size, f"{message}: {name}: {a} and {b}")

    def columns(self, path, units, is_static=False):
        columns = {}
        for row in self.history(*path):
            for name, value in row.items():
                # The iterations may differ by one; these three are round-off.
                if name in ("step", "iterations", "energy_error", "max_constraint_error", "residual"):
                    continue
                if name.startswith("constraint_"):
                    continue
                # In load steps it is a factor.
                is_factor = is_static and name in ("time", "time_step")
                unit = 1.0 if is_factor else column_unit(name, units)
                columns.setdefault(name, []).append(value / unit)
        # Together they have a size, single ones may be zero.
        for name in ("p", "l", "reaction_"):
            parts = [columns.pop(name + axis) for axis in "xyz" if name + axis in columns]
            if parts:
                columns[name] = sum(parts, [])
        return columns

    def everywhere(self, tolerance, compute):
        expected = compute(METRE)
        for units in OTHERS:
            with self.subTest(units=units):
                self.expect_same(expected, compute(units), tolerance, str(units))
        return expected

    def test_run(self):
        for more in ("", MULTIPLIERS):
            for rule in RULES:

                def compute(units):
                    scene = self.scene(units, more)
                    step = 0.05 if rule not in ("explicit", "verlet") else 0.01
                    self.run_program(
                        "run", scene, "--out", "r", "--set", f'time.integrator="{rule}"',
                        "--set", f"time.step={step * units.time!r}")  # fmt: skip
                    return self.columns(("r", "history.csv"), units)

                with self.subTest(rule=rule, multipliers=bool(more)):
                    found = self.everywhere(1e-7, compute)
                    self.assertGreater(found["elastic_energy"][-1], 1e-5)

    def test_static(self):
        for more in ("", MULTIPLIERS):

            def compute(units):
                self.run_program("static", self.scene(units, more), "--out", "s", "--steps", "2")
                summary = self.read_json("s", "summary.json")
                self.assertIsNone(summary["equilibrium"]["loss_of_stability"])
                self.assertEqual(summary["equilibrium"]["limit_points"], [])
                return self.columns(("s", "history.csv"), units, is_static=True)

            with self.subTest(multipliers=bool(more)):
                found = self.everywhere(1e-7, compute)
                self.assertGreater(found["max_displacement"][-1], 0.1)

    def test_modes(self):
        for more in ("", MULTIPLIERS):
            for loaded in ([], ["--static"]):

                def compute(units):
                    self.run_program("modes", self.scene(units, more), "-n", "6", "--out", "m", *loaded)
                    rows = self.table("m", "modes.csv")
                    scales = {"frequency": 1 / units.time, "omega_squared": 1 / units.time**2,
                              "effective_mass_x": 1, "effective_mass_y": 1, "effective_mass_z": 1,
                              "modal_mass": units.mass, "damping_ratio": 1,
                              "growth_rate": 1 / units.time}  # fmt: skip
                    columns = {name: [float(row[name]) / scale for row in rows]
                               for name, scale in scales.items()}  # fmt: skip
                    columns["kind"] = [float(row["kind"] == "elastic") for row in rows]
                    return columns

                with self.subTest(multipliers=bool(more), loaded=loaded):
                    found = self.everywhere(1e-6, compute)
                    self.assertEqual(found["kind"], [1.0] * 6)
                    self.assertGreater(min(found["damping_ratio"]), 1e-3)

    def test_check(self):
        for more in ("", MULTIPLIERS):

            def compute(units):
                result = self.run_program("check", self.scene(units, more), "--json", "--spectrum")
                report = json.loads(result.stdout)
                scales = {"mass": units.mass, "wave_speed": units.length / units.time,
                          "wave_time": units.time, "omega_max": 1 / units.time,
                          "stable_step": units.time, "lowest_frequency": 1 / units.time,
                          "highest_frequency": 1 / units.time, "lowest_damping_ratio": 1,
                          "free_degrees_of_freedom": 1, "multipliers": 1}  # fmt: skip
                columns = {name: [report[name] / scale] for name, scale in scales.items()}
                columns["size"] = [x / units.length for x in report["size"]]
                return columns

            with self.subTest(multipliers=bool(more)):
                self.everywhere(1e-6, compute)  # h_crit is found by iterations

    def test_study(self):
        def compute(units):
            steps = ",".join(repr(h * units.time) for h in (0.1, 0.05))
            self.run_program(
                "study", self.scene(units), "--out", "st", "--integrators", "midpoint,backward-euler",
                "--steps", steps, "--reference-step", repr(0.0125 * units.time), "--no-plots")  # fmt: skip
            rows = self.table("st", "study.csv")
            scales = {"step": units.time, "position_error": 1, "position_error_rms": 1,
                      "max_relative_energy_drift": 1}  # fmt: skip
            columns = {name: [float(row[name]) / scale for row in rows] for name, scale in scales.items()}
            columns["observed_order"] = [float(row["observed_order"] or 0) for row in rows]
            columns["ok"] = [float(row["status"] == "ok") for row in rows]
            return columns

        found = self.everywhere(1e-5, compute)
        self.assertEqual(set(found["ok"]), {1.0})


class Flutter(ProgramTest):
    # The column of Beck flutters under more than 20.05 EI/L² (ZAMP 3, 1952), in any units.
    COLUMN = """
[mesh]
generate = {{ kind = "box", size = [{l!r}, {t!r}, {t!r}], cells = [8, 1, 1] }}
element = "quadratic"
[material]
model = "neo-hookean"
youngs_modulus = {e!r}
poissons_ratio = 0.0
density = {d!r}
[damping]
mass_damping = {damping!r}
[[fix]]
select = {{ plane = {{ axis = "x", at = 0.0 }} }}
[[pressure]]
select = {{ plane = {{ axis = "x", at = {l!r} }} }}
value = {p!r}
"""

    def test_column_of_beck(self):
        thickness = 0.05
        for units in [METRE, Units(20e-6, 1.6e11, 2330.0), *OTHERS]:
            for share, flutters in ((0.9, False), (1.25, True)):
                with self.subTest(units=units, share=share):
                    pressure = share * 20.0509 * thickness**2 / 12 * units.stress
                    scene = self.write("column.toml", self.COLUMN.format(
                        l=units.length, t=thickness * units.length, e=units.stress, d=units.density,
                        damping=1e-3 / units.time, p=pressure))  # fmt: skip
                    self.run_program(f"static {scene} --out s --quiet")
                    loss = self.read_json("s", "summary.json")["equilibrium"]["loss_of_stability"]
                    if not flutters:
                        self.assertIsNone(loss)
                        continue
                    self.assertTrue(loss["flutter"])
                    self.assertAlmostEqual(share * loss["below"], 1.0, delta=0.02)


if __name__ == "__main__":
    main()
