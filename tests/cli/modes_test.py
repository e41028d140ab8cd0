"""What `tetraction modes` and `check --spectrum` print and write, and [damping] ratio."""

import csv
import math
import os
import re
import sys
import xml.etree.ElementTree as ElementTree

sys.path.insert(0, f"{sys.path[0]}/..")
from support.program import BEAM_MESH, BEAM_CLAMP, BEAM, BeamTest, main, read_grid
from support.scenes import plane, tables

COLUMNS = ["mode", "frequency", "omega_squared", "effective_mass_x", "effective_mass_y",
           "effective_mass_z", "modal_mass", "kind", "damping_ratio", "growth_rate"]  # fmt: skip


class Modes(BeamTest):
    def rows(self, folder="m"):
        with open(self.path(folder, "modes.csv"), newline="") as file:
            reader = csv.DictReader(file)
            self.assertEqual(reader.fieldnames, COLUMNS)
            return list(reader)

    def test_table_and_files(self):
        result = self.run_program("modes beam.toml -n 4 --out m")
        self.assertIn("frequency [Hz]", result.stdout)
        self.assertEqual(result.stdout.count("elastic"), 4)
        rows = self.rows()
        self.assertEqual([row["mode"] for row in rows], ["1", "2", "3", "4"])
        for row in rows:
            self.assertEqual(row["kind"], "elastic")
            frequency = float(row["frequency"])
            self.assertAlmostEqual((2 * math.pi * frequency) ** 2 / float(row["omega_squared"]), 1)
            self.assertIn(f"{frequency:.7g}", result.stdout)
        # Bending of a square beam in two directions, with most of the mass. On this coarse mesh the
        # two frequencies are a fifth apart.
        first, second = (float(row["frequency"]) for row in rows[:2])
        self.assertAlmostEqual(second / first, 1.0, delta=0.25)
        across = sum(float(r["effective_mass_y"]) + float(r["effective_mass_z"]) for r in rows[:2])
        self.assertGreater(across, 1.2)
        summary = self.read_json("m", "summary.json")
        self.assertEqual(summary["command"], "modes")
        self.assertAlmostEqual(summary["modes"][0]["frequency"], first, places=12)
        self.assertEqual(summary["scene"]["mesh"]["generate"]["cells"], [8, 2, 2])
        self.assertEqual(sorted(os.listdir(self.path("m"))),
                         sorted([f"mode_0{i}.{e}" for i in range(1, 5) for e in ("vtu", "pvd")]
                                + ["modes.csv", "summary.json", "swing"]))  # fmt: skip

        # Fewer modes leave nothing of the former ones.
        quiet = self.run_program("modes beam.toml -n 2 --out m --quiet")
        self.assertEqual(quiet.stdout, "")
        self.assertEqual(len(self.rows()), 2)
        self.assertFalse(os.path.exists(self.path("m", "mode_03.vtu")))
        self.assertEqual(len(os.listdir(self.path("m", "swing"))), 2 * 13)

    def test_shapes_for_paraview(self):
        self.run_program("modes beam.toml -n 1 --out m")
        grid, arrays, _ = read_grid(self.path("m", "mode_01.vtu"))
        self.assertEqual(grid.GetNumberOfCells(), 8 * 2 * 2 * 6)
        lengths = (arrays["mode"] ** 2).sum(axis=1) ** 0.5
        self.assertAlmostEqual(lengths.max(), 1.0, places=12)
        collection = ElementTree.parse(self.path("m", "mode_01.pvd")).findall(".//DataSet")
        self.assertEqual(len(collection), 24)
        period = 1.0 / float(self.rows()[0]["frequency"])
        diagonal = math.sqrt(18.0)
        for k, entry in enumerate(collection):
            self.assertAlmostEqual(float(entry.get("timestep")), period * k / 24, places=12)
            _, found, _ = read_grid(self.path("m", entry.get("file")))
            largest = (found["displacement"] ** 2).sum(axis=1).max() ** 0.5
            expected = 0.05 * diagonal * abs(math.sin(2 * math.pi * k / 24))
            self.assertAlmostEqual(largest, expected, delta=1e-6)
        # The two halves of a period are opposite.
        up = read_grid(self.path("m", collection[6].get("file")))[1]["displacement"]
        down = read_grid(self.path("m", collection[18].get("file")))[1]["displacement"]
        self.assertLess(abs(up + down).max(), 1e-6)

    def test_free_body_and_all_modes(self):
        scene = self.write("free.toml", BEAM.replace("[[fix]]\nselect = { plane = { axis = \"x\", at = 0.0 } }\n", "")
                           .replace("[8, 2, 2]", "[1, 1, 1]"))  # fmt: skip
        result = self.run_program(f"modes {scene} -n 100 --out m")
        rows = self.rows()
        self.assertEqual(len(rows), 24)
        self.assertIn("no more than these 24 modes", result.stdout)
        self.assertEqual([row["kind"] for row in rows[:7]], ["rigid"] * 6 + ["elastic"])
        for row in rows[:6]:
            self.assertEqual(float(row["frequency"]), 0.0)
        for axis in "xyz":
            self.assertAlmostEqual(sum(float(r["effective_mass_" + axis]) for r in rows), 1, places=9)

    def test_equilibrium_under_loads(self):
        # A beam that hangs along gravity is stiffened by its weight in bending.
        scene = self.write("beam.toml", BEAM.replace(
            "[environment]", "[environment]\nstrength = 50.0\ndirection = [1, 0, 0]"))  # fmt: skip
        self.run_program(f"modes {scene} -n 2 --out rest")
        self.run_program(f"modes {scene} -n 2 --out loaded --static")
        rest, loaded = (float(self.rows(f)[0]["frequency"]) for f in ("rest", "loaded"))
        self.assertGreater(loaded, 1.02 * rest)
        arrays = read_grid(self.path("loaded", "mode_01.vtu"))[1]
        self.assertGreater(arrays["displacement"][:, 0].max(), 0.1)
        self.assertNotIn("displacement", read_grid(self.path("rest", "mode_01.vtu"))[1])

    def static_displacements(self, scene):
        """Those of static, and those of the equilibrium whose modes are computed."""
        self.run_program(f"modes {scene} -n 1 --out modes --static")
        self.run_program(f"static {scene} --out static")
        expected = read_grid(self.path("static", "final.vtu"))[1]["displacement"]
        computed = read_grid(self.path("modes", "mode_01.vtu"))[1]["displacement"]
        return expected, computed

    def test_equilibrium_is_that_of_static(self):
        # Consistent weights of gravity matter for few quadratic elements: lumped masses bend a column of
        # two cells sideways by half of its elongation.
        scene = self.write("column.toml", """
[mesh]
generate = { kind = "box", size = [1, 1, 2], cells = [1, 1, 2] }
element = "quadratic"
[material]
model = "neo-hookean"
youngs_modulus = 1e6
poissons_ratio = 0.3
density = 1000
[environment]
kind = "gravity"
[[fix]]
select = { plane = { axis = "z", at = 2.0 } }
[[body_force]]
select = { all = true }
vector = [0, 0, -5e3]
""")
        expected, computed = self.static_displacements(scene)
        self.assertGreater(abs(expected).max(), 1e-2)
        self.assertLess(abs(computed - expected).max(), 1e-6 * abs(expected).max())

    def test_prescribed_displacements_grow_as_in_static(self):
        # Posed at once, the offset would invert elements.
        scene = self.write("cube.toml", """
[mesh]
generate = { kind = "box", size = [1, 1, 1], cells = [2, 2, 2] }
element = "quadratic"
[material]
model = "neo-hookean"
youngs_modulus = 1e6
poissons_ratio = 0.4
density = 1000
[[fix]]
select = { plane = { axis = "z", at = 0.0 } }
[[fix]]
select = { plane = { axis = "z", at = 1.0 } }
offset = [0, 0, -0.3]
""")
        expected, computed = self.static_displacements(scene)
        self.assertLess(abs(computed - expected).max(), 1e-6)

    def test_pressure_with_a_free_rim(self):
        # A pressure on the tip that follows it raises the first frequency; a dead load would lower it.
        scene = self.write("beam.toml", BEAM + tables(pressure=[dict(select=plane("x", 4.0),
                                                        value=5.0e3)]))  # fmt: skip
        gravity = ["--set", "environment.kind=none"]
        self.run_program(f"modes {scene} -n 1 --out rest", *gravity)
        result = self.run_program(f"modes {scene} -n 1 --out loaded --static", *gravity)
        self.assertNotIn("rim", result.stderr)
        rest, loaded = (self.rows(f)[0] for f in ("rest", "loaded"))
        self.assertGreater(float(loaded["frequency"]), 1.001 * float(rest["frequency"]))
        self.assertEqual((loaded["kind"], float(loaded["growth_rate"])), ("elastic", 0.0))

    def test_slender_body(self):
        # The bending of a wire is far below the highest frequency of its mesh, and yet no rigid mode.
        thin = ["--set", "mesh.generate.size=[1, 3e-4, 3e-4]", "--set", "mesh.generate.cells=[20, 1, 1]",
                "--set", 'mesh.element="quadratic"', "--set", "environment.kind=none"]  # fmt: skip
        result = self.run_program("modes beam.toml -n 2 --out m", *thin)
        self.assertNotIn("round-off", result.stderr)
        rows = self.rows()
        self.assertEqual([row["kind"] for row in rows], ["elastic", "elastic"])
        lowest = float(rows[0]["frequency"])
        self.assertAlmostEqual(float(rows[1]["frequency"]) / lowest, 1.0, delta=0.01)
        text = self.run_program("check beam.toml", *thin).stdout
        self.assertIn(f"frequencies: {lowest:.5g} Hz to ", text)
        self.assertNotIn("rigid mode", text)
        # Where nothing of the frequency is left, it is said.
        thinner = [*thin, "--set", "mesh.generate.size=[1, 1e-6, 1e-6]"]
        result = self.run_program("modes beam.toml -n 2 --out m", *thinner)
        self.assertIn("round-off spoils", result.stderr)

    def test_damping_ratios(self):
        plain = self.run_program("modes beam.toml -n 2 --out m")
        self.assertNotIn("damping", plain.stdout)
        self.assertEqual([float(row["damping_ratio"]) for row in self.rows()], [0.0, 0.0])
        damping = ["--set", "damping.mass_damping=0.5"]
        damped = self.run_program("modes beam.toml -n 2 --out m", *damping)
        for row in self.rows():
            ratio = 0.5 / (4 * math.pi * float(row["frequency"]))
            self.assertAlmostEqual(float(row["damping_ratio"]), ratio, places=12)
            self.assertIn(f"{ratio:.4g}", damped.stdout)
        lowest = float(self.rows()[0]["damping_ratio"])
        self.assertIn(f": {lowest:.4g} (tetraction modes", self.run_program("check", "beam.toml", *damping).stdout)
        report = self.json_of("check beam.toml", *damping)
        self.assertAlmostEqual(report["lowest_damping_ratio"], lowest, places=12)

    def test_damping_of_rigid_modes(self):
        # They have no critical damping, and no table has an infinite number.
        free = BEAM.replace(BEAM_CLAMP, "")
        scene = self.write("free.toml", free)
        self.run_program(f"modes {scene} -n 7 --out m --set damping.mass_damping=0.5")
        rows = self.rows()
        self.assertEqual([row["kind"] for row in rows], ["rigid"] * 6 + ["elastic"])
        self.assertEqual([row["damping_ratio"] for row in rows[:6]], [""] * 6)
        self.assertGreater(float(rows[6]["damping_ratio"]), 0.0)
        # Viscosity does not damp them.
        self.run_program(f"modes {scene} -n 6 --out m --set damping.viscosity=100")
        self.assertEqual([row["damping_ratio"] for row in self.rows()], ["0"] * 6)

    def test_refusals(self):
        for count in ("0", "-3", "1001", "many"):
            self.refused(2, "modes beam.toml -n", count)
        self.refused(3, "modes none.toml")
        held = ["--set", "fix.0.select={ all = true }"]
        self.assertIn("every vertex is held", self.refused(2, "modes", "beam.toml", *held, "--out", "m"))
        self.assertFalse(os.path.exists(self.path("m", "modes.csv")))
        self.refused(4, "modes beam.toml --out /dev/null/m")

    def test_results_of_commands_do_not_mix(self):
        self.run_program("modes beam.toml -n 1 --out m")
        self.assertIn("modes", self.refused(2, "run beam.toml --out m"))
        self.assertIn("modes", self.refused(2, "study beam.toml --out m --no-plots"))
        self.run_program("run beam.toml --out r")
        self.assertIn("run", self.refused(2, "modes beam.toml --out r"))
        # The mesh of the scene may be the shape of a mode, but not of one that is written over.
        self.write("shape.toml", BEAM.replace(
            BEAM_MESH,
            'file = "m/mode_01.vtu"'))  # fmt: skip
        self.assertIn("overwritten", self.refused(2, "modes shape.toml --out m"))
        self.run_program("modes shape.toml --out other")


