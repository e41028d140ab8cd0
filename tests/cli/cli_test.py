"""The real program on real files: what a user types, reads and gets wrong.

Usage: python3 cli_test.py PROGRAM DATA_DIRECTORY [unittest arguments]
"""

import csv
import json
import math
import os
import shutil
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree as ElementTree

PROGRAM, DATA = os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2])

BEAM = """
[mesh]
generate = { kind = "beam", size = [4, 1, 1], cells = [8, 2, 2] }
[material]
model = "neo-hookean"
youngs_modulus = 1.0e6
poissons_ratio = 0.4
density = 1000.0
[time]
integrator = "midpoint"
step = 0.01
end = 0.1
[environment]
kind = "gravity"
[[fix]]
select = { plane = { axis = "x", at = 0.0 } }
[output]
every = 4
"""


class CliTest(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="tetraction-cli-")
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)

    def path(self, *names):
        return os.path.join(self.folder, *names)

    def write(self, name, text):
        with open(self.path(name), "wb") as file:
            file.write(text if isinstance(text, bytes) else text.encode())
        return self.path(name)

    def run_program(self, *arguments, code=0):
        result = subprocess.run(
            [PROGRAM, *arguments], capture_output=True, text=True, timeout=300, cwd=self.folder
        )
        self.assertEqual(result.returncode, code, result.stdout + result.stderr)
        for trace in ("terminate called", "Segmentation", "Assertion", "core dumped"):
            self.assertNotIn(trace, result.stderr)
        return result

    def refused(self, code, *arguments):
        """One message on stderr, nothing on stdout."""
        result = self.run_program(*arguments, code=code)
        self.assertEqual(result.stdout, "")
        messages = [l for l in result.stderr.splitlines() if l.startswith("tetraction: ")]
        self.assertEqual(len(messages), 1, result.stderr)
        return result.stderr

    def history(self, *names):
        with open(self.path(*names), newline="") as file:
            return [{k: float(v) for k, v in row.items()} for row in csv.DictReader(file)]


