"""The real program in a folder of its own, for the tests of its commands.

All these tests are called as: python3 NAME_test.py PROGRAM DATA_DIRECTORY [CLASS...]
"""

import contextlib
import csv
import json
import os
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
import unittest


PROGRAM, DATA = os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2])

BEAM_MESH = 'generate = { kind = "beam", size = [4, 1, 1], cells = [8, 2, 2] }'
BEAM_CLAMP = '[[fix]]\nselect = { plane = { axis = "x", at = 0.0 } }\n'
BEAM = f"""
[mesh]
{BEAM_MESH}
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
{BEAM_CLAMP}[output]
every = 4
"""
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
INTEGRATORS = ("explicit", "verlet", "midpoint", "backward-euler", "energy-momentum")


def main(operands=2):
    """Runs the classes that the command line names behind this many operands."""
    unittest.main("__main__", argv=[sys.argv[0], *sys.argv[1 + operands :]])


def own_lines(stderr):
    """The lines without the warning of a slow BLAS, which is the machine's and not the run's."""
    return [l for l in stderr.splitlines() if not ("warning: " in l and "BLAS" in l)]


def sets(*overrides):
    """The arguments that change these keys of a scene."""
    return [word for override in overrides for word in ("--set", override)]


def read_grid(path):
    """A VTU file as VTK's grid, its arrays of points and cells by their names, and its points."""
    import vtk
    from vtk.util.numpy_support import vtk_to_numpy

    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(path)
    reader.Update()
    grid = reader.GetOutput()
    arrays = {
        data.GetArrayName(i): vtk_to_numpy(data.GetArray(i)).copy()
        for data in (grid.GetCellData(), grid.GetPointData())
        for i in range(data.GetNumberOfArrays())
    }
    return grid, arrays, vtk_to_numpy(grid.GetPoints().GetData()).copy()


def files_below(folder):
    """The contents of all files of a folder by their paths."""
    result = {}
    for root, _, names in os.walk(folder):
        for name in names:
            path = os.path.join(root, name)
            with open(path, "rb") as file:
                result[os.path.relpath(path, folder)] = file.read()
    return result


class ProgramTest(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="tetraction-test-")
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)

    def path(self, *names):
        return os.path.join(self.folder, *names)

    def exists(self, *names):
        return os.path.exists(self.path(*names))

    def write(self, name, text):
        with open(self.path(name), "wb") as file:
            file.write(text if isinstance(text, bytes) else text.encode())
        return self.path(name)

    def read_bytes(self, *names):
        with open(self.path(*names), "rb") as file:
            return file.read()

    def read(self, *names):
        return self.read_bytes(*names).decode()

    def read_json(self, *names):
        return json.loads(self.read_bytes(*names))

    def summary(self, *names):
        return self.read_json(*names, "summary.json")

    def table(self, *names):
        """The rows of a table of texts by the names of its columns."""
        return list(csv.DictReader(self.read(*names).splitlines()))

    def history(self, *names):
        return [{k: float(v) for k, v in row.items()} for row in self.table(*names)]

    def run_program(self, *arguments, code=0, env=None, cwd=None):
        """Blanks in the first argument separate words. The exit code is this one or one of these."""
        environment = {**os.environ, **(env or {})}  # None takes a variable out
        result = subprocess.run(
            [PROGRAM, *words_of(arguments)], capture_output=True, encoding="utf-8",
            errors="surrogateescape", timeout=300, cwd=cwd or self.folder,
            env={name: value for name, value in environment.items() if value is not None},
        )  # fmt: skip
        codes = (code,) if isinstance(code, int) else code
        self.assertIn(result.returncode, codes, result.stdout + result.stderr)
        for trace in ("terminate called", "Segmentation", "Assertion", "core dumped"):
            self.assertNotIn(trace, result.stderr)
        return result

    def slow_blas(self):
        """An environment in which OpenBLAS is slow, where the machine can have one."""
        slow = {"OPENBLAS_CORETYPE": "Prescott"}
        if "Prescott" not in self.run_program("--version", env=slow).stdout:
            self.skipTest("OpenBLAS has no such kernels here")
        if " avx2 " not in self.read("/proc/cpuinfo"):
            self.skipTest("the processor has nothing better")
        return slow

    def json_of(self, *arguments, **keywords):
        """The output with --json."""
        return json.loads(self.run_program(*arguments, "--json", **keywords).stdout)

    def refused(self, code, *arguments, says=()):
        """One message on stderr, beside what is said of the machine, and nothing on stdout. The message has
        this text or all these texts."""
        result = self.run_program(*arguments, code=code)
        self.assertEqual(result.stdout, "")
        messages = [l for l in own_lines(result.stderr) if l.startswith("tetraction: ")]
        self.assertEqual(len(messages), 1, result.stderr)
        message = "\n".join(own_lines(result.stderr))
        self.assert_parts(message, says)
        return message

    def assert_parts(self, text, parts):
        for part in (parts,) if isinstance(parts, str) else parts:
            self.assertIn(part, text)

    def start(self, *arguments, **keywords):
        """The program in the background. It is killed at the end of the test."""
        process = subprocess.Popen([PROGRAM, *words_of(arguments)], cwd=self.folder, text=True,
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, **keywords)  # fmt: skip
        for cleanup in (process.stdout.close, process.stderr.close, process.wait, process.kill):
            self.addCleanup(cleanup)
        return process

    def wait_for(self, condition, process=None, seconds=60):
        """Waits until the condition holds while the process runs."""
        end = time.monotonic() + seconds
        while not condition():
            self.assertLess(time.monotonic(), end, "waited too long")
            if process is not None and process.poll() is not None:
                self.fail(process.stderr.read())
            time.sleep(0.002)

    @contextlib.contextmanager
    def small_disk(self, name, size):
        """A file system in memory, where the machine allows one."""
        os.makedirs(self.path(name), exist_ok=True)
        mount = ["mount", "-t", "tmpfs", "-o", f"size={size}k", "tmpfs", self.path(name)]
        if subprocess.run(mount, capture_output=True).returncode != 0:
            self.skipTest("no file system can be mounted")
        try:
            yield
        finally:
            subprocess.run(["umount", self.path(name)], check=True)

    def wait_for_file(self, process, *names):
        self.wait_for(lambda: self.exists(*names), process)


class BeamTest(ProgramTest):
    """Tests with the scene BEAM as beam.toml."""

    def setUp(self):
        super().setUp()
        self.write("beam.toml", BEAM)


def words_of(arguments):
    first, *others = arguments or ("",)
    if isinstance(first, str) and " " in first:
        return [*shlex.split(first), *others]
    return list(arguments)
