"""`tetraction static` and runs that start at an equilibrium."""

import re
import sys

sys.path.insert(0, f"{sys.path[0]}/..")
from support.program import BEAM, BeamTest, main, own_lines
from support.scenes import plane, tables

# A tetrahedron of 1/6 m³ with one degree of freedom, of a law that has a largest force.
TORN = tables(mesh=dict(generate={"kind": "tetrahedron", "size": 1.0}),
              material=dict(model="yeoh", c10=1.0e5, c20=-1.0e5, c30=0.0, kappa=3.0e5),
              fix=[dict(select=plane("x", 0.0)), dict(select={"all": True}, components="yz")],
              force=[dict(select={"vertices": [1]}, vector=[1.0e5, 0, 0])])


class Static(BeamTest):
    def test_equilibrium_of_a_beam(self):
        result = self.run_program("static beam.toml --out s --steps 4")
        for words in ("4 load steps to load factor 1", "largest displacement:", "sum (", "residual"):
            self.assertIn(words, result.stdout)
        rows = self.history("s", "history.csv")
        self.assertEqual([row["time"] for row in rows], [0, 0.25, 0.5, 0.75, 1])
        self.assertEqual(rows[0]["max_displacement"], 0)
        self.assertNotIn("kinetic_energy", rows[0])
        for row in rows:
            weight = 9.81 * 4000 * row["time"]
            self.assertAlmostEqual(row["reaction_y"], weight, delta=1e-9 * 39240)
            self.assertEqual(row["max_constraint_error"], 0)
            self.assertAlmostEqual(
                row["total_energy"], row["elastic_energy"] + row["environment_energy"], delta=1e-6
            )
        falls = [row["max_displacement"] for row in rows]
        self.assertEqual(falls, sorted(falls))
        summary = self.read_json("s", "summary.json")
        self.assertEqual(summary["status"], "ok")
        self.assertEqual(summary["steps"], 4)
        self.assertEqual(summary["equilibrium"]["load_factor"], 1)
        self.assertEqual(summary["equilibrium"]["max_displacement"], falls[-1])
        self.assertEqual(summary["equilibrium"]["limit_points"], [])
        self.assertNotIn("stable_step", summary)
        # Frames have the load factor as their time: the first, every fourth and the last.
        times = [float(t) for t in re.findall('timestep="([^"]*)"', self.read("s", "frames.pvd"))]
        self.assertEqual(times, [0, 1])
        self.assertTrue(self.exists("s", "final.vtu"))
        # One step leads to the same equilibrium.
        self.run_program("static beam.toml --out s --quiet")
        rows = self.history("s", "history.csv")
        self.assertEqual(len(rows), 2)
        self.assertAlmostEqual(rows[1]["max_displacement"], falls[-1], delta=1e-9)

    def test_the_folder_of_a_study_is_refused(self):
        self.write("study.json", "{}")
        self.assertIn("study", self.refused(2, "static beam.toml --out ."))

    def test_free_motions_are_named(self):
        scene = self.write("free.toml", BEAM[: BEAM.index("[[fix]]")])
        message = self.refused(2, f"static {scene} --out s")
        self.assertIn("the body can still move along x, move along y, move along z, rotate about x, "
                      "rotate about y and rotate about z.", message)  # fmt: skip
        message = self.refused(2, f"run {scene} --out s --set initial.static=true")
        self.assertIn("the body can still move along x", message)

    def test_no_equilibrium_beyond_a_limit_point(self):
        scene = self.write("torn.toml", TORN)
        result = self.run_program(f"static {scene} --out s --quiet", code=1)
        message = "\n".join(own_lines(result.stderr))

        def energy(stretch):
            x = stretch ** (-2 / 3) * (stretch**2 + 2) - 3
            return 1e5 * x - 1e5 * x**2 + 1.5e5 * (stretch - 1) ** 2

        stretches = [1 + 1e-3 * i for i in range(1, 1500)]
        factor = max(energy(s + 5e-4) - energy(s - 5e-4) for s in stretches) / 1e-3 / 6 / 1e5
        found = re.search(r"limit point near load factor ([\d.]+) \(between [\d.]+ and [\d.]+\)", message)
        self.assertIsNotNone(found, message)
        self.assertAlmostEqual(float(found[1]), factor, delta=1e-3)
        self.assertIn("the body buckles or snaps through", message)
        self.assertIn("no equilibrium was found beyond load factor", message)
        summary = self.read_json("s", "summary.json")
        self.assertEqual((summary["status"], summary["exit_status"]), ("failed", 1))
        self.assertFalse(summary["equilibrium"]["limit_points"][0]["passed"])
        self.assertAlmostEqual(self.history("s", "history.csv")[-1]["time"], factor, delta=1.1e-3)
        # A run cannot start from there.
        message = self.refused(1, f"run {scene} --out r --set initial.static=true")
        self.assertIn("initial.static = true: there is no equilibrium to start from", message)

    def test_examination_of_stability(self):
        # A column under a force that follows its end flutters from 20.05 EI/L² on (Beck 1952).
        def column(share):
            pressure = share * 20.0509 * 1e9 * 0.05**2 / 12
            return self.write("column.toml", f"""
[mesh]
generate = {{ kind = "box", size = [1, 0.05, 0.05], cells = [8, 1, 1] }}
element = "quadratic"
[material]
model = "neo-hookean"
youngs_modulus = 1e9
poissons_ratio = 0.0
density = 1000.0
[[fix]]
select = {{ plane = {{ axis = "x", at = 0.0 }} }}
[[pressure]]
select = {{ plane = {{ axis = "x", at = 1.0 }} }}
value = {pressure!r}
""")

        def summary_of(*arguments):
            result = self.run_program("static", *arguments, "--out", "s", "--quiet")
            return self.read_json("s", "summary.json"), result.stderr

        for share in (1e-4, 0.5, 1.25):
            with self.subTest(share=share):
                summary, said = summary_of(column(share))
                times = summary["wall_seconds"]
                self.assertGreater(times["stability"], 0.0)
                self.assertGreater(times["stepping"], 0.0)
                self.assertEqual(summary["equilibrium"]["loss_of_stability"] is not None, share > 1)
                self.assertEqual("swing further and further" in said, share > 1)
        # Without it the same equilibrium is found, and a warning tells.
        expected = self.history("s", "history.csv")[-1]
        summary, said = summary_of(column(1.25), "--no-stability")
        self.assertEqual(summary["wall_seconds"]["stability"], 0.0)
        self.assertFalse(summary["equilibrium"]["stability_examined"])
        self.assertIsNone(summary["equilibrium"]["loss_of_stability"])
        self.assertIn("are not examined for small motions that grow", said)
        found = self.history("s", "history.csv")[-1]
        self.assertAlmostEqual(found["max_displacement"], expected["max_displacement"],
                               delta=1e-9 * expected["max_displacement"])  # fmt: skip
        # Other bodies have nothing to examine.
        summary, said = summary_of(self.write("beam.toml", BEAM), "--no-stability")
        self.assertEqual(summary["wall_seconds"]["stability"], 0.0)
        self.assertTrue(summary["equilibrium"]["stability_examined"])
        self.assertNotIn("examined", said)

    def test_motions_are_told_of(self):
        handle = ('[[constraint]]\nkind = "rigid"\nselect = { plane = { axis = "x", at = 4.0 } }\n'
                  'angular_velocity = [1.0, 0.0, 0.0]\n')  # fmt: skip
        result = self.run_program("static", self.write("driven.toml", BEAM + handle), "--out",
                                  self.path("driven"))  # fmt: skip
        self.assertIn("has not moved with its velocity yet", result.stderr)
        self.assertEqual(result.stderr.count("has not moved"), 1)

    def test_events_are_told_of(self):
        scene = self.write("beam.toml", BEAM + '[[event]]\nat = 0.05\nset = { "damping.drag" = 1.0 }\n')
        result = self.run_program(f"static {scene} --out s --quiet")
        self.assertIn("its 1 [[event]] is not made", result.stderr)

    def test_a_run_from_the_equilibrium_stays_there(self):
        self.run_program("run beam.toml --out r --quiet --set initial.static=true")
        rows = self.history("r", "history.csv")
        self.assertGreater(rows[0]["elastic_energy"], 100)
        for row in rows:
            self.assertLess(row["kinetic_energy"], 1e-12 * rows[0]["elastic_energy"])
        self.assertTrue(self.read_json("r", "summary.json")["scene"]["initial"]["static"])
        self.refused(2, "run beam.toml --out r --set initial.static=1", says="must be")


if __name__ == "__main__":
    main()
