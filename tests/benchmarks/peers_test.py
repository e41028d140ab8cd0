"""The command that computes one beam with this library and with other programs, benchmarks/peers/run.

Usage: python3 peers_test.py COMMAND OWN_PROGRAM FOLDER [unittest arguments]

OWN_PROGRAM is tetraction_beam. In FOLDER the command builds what belongs to the other programs that are installed.
"""

import os
import re
import subprocess
import sys
import tempfile
import unittest

COMMAND, OWN, FOLDER = map(os.path.abspath, sys.argv[1:4])
sys.dont_write_bytecode = True
sys.path.insert(0, os.path.dirname(COMMAND))
import beam  # noqa: E402
from table import disagreements, merged, table  # noqa: E402

# The mean of the free end of S after 20 steps, m, as Vega FEM 4.0 computes it.
TIP = -0.2162120364


def run(*arguments):
    return subprocess.run([sys.executable, COMMAND, "--own", OWN, "--folder", FOLDER, *arguments],
                          capture_output=True, text=True, check=False)  # fmt: skip


def rows_of(text):
    """The cells of the rows below the heading."""
    lines = [line for line in text.splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[2:]]


class Peers(unittest.TestCase):
    def test_one_body_with_all_that_is_installed(self):
        done = run("--sizes", "S", "--rounds", "1")
        self.assertEqual(done.returncode, 0, done.stderr)
        rows = rows_of(done.stdout)
        names = [row[1].split(",")[0] for row in rows]
        missing = [name for name in ("deal.II", "dolfinx") if f"{name} is not installed" in done.stderr]
        self.assertEqual(sorted(names + missing), ["deal.II", "dolfinx", "tetraction"])
        self.assertEqual(done.stderr.count("apt-get install"), len(missing))
        self.assertEqual(names[0], "tetraction")
        self.assertAlmostEqual(float(re.search(r"-0\.\d+", rows[0][-1])[0]), TIP, delta=1e-9)
        for row in rows:
            self.assertEqual(len(row), 8)
            self.assertEqual(row[0], "S")
            # Time, ratio, iterations and memory are there; their values are not a matter of a test.
            self.assertTrue(all(float(cell) > 0 for cell in row[2:7]), row)
        for row in rows[1:]:
            self.assertLess(float(row[-1]), 1e-7)
        self.assertRegex(done.stdout, r"\ntetraction \d+\.\d+\.\d+.*; .+, one of \d+ cores")
        self.assertEqual([name for name in os.listdir(FOLDER) if name.startswith("tmp")], [])

    def test_without_other_programs(self):
        done = run("--sizes", "S", "--rounds", "2", "--steps", "2", "--without-peers")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(len(rows_of(done.stdout)), 1)
        self.assertNotIn("not installed", done.stderr)

    def test_wrong_arguments_and_programs(self):
        for arguments in (["--sizes", "S,Q"], ["--rounds", "0"], ["--core", "100000"]):
            done = run(*arguments)
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertEqual(done.stdout, "")
        with tempfile.NamedTemporaryFile("w", suffix=".txt") as file:
            for text in ("", "weight 7\n", "vertices 2\n1 2 3\n"):
                file.seek(0)
                file.truncate()
                file.write(text)
                file.flush()
                done = subprocess.run([OWN, file.name], capture_output=True, text=True, check=False)
                self.assertEqual(done.returncode, 1)
                self.assertIn(file.name, done.stderr)


class PeersTable(unittest.TestCase):
    def result(self, program, tip, seconds=(0.5, 0.25)):
        return {"program": program, "version": "1.0", "solver": "cg", "seconds": list(seconds),
                "newton": 4, "iterations": 60, "bytes": 2000, "tip": tip}  # fmt: skip

    def test_least_times_of_all_rounds(self):
        rounds = [self.result("ours", -1.0, (3.0, 1.0)), self.result("ours", -1.0, (2.0, 4.0))]
        rounds[1]["bytes"] = 1000
        best = merged(rounds)
        self.assertEqual(best["seconds"], [2.0, 1.0])
        self.assertEqual(best["bytes"], 1000)
        self.assertEqual(rounds[0]["seconds"], [3.0, 1.0])

    def test_columns(self):
        results = {"S": [self.result("ours", -1.0), self.result("other", -1.00000002, (1.5, 0.0))]}
        rows = rows_of("\n".join(table(results, {"S": 10})))
        self.assertEqual(rows[0], ["S", "ours, cg", "375", "1", "2.00", "30.0", "200", "tip: -1.000000000 m"])
        self.assertEqual(rows[1], ["S", "other, cg", "750", "2.0", "2.00", "30.0", "200", "2e-08"])

    def test_different_answers_are_told(self):
        ours = self.result("ours", -1.0)
        near, far = self.result("near", -1.00000005), self.result("far", -1.001)
        broken = self.result("broken", float("nan"))
        told = disagreements({"S": [ours, near], "M": [ours, near, far, broken]})
        self.assertEqual(len(told), 2)
        self.assertIn("far, cg: the tip of M", told[0])
        self.assertIn("broken, cg: the tip of M", told[1])


class PeersBeam(unittest.TestCase):
    def test_tetrahedra_fill_the_beam(self):
        cells = (3, 2, 1)
        points = list(beam.vertices(cells))
        self.assertEqual(len(points), 4 * 3 * 2)
        self.assertEqual((points[0], points[-1]), ((0, 0, 0), beam.LENGTHS))
        total = 0.0
        faces = {}
        for corners in beam.tetrahedra(cells):
            origin, *ends = (points[corner] for corner in corners)
            a, b, c = ([x - y for x, y in zip(end, origin)] for end in ends)
            volume = (a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2])
                      + a[2] * (b[0] * c[1] - b[1] * c[0])) / 6  # fmt: skip
            self.assertAlmostEqual(volume, 4 / 36)
            total += volume
            for left_out in corners:
                face = tuple(sorted(set(corners) - {left_out}))
                faces[face] = faces.get(face, 0) + 1
        self.assertAlmostEqual(total, 4.0)
        self.assertEqual(beam.tetrahedron_count(cells), 36)
        # Two triangles on each of the 2 (6 + 3 + 2) quadrilaterals of the surface belong to one tetrahedron, the
        # others to two.
        self.assertEqual(sum(count == 1 for count in faces.values()), 2 * 2 * (3 * 2 + 3 * 1 + 2 * 1))
        self.assertEqual(max(faces.values()), 2)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]])
