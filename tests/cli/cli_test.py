"""The real program on real files: what a user types, reads and gets wrong.

Usage: python3 cli_test.py PROGRAM DATA_DIRECTORY [unittest arguments]
"""

import csv
import json
import math
import os
import re
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


def own_lines(stderr):
    """The lines without the warning of a slow BLAS, which is the machine's and not the run's."""
    return [l for l in stderr.splitlines() if not ("warning: " in l and "BLAS" in l)]


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

    def run_program(self, *arguments, code=0, env=None, cwd=None):
        environment = {**os.environ, **(env or {})}  # None takes a variable out
        result = subprocess.run(
            [PROGRAM, *arguments], capture_output=True, encoding="utf-8", errors="surrogateescape",
            timeout=300, cwd=cwd or self.folder,
            env={name: value for name, value in environment.items() if value is not None},
        )  # fmt: skip
        self.assertEqual(result.returncode, code, result.stdout + result.stderr)
        for trace in ("terminate called", "Segmentation", "Assertion", "core dumped"):
            self.assertNotIn(trace, result.stderr)
        return result

    def refused(self, code, *arguments):
        """One message on stderr, beside what is said of the machine, and nothing on stdout."""
        result = self.run_program(*arguments, code=code)
        self.assertEqual(result.stdout, "")
        messages = [l for l in own_lines(result.stderr) if l.startswith("tetraction: ")]
        self.assertEqual(len(messages), 1, result.stderr)
        return "\n".join(own_lines(result.stderr))

    def history(self, *names):
        with open(self.path(*names), newline="") as file:
            return [{k: float(v) for k, v in row.items()} for row in csv.DictReader(file)]