class Run(CliTest):
    def test_outputs(self):
        scene = self.write("beam.toml", BEAM)
        result = self.run_program("run", scene, "--out", self.path("out"))
        self.assertIn("10 steps of 0.01 s", result.stdout)
        self.assertNotIn("\r", result.stderr)  # no progress bar but on a terminal

        rows = self.history("out", "history.csv")
        with open(self.path("out", "history.csv")) as file:
            header = file.readline().strip()
        self.assertEqual(
            header,
            "step,time,kinetic_energy,elastic_energy,environment_energy,total_energy,external_work,"
            "dissipated_energy,constraint_work,edit_work,energy_error,px,py,pz,lx,ly,lz,"
            "max_constraint_error,iterations",
        )
        self.assertEqual([row["step"] for row in rows], list(range(11)))
        self.assertAlmostEqual(rows[-1]["time"], 0.1, places=15)
        # Potential of gravity at rest: M g y, M = 4000 kg, mean y = 0.5 m.
        self.assertAlmostEqual(rows[0]["environment_energy"], 4000 * 9.81 * 0.5, delta=1e-8)
        for row in rows:
            self.assertEqual(row["max_constraint_error"], 0.0)
            self.assertAlmostEqual(
                row["total_energy"],
                row["kinetic_energy"] + row["elastic_energy"] + row["environment_energy"],
                delta=1e-9,
            )
            self.assertAlmostEqual(
                row["energy_error"], row["total_energy"] - rows[0]["total_energy"], delta=1e-9
            )

        root = ElementTree.parse(self.path("out", "frames.pvd")).getroot()
        sets = root.find("Collection").findall("DataSet")
        self.assertEqual([float(s.get("timestep")) for s in sets], [0, 0.04, 0.08, 0.1])
        for s in sets:
            self.assertTrue(os.path.exists(self.path("out", s.get("file"))))

        with open(self.path("out", "summary.json")) as file:
            summary = json.load(file)
        self.assertEqual(summary["status"], "ok")
        self.assertEqual(summary["steps"], 10)
        self.assertEqual(summary["mesh"]["tetrahedra"], 192)
        self.assertAlmostEqual(summary["mass"], 4000.0, delta=1e-9)
        self.assertGreater(summary["iterations"], 9)
        self.assertGreater(summary["stable_step"], 0)
        self.assertEqual(summary["scene"]["time"]["step"], 0.01)

    def test_final_state_read_with_vtk(self):
        scene = self.write("beam.toml", BEAM)
        self.run_program("run", scene, "--out", self.path("out"), "--quiet")
        import vtk
        from vtk.util.numpy_support import vtk_to_numpy

        reader = vtk.vtkXMLUnstructuredGridReader()
        reader.SetFileName(self.path("out", "final.vtu"))
        reader.Update()
        grid = reader.GetOutput()
        self.assertEqual(grid.GetNumberOfCells(), 192)
        self.assertAlmostEqual(grid.GetFieldData().GetArray("TimeValue").GetValue(0), 0.1)
        point, cell = grid.GetPointData(), grid.GetCellData()
        for name in ("displacement", "velocity", "momentum", "external_force", "reaction_force",
                     "deformation"):  # fmt: skip
            self.assertEqual(point.GetArray(name).GetNumberOfComponents(), 3, name)
        for name in ("cauchy_stress", "green_strain"):
            self.assertEqual(cell.GetArray(name).GetNumberOfComponents(), 6, name)
        for name in ("von_mises", "jacobian", "energy_density", "region"):
            self.assertEqual(cell.GetArray(name).GetNumberOfComponents(), 1, name)
        fixed = vtk_to_numpy(point.GetArray("fixed"))
        displacement = vtk_to_numpy(point.GetArray("displacement"))
        points = vtk_to_numpy(grid.GetPoints().GetData())
        self.assertEqual(fixed.sum(), 9)
        self.assertTrue((displacement[fixed == 1] == 0).all())
        self.assertTrue((points[fixed == 1][:, 0] == 0).all())
        self.assertLess(displacement[:, 1].min(), -0.01)
        # The history's elastic energy is the sum of density times rest volume.
        volume = 4.0 / 192
        density = vtk_to_numpy(cell.GetArray("energy_density"))
        last = self.history("out", "history.csv")[-1]
        self.assertAlmostEqual(density.sum() * volume, last["elastic_energy"], places=8)
        # And p its momentum.
        momentum = vtk_to_numpy(point.GetArray("momentum")).sum(axis=0)
        for value, key in zip(momentum, ("px", "py", "pz")):
            self.assertAlmostEqual(value, last[key], places=8)

    def test_integrators_and_automatic_step(self):
        scene = self.write("beam.toml", BEAM)
        for integrator in ("explicit", "verlet"):
            result = self.run_program(
                "run", scene, "--out", self.path(integrator), "--json", "--set",
                f"time.integrator={integrator}", "--set", 'time.step="auto"',
            )  # fmt: skip
            summary = json.loads(result.stdout)
            self.assertAlmostEqual(summary["time_step"], 0.5 * summary["stable_step"], places=15)
            self.assertLess(summary["linear_momentum_drift"], 1e-12)

    def test_same_bits_again_and_with_other_threads(self):
        scene = self.write("beam.toml", BEAM)
        for name, threads in (("a", "1"), ("b", "1"), ("c", "2")):
            self.run_program("--threads", threads, "run", scene, "--out", self.path(name), "--quiet")
        texts = [self.history(n, "history.csv") for n in "abc"]
        self.assertEqual(texts[0], texts[1])
        self.assertEqual(texts[0], texts[2])

    def test_initial_fields_from_the_mesh_file(self):
        self.run_program("mesh", "generate", "cube", "--cells", "2", self.path("cube.vtu"))
        import vtk

        reader = vtk.vtkXMLUnstructuredGridReader()
        reader.SetFileName(self.path("cube.vtu"))
        reader.Update()
        grid = reader.GetOutput()
        array = vtk.vtkDoubleArray()
        array.SetName("swing")
        array.SetNumberOfComponents(3)
        for i in range(grid.GetNumberOfPoints()):
            x = grid.GetPoint(i)
            array.InsertNextTuple3(0.01 * x[1], 0.0, 0.02 * x[0])
        grid.GetPointData().AddArray(array)
        writer = vtk.vtkXMLUnstructuredGridWriter()
        writer.SetFileName(self.path("swing.vtu"))
        writer.SetInputData(grid)
        writer.Write()
        scene = self.write("swing.toml", """
[mesh]
file = "swing.vtu"
[material]
youngs_modulus = 1e5
poissons_ratio = 0.3
[time]
integrator = "verlet"
step = "auto"
end = 0.01
[initial]
displacement_array = "swing"
velocity_array = "swing"
""")
        self.run_program("run", scene, "--out", self.path("out"), "--quiet")
        first = self.history("out", "history.csv")[0]
        self.assertGreater(first["elastic_energy"], 1e-3)
        self.assertGreater(first["kinetic_energy"], 1e-3)
        self.refused(2, "run", scene, "--out", self.path("o"), "--set",
                     "initial.displacement_array=swong")  # fmt: skip


