"""The commands of meshes."""

import csv
import os
import sys

sys.path.insert(0, f"{sys.path[0]}/..")
from support.program import DATA, ProgramTest, main


class Mesh(ProgramTest):
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
                      self.run_program(f"mesh info {mesh}").stdout)
        info = self.json_of(f"mesh info {mesh}")
        self.assertEqual(info["cell_arrays"]["E"], {"components": 1, "min": 2e5, "max": 5e5})
        for name in ("a.vtu", "a.vtk", "a.msh"):
            self.assertNotIn("lost", self.run_program("mesh", "convert", mesh,
                                                      self.path(name)).stderr)  # fmt: skip
            self.assertIn("E", self.json_of("mesh info", self.path(name))["cell_arrays"])
        self.assertIn("these arrays of", self.run_program(f"mesh convert {mesh} a.veg").stderr)

    def test_convert_keeps_the_mesh(self):
        part = os.path.join(DATA, "serpentine_spring.msh")
        volume = self.json_of(f"mesh info {part}")["volume"]
        for ending in ("vtu", "vtk", "msh", "veg", "node"):
            out = self.path("part." + ending)
            self.run_program(f"mesh convert {part} {out}")
            info = self.json_of(f"mesh info {out}")
            self.assertEqual(info["tetrahedra"], 6194, ending)
            self.assertAlmostEqual(info["volume"], volume, delta=1e-15 * volume)

    def test_quadratic_tetrahedra(self):
        """A sphere with curved edges, and a beam whose bending linear tetrahedra miss."""
        sphere = os.path.join(os.path.dirname(__file__), "..", "data", "meshes", "sphere_p2.msh")
        volume = self.json_of(f"mesh info {sphere}")["volume"]
        for ending in ("vtu", "vtk", "msh"):
            out = self.path("sphere." + ending)
            self.run_program(f"mesh convert {sphere} {out}")
            info = self.json_of(f"mesh info {out}")
            self.assertEqual((info["tetrahedra"], info["element"]), (683, "quadratic"))
            self.assertAlmostEqual(info["volume"], volume, delta=1e-14 * volume)
        self.assertIn("683 quadratic tetrahedra", self.run_program(f"mesh info {sphere}").stdout)

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
        self.run_program("mesh generate beam --size 4,1,1 --cells 20,4,4 beam.vtu")
        info = self.json_of("mesh info beam.vtu")
        self.assertEqual((info["vertices"], info["tetrahedra"]), (525, 1920))
        self.assertEqual(info["bounding_box"]["max"], [4, 1, 1])
        self.assertGreater(info["quality"][0]["min"], 0.4)
        self.run_program("mesh generate tetrahedron t.vtk")
        self.assertIn("1 tetrahedra", self.run_program("mesh info t.vtk").stdout)


if __name__ == "__main__":
    main()
