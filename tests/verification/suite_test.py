"""The verification suite itself: it finds numbers that are off, and its meshes are right.

Usage: suite_test.py PROGRAM [TestCase...]
"""

import json
import os
import shutil
import subprocess
import sys
import tempfile
import unittest

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "suite"))

from cases import Case  # noqa: E402
from meshes import SHAPES, write_mesh  # noqa: E402
from program import Program, ProgramError  # noqa: E402

PROGRAM = os.path.abspath(sys.argv[1])
# Volumes of the bodies in m³, with straight and with curved edges where these differ.
VOLUMES = {
    "arc_beam": ((4, 2, 1), None),
    "cook": ((2, 2, 1), 5760.0),
    "bushing": ((12, 2, 2), 3.1667254e-5),
    "l_block": ((3, 3, 3), 117.0),
    "cross": ((1, 1, 1), 13.0),
    "distorted_box": ((3, 2, 2), 2.0),
    "elliptic_plate": ((4, 6, 2), 3.2692199),
    "graded_block": ((3, 3, 3), None),
    "ball": ((4, 4, 4), None),
}


class Suite(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def copy_of(self, name, old, new):
        """A case whose description has been changed."""
        folder = os.path.join(self.folder, name)
        shutil.copytree(os.path.join(HERE, "cases", name), folder)
        path = os.path.join(folder, "case.toml")
        with open(path, encoding="utf-8") as file:
            text = file.read()
        self.assertIn(old, text)
        with open(path, "w", encoding="utf-8") as file:
            file.write(text.replace(old, new))
        return Case(folder)

    def failures(self, case):
        values, orders = case.execute(Program(PROGRAM), os.path.join(self.folder, "w"), True)
        self.assertTrue(values)
        return sorted(v.quantity for v in values if not v.holds)

    def test_a_number_that_is_off_is_found(self):
        case = self.copy_of("simple_shear", '"neo-hookean" = 0.5,', '"neo-hookean" = 0.5000001,')
        self.assertEqual(self.failures(case), ["σ₁₂"] * 3)

    def test_a_scene_that_is_wrong_is_found(self):
        self.assertEqual(self.failures(self.copy_of("wave_front", "within = 0.01", "within = 0.01")), [])
        case = self.copy_of("simple_shear", '"stvk" } }', '"stvk", "material.lambda" = 1.6 } }')
        self.assertEqual(self.failures(case), ["σ₁₁"] * 2 + ["σ₁₂"] * 2)

    def test_a_run_that_fails_is_an_error(self):
        case = self.copy_of("simple_shear", '"stvk" } }', '"stvk", "material.lambda" = -1.0 } }')
        with self.assertRaisesRegex(ProgramError, "lambda"):
            self.failures(case)

    def test_misses_that_are_too_small_are_found(self):
        case = self.copy_of("simple_shear", "within = 1e-10", "beyond = 0.1")
        self.assertEqual(len(self.failures(case)), 10)

    def test_meshes_fill_their_bodies(self):
        self.assertEqual(set(VOLUMES), set(SHAPES))
        for shape, (cells, exact) in VOLUMES.items():
            volumes = {}
            for element in ("linear", "quadratic"):
                path = os.path.join(self.folder, f"{shape}-{element}.msh")
                write_mesh(path, shape, cells, element)
                info = subprocess.run([PROGRAM, "mesh", "info", path, "--json"], check=True,
                                      capture_output=True, text=True)
                data = json.loads(info.stdout)
                volumes[element] = data["volume"]
                self.assertEqual(data["reoriented_tetrahedra"], 0, shape)
            if exact is not None:
                # Curved edges come to within a ten-thousandth; straight ones have chords for arcs.
                self.assertAlmostEqual(volumes["quadratic"] / exact, 1.0, delta=2e-4, msg=shape)
                self.assertAlmostEqual(volumes["linear"] / exact, 1.0,
                                       delta=0.06 if shape in ("bushing", "elliptic_plate") else 1e-12,
                                       msg=shape)

    def test_scenes_run_by_themselves(self):
        for name in sorted(os.listdir(os.path.join(HERE, "cases"))):
            case = Case(os.path.join(HERE, "cases", name))
            mesh = case.write_shipped_mesh(self.folder)
            if mesh is not None:
                with open(mesh, encoding="utf-8") as made:
                    with open(os.path.join(case.folder, os.path.basename(mesh)), encoding="utf-8") as kept:
                        self.assertEqual(made.read(), kept.read(), f"scripts/verify --meshes {name}")
            check = subprocess.run([PROGRAM, "check", case.scene], check=False,
                                   capture_output=True, text=True)
            self.assertEqual(check.returncode, 0, check.stderr)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0]] + sys.argv[2:])