class Failures(CliTest):
    def test_unstable_run_keeps_what_was_computed(self):
        scene = self.write("beam.toml", BEAM)
        result = self.run_program(
            "run", scene, "--out", self.path("out"), "--set", "time.integrator=verlet", "--set",
            "time.step=0.02", "--set", "time.end=2", code=1,
        )  # fmt: skip
        self.assertIn("warning", result.stderr)
        for part in ("step ", "element ", "stability limit"):
            self.assertIn(part, result.stderr)
        rows = self.history("out", "history.csv")
        self.assertGreater(len(rows), 1)
        for row in rows:
            for value in row.values():
                self.assertTrue(math.isfinite(value))
        with open(self.path("out", "summary.json")) as file:
            self.assertEqual(json.load(file)["status"], "unstable")
        self.run_program("mesh", "info", self.path("out", "final.vtu"))

    def test_step_so_large_that_an_element_inverts(self):
        scene = self.write("beam.toml", BEAM)
        result = self.run_program(
            "run", scene, "--out", self.path("out"), "--set", "time.integrator=explicit", "--set",
            "time.step=0.02", "--set", "time.end=2", code=1,
        )  # fmt: skip
        self.assertIn("inverted", result.stderr)
        self.assertIn("element ", result.stderr)

    def test_step_that_does_not_converge(self):
        scene = self.write("beam.toml", BEAM)
        result = self.run_program(
            "run", scene, "--out", self.path("out"), "--set", "solver.max_iterations=1", "--set",
            "solver.tolerance=1e-13", "--set", "time.step=0.1", code=1,
        )  # fmt: skip
        self.assertIn("did not converge", result.stderr)
        for line in result.stderr.splitlines():  # no library prints on its own
            self.assertTrue(line.startswith("tetraction: "), line)
        self.assertEqual(len(self.history("out", "history.csv")), 1)
        with open(self.path("out", "summary.json")) as file:
            self.assertEqual(json.load(file)["status"], "failed")

    def test_wrong_scenes(self):
        scene = self.write("beam.toml", BEAM)
        cases = {
            "time.stp=1": "did you mean step",
            "time.step=fast": "time.step",
            "time.step=-0.01": "above 0",
            "material.poissons_ratio=0.5": "0.5",
            "material.poissons_ratio=0.7": "0.5",
            "material.density=-1": "density",
            "material.model=rubber": "neo-hookean",
            "fix.0.select={all=true}": "fixed",
            'fix.0.select={plane={axis="y",at=17}}': "selects no vertex",
            "fix.0.select={vertices=[100000]}": "100000",
            'fix.0.select={group="lid"}': "group",
            "time.end=1e-5": "no step",
        }
        for override, expected in cases.items():
            with self.subTest(override):
                message = self.refused(
                    2, "run", scene, "--out", self.path("out"), "--set", override
                )
                self.assertIn(expected, message)

    def test_places_in_the_scene(self):
        wrong = self.write("wrong.toml", BEAM.replace("density = 1000.0", "densty = 1000.0"))
        message = self.refused(2, "check", wrong)
        self.assertIn("wrong.toml:8:1", message)
        self.assertIn("density", message)
        broken = self.write("broken.toml", BEAM + "\n[time\n")
        self.assertRegex(self.refused(2, "check", broken), r"broken\.toml:\d+:\d+")
        missing = self.write("missing.toml", BEAM.replace("[mesh]", "[output]").replace(
            "generate", "# generate").replace("[output]\nevery", "every", 1))  # fmt: skip
        self.refused(2, "check", missing)

    def test_wrong_files(self):
        self.refused(3, "run", self.path("none.toml"))
        scene = self.write("mesh.toml", BEAM.replace(
            'generate = { kind = "beam", size = [4, 1, 1], cells = [8, 2, 2] }',
            'file = "mesh.msh"'))  # fmt: skip
        self.assertIn("mesh.msh", self.refused(3, "run", scene))
        with open(os.path.join(DATA, "serpentine_spring.msh"), "rb") as file:
            good = file.read()
        self.write("mesh.msh", good[: len(good) // 2])
        self.assertIn("truncated", self.refused(3, "run", scene))
        self.run_program("mesh", "generate", "box", self.path("box.vtu"))
        with open(self.path("box.vtu"), "rb") as file:
            good = file.read()
        self.write("cut.vtu", good[: 2 * len(good) // 3])
        self.assertIn("cut.vtu", self.refused(3, "mesh", "info", self.path("cut.vtu")))
        self.write("triangle.msh", "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n3\n1 0 0 0\n"
                   "2 1 0 0\n3 0 1 0\n$EndNodes\n$Elements\n1\n1 2 2 0 1 1 2 3\n$EndElements\n")  # fmt: skip
        self.assertIn("no tetrahedra",
                      self.refused(3, "mesh", "info", self.path("triangle.msh")))  # fmt: skip

    def test_output_that_cannot_be_written(self):
        scene = self.write("beam.toml", BEAM)
        self.write("file", "in the way")
        self.refused(4, "run", scene, "--out", self.path("file", "out"))
        self.refused(4, "run", scene, "--out", self.path("file"))
        self.refused(4, "mesh", "generate", "cube", self.path("nowhere", "cube.vtu"))

    def test_wrong_command_lines(self):
        for arguments in (["fly"], ["run"], ["run", "a.toml", "--sets", "x=1"], ["mesh"], []):
            with self.subTest(arguments):
                self.run_program(*arguments, code=2)
        scene = self.write("beam.toml", BEAM)
        self.refused(2, "study", scene, "--integrators", "euler")
        self.refused(2, "study", scene, "--steps", "-1")


class Mesh(CliTest):
    def test_convert_keeps_the_mesh(self):
        part = os.path.join(DATA, "serpentine_spring.msh")
        volume = json.loads(self.run_program("mesh", "info", part, "--json").stdout)["volume"]
        for ending in ("vtu", "vtk", "msh", "veg", "node"):
            out = self.path("part." + ending)
            self.run_program("mesh", "convert", part, out)
            info = json.loads(self.run_program("mesh", "info", out, "--json").stdout)
            self.assertEqual(info["tetrahedra"], 6194, ending)
            self.assertAlmostEqual(info["volume"], volume, delta=1e-15 * volume)

    def test_generate(self):
        self.run_program("mesh", "generate", "beam", "--size", "4,1,1", "--cells", "20,4,4",
                         self.path("beam.vtu"))  # fmt: skip
        info = json.loads(self.run_program("mesh", "info", self.path("beam.vtu"), "--json").stdout)
        self.assertEqual((info["vertices"], info["tetrahedra"]), (525, 1920))
        self.assertEqual(info["bounding_box"]["max"], [4, 1, 1])
        self.assertGreater(info["quality"][0]["min"], 0.4)
        self.run_program("mesh", "generate", "tetrahedron", self.path("t.vtk"))
        self.assertIn("1 tetrahedra", self.run_program("mesh", "info", self.path("t.vtk")).stdout)


class Check(CliTest):
    def test_derivatives_are_exact(self):
        scene = self.write("beam.toml", BEAM)
        report = json.loads(self.run_program("check", scene, "--json").stdout)
        self.assertEqual(len(report["derivatives"]), 3)
        for row in report["derivatives"]:
            self.assertLess(row["force_error"], 1e-7)
            self.assertLess(row["stiffness_error"], 1e-7)
        self.assertAlmostEqual(report["mass"], 4000.0, delta=1e-9)
        mu, lam = 1e6 / 2.8, 1e6 * 0.4 / (1.4 * 0.2)
        self.assertAlmostEqual(report["wave_speed"], math.sqrt((lam + 2 * mu) / 1000), places=9)
        text = self.run_program("check", scene).stdout
        self.assertIn("h_crit", text)


class Study(CliTest):
    def test_table_files_and_plots(self):
        scene = self.write("beam.toml", BEAM)
        result = self.run_program(
            "study", scene, "--steps", "0.0025,0.005,0.05", "--out", self.path("s"),
            "--reference-step", "0.00125",
        )  # fmt: skip
        self.assertIn("unstable", result.stdout)
        with open(self.path("s", "study.csv"), newline="") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual(
            list(rows[0])[:10],
            ["integrator", "step", "status", "steps", "wall_seconds",
             "seconds_per_simulated_second", "iterations_per_step", "max_relative_energy_drift",
             "linear_momentum_drift", "angular_momentum_drift"],
        )  # fmt: skip
        self.assertEqual(len(rows), 12)
        by = {(r["integrator"], float(r["step"])): r for r in rows}
        self.assertEqual(by["explicit", 0.05]["status"], "unstable")
        self.assertEqual(by["verlet", 0.05]["status"], "unstable")
        self.assertEqual(by["backward-euler", 0.05]["status"], "ok")
        self.assertAlmostEqual(float(by["explicit", 0.005]["observed_order"]), 1, delta=0.1)
        self.assertAlmostEqual(float(by["midpoint", 0.005]["observed_order"]), 2, delta=0.15)
        self.assertAlmostEqual(float(by["backward-euler", 0.005]["observed_order"]), 1, delta=0.1)
        with open(self.path("s", "study.json")) as file:
            study = json.load(file)
        for run in study["runs"]:
            self.assertTrue(os.path.exists(self.path("s", run["directory"], "final.vtu")))
        for name in ("energy_over_time", "linear_momentum_over_time", "angular_momentum_over_time",
                     "error_over_step", "work_precision", "energy_drift_over_step",
                     "momentum_drift_over_step"):  # fmt: skip
            for ending in ("png", "svg"):
                self.assertGreater(os.path.getsize(self.path("s", f"{name}.{ending}")), 5000)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]], verbosity=1)