class Run(CliTest):
    def test_the_step_is_written_as_it_is_read(self):
        scene = self.write("beam.toml", BEAM)
        self.run_program("run", scene, "--out", "out", "--set", "time.step=1e-6", "--set", "time.end=3e-6")
        with open(self.path("out", "history.csv"), newline="") as file:
            steps = [row["time_step"] for row in csv.DictReader(file)]
        self.assertEqual(steps, ["0", "1e-06", "1e-06", "1e-06"])

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
            "max_constraint_error,iterations,reaction_x,reaction_y,reaction_z,time_step",
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
        solver = summary["solver"]
        self.assertEqual(
            list(solver),
            ["kind", "linear", "linear_used", "iterations", "factorizations", "cg_iterations",
             "message", "steps_limited_by_round_off", "tolerance_reached"],
        )  # fmt: skip
        self.assertEqual(solver["kind"], summary["scene"]["solver"]["kind"])
        self.assertEqual(solver["linear"], "auto")
        self.assertGreater(solver["iterations"], 9)
        self.assertEqual(solver["iterations"], sum(row["iterations"] for row in rows))
        self.assertIn("converged", solver["message"])
        self.assertIs(type(summary["peak_memory_bytes"]), int)
        self.assertGreater(summary["peak_memory_bytes"], 2**20)
        self.assertLess(summary["peak_memory_bytes"], 2**32)
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

    def test_solvers(self):
        scene = self.write("beam.toml", BEAM)
        energies = []
        runs = [("ceres", "auto"), ("newton", "auto"), ("newton", "matrix-free"), ("newton", "cg"),
                ("newton", "factor")]  # fmt: skip
        for kind, linear in runs:
            result = self.run_program(
                "run", scene, "--out", self.path("out"), "--json", "--set", f"solver.kind={kind}",
                "--set", f"solver.linear={linear}",
            )  # fmt: skip
            summary = json.loads(result.stdout)
            for solver in (summary["solver"], summary["scene"]["solver"]):
                self.assertEqual((solver["kind"], solver["linear"]), (kind, linear))
            if kind == "ceres":
                self.assertEqual(summary["solver"]["linear_used"], "cholesky")
                self.assertEqual(summary["solver"]["cg_iterations"], 0)
            energies.append(self.history("out", "history.csv")[-1]["elastic_energy"])
        for energy in energies:
            self.assertAlmostEqual(energy / energies[0], 1, delta=1e-6)
        message = self.refused(2, "run", scene, "--set", "solver.kind=ceres", "--set",
                               "solver.linear=cg")  # fmt: skip
        self.assertIn("solver.linear", message)
        # Explicit rules have no solver.
        result = self.run_program(
            "run", scene, "--out", self.path("out"), "--json", "--set", "solver.kind=newton",
            "--set", "time.integrator=verlet", "--set", "time.step=auto",
        )  # fmt: skip
        solver = json.loads(result.stdout)["solver"]
        self.assertEqual((solver["linear_used"], solver["iterations"]), (None, 0))

    def test_an_event_changes_the_solver(self):
        change = '[[event]]\nat = 0.05\nset = { "solver.kind" = "newton", "solver.linear" = "cg" }\n'
        scene = self.write("beam.toml", BEAM + '[solver]\nkind = "ceres"\n' + change)
        result = self.run_program("run", scene, "--out", self.path("out"), "--json")
        summary = json.loads(result.stdout)
        self.assertEqual(summary["scene"]["solver"]["kind"], "ceres")
        self.assertEqual((summary["solver"]["kind"], summary["solver"]["linear"]), ("newton", "cg"))
        self.assertEqual(summary["events"][0]["energy_jump"], 0)

    def test_a_slow_blas_is_warned_of_once(self):
        slow = {"OPENBLAS_CORETYPE": "Prescott"}
        if "Prescott" not in self.run_program("--version", env=slow).stdout:
            self.skipTest("OpenBLAS has no such kernels here")
        with open("/proc/cpuinfo") as file:
            if " avx2 " not in file.read():
                self.skipTest("the processor has nothing better")
        scene = self.write("beam.toml", BEAM)

        def warnings(*arguments, env=slow):
            lines = self.run_program(*arguments, env=env).stderr.splitlines()
            return [line for line in lines if "OPENBLAS_CORETYPE=Prescott" in line]

        run = ["run", scene, "--out", self.path("out")]
        verlet = ["--set", "time.integrator=verlet", "--set", "time.step=auto"]
        self.assertEqual(len(warnings(*run)), 1)
        with open(self.path("out", "summary.json")) as file:
            self.assertIn("OPENBLAS_CORETYPE=Prescott", json.load(file)["warnings"][0])
        self.assertEqual(warnings(*run, env={"OPENBLAS_CORETYPE": None}), [])
        self.assertEqual(warnings(*run, *verlet), [])
        study = ["study", scene, "--steps", "0.005,0.01", "--no-plots", "--out", self.path("s")]
        self.assertEqual(len(warnings(*study, "--integrators", "midpoint,backward-euler")), 1)
        self.assertEqual(
            warnings(*study, "--integrators", "verlet", "--reference-integrator", "verlet"), []
        )

    def test_same_bits_again_and_with_other_threads(self):
        scene = self.write("beam.toml", BEAM)
        for name, threads in (("a", "1"), ("b", "1"), ("c", "2")):
            out = self.path(name)
            self.run_program("--threads", threads, "run", scene, "--out", out, "--quiet")
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


    def test_initial_fields_by_file_and_formula(self):
        self.write("u.csv", "vertex,x,y,z\n80,0.01,0,0\n")
        scene = self.write("beam.toml", BEAM + """
[initial]
displacement = { file = "u.csv" }
velocity = { formula = ["0", "0.5*X", "0"] }
""")
        self.run_program("check", scene, "--json", cwd="/")
        self.run_program("run", scene, "--out", self.path("out"), "--quiet", cwd="/")
        first = self.history("out", "history.csv")[0]
        self.assertGreater(first["elastic_energy"], 1.0)
        # The speed is 0.5 X along y, but zero at the clamp, and linear: the momentum is exact.
        self.assertAlmostEqual(first["py"] / (4000 * 0.5 * 2), 1, delta=1e-12)
        with open(self.path("out", "summary.json")) as file:
            echo = json.load(file)["scene"]["initial"]
        self.assertEqual(echo["velocity"], {"formula": ["0", "0.5*X", "0"]})
        study = ["study", scene, "--steps", "0.05", "--integrators", "midpoint", "--no-plots"]
        self.run_program(*study, "--out", self.path("study"), "--quiet")
        self.write("u.csv", "vertex,x,y,z\n80,0.01,0,0\n80,1,0,0\n")
        self.assertIn("u.csv:3: vertex 80", self.refused(3, "check", scene))
        self.write("u.csv", "vertex,x,y,z\n8000,0.01,0,0\n")
        self.assertIn("u.csv:2: the mesh has no vertex 8000", self.refused(3, "run", scene))
        os.remove(self.path("u.csv"))
        self.assertIn("u.csv: no such file", self.refused(3, "check", scene))

    def test_named_selections_and_faces(self):
        scene = self.write("beam.toml", BEAM.replace(
            'select = { plane = { axis = "x", at = 0.0 } }', 'select = "clamp"') + """
[[force]]
select = { all_of = ["top", { not = "clamp" }] }
vector = [0, 1, 0]
[[event]]
at = 0.05
unfix = { select = "clamp" }
[selection.clamp]
plane = { axis = "x", at = 0.0 }
[selection.top]
faces = { normal = [0, 1, 0], angle = 10 }
""")  # fmt: skip
        self.run_program("run", scene, "--out", self.path("out"), "--quiet")
        plain = self.write("plain.toml", BEAM + """
[[force]]
select = { box = { min = [0.1, 1, 0], max = [4, 1, 1] } }
vector = [0, 1, 0]
[[event]]
at = 0.05
unfix = { select = { plane = { axis = "x", at = 0.0 } } }
""")
        self.run_program("run", plain, "--out", self.path("same"), "--quiet")
        with open(self.path("out", "history.csv")) as a, open(self.path("same", "history.csv")) as b:
            self.assertEqual(a.read(), b.read())
        message = self.refused(2, "check", scene, "--set", "fix.0.select=clmp")
        self.assertIn("did you mean clamp? the scene has clamp or top", message)
        message = self.refused(2, "check", scene, "--set", "selection.top={not='top'}")
        self.assertIn("refer to itself: top → top", message)

    def test_the_unit_of_a_mesh_file(self):
        self.run_program("mesh", "generate", "box", "--size", "400,100,100", "--cells", "8,2,2",
                         self.path("beam.msh"))  # fmt: skip
        scene = self.write("beam.toml", BEAM.replace(
            'generate = { kind = "beam", size = [4, 1, 1], cells = [8, 2, 2] }',
            'file = "beam.msh"\nunit = "cm"'))  # fmt: skip
        report = json.loads(self.run_program("check", scene, "--json").stdout)
        for size, expected in zip(report["size"], (4, 1, 1)):
            self.assertAlmostEqual(size, expected, delta=1e-14)
        self.assertAlmostEqual(report["mass"], 4000, delta=1e-9)
        material = report["materials"][0]
        shear = 1e6 / 2.8
        pressure = shear + 1e6 * 0.4 / (1.4 * 0.2) + shear
        self.assertAlmostEqual(material["wave_speed"], math.sqrt(pressure / 1000), delta=1e-9)
        self.assertAlmostEqual(material["shear_wave_speed"], math.sqrt(shear / 1000), delta=1e-9)
        self.assertAlmostEqual(report["wave_time"], 4 / math.sqrt(pressure / 1000), delta=1e-9)
        text = self.run_program("check", scene).stdout
        self.assertIn("size: 4 x 1 x 1 m; a pressure wave takes", text)
        twice = self.run_program("check", scene, "--json", "--set", "mesh.scale=2").stdout
        self.assertAlmostEqual(json.loads(twice)["size"][0], 8, delta=1e-14)


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
            'fix.0.select={plane={axis="y",at=17}}': "selects no vertex",
            "fix.0.select={vertices=[100000]}": "100000",
            'fix.0.select={group="lid"}': "group",
            "fix.0.select=lid": "no named selections",
            "fix.0.select={all_of=[]}": "one or more selections",
            'fix.0.select={not="fix"}': "fix.0.select.not",
            "fix.0.select={not={all=true}}": "selects no vertex",
            "fix.0.select={faces={normal=[0,0,0]}}": "must not be zero",
            "mesh.unit=mm": "this mesh is generated",
            "mesh.unit=mile": "m, mm, cm, um or in",
            "initial.displacement={formula=['X','Y','W']}": "\"W\", character 1",
            "initial.displacement={formula=['X','Y','1/Z']}": "inf at vertex 0",
            "initial.velocity={formula=['X','Y']}": "three texts",
            "initial.velocity={}": "either file",
        }
        for override, expected in cases.items():
            with self.subTest(override):
                message = self.refused(
                    2, "run", scene, "--out", self.path("out"), "--set", override
                )
                self.assertIn(expected, message)

    def test_numbers_and_keys_beyond_all_bounds(self):
        scene = self.write("beam.toml", BEAM)
        penalty = '[[fix]]\nselect = { vertices = [80] }\nmode = "penalty"\npenalty = 1e6\n'
        springs = self.write("springs.toml", BEAM + penalty)
        for key in ("material.youngs_modulus", "material.density", "mesh.generate.size.0",
                    "fix.1.penalty"):  # fmt: skip
            for value in ("1e300", "1e-300", "1e308"):
                for command in (["run", "--out", self.path("o")], ["check"]):
                    with self.subTest(key, value=value, command=command[0]):
                        file = springs if "penalty" in key else scene
                        message = self.refused(2, *command, file, "--set", f"{key}={value}")
                        self.assertIn(key.replace(".0", ""), message)
        # What overflows only together names the keys that may be to blame.
        message = self.refused(2, "check", scene, "--set", "mesh.generate.size=[1e30,1e30,1e30]")
        self.assertIn("mesh.generate.size", message)
        deep = ".".join(["a"] * 35000)
        for text in (f"{deep} = 1\n", f"[{deep}]\n", f"[[{deep}]]\n", "x = " + "[" * 100000 + "\n",
                     f"[[event]]\nat = 0\nset = {{ {deep} = 1 }}\n"):  # fmt: skip
            self.assertIn("deep", self.refused(2, "check", self.write("deep.toml", BEAM + text)))
        for override in (f"{deep}=1", f"material.{deep}=1", f"x={{{deep}=1}}", "x=" + "[" * 100000):
            self.assertIn("deep", self.refused(2, "check", scene, "--set", override))

    def test_names_that_are_not_utf8(self):
        folder = os.path.join(os.fsencode(self.folder), b"f\xff")
        os.mkdir(folder)
        mesh, scene = os.path.join(folder, b"m\xe4.msh"), os.path.join(folder, b"b\xe4.toml")
        self.run_program("mesh", "generate", "beam", mesh)
        json.loads(self.run_program("mesh", "info", mesh, "--json").stdout)
        generated = 'generate = { kind = "beam", size = [4, 1, 1], cells = [8, 2, 2] }'
        with open(scene, "w") as file:
            file.write(BEAM.replace(generated, 'file = "m.msh"'))
        os.rename(mesh, os.path.join(folder, b"m.msh"))
        out = os.path.join(folder, b"o\xfe")
        json.loads(self.run_program("check", scene, "--json").stdout)
        json.loads(self.run_program("run", scene, "--out", out, "--json").stdout)
        study = ["study", scene, "--steps", "0.05", "--integrators", "midpoint", "--no-plots"]
        json.loads(self.run_program(*study, "--out", out + b"s", "--json").stdout)
        with open(os.path.join(out + b"s", b"study.csv"), encoding="utf-8") as file:
            self.assertIn("\\xfe", file.read())  # in the column of the command

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
    def test_cell_arrays_are_listed_and_their_loss_is_told(self):
        mesh = self.write("part.msh", """$MeshFormat
2.2 0 8
$EndMeshFormat
$Nodes
5
1 0 0 0
2 1 0 0
3 0 1 0
4 0 0 1
5 1 1 1
$EndNodes
$Elements
2
11 4 0 1 2 3 4
12 4 0 2 3 4 5
$EndElements
$ElementData
1
"E"
1
0.0
3
0
1
2
11 2e5
12 5e5
$EndElementData
""")
        self.assertIn('cell array "E": a number a tetrahedron, from 200000 to 500000',
                      self.run_program("mesh", "info", mesh).stdout)
        info = json.loads(self.run_program("mesh", "info", mesh, "--json").stdout)
        self.assertEqual(info["cell_arrays"]["E"], {"components": 1, "min": 2e5, "max": 5e5})
        for name in ("a.vtu", "a.vtk", "a.msh"):
            self.assertNotIn("lost", self.run_program("mesh", "convert", mesh,
                                                      self.path(name)).stderr)  # fmt: skip
            self.assertIn("E", json.loads(self.run_program(
                "mesh", "info", self.path(name), "--json").stdout)["cell_arrays"])  # fmt: skip
        self.assertIn("these arrays of", self.run_program("mesh", "convert", mesh,
                                                      self.path("a.veg")).stderr)  # fmt: skip

    def test_convert_keeps_the_mesh(self):
        part = os.path.join(DATA, "serpentine_spring.msh")
        volume = json.loads(self.run_program("mesh", "info", part, "--json").stdout)["volume"]
        for ending in ("vtu", "vtk", "msh", "veg", "node"):
            out = self.path("part." + ending)
            self.run_program("mesh", "convert", part, out)
            info = json.loads(self.run_program("mesh", "info", out, "--json").stdout)
            self.assertEqual(info["tetrahedra"], 6194, ending)
            self.assertAlmostEqual(info["volume"], volume, delta=1e-15 * volume)

    def test_quadratic_tetrahedra(self):
        """A sphere with curved edges, and a beam whose bending linear tetrahedra miss."""
        sphere = os.path.join(os.path.dirname(__file__), "..", "data", "meshes", "sphere_p2.msh")
        volume = json.loads(self.run_program("mesh", "info", sphere, "--json").stdout)["volume"]
        for ending in ("vtu", "vtk", "msh"):
            out = self.path("sphere." + ending)
            self.run_program("mesh", "convert", sphere, out)
            info = json.loads(self.run_program("mesh", "info", out, "--json").stdout)
            self.assertEqual((info["tetrahedra"], info["element"]), (683, "quadratic"))
            self.assertAlmostEqual(info["volume"], volume, delta=1e-14 * volume)
        self.assertIn("683 quadratic tetrahedra", self.run_program("mesh", "info", sphere).stdout)

        # The beam of Turek & Hron (2006), CSM1, with a flat clamp: -65.54 mm.
        scene = self.write("csm1.toml", """
[mesh]
generate = { kind = "box", size = [0.35, 0.02, 0.005], cells = [70, 4, 1] }
element = "quadratic"
[material]
model = "stvk"
youngs_modulus = 1.4e6
poissons_ratio = 0.4
density = 1000
[environment]
kind = "gravity"
strength = 2
direction = [0, -1, 0]
[[fix]]
select = { plane = { axis = "x", at = 0.0 } }
[[fix]]
select = { box = { min = [-1, -1, -1], max = [1, 1, 1] } }
components = "z"
[[probe]]
name = "tip"
point = [0.35, 0.01, 0.0025]
quantity = "displacement"
""")
        tip = {}
        for element in ("linear", "quadratic"):
            self.run_program("static", scene, "--out", self.path(element), "--set",
                             f"mesh.element={element}")  # fmt: skip
            with open(self.path(element, "probes.csv"), newline="") as file:
                rows = [r for r in csv.reader(file) if not r[0].startswith("#")]
            tip[element] = float(rows[-1][3])
        self.assertAlmostEqual(tip["quadratic"], -0.06554, delta=0.003 * 0.06554)
        self.assertGreater(tip["linear"], -0.052)

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
        self.assertEqual(len(report["derivatives"]), 4)
        nodal = json.loads(self.run_program("check", scene, "--json", "--set",
                                            'mesh.volume="nodal"').stdout)  # fmt: skip
        self.assertEqual(nodal["derivatives"][-1]["material"], "nodal volumes")
        for row in report["derivatives"] + nodal["derivatives"]:
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
        self.assertEqual(len(rows), 15)
        by = {(r["integrator"], float(r["step"])): r for r in rows}
        self.assertEqual(by["explicit", 0.05]["status"], "unstable")
        self.assertEqual(by["verlet", 0.05]["status"], "unstable")
        self.assertEqual(by["backward-euler", 0.05]["status"], "ok")
        self.assertAlmostEqual(float(by["explicit", 0.005]["observed_order"]), 1, delta=0.1)
        self.assertAlmostEqual(float(by["midpoint", 0.005]["observed_order"]), 2, delta=0.15)
        self.assertAlmostEqual(float(by["backward-euler", 0.005]["observed_order"]), 1, delta=0.1)
        self.assertAlmostEqual(
            float(by["energy-momentum", 0.05]["observed_order"]), 2, delta=0.15
        )
        with open(self.path("s", "study.json")) as file:
            study = json.load(file)
        for run in study["runs"]:
            self.assertTrue(os.path.exists(self.path("s", run["directory"], "final.vtu")))
        for name in ("energy_over_time", "error_over_step", "rms_error_over_step", "work_precision",
                     "energy_drift_over_step", "momentum_drift_over_step"):  # fmt: skip
            for ending in ("png", "svg", "pdf"):
                self.assertGreater(os.path.getsize(self.path("s", f"{name}.{ending}")), 5000)

    def test_matplotlib_does_not_speak(self):
        scene = self.write("beam.toml", BEAM)
        # Of a folder for its settings that it cannot make, matplotlib warns.
        result = self.run_program("study", scene, "--steps", "0.05", "--integrators", "midpoint",
                                  "--out", "s", "--quiet",
                                  env={"MPLCONFIGDIR": "/dev/null/settings"})  # fmt: skip
        self.assertEqual(own_lines(result.stderr), [])
        self.assertTrue(os.path.exists(self.path("s", "energy_over_time.png")))

    def test_python_files_of_the_working_folder_do_not_run(self):
        scene = self.write("beam.toml", BEAM)
        for module in ("csv", "json", "math", "matplotlib", "numpy", "os", "sitecustomize"):
            self.write(module + ".py", f"open({self.path('ran')!r}, 'w')\nraise SystemExit\n")
        self.write("matplotlibrc", "backend: module://csv\n")
        result = self.run_program("study", scene, "--steps", "0.05", "--integrators", "midpoint",
                                  "--out", "s", env={"PYTHONPATH": self.folder})  # fmt: skip
        self.assertFalse(os.path.exists(self.path("ran")))
        self.assertNotIn("plots were not drawn", result.stderr)
        self.assertTrue(os.path.exists(self.path("s", "energy_over_time.png")))

    def test_errors_are_relative_to_the_displacement(self):
        """As anybody works them out from the results; the reference is told from the others."""
        scene = self.write("beam.toml", BEAM)
        result = self.run_program(
            "study", scene, "--steps", "0.005,0.02", "--integrators", "midpoint,backward-euler",
            "--out", self.path("s"), "--no-plots",
        )  # fmt: skip
        import vtk
        from vtk.util.numpy_support import vtk_to_numpy

        def displacement(directory):
            reader = vtk.vtkXMLUnstructuredGridReader()
            reader.SetFileName(self.path("s", directory, "final.vtu"))
            reader.Update()
            return vtk_to_numpy(reader.GetOutput().GetPointData().GetArray("displacement")).copy()

        with open(self.path("s", "study.csv"), newline="") as file:
            rows = {(r["integrator"], r["step"][:4]): r for r in csv.DictReader(file)}
        reference = displacement("midpoint-0.005")
        for (integrator, step), row in rows.items():
            if row["role"] == "reference":
                self.assertEqual((integrator, float(row["position_error"])), ("midpoint", 0))
                self.assertEqual(float(row["position_error_rms"]), 0)
                continue
            self.assertEqual(row["role"], "run")
            difference = displacement(f"{integrator}-{float(row['step']):.10g}") - reference
            expected = (difference**2).sum() ** 0.5 / (reference**2).sum() ** 0.5
            self.assertAlmostEqual(float(row["position_error"]) / expected, 1, delta=1e-8)
            self.assertGreater(float(row["position_error_rms"]), 0)
        self.assertEqual([r["role"] for r in rows.values()].count("reference"), 1)
        self.assertRegex(result.stdout, r"midpoint +newton +0\.005 .* reference")

    def test_the_table_names_the_rules_of_its_stability_limits(self):
        """With damping the limits of the explicit rules differ; rules that do not take part have none."""
        scene = self.write("beam.toml", BEAM)

        def closing_line(integrators, *overrides):
            result = self.run_program(
                "study", scene, "--integrators", integrators, "--steps", "1e-3", "--set",
                "time.end=2e-3", "--no-plots", "--out", self.path("s"), *overrides,
            )  # fmt: skip
            line = re.search(r"Stability limit: (.*)\. Reference", result.stdout).group(1)
            with open(self.path("s", "study.csv"), newline="") as file:
                limits = {r["integrator"]: float(r["stable_step"]) for r in csv.DictReader(file)}
            return line, limits

        damped = ("--set", "damping.viscosity=1000")
        line, limits = closing_line("explicit,verlet")
        self.assertEqual(line, f"h_crit = {limits['explicit']:.4g} s (explicit and verlet)")
        line, limits = closing_line("explicit,verlet", *damped)
        self.assertLess(limits["explicit"], 0.9 * limits["verlet"])
        self.assertEqual(line, f"h_crit = {limits['explicit']:.4g} s (explicit), "
                               f"{limits['verlet']:.4g} s (verlet)")  # fmt: skip
        line, limits = closing_line("verlet,midpoint", *damped)
        self.assertEqual(line, f"h_crit = {limits['verlet']:.4g} s (verlet)")
        line, limits = closing_line("midpoint", *damped)
        self.assertEqual(line, f"h_crit = {limits['midpoint']:.4g} s (explicit)")

    def test_variants_show_that_the_penalty_blows_up(self):
        """The shipped scene, as its header says: at one step the exact constraint runs."""
        scene = os.path.join(os.path.dirname(DATA), "examples", "scenes",
                             "penalty_versus_exact.toml")  # fmt: skip
        result = self.run_program(
            "study", scene, "--vary", "fix.0.mode=exact,penalty", "--integrators", "verlet",
            "--steps", "5e-4", "--reference-integrator", "verlet", "--out", self.path("s"),
            "--set", "time.end=0.05", "--no-plots",
        )  # fmt: skip
        self.assertIn("exact: h_crit", result.stdout)
        self.assertIn("penalty: h_crit", result.stdout)
        with open(self.path("s", "study.csv"), newline="") as file:
            rows = {row["variant"]: row for row in csv.DictReader(file)}
        self.assertEqual(rows["exact"]["status"], "ok")
        self.assertEqual(rows["penalty"]["status"], "unstable")
        self.assertLess(float(rows["penalty"]["stable_step"]), 5e-4)
        self.assertGreater(float(rows["exact"]["stable_step"]), 5e-4)
        self.assertEqual(rows["exact"]["role"], "reference")
        # It has a reference of its own, which blows up, too.
        self.assertEqual(rows["penalty"]["role"], "reference")
        self.assertIn("Reference of penalty: verlet with h = 5e-4 s (unstable)", result.stdout)
        self.assertIn("the reference run of penalty did not reach the end", result.stderr)
        for key in ("time.end=1,2", "output.every=1,2", "time.step=1e-3,1e-4"):
            self.assertIn("one end time", self.refused(2, "study", scene, "--vary", key))
        for bad in ("fix.0.mode", "fix.0.mode=", "fix.0.mode=exact,soft"):
            self.assertIn("fix.0.mode", self.refused(2, "study", scene, "--vary", bad))

    def test_solvers_side_by_side(self):
        """They minimise the same potential: positions agree to the tolerance."""
        scene = self.write("beam.toml", BEAM)
        self.run_program(
            "study", scene, "--vary", "solver.kind=ceres,newton", "--integrators",
            "midpoint,backward-euler", "--steps", "0.01", "--out", self.path("s"), "--no-plots",
        )  # fmt: skip
        with open(self.path("s", "study.csv"), newline="") as file:
            rows = {(r["variant"], r["integrator"]): r for r in csv.DictReader(file)}
        self.assertEqual(len(rows), 4)
        for row in rows.values():
            self.assertEqual(row["status"], "ok")
            self.assertGreaterEqual(float(row["iterations_per_step"]), 1)
        self.assertEqual(float(rows["ceres", "midpoint"]["position_error"]), 0)
        self.assertLess(float(rows["newton", "midpoint"]["position_error"]), 1e-8)
        errors = [float(rows[kind, "backward-euler"]["position_error"]) for kind in ("ceres", "newton")]
        self.assertGreater(errors[0], 1e-6)
        self.assertAlmostEqual(errors[1] / errors[0], 1, delta=1e-4)
        for kind in ("ceres", "newton"):
            with open(self.path("s", f"{kind}-midpoint-0.01", "summary.json")) as file:
                self.assertEqual(json.load(file)["solver"]["kind"], kind)
        message = self.refused(2, "study", scene, "--vary", "solver.kind=ceres,newtn")
        self.assertIn("did you mean newton?", message)

    def test_a_study_does_not_take_events_that_change_its_steps(self):
        scene = self.write(
            "beam.toml", BEAM + '[[event]]\nat = 0.01\nset = { "time.step" = 1e-3 }\n'
        )
        message = self.refused(2, "study", scene, "--out", self.path("s"))
        self.assertIn("event.0", message)
        self.assertIn("[time]", message)


