"""Runs: what they write, and how they fail."""

import json
import math
import os
import sys
import xml.etree.ElementTree as ElementTree

sys.path.insert(0, f"{sys.path[0]}/..")
from support.program import DATA, BEAM_MESH, BEAM, BeamTest, main, read_grid, sets
from support.scenes import tables


class Run(BeamTest):
    def test_the_step_is_written_as_it_is_read(self):
        self.run_program("run beam.toml --out out --set time.step=1e-6 --set time.end=3e-6")
        steps = [row["time_step"] for row in self.table("out", "history.csv")]
        self.assertEqual(steps, ["0", "1e-06", "1e-06", "1e-06"])

    def test_outputs(self):
        result = self.run_program("run beam.toml --out out")
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
            self.assertTrue(self.exists("out", s.get("file")))

        summary = self.read_json("out", "summary.json")
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
        self.run_program("run beam.toml --out out --quiet")
        grid, arrays, points = read_grid(self.path("out", "final.vtu"))
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
        fixed, displacement = arrays["fixed"], arrays["displacement"]
        self.assertEqual(fixed.sum(), 9)
        self.assertTrue((displacement[fixed == 1] == 0).all())
        self.assertTrue((points[fixed == 1][:, 0] == 0).all())
        self.assertLess(displacement[:, 1].min(), -0.01)
        # The history's elastic energy is the sum of density times rest volume.
        volume = 4.0 / 192
        last = self.history("out", "history.csv")[-1]
        self.assertAlmostEqual(arrays["energy_density"].sum() * volume, last["elastic_energy"], places=8)
        # And p its momentum.
        for value, key in zip(arrays["momentum"].sum(axis=0), ("px", "py", "pz")):
            self.assertAlmostEqual(value, last[key], places=8)

    def test_integrators_and_automatic_step(self):
        for integrator in ("explicit", "verlet"):
            result = self.run_program(f"run beam.toml --out {integrator} --json --set "
                                      f"time.integrator={integrator} --set", 'time.step="auto"')  # fmt: skip
            summary = json.loads(result.stdout)
            self.assertAlmostEqual(summary["time_step"], 0.5 * summary["stable_step"], places=15)
            self.assertLess(summary["linear_momentum_drift"], 1e-12)

    def test_solvers(self):
        energies = []
        runs = [("ceres", "auto"), ("newton", "auto"), ("newton", "matrix-free"), ("newton", "cg"),
                ("newton", "factor")]  # fmt: skip
        for kind, linear in runs:
            result = self.run_program(f"run beam.toml --out out --json --set solver.kind={kind} "
                                      f"--set solver.linear={linear}")  # fmt: skip
            summary = json.loads(result.stdout)
            for solver in (summary["solver"], summary["scene"]["solver"]):
                self.assertEqual((solver["kind"], solver["linear"]), (kind, linear))
            if kind == "ceres":
                self.assertEqual(summary["solver"]["linear_used"], "cholesky")
                self.assertEqual(summary["solver"]["cg_iterations"], 0)
            energies.append(self.history("out", "history.csv")[-1]["elastic_energy"])
        for energy in energies:
            self.assertAlmostEqual(energy / energies[0], 1, delta=1e-6)
        message = self.refused(2, "run beam.toml --set solver.kind=ceres --set solver.linear=cg")
        self.assertIn("solver.linear", message)
        # Explicit rules have no solver.
        result = self.run_program("run beam.toml --out out --json --set solver.kind=newton --set "
                                  "time.integrator=verlet --set time.step=auto")  # fmt: skip
        solver = json.loads(result.stdout)["solver"]
        self.assertEqual((solver["linear_used"], solver["iterations"]), (None, 0))

    def test_an_event_changes_the_solver(self):
        change = '[[event]]\nat = 0.05\nset = { "solver.kind" = "newton", "solver.linear" = "cg" }\n'
        scene = self.write("beam.toml", BEAM + '[solver]\nkind = "ceres"\n' + change)
        result = self.run_program(f"run {scene} --out out --json")
        summary = json.loads(result.stdout)
        self.assertEqual(summary["scene"]["solver"]["kind"], "ceres")
        self.assertEqual((summary["solver"]["kind"], summary["solver"]["linear"]), ("newton", "cg"))
        self.assertEqual(summary["events"][0]["energy_jump"], 0)

    def test_a_slow_blas_is_warned_of_once(self):
        slow = self.slow_blas()

        def warnings(*arguments, env=slow):
            lines = self.run_program(*arguments, env=env).stderr.splitlines()
            return [line for line in lines if "OPENBLAS_CORETYPE=Prescott" in line]

        run = ["run", "beam.toml", "--out", self.path("out")]
        verlet = ["--set", "time.integrator=verlet", "--set", "time.step=auto"]
        self.assertEqual(len(warnings(*run)), 1)
        self.assertIn("OPENBLAS_CORETYPE=Prescott", self.read_json("out", "summary.json")["warnings"][0])
        self.assertEqual(warnings(*run, env={"OPENBLAS_CORETYPE": None}), [])
        self.assertEqual(warnings(*run, *verlet), [])
        study = ["study", "beam.toml", "--steps", "0.005,0.01", "--no-plots", "--out", self.path("s")]
        self.assertEqual(len(warnings(*study, "--integrators", "midpoint,backward-euler")), 1)
        self.assertEqual(
            warnings(*study, "--integrators", "verlet", "--reference-integrator", "verlet"), []
        )

    def test_same_bits_again_and_with_other_threads(self):
        for name, threads in (("a", "1"), ("b", "1"), ("c", "2")):
            out = self.path(name)
            self.run_program("--threads", threads, "run", "beam.toml", "--out", out, "--quiet")
        texts = [self.history(n, "history.csv") for n in "abc"]
        self.assertEqual(texts[0], texts[1])
        self.assertEqual(texts[0], texts[2])

    def test_initial_fields_from_the_mesh_file(self):
        self.run_program("mesh generate cube --cells 2 cube.vtu")
        import vtk

        grid, _, _ = read_grid(self.path("cube.vtu"))
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
        scene = self.write("swing.toml", tables(mesh=dict(file="swing.vtu"),
                                                material=dict(youngs_modulus=1e5,
                                                  poissons_ratio=0.3),
                                                time=dict(integrator="verlet", step="auto",
                                                  end=0.01),
                                                initial=dict(displacement_array="swing",
                                                  velocity_array="swing")))
        self.run_program(f"run {scene} --out out --quiet")
        first = self.history("out", "history.csv")[0]
        self.assertGreater(first["elastic_energy"], 1e-3)
        self.assertGreater(first["kinetic_energy"], 1e-3)
        self.refused(2, f"run {scene} --out o --set initial.displacement_array=swong")


    def test_initial_fields_by_file_and_formula(self):
        self.write("u.csv", "vertex,x,y,z\n80,0.01,0,0\n")
        scene = self.write("beam.toml", BEAM + tables(initial=dict(displacement={"file": "u.csv"},
                                                        velocity={"formula": ["0", "0.5*X", "0"]})))
        self.run_program(f"check {scene} --json", cwd="/")
        self.run_program(f"run {scene} --out", self.path("out"), "--quiet", cwd="/")
        first = self.history("out", "history.csv")[0]
        self.assertGreater(first["elastic_energy"], 1.0)
        # The speed is 0.5 X along y, but zero at the clamp, and linear: the momentum is exact.
        self.assertAlmostEqual(first["py"] / (4000 * 0.5 * 2), 1, delta=1e-12)
        echo = self.read_json("out", "summary.json")["scene"]["initial"]
        self.assertEqual(echo["velocity"], {"formula": ["0", "0.5*X", "0"]})
        study = ["study", scene, "--steps", "0.05", "--integrators", "midpoint", "--no-plots"]
        self.run_program(*study, "--out", self.path("study"), "--quiet")
        self.write("u.csv", "vertex,x,y,z\n80,0.01,0,0\n80,1,0,0\n")
        self.assertIn("u.csv:3: vertex 80", self.refused(3, f"check {scene}"))
        self.write("u.csv", "vertex,x,y,z\n8000,0.01,0,0\n")
        self.assertIn("u.csv:2: the mesh has no vertex 8000", self.refused(3, f"run {scene}"))
        os.remove(self.path("u.csv"))
        self.assertIn("u.csv: no such file", self.refused(3, f"check {scene}"))

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
        self.run_program(f"run {scene} --out out --quiet")
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
        message = self.refused(2, f"check {scene} --set fix.0.select=clmp")
        self.assertIn("did you mean clamp? the scene has clamp or top", message)
        message = self.refused(2, f"check {scene} --set", "selection.top={not='top'}")
        self.assertIn("refer to itself: top → top", message)

    def test_the_unit_of_a_mesh_file(self):
        self.run_program("mesh generate box --size 400,100,100 --cells 8,2,2 beam.msh")
        scene = self.write("beam.toml", BEAM.replace(BEAM_MESH, 'file = "beam.msh"\nunit = "cm"'))
        report = self.json_of(f"check {scene}")
        for size, expected in zip(report["size"], (4, 1, 1)):
            self.assertAlmostEqual(size, expected, delta=1e-14)
        self.assertAlmostEqual(report["mass"], 4000, delta=1e-9)
        material = report["materials"][0]
        shear = 1e6 / 2.8
        pressure = shear + 1e6 * 0.4 / (1.4 * 0.2) + shear
        self.assertAlmostEqual(material["wave_speed"], math.sqrt(pressure / 1000), delta=1e-9)
        self.assertAlmostEqual(material["shear_wave_speed"], math.sqrt(shear / 1000), delta=1e-9)
        self.assertAlmostEqual(report["wave_time"], 4 / math.sqrt(pressure / 1000), delta=1e-9)
        text = self.run_program(f"check {scene}").stdout
        self.assertIn("size: 4 x 1 x 1 m; a pressure wave takes", text)
        twice = self.run_program(f"check {scene} --json --set mesh.scale=2").stdout
        self.assertAlmostEqual(json.loads(twice)["size"][0], 8, delta=1e-14)