class Spectrum(BeamTest):
    def test_check_says_what_the_step_resolves(self):
        plain = self.run_program("check beam.toml").stdout
        frequency = re.search(r"frequencies: ([\d.]+) Hz to ([\d.]+) Hz", plain)
        self.run_program("modes beam.toml -n 1 --out m")
        lowest = float(self.table("m", "modes.csv")[0]["frequency"])
        self.assertAlmostEqual(float(frequency[1]), lowest, delta=1e-4 * lowest)
        # 2 atan(x/2) (1 + 0.1) = x has the solution x = 1.1525… for midpoint.
        resolved = float(re.search(r"midpoint with this step resolves motion up to ([\d.]+)", plain)[1])
        x = 2 * math.pi * resolved * 0.01
        self.assertAlmostEqual(x / (2 * math.atan(x / 2)), 1.1, delta=2e-3)
        self.assertNotIn("omega h", plain)

        table = self.run_program("check beam.toml --spectrum").stdout
        for rule in ("explicit", "verlet", "midpoint", "backward-euler"):
            self.assertRegex(table, rf"\n{rule} .* Hz\n")
        report = self.json_of("check beam.toml --spectrum")
        rules = {row["integrator"]: row for row in report["spectrum"]["integrators"]}
        x = 2 * math.pi * lowest * 0.01
        self.assertAlmostEqual(rules["midpoint"]["lowest"]["omega_h"], x, places=9)
        self.assertAlmostEqual(rules["midpoint"]["lowest"]["period_error"],
                               x / (2 * math.atan(x / 2)) - 1, places=9)  # fmt: skip
        self.assertAlmostEqual(rules["backward-euler"]["lowest"]["damping_ratio"],
                               0.5 * math.log1p(x * x) / math.atan(x), places=9)  # fmt: skip
        self.assertIs(rules["verlet"]["highest"]["stable"], False)
        self.assertIs(rules["midpoint"]["highest"]["stable"], True)

    def test_bodies_without_elastic_modes(self):
        held = ["--set", "fix.0.select={ all = true }"]
        self.assertNotIn("frequencies", self.run_program("check", "beam.toml", "--spectrum", *held).stdout)