# A beam to which everything happens: the numbers of its events' steps are in STEPS.
EVENTS = BEAM.replace("end = 0.1", "end = 0.1\n[damping]\nviscosity = 20.0").replace(
    "step = 0.01", "step = 0.002"
) + """
[[event]]
at = 0.02
set = { "time.step" = 1e-3, "material.youngs_modulus" = 2e6 }
[[event]]
at = 0.03
set = { "environment.kind" = "none", "damping.drag" = 0.5, "damping.mass_damping" = 1 }
[[event]]
at = 0.04
momentum = { select = { plane = { axis = "x", at = 4.0 } }, value = [0, 0, 30] }
[[event]]
at = 0.05
fix = { select = { plane = { axis = "x", at = 4.0 } }, velocity = [0, 0, 0.5] }
[[event]]
at = 0.06
unfix = { plane = { axis = "x", at = 0.0 } }
[[event]]
at = 0.07
force = [{ select = { nearest = [0, 0, 0] }, vector = [0, 5000, 0] }]
constraint = { kind = "distance", vertices = [0, 80] }
[[event]]
at = 0.08
set = { "time.integrator" = "verlet", "time.step" = "auto" }
"""
STEPS = [10, 20, 30, 40, 50, 60, 70]

CUBE = """
[mesh]
generate = { kind = "cube", cells = 2 }
[material]
youngs_modulus = 1.0e5
poissons_ratio = 0.3
[time]
integrator = "verlet"
step = 1e-3
end = 0.02
"""
# Vertex i + 3 (j + 3 k) of the cube is at (i, j, k)/2.
ALONG_X, ALONG_Y, ALONG_Z = 2, 6, 18