class Failures(BeamTest):
    def test_unstable_run_keeps_what_was_computed(self):
        result = self.run_program("run beam.toml --out out --set time.integrator=verlet --set "
                                  "time.step=0.02 --set time.end=2", code=1)  # fmt: skip
        self.assert_parts(result.stderr, ("warning", "step ", "element ", "stability limit"))
        rows = self.history("out", "history.csv")
        self.assertGreater(len(rows), 1)
        for row in rows:
            for value in row.values():
                self.assertTrue(math.isfinite(value))
        self.assertEqual(self.read_json("out", "summary.json")["status"], "unstable")
        self.run_program("mesh info out/final.vtu")

    def test_step_so_large_that_an_element_inverts(self):
        result = self.run_program("run beam.toml --out out --set time.integrator=explicit --set "
                                  "time.step=0.02 --set time.end=2", code=1)  # fmt: skip
        self.assert_parts(result.stderr, ("inverted", "element "))

    def test_step_that_does_not_converge(self):
        result = self.run_program("run beam.toml --out out --set solver.max_iterations=1 --set "
                                  "solver.tolerance=1e-13 --set time.step=0.1", code=1)  # fmt: skip
        self.assertIn("did not converge", result.stderr)
        for line in result.stderr.splitlines():  # no library prints on its own
            self.assertTrue(line.startswith("tetraction: "), line)
        self.assertEqual(len(self.history("out", "history.csv")), 1)
        self.assertEqual(self.read_json("out", "summary.json")["status"], "failed")

    def test_wrong_scenes(self):
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
                self.refused(2, "run beam.toml --out out --set", override, says=expected)

    def test_numbers_and_keys_beyond_all_bounds(self):
        penalty = '[[fix]]\nselect = { vertices = [80] }\nmode = "penalty"\npenalty = 1e6\n'
        springs = self.write("springs.toml", BEAM + penalty)
        for key in ("material.youngs_modulus", "material.density", "mesh.generate.size.0",
                    "fix.1.penalty"):  # fmt: skip
            for value in ("1e300", "1e-300", "1e308"):
                for command in (["run", "--out", self.path("o")], ["check"]):
                    with self.subTest(key, value=value, command=command[0]):
                        file = springs if "penalty" in key else "beam.toml"
                        message = self.refused(2, *command, file, "--set", f"{key}={value}")
                        self.assertIn(key.replace(".0", ""), message)
        # What overflows only together names the keys that may be to blame.
        message = self.refused(2, "check beam.toml --set mesh.generate.size=[1e30,1e30,1e30]")
        self.assertIn("mesh.generate.size", message)
        deep = ".".join(["a"] * 35000)
        for text in (f"{deep} = 1\n", f"[{deep}]\n", f"[[{deep}]]\n", "x = " + "[" * 100000 + "\n",
                     f"[[event]]\nat = 0\nset = {{ {deep} = 1 }}\n"):  # fmt: skip
            self.assertIn("deep", self.refused(2, "check", self.write("deep.toml", BEAM + text)))
        for override in (f"{deep}=1", f"material.{deep}=1", f"x={{{deep}=1}}", "x=" + "[" * 100000):
            self.assertIn("deep", self.refused(2, "check beam.toml --set", override))

    def test_names_that_are_not_utf8(self):
        folder = os.path.join(os.fsencode(self.folder), b"f\xff")
        os.mkdir(folder)
        mesh, scene = os.path.join(folder, b"m\xe4.msh"), os.path.join(folder, b"b\xe4.toml")
        self.run_program("mesh generate beam", mesh)
        self.json_of("mesh", "info", mesh)
        with open(scene, "w") as file:
            file.write(BEAM.replace(BEAM_MESH, 'file = "m.msh"'))
        os.rename(mesh, os.path.join(folder, b"m.msh"))
        out = os.path.join(folder, b"o\xfe")
        self.json_of("check", scene)
        self.json_of("run", scene, "--out", out)
        study = ["study", scene, "--steps", "0.05", "--integrators", "midpoint", "--no-plots"]
        self.json_of(*study, "--out", out + b"s")
        with open(os.path.join(out + b"s", b"study.csv"), encoding="utf-8") as file:
            self.assertIn("\\xfe", file.read())  # in the column of the command

    def test_places_in_the_scene(self):
        wrong = self.write("wrong.toml", BEAM.replace("density = 1000.0", "densty = 1000.0"))
        self.refused(2, f"check {wrong}", says=("wrong.toml:8:1", "density"))
        broken = self.write("broken.toml", BEAM + "\n[time\n")
        self.assertRegex(self.refused(2, f"check {broken}"), r"broken\.toml:\d+:\d+")
        missing = self.write("missing.toml", BEAM.replace("[mesh]", "[output]").replace(
            "generate", "# generate").replace("[output]\nevery", "every", 1))  # fmt: skip
        self.refused(2, f"check {missing}")

    def test_wrong_files(self):
        self.refused(3, "run none.toml")
        scene = self.write("mesh.toml", BEAM.replace(BEAM_MESH, 'file = "mesh.msh"'))
        self.assertIn("mesh.msh", self.refused(3, f"run {scene}"))
        good = self.read_bytes(os.path.join(DATA, "serpentine_spring.msh"))
        self.write("mesh.msh", good[: len(good) // 2])
        self.assertIn("truncated", self.refused(3, f"run {scene}"))
        self.run_program("mesh generate box box.vtu")
        good = self.read_bytes("box.vtu")
        self.write("cut.vtu", good[: 2 * len(good) // 3])
        self.assertIn("cut.vtu", self.refused(3, "mesh info cut.vtu"))
        self.write("triangle.msh", "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n3\n1 0 0 0\n"
                   "2 1 0 0\n3 0 1 0\n$EndNodes\n$Elements\n1\n1 2 2 0 1 1 2 3\n$EndElements\n")  # fmt: skip
        self.refused(3, "mesh info triangle.msh", says="no tetrahedra")

    def test_output_that_cannot_be_written(self):
        self.write("file", "in the way")
        self.refused(4, "run beam.toml --out file/out")
        self.refused(4, "run beam.toml --out file")
        self.refused(4, "mesh generate cube nowhere/cube.vtu")

    def test_wrong_command_lines(self):
        for arguments in (["fly"], ["run"], ["run", "a.toml", "--sets", "x=1"], ["mesh"], []):
            with self.subTest(arguments):
                self.run_program(*arguments, code=2)
        self.refused(2, "study beam.toml --integrators euler")
        self.refused(2, "study beam.toml --steps -1")


if __name__ == "__main__":
    main()