class DampingRatio(BeamTest):
    RATIO = 'damping.ratio={ at = [2, 8], value = [0.02, 0.03] }'

    def test_ratio_becomes_two_numbers(self):
        result = self.run_program("run beam.toml --set", self.RATIO, "--out", "r")
        w1, w2 = 2 * math.pi * 2, 2 * math.pi * 8
        beta = 2 * (0.03 * w2 - 0.02 * w1) / (w2**2 - w1**2)
        mass_damping = 0.04 * w1 - beta * w1**2
        self.assertIn("note: damping.ratio gives mass_damping = ", result.stderr)
        self.assertIn("shear 0.02 and 0.03; bending and tension ", result.stderr)
        echo = self.read_json("r", "summary.json")["scene"]["damping"]
        self.assertAlmostEqual(echo["mass_damping"], mass_damping, places=12)
        self.assertAlmostEqual(echo["viscosity"], beta * 1e6 / 2.8, delta=1e-9)
        self.assertNotIn("ratio", echo)
        # The numbers of the echo give the same run.
        numbers = ["--set", f"damping.mass_damping={echo['mass_damping']!r}",
                   "--set", f"damping.viscosity={echo['viscosity']!r}"]  # fmt: skip
        self.run_program("run beam.toml", *numbers, "--out", "n", "--quiet")
        with open(self.path("r", "history.csv")) as a, open(self.path("n", "history.csv")) as b:
            self.assertEqual(a.read(), b.read())
        self.assertIn("bending and tension", self.run_program("check", "beam.toml", "--set", self.RATIO).stdout)
        quiet = self.run_program("run beam.toml --set", self.RATIO, "--out", "r", "--quiet")
        self.assertNotIn("note:", quiet.stderr)

    def test_events_change_the_ratio(self):
        scene = self.write("beam.toml", BEAM + """
[damping]
ratio = { at = [2, 8], value = [0.02, 0.03] }
[[event]]
at = 0.05
set = { "damping.ratio.value" = [0.0, 0.0] }
""")  # fmt: skip
        self.run_program(f"run {scene} --out r")
        rows = self.history("r", "history.csv")
        self.assertGreater(rows[5]["dissipated_energy"], 0.0)
        self.assertEqual(rows[-1]["dissipated_energy"], rows[5]["dissipated_energy"])

    def test_refusals(self):
        for wrong, said in (
            ("{ at = [2, 8], value = [0.02, 0.09] }", "negative mass_damping"),
            ("{ at = [2, 8], value = [0.09, 0.02] }", "negative viscosity"),
            ("{ at = [2, 2], value = [0.02, 0.02] }", "twice"),
            ("{ at = [2, 8], value = [-0.02, 0.02] }", "from 0 to 100"),
            ("{ at = [0, 8], value = [0.02, 0.02] }", "above 0"),
            ("{ at = [2, 8, 9], value = [0.02, 0.02] }", "3 entries"),
            ("{ at = [2, 8] }", "damping.ratio.value"),
            ("{ at = [2, 8], values = [0.02, 0.02] }", "values"),
            ("0.02", "damping.ratio"),
        ):
            with self.subTest(wrong):
                self.assertIn(said, self.refused(2, "run", "beam.toml", "--set", "damping.ratio=" + wrong))
        for key in ("viscosity", "mass_damping"):
            message = self.refused(2, "run", "beam.toml", "--set", self.RATIO, "--set", f"damping.{key}=1")
            self.assertIn("one key too many", message)
        region = "material_region.0={ select = { all = true }, youngs_modulus = 2e6, poissons_ratio = 0.4 }"
        self.refused(2, "run beam.toml --set", self.RATIO, "--set", region, says="shear moduli")


if __name__ == "__main__":
    main()