INTEGRATORS = ("explicit", "verlet", "midpoint", "backward-euler", "energy-momentum")


class Mechanics(CliTest):
    """Constraints, damping, environments, regions and what happens during a run."""

    def summary(self, *names):
        with open(self.path(*names, "summary.json")) as file:
            return json.load(file)

    def simulate(self, text, *overrides, out="out", code=0):
        """Runs the scene; its history, whose every number is finite."""
        scene = self.write("scene.toml", text)
        arguments = [a for o in overrides for a in ("--set", o)]
        self.result = self.run_program(
            "run", scene, "--out", self.path(out), "--quiet", *arguments, code=code
        )
        rows = self.history(out, "history.csv")
        for row in rows:
            for name, value in row.items():
                self.assertTrue(math.isfinite(value), f"{name} of step {row['step']}: {value}")
        return rows

    def messages(self):
        """The lines of stderr, each a message of the program."""
        lines = own_lines(self.result.stderr)
        for line in lines:
            self.assertTrue(line.startswith("tetraction: "), line)
        return lines

    def warnings_of(self):
        return [line for line in self.messages() if "warning" in line]

    def refused_scene(self, text, *overrides):
        scene = self.write("scene.toml", text)
        arguments = [a for o in overrides for a in ("--set", o)]
        return self.refused(2, "run", scene, "--out", self.path("refused"), *arguments)

    def assert_books_close(self, rows):
        largest = max(
            abs(row[name])
            for row in rows
            for name in ("kinetic_energy", "elastic_energy", "environment_energy", "external_work",
                         "dissipated_energy", "constraint_work", "edit_work", "energy_error")
        )  # fmt: skip
        start = rows[0]["total_energy"]
        for row in rows:
            entered = (row["external_work"] - row["dissipated_energy"] + row["constraint_work"]
                       + row["edit_work"] + row["energy_error"])  # fmt: skip
            self.assertAlmostEqual(row["total_energy"] - start, entered, delta=1e-12 * largest)
            parts = row["kinetic_energy"] + row["elastic_energy"] + row["environment_energy"]
            self.assertAlmostEqual(row["total_energy"], parts, delta=1e-12 * largest)
        return largest

    def fields(self, *names):
        """Point fields of a VTU file, and the points."""
        import vtk
        from vtk.util.numpy_support import vtk_to_numpy

        reader = vtk.vtkXMLUnstructuredGridReader()
        reader.SetFileName(self.path(*names))
        reader.Update()
        grid = reader.GetOutput()
        data = grid.GetPointData()
        arrays = {
            data.GetArrayName(i): vtk_to_numpy(data.GetArray(i)).copy()
            for i in range(data.GetNumberOfArrays())
        }
        return arrays, vtk_to_numpy(grid.GetPoints().GetData()).copy()

    # Steps.

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
        result = self.run_program("run", scene, "--out", self.path("out"), "--set",
                                  "time.end=4e-4")  # fmt: skip
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

    PRESS = """
[mesh]
generate = { kind = "cube", cells = 2 }
[material]
youngs_modulus = 1e6
poissons_ratio = 0.4
[time]
integrator = "verlet"
step = "auto"
end = 3
[damping]
viscosity = 100
[[fix]]
select = { plane = { axis = "x", at = 0 } }
[[fix]]
select = { plane = { axis = "x", at = 1 } }
velocity = [-0.5, 0, 0]
"""

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
        result = self.run_program("run", scene, "--out", self.path("out"), "--set",
                                  "time.adapt=error")  # fmt: skip
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
                message = self.refused_scene(CUBE, *overrides)
                self.assertIn("time.", message)
                self.assertIn(part, message)
        scene = self.write("scene.toml", CUBE)
        self.assertIn("time.adapt", self.refused(2, "study", scene, "--steps", "1e-3", "--out",
                                                 self.path("study"), "--set", "time.adapt=error"))  # fmt: skip
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

    # Events.

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
        text = CUBE + """
[[fix]]
select = { plane = { axis = "x", at = 0 } }
[[event]]
at = 0.005
unfix = { plane = { axis = "x", at = 0 } }
fix = { select = { plane = { axis = "x", at = 0 } }, offset = [0, 0, 0.01] }
"""
        self.assert_books_close(self.simulate(text))
        fields, points = self.fields("out", "final.vtu")
        clamp = points[:, 0] == 0
        self.assertTrue((fields["fixed"] == clamp).all())
        self.assertLess(abs(fields["displacement"][clamp] - [0, 0, 0.01]).max(), 1e-15)

    def test_an_event_moves_a_fix(self):
        text = CUBE + """
[[fix]]
select = { plane = { axis = "x", at = 0 } }
[[event]]
at = 0.005
set = { "fix.0.velocity" = [-0.5, 0, 0] }
[[event]]
at = 0.015
set = { "fix.0.velocity" = [0, 0, 0] }
"""
        rows = self.simulate(text)
        self.assert_books_close(rows)
        fields, points = self.fields("out", "final.vtu")
        clamp = points[:, 0] == 0
        self.assertLess(abs(fields["displacement"][clamp] - [-0.005, 0, 0]).max(), 1e-15)
        self.assertGreater(rows[-1]["constraint_work"], 0)
        self.assertEqual(rows[-1]["constraint_work"], rows[16]["constraint_work"])

    def test_an_event_changes_a_rod(self):
        text = CUBE + """
[[constraint]]
kind = "distance"
vertices = [0, 2]
[[event]]
at = 0.01
set = { "constraint.0.length" = 1.1 }
"""
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
                message = self.refused_scene(event + lines + "\n")
                for part in parts:
                    self.assertIn(part, message)

    def test_events_that_fail_in_the_run_keep_what_was_computed(self):
        text = CUBE + """
[initial]
velocity = [1, 0, 0]
[[fix]]
select = { vertices = [0] }
[[event]]
at = 0.01
fix = { select = { vertices = [0] }, offset = [0, 0, 0.1] }
"""
        rows = self.simulate(text, code=1)
        self.assertEqual(len(rows), 11)
        self.assertEqual(len(self.messages()), 1)
        for part in ("event at 0.01 s", "event.0.fix", "fix.0", "vertex 0"):
            self.assertIn(part, self.result.stderr)
        self.assertEqual(self.summary("out")["status"], "failed")
        self.run_program("mesh", "info", self.path("out", "final.vtu"))

    def test_events_that_make_the_step_too_large_are_warned_of(self):
        text = CUBE.replace("end = 0.02", "end = 2")
        event = '[[event]]\nat = 0.01\nset = { "time.step" = 0.1 }\n[initial]\nstretch=[1.01,1,1]\n'
        self.simulate(text + event, code=1)
        self.assertEqual(len(self.warnings_of()), 1)
        for part in ("event at 0.01 s", "h_crit", "verlet"):
            self.assertIn(part, self.warnings_of()[0])
        self.assertIn("h_crit", self.summary("out")["events"][0]["warning"])

    # Constraints.

    def test_contradictions_are_refused(self):
        rod = '[[constraint]]\nkind = "distance"\nvertices = [0, 2]\nlength = {}\n'
        fix = "[[fix]]\nselect = {{ vertices = [0] }}\noffset = [0, 0, {}]\n"
        message = self.refused_scene(CUBE + fix.format(0) + fix.format(0.1))
        for part in ("scene.toml:11:1: fix.0", "scene.toml:14:1: fix.1", "vertex 0"):
            self.assertIn(part, message)
        message = self.refused_scene(CUBE + rod.format(1) + rod.format(1.1))
        self.assertRegex(message, r"scene\.toml:1[15]:1: constraint\.[01]")
        # A rod between two fixed vertices that is too long.
        ends = "[[fix]]\nselect = { vertices = [0, 2] }\n"
        self.assertIn("constraint.0", self.refused_scene(CUBE + ends + rod.format(1.1)))
        # A handle and a rod of another length in it.
        handle = '[[constraint]]\nkind = "rigid"\nselect = { plane = { axis = "y", at = 0 } }\n'
        self.assertIn("constraint.", self.refused_scene(CUBE + handle + rod.format(1.1)))
        # A fixed vertex in a free handle.
        message = self.refused_scene(CUBE + handle + fix.format(0))
        self.assertIn("constraint.0", message)
        self.assertIn("vertex 0", message)
        # A fixed vertex off its plane; parallel planes.
        plane = ('[[constraint]]\nkind = "plane"\nselect = {{ vertices = [0] }}\n'
                 "point = [0, 0, {}]\nnormal = [0, 0, 1]\n")  # fmt: skip
        message = self.refused_scene(CUBE + fix.format(0) + plane.format(0.1))
        self.assertRegex(message, r"constraint\.0|fix\.0")
        self.assertIn("vertex 0", message)
        message = self.refused_scene(CUBE + plane.format(0) + plane.format(0.1))
        self.assertRegex(message, r"constraint\.[01]")
        # Vertices and selections that are not there.
        self.assertIn("1000", self.refused_scene(
            CUBE + '[[constraint]]\nkind = "distance"\nvertices = [0, 1000]\n'))  # fmt: skip
        self.assertIn("constraint.0", self.refused_scene(
            CUBE + '[[constraint]]\nkind = "rigid"\nselect = { group = "lid" }\n'))  # fmt: skip

    def test_a_body_of_which_every_vertex_is_held(self):
        scene = self.write(
            "held.toml",
            BEAM.replace('{ plane = { axis = "x", at = 0.0 } }', "{ all = true }"),
        )
        report = json.loads(self.run_program("check", scene, "--json").stdout)
        self.assertEqual(report["free_degrees_of_freedom"], 0)
        self.assertIsNone(report["stable_step"])
        self.assertIn("every vertex is held", self.run_program("check", scene).stdout)
        for rule in ("explicit", "verlet", "midpoint", "backward-euler"):
            for solver in ("newton", "ceres"):
                with self.subTest(rule=rule, solver=solver):
                    self.run_program(
                        "run", scene, "--out", self.path("out"), "--set", f"time.integrator={rule}",
                        "--set", f"solver.kind={solver}",
                    )  # fmt: skip
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
        self.run_program("run", scene, "--out", self.path("out"))
        scene = self.write("differ.toml", BEAM.replace("[output]", fixes.replace("yz", "xz")))
        self.assertIn("different targets", self.refused(2, "run", scene))

    def test_a_force_that_acts_for_less_than_a_step(self):
        scene = self.write(
            "push.toml",
            """
[mesh]
generate = { kind = "cube", size = 1.0, cells = 2 }
[material]
model = "neo-hookean"
youngs_modulus = 1.0e4
poissons_ratio = 0.3
density = 10.0
[time]
integrator = "explicit"
step = 0.002
end = 0.1
[[force]]
select = { all = true }
vector = [10.0, 0, 0]
from = 0.012
until = 0.013
""",
        )
        for step in (0.0004, 0.002, 0.05):
            rule = "explicit" if step < 0.01 else "midpoint"
            self.run_program(
                "run", scene, "--out", self.path("out"), "--set", f"time.step={step}",
                "--set", f"time.integrator={rule}",
            )  # fmt: skip
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
        message = self.refused_scene(CUBE + handle + "angular_velocity = [0, 0, 1]\n")
        for part in ("scene.toml:11:1: constraint.0", "line"):
            self.assertIn(part, message)
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
        pulled = CUBE + """
[[constraint]]
kind = "distance"
vertices = [0, 2]
[[force]]
select = { vertices = [0] }
vector = [-300, 0, 0]
[[force]]
select = { vertices = [2] }
vector = [300, 0, 0]
"""
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
        text = CUBE + """
[initial]
velocity = [1, 2, 3]
[[constraint]]
kind = "plane"
select = { plane = { axis = "z", at = 0 } }
normal = [0, 0, -5]
[[constraint]]
kind = "line"
select = { vertices = [26] }
direction = [1, 1, 0]
"""
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
        text = CUBE + """
[output]
every = 1
[environment]
kind = "gravity"
[[fix]]
select = { plane = { axis = "x", at = 0 } }
[[constraint]]
kind = "distance"
vertices = [2, 26]
[[constraint]]
kind = "plane"
select = { vertices = [20] }
normal = [0, 1, 1]
[[force]]
select = { nearest = [1, 1, 0] }
vector = [10, 300, -20]
"""
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

    # Regions and environments.

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
        import vtk
        from vtk.util.numpy_support import vtk_to_numpy

        reader = vtk.vtkXMLUnstructuredGridReader()
        reader.SetFileName(self.path("out", "final.vtu"))
        reader.Update()
        region = vtk_to_numpy(reader.GetOutput().GetCellData().GetArray("region"))
        self.assertEqual([(region == r).sum() for r in range(3)], [72, 96, 24])
        # A region that selects no element is an error.
        nowhere = "material_region.0.select={box={min=[9,9,9],max=[9,9,9]}}"
        message = self.refused_scene(text, nowhere)
        self.assertIn("material_region.0", message)
        # What mass appears from nowhere is refused, in an event too.
        self.assertIn("density", self.refused_scene(
            text, 'event.0.set={"material_region.1.density"=10}'))  # fmt: skip

    def falling_body(self):
        """A tetrahedron on the x axis, one vertex towards the origin."""
        self.write("fall.node", "4 3 0 0\n0 1 0 0\n1 2 1 0\n2 2 -0.5 0.8660254037844386\n"
                   "3 2 -0.5 -0.8660254037844386\n")  # fmt: skip
        self.write("fall.ele", "1 4 0\n0 0 1 2 3\n")
        return """
[mesh]
file = "fall.node"
[material]
youngs_modulus = 1e6
poissons_ratio = 0.3
[time]
step = 1e-3
end = 2
[output]
every = 1000
[environment]
kind = "attraction"
strength = 1e3
"""

    def test_attraction_through_the_origin(self):
        text = self.falling_body()
        for integrator in INTEGRATORS:
            for step in ("1e-3", "3e-3"):
                with self.subTest(integrator, step=step):
                    overrides = (f"time.integrator={integrator}", f"time.step={step}")
                    scene = self.write("scene.toml", text)
                    result = subprocess.run(
                        [PROGRAM, "run", scene, "--out", self.path("out"), "--quiet", "--set",
                         overrides[0], "--set", overrides[1]],
                        capture_output=True, text=True, timeout=300,
                    )  # fmt: skip
                    self.assertIn(result.returncode, (0, 1), result.stderr)
                    rows = self.history("out", "history.csv")
                    for row in rows:
                        for name, value in row.items():
                            self.assertTrue(math.isfinite(value), f"{name}: {value}")
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
        scene = self.write("scene.toml", CUBE)
        result = subprocess.run(
            [PROGRAM, "run", scene, "--out", self.path("out"), "--quiet", "--set",
             'environment={kind="attraction",strength=1e300,softening=1e-200}'],
            capture_output=True, text=True, timeout=300,
        )  # fmt: skip
        self.assertIn(result.returncode, (1, 2), result.stderr)
        self.assertEqual(len([l for l in result.stderr.splitlines() if "warning" not in l]), 1)
        if os.path.exists(self.path("out", "history.csv")):
            for row in self.history("out", "history.csv"):
                for name, value in row.items():
                    self.assertTrue(math.isfinite(value), f"{name}: {value}")

    def test_more_steps_than_can_be_counted(self):
        for override in ("time.step=1e-300", "time.step=1e-22", "time.end=1e300"):
            with self.subTest(override):
                message = self.refused_scene(CUBE, override)
                self.assertIn("time.step", message)
                self.assertNotIn("less than half", message)
        for setting in ('"time.step" = 1e-300', '"time.end" = 1e300'):
            with self.subTest(setting):  # not a run that ends well at 0.01 s
                text = CUBE + f"[[event]]\nat = 0.01\nset = {{ {setting} }}\n"
                scene = self.write("scene.toml", text)
                result = subprocess.run(
                    [PROGRAM, "run", scene, "--out", self.path("out"), "--quiet"],
                    capture_output=True, text=True, timeout=300,
                )  # fmt: skip
                self.assertIn(result.returncode, (1, 2), result.stderr)
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

    def test_the_other_commands_take_such_scenes(self):
        scene = self.write("scene.toml", EVENTS)
        self.run_program("check", scene)
        report = json.loads(self.run_program("check", scene, "--json").stdout)
        self.assertAlmostEqual(report["mass"], 4000, delta=1e-9)
        echo = self.run_program("run", scene, "--json", "--out", self.path("out"))
        self.assertEqual(len(json.loads(echo.stdout)["scene"]["event"]), 7)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]], verbosity=1)
