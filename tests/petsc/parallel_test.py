"""Runs in several processes against the same runs in one: mpirun -n N tetraction run.

Usage: python3 parallel_test.py PROGRAM MPIRUN DATA_DIRECTORY [unittest arguments]
"""

import csv
import json
import math
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest
import xml.etree.ElementTree as ElementTree

PROGRAM, MPIRUN, DATA = sys.argv[1:4]
PROCESSES = (1, 2, 3, 4)

# As root, on fewer cores than processes, and in containers.
ENVIRONMENT = {
    **os.environ,
    "OMPI_ALLOW_RUN_AS_ROOT": "1",
    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
    "OMPI_MCA_rmaps_base_oversubscribe": "1",
    "OMPI_MCA_btl_vader_single_copy_mechanism": "none",
}

# What acts on vertices, on elements and on faces, with everything that changes in time.
BODY = """
[mesh]
generate = { kind = "beam", size = [0.4, 0.1, 0.1], cells = [8, 3, 3] }
[material]
model = "neo-hookean"
youngs_modulus = 1.0e6
poissons_ratio = 0.3
density = 1000.0
[environment]
kind = "gravity"
"""
LOADS = """
[[material_region]]
select = { box = { min = [0.2, -1, -1], max = [1, 1, 1] } }
model = "mooney-rivlin"
mu1 = 1.0e5
mu2 = 5.0e4
lambda = 4.0e5
density = 1500.0
[[amplitude]]
name = "ramp"
points = [[0.0, 0.0], [0.01, 1.0]]
[[fix]]
select = { plane = { axis = "x", at = 0.0 } }
velocity = [0.0, 0.05, 0.0]
[[fix]]
select = { nearest = [0.4, 0.1, 0.1] }
components = "z"
mode = "penalty"
penalty = 2.0e3
[[force]]
select = { plane = { axis = "x", at = 0.4 } }
total = [5.0, 0.0, 0.0]
amplitude = "ramp"
[[force]]
select = { vertices = [17, 40] }
vector = [0.0, 0.2, 0.0]
[[traction]]
select = { faces = { normal = [0, 1, 0] } }
vector = [0.0, -200.0, 0.0]
until = 0.015
[[moment]]
select = { plane = { axis = "x", at = 0.4 } }
vector = [0.05, 0.0, 0.0]
[[body_force]]
select = { all = true }
vector = [0.0, 0.0, 300.0]
"""
PROBES = """
[[probe]]
name = "tip"
select = { plane = { axis = "x", at = 0.4 } }
quantity = "displacement"
[[probe]]
name = "support"
select = { plane = { axis = "x", at = 0.0 } }
quantity = "reaction"
[[probe]]
name = "inside"
point = [0.21, 0.04, 0.06]
quantity = "velocity"
[[probe]]
name = "stress"
select = { box = { min = [0.1, -1, -1], max = [0.3, 1, 1] } }
quantity = "von_mises"
every = 5
[[probe]]
name = "common"
point = [0.2, 0.0333333333333, 0.0333333333333]
quantity = "jacobian"
"""


def time_of(integrator, step, steps):
    return f"""
[time]
integrator = "{integrator}"
step = {step}
end = {step * steps}
"""


OUTPUT = """
[output]
every = 20
fields = ["displacement", "velocity", "cauchy_stress", "cauchy_stress_nodal", "region", "fixed"]
"""


def table(path):
    with open(path, newline="") as file:
        rows = list(csv.reader(file))
    return rows[0], [[float(cell) if cell else math.nan for cell in row] for row in rows[1:]]


def last_value(out, column):
    names, rows = table(os.path.join(out, "history.csv"))
    return rows[-1][names.index(column)]


def summary_of(out):
    with open(os.path.join(out, "summary.json"), encoding="utf-8") as file:
        return json.load(file)


# Columns that are compared relative to the largest number of any of them.
SCALES = [
    ("kinetic_energy", "elastic_energy", "environment_energy", "total_energy", "external_work",
     "dissipated_energy", "constraint_work", "edit_work", "energy_error", "kinetic_energy_0",
     "kinetic_energy_1", "elastic_energy_0", "elastic_energy_1"),
    ("px", "py", "pz"),
    ("lx", "ly", "lz"),
    ("reaction_x", "reaction_y", "reaction_z"),
]


def largest_difference(names, ours, theirs, iterations=False):
    """The largest difference of two tables, relative to the size of each kind of column."""
    kinds = {name: kind for kind in SCALES for name in kind}
    columns = {name: i for i, name in enumerate(names)}
    most, where = 0.0, ""
    for name, i in columns.items():
        if name in ("max_constraint_error", "iterations") and not iterations:
            continue
        group = [columns[n] for n in kinds.get(name, (name,)) if n in columns]
        if name not in kinds and name[-2:] in ("_x", "_y", "_z"):
            group = [j for n, j in columns.items() if n[:-2] == name[:-2]]
        scale = max((abs(row[j]) for row in ours for j in group if not math.isnan(row[j])), default=0)
        for a, b in zip(ours, theirs):
            if math.isnan(a[i]) and math.isnan(b[i]):
                continue
            difference = abs(a[i] - b[i])
            relative = 0.0 if difference == 0 else difference / scale if scale else math.inf
            if not relative <= most:
                most, where = relative, name
    return most, where


def points_of(path, array):
    """The values of a point array by the number of the vertex, and the cell array element_id."""
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOXML import vtkXMLPUnstructuredGridReader, vtkXMLUnstructuredGridReader

    reader = vtkXMLPUnstructuredGridReader() if path.endswith(".pvtu") else vtkXMLUnstructuredGridReader()
    reader.SetFileName(path)
    reader.Update()
    grid = reader.GetOutput()
    ids = vtk_to_numpy(grid.GetPointData().GetArray("vertex_id"))
    values = vtk_to_numpy(grid.GetPointData().GetArray(array))
    elements = vtk_to_numpy(grid.GetCellData().GetArray("element_id"))
    by_id = {}
    for vertex, value in zip(ids, values):
        by_id.setdefault(int(vertex), []).append(value)
    return by_id, sorted(int(e) for e in elements)


def symmetric_column(count):
    """Unit cubes in a row along x, each of 24 tetrahedra around its centre, as a file of Gmsh."""
    numbers = {}
    tetrahedra = []

    def number(*point):
        return numbers.setdefault(point, len(numbers) + 1)

    for i in range(count):
        centre = (i + 0.5, 0.5, 0.5)
        for axis in range(3):
            for side in (0, 1):
                ring = []
                for u, v in ((0, 0), (1, 0), (1, 1), (0, 1)):
                    corner = [0, 0, 0]
                    corner[axis], corner[(axis + 1) % 3], corner[(axis + 2) % 3] = side, u, v
                    ring.append((corner[0] + i, corner[1], corner[2]))
                face = tuple(sum(p[k] for p in ring) / 4 for k in range(3))
                for a, b in zip(ring, ring[1:] + ring[:1]):
                    nodes = [number(*centre), number(*face), number(*a), number(*b)]
                    tetrahedra.append(nodes if side == 1 else [nodes[0], nodes[1], nodes[3], nodes[2]])
    points = "".join(f"{n} {x} {y} {z}\n" for (x, y, z), n in numbers.items())
    cells = "".join(f"{e} 4 2 1 1 {a} {b} {c} {d}\n" for e, (a, b, c, d) in enumerate(tetrahedra, 1))
    return (f"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{len(numbers)}\n{points}$EndNodes\n"
            f"$Elements\n{len(tetrahedra)}\n{cells}$EndElements\n")


class ParallelTest(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="tetraction-parallel-")
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)

    def path(self, *names):
        return os.path.join(self.folder, *names)

    def write(self, name, text):
        with open(self.path(name), "w") as file:
            file.write(text)
        return self.path(name)

    def run_scene(self, scene, processes=None, *arguments, code=0, out=None):
        """One run; with processes None without mpirun."""
        out = out or self.path("serial" if processes is None else f"out{processes}")
        command = [PROGRAM, "run", scene, "--out", out, *arguments]
        if processes is not None:
            command = [MPIRUN, "-n", str(processes), *command]
            if processes == 1:
                command += ["--set", 'solver.engine="petsc"']
        done = subprocess.run(command, capture_output=True, text=True, cwd=self.folder, timeout=500,
                              env=ENVIRONMENT)
        self.assertEqual(done.returncode, code, done.stderr + done.stdout)
        return out, done

    def assert_one_message(self, done, text):
        own = [line for line in done.stderr.splitlines() if line.startswith("tetraction: ")]
        self.assertEqual(len(own), 1, done.stderr)
        self.assertIn(text, own[0])


class Explicit(ParallelTest):
    def compare(self, scene, tolerance=1e-12):
        serial, _ = self.run_scene(scene)
        names, rows = table(os.path.join(serial, "history.csv"))
        expected, expected_elements = points_of(os.path.join(serial, "final.vtu"), "displacement")
        size = max(max(abs(x) for x in values[0]) for values in expected.values())
        for processes in PROCESSES:
            with self.subTest(processes=processes):
                out, _ = self.run_scene(scene, processes)
                own_names, own_rows = table(os.path.join(out, "history.csv"))
                self.assertEqual(names, own_names)
                self.assertEqual(len(rows), len(own_rows))
                difference, where = largest_difference(names, rows, own_rows)
                self.assertLessEqual(difference, tolerance, where)
                found, elements = points_of(os.path.join(out, "final.pvtu"), "displacement")
                self.assertEqual(elements, expected_elements)
                self.assertEqual(found.keys(), expected.keys())
                for vertex, copies in found.items():
                    for copy in copies:
                        # All processes have the same bits.
                        self.assertEqual(list(copy), list(copies[0]))
                        for a, b in zip(copy, expected[vertex][0]):
                            self.assertLessEqual(abs(a - b), tolerance * size)
                if os.path.exists(os.path.join(serial, "probes.csv")):
                    probes, values = table(os.path.join(serial, "probes.csv"))
                    own_probes, own_values = table(os.path.join(out, "probes.csv"))
                    self.assertEqual(probes, own_probes)
                    difference, where = largest_difference(probes, values, own_values)
                    self.assertLessEqual(difference, tolerance, where)
        return serial

    def test_loads_and_probes(self):
        for rule in ("explicit", "verlet"):
            with self.subTest(rule=rule):
                self.compare(self.write(
                    f"{rule}.toml", BODY + LOADS + PROBES + time_of(rule, 2e-4, 100) + OUTPUT))

    def test_damping(self):
        damping = "[damping]\nmass_damping = 3.0\nviscosity = 40.0\ndrag = 0.02\n"
        for rule in ("explicit", "verlet"):
            with self.subTest(rule=rule):
                self.compare(self.write(
                    f"{rule}.toml", BODY + LOADS + damping + time_of(rule, 1e-4, 60) + OUTPUT))

    def test_free_body_in_a_central_field(self):
        self.compare(self.write("orbit.toml", BODY.replace("gravity", "attraction").replace(
            'kind = "attraction"',
            'kind = "attraction"\nstrength = 0.02\nsoftening = 0.05') +
            "[initial]\nvelocity = [0.3, 0.2, 0.0]\nangular_velocity = [0.0, 3.0, 5.0]\n"
            "stretch = [1.05, 1.0, 0.97]\n" + time_of("verlet", 2e-4, 100) + OUTPUT))

    def test_mesh_file_with_groups(self):
        self.compare(self.write("fork.toml", f"""
[mesh]
file = "{os.path.join(DATA, "tuning_fork.msh")}"
unit = "mm"
[material]
model = "stvk"
youngs_modulus = 2.0e9
poissons_ratio = 0.3
density = 7800.0
[damping]
mass_damping = 10.0
[[fix]]
select = {{ group = "stem" }}
[[traction]]
select = {{ group = "left" }}
vector = [2000.0, 0.0, 0.0]
[[force]]
select = {{ group = "right" }}
total = [-0.02, 0.0, 0.01]
[[body_force]]
select = {{ group = "body" }}
acceleration = [0.0, 0.0, -20.0]
""" + time_of("verlet", 1e-7, 100) + OUTPUT))

    def test_events(self):
        events = """
[[event]]
at = 0.005
set = { "damping.mass_damping" = 2.0, "material.youngs_modulus" = 8.0e5 }
[[event]]
at = 0.008
force = { select = { nearest = [0.4, 0.0, 0.0] }, vector = [0.0, 0.3, 0.0] }
[[event]]
at = 0.01
unfix = { select = { plane = { axis = "x", at = 0.0 } } }
"""
        self.compare(self.write("events.toml",
                                BODY + LOADS + events + time_of("verlet", 2e-4, 100) + OUTPUT))

    def test_automatic_step_is_stable(self):
        scene = self.write("auto.toml", BODY + LOADS + """
[time]
integrator = "verlet"
step = "auto"
end = 0.01
""" + OUTPUT)
        serial, _ = self.run_scene(scene)
        expected = summary_of(serial)
        for processes in PROCESSES:
            out, _ = self.run_scene(scene, processes)
            summary = summary_of(out)
            # Both estimates of the stability limit have the tolerance 1e-4 of their iterations.
            self.assertAlmostEqual(summary["stable_step"] / expected["stable_step"], 1.0, delta=1e-3)
            self.assertAlmostEqual(summary["time_steps"]["smallest"] /
                                   expected["time_steps"]["smallest"], 1.0, delta=1e-2)
            self.assertEqual(summary["processes"], processes)
            for key in ("vertices", "tetrahedra"):
                self.assertEqual(summary["mesh"][key], expected["mesh"][key])
            self.assertEqual(summary["degrees_of_freedom"], expected["degrees_of_freedom"])


class AdaptiveSteps(ParallelTest):
    def compare(self, scene, tolerance, control):
        serial, _ = self.run_scene(scene)
        names, rows = table(os.path.join(serial, "history.csv"))
        self.assertGreater(control(summary_of(serial)), 0)
        for processes in (2, 3):
            with self.subTest(processes=processes):
                out, _ = self.run_scene(scene, processes)
                _, own_rows = table(os.path.join(out, "history.csv"))
                self.assertEqual(len(rows), len(own_rows))
                difference, where = largest_difference(names, rows, own_rows)
                self.assertLessEqual(difference, tolerance, where)
                self.assertEqual(control(summary_of(out)), control(summary_of(serial)))

    def test_adapt_to_an_error(self):
        # The steps of verlet are far below the stability limit, which parts find in iterations of their own. The
        # estimated error is a difference of positions, so that their round-off changes it by 1e-7 of its size.
        for rule, largest_error, tolerance in (("verlet", 1e-9, 1e-5), ("midpoint", 1e-5, 1e-6)):
            with self.subTest(rule=rule):
                time = f"""
[time]
integrator = "{rule}"
adapt = "error"
tolerance = {largest_error}
step = 1e-4
end = 0.02
[solver]
tolerance = 1e-11
"""
                scene = self.write(f"{rule}.toml", BODY + LOADS + time + OUTPUT)
                self.compare(scene, tolerance, lambda summary: summary["steps"])

    def test_adapt_to_the_energy(self):
        time = """
[time]
integrator = "midpoint"
adapt = "energy"
step = 2e-3
end = 0.03
[initial]
stretch = [1.3, 0.9, 0.95]
angular_velocity = [0.0, 0.0, 20.0]
[solver]
tolerance = 1e-11
"""
        self.compare(self.write("energy.toml", BODY + time + OUTPUT), 1e-6,
                     lambda summary: summary["steps"])

    def test_retry(self):
        """A sudden load that the steps do not resolve."""
        for rule, tolerance in (("verlet", 1e-9), ("midpoint", 1e-6)):
            with self.subTest(rule=rule):
                time = f"""
[[force]]
select = {{ plane = {{ axis = "x", at = 0.4 }} }}
total = [-1.0e5, 0.0, 0.0]
from = 0.002
until = 0.0024
[time]
integrator = "{rule}"
step = 2e-4
end = 0.004
retry = 6
[solver]
tolerance = 1e-11
"""
                self.compare(self.write(f"retry_{rule}.toml", BODY + time + OUTPUT), tolerance,
                             lambda summary: summary["time_steps"]["retried"])


class Implicit(ParallelTest):
    def assert_ends_like(self, expected, column, delta, scene, *cases):
        """The last value of a column, with numbers of processes and linear solvers. Returns the folders."""
        outs = []
        for processes, linear in cases:
            with self.subTest(processes=processes, linear=linear):
                out, _ = self.run_scene(scene, processes, "--set", f'solver.linear="{linear}"',
                                        out=self.path(f"{linear}{processes}"))
                outs.append(out)
                self.assertAlmostEqual(last_value(out, column) / expected, 1.0, delta=delta)
        return outs

    def test_rules_to_the_tolerance(self):
        for rule in ("midpoint", "backward-euler"):
            scene = self.write(f"{rule}.toml", BODY + LOADS + PROBES + time_of(rule, 2e-3, 10) +
                               "[solver]\ntolerance = 1e-10\n" + OUTPUT)
            serial, _ = self.run_scene(scene)
            names, rows = table(os.path.join(serial, "history.csv"))
            for processes in PROCESSES:
                with self.subTest(rule=rule, processes=processes):
                    out, _ = self.run_scene(scene, processes)
                    _, own_rows = table(os.path.join(out, "history.csv"))
                    difference, where = largest_difference(names, rows, own_rows)
                    # Ten steps that are each solved to 1e-10 of their forces.
                    self.assertLessEqual(difference, 1e-8, where)

    def test_damping_and_linear_solvers(self):
        damping = "[damping]\nmass_damping = 3.0\nviscosity = 40.0\n"
        scene = self.write("damped.toml", BODY + LOADS + damping + time_of("midpoint", 2e-3, 8) +
                           "[solver]\ntolerance = 1e-10\n" + OUTPUT)
        serial, _ = self.run_scene(scene)
        names, rows = table(os.path.join(serial, "history.csv"))
        for linear in ("auto", "matrix-free", "cg", "factor"):
            with self.subTest(linear=linear):
                out, _ = self.run_scene(scene, 2, "--set", f'solver.linear="{linear}"')
                _, own_rows = table(os.path.join(out, "history.csv"))
                difference, where = largest_difference(names, rows, own_rows)
                self.assertLessEqual(difference, 1e-8, where)

    def test_auto_changes_to_a_factor(self):
        """A column that bends under a dead load in steps that meet negative curvature many times."""
        self.write("column.msh", symmetric_column(20))
        scene = self.write("dead_load.toml", """
[mesh]
file = "column.msh"
[material]
youngs_modulus = 1.0e5
poissons_ratio = 0.3
[[fix]]
select = { plane = { axis = "x", at = 0.0 } }
[[force]]
select = { plane = { axis = "x", at = 20.0 } }
total = [-1000.0, 0.0, 0.0]
amplitude = "ramp"
[[amplitude]]
name = "ramp"
points = [[0.0, 0.0], [20.0, 1.0]]
[solver]
max_iterations = 400
""" + time_of("backward-euler", 10.0, 6) + OUTPUT)

        elastic = last_value(self.run_scene(scene)[0], "elastic_energy")
        self.assertGreater(elastic, 5e3)  # 100 J where it stays straight
        outs = self.assert_ends_like(elastic, "elastic_energy", 1e-4, scene, (1, "auto"), (3, "auto"),
                                     (1, "factor"), (3, "factor"))
        for out in outs:
            self.assertGreater(summary_of(out)["solver"]["factorizations"], 0)

    def test_crushed_beam(self):
        """Steps that meet negative curvature in much deformed elements many times."""
        scene = self.write("crushed.toml", """
[mesh]
generate = { kind = "beam", size = [4, 1, 1], cells = [8, 2, 2] }
[material]
youngs_modulus = 1.0e6
poissons_ratio = 0.4
[[fix]]
select = { plane = { axis = "x", at = 0.0 } }
[[force]]
select = { plane = { axis = "x", at = 4.0 } }
total = [-2.0e7, 0.0, 0.0]
""" + time_of("backward-euler", 0.1, 3) + OUTPUT)
        serial = last_value(self.run_scene(scene)[0], "total_energy")
        self.assert_ends_like(serial, "total_energy", 1e-4, scene, (2, "auto"), (1, "factor"), (3, "factor"))

    def test_free_body_under_a_large_load(self):
        """Steps that meet negative curvature end where one process ends them."""
        scene = self.write("free.toml", """
[mesh]
generate = { kind = "beam", size = [2.5, 1.0, 1.0], cells = [6, 2, 2] }
[material]
model = "mooney-rivlin"
youngs_modulus = 1.6e5
poissons_ratio = 0.45
ratio = 0.2
[[force]]
select = { plane = { axis = "x", at = 2.5 } }
total = [-900.0, 40.0, 4.0]
""" + time_of("backward-euler", 3.3, 8) + OUTPUT)

        serial = last_value(self.run_scene(scene)[0], "total_energy")
        self.assert_ends_like(serial, "total_energy", 1e-5, scene, (1, "factor"), (3, "factor"), (3, "cg"))

    def test_one_process_of_the_engine_is_the_same_run(self):
        scene = self.write("same.toml", BODY + LOADS + time_of("midpoint", 2e-3, 8) + OUTPUT)
        serial, _ = self.run_scene(scene)
        out, _ = self.run_scene(scene, 1)
        names, rows = table(os.path.join(serial, "history.csv"))
        _, own_rows = table(os.path.join(out, "history.csv"))
        for column in ("iterations", "elastic_energy", "px", "lz"):
            place = names.index(column)
            self.assertEqual([row[place] for row in rows], [row[place] for row in own_rows], column)

    def test_copies_have_the_same_bits(self):
        """So have repeated runs with the same parts."""
        scene = self.write("bits.toml", BODY + LOADS + time_of("backward-euler", 5e-3, 5) + OUTPUT)
        out, _ = self.run_scene(scene, 3)
        again, _ = self.run_scene(scene, 3, out=self.path("again"))
        first, _ = points_of(os.path.join(out, "final.pvtu"), "displacement")
        second, _ = points_of(os.path.join(again, "final.pvtu"), "displacement")
        self.assertGreater(max(len(copies) for copies in first.values()), 1)
        for copies in [*first.values(), *second.values()]:
            self.assertEqual(len({tuple(copy) for copy in copies}), 1)
        shared = [{v for v, copies in points.items() if len(copies) > 1} for points in (first, second)]
        if shared[0] == shared[1]:
            for vertex, copies in first.items():
                self.assertEqual(tuple(copies[0]), tuple(second[vertex][0]))

    def test_coarse_space_of_all_parts(self):
        """A long beam with large steps needs hundreds of iterations without a coarse space."""
        scene = self.write(
            "long.toml",
            BODY.replace("[0.4, 0.1, 0.1]", "[4.0, 0.1, 0.1]").replace("[8, 3, 3]", "[80, 2, 2]") +
            '[[fix]]\nselect = { plane = { axis = "x", at = 0.0 } }\n' +
            time_of("backward-euler", 0.05, 10) + '[solver]\nlinear = "matrix-free"\n' + OUTPUT)

        def iterations(out):
            return summary_of(out)["solver"]["cg_iterations"]

        serial = iterations(self.run_scene(scene)[0])
        for processes in (2, 4):
            with self.subTest(processes=processes):
                own = iterations(self.run_scene(scene, processes)[0])
                self.assertLess(own, 1.5 * serial)

    def test_saddle_points_are_left(self):
        """A symmetric column under its buckling load does not move sideways by itself."""
        self.write("column.msh", symmetric_column(20))
        scene = self.write("column.toml", """
[mesh]
file = "column.msh"
[material]
model = "neo-hookean"
youngs_modulus = 1.0e6
poissons_ratio = 0.3
density = 1000.0
[[fix]]
select = { plane = { axis = "x", at = 0.0 } }
[[fix]]
select = { plane = { axis = "x", at = 20.0 } }
velocity = [-0.5, 0.0, 0.0]
[time]
integrator = "backward-euler"
step = 0.5
end = 4.0
[output]
every = 8
""")
        for processes, linear in ((None, "auto"), (2, "auto"), (3, "auto"), (1, "factor"), (3, "factor"),
                                  (1, "cg"), (3, "cg")):
            with self.subTest(processes=processes, linear=linear):
                out, _ = self.run_scene(scene, processes, "--set", f'solver.linear="{linear}"')
                final = os.path.join(out, "final.vtu" if processes is None else "final.pvtu")
                moved, _ = points_of(final, "displacement")
                sideways = max(max(abs(x[1]), abs(x[2])) for copies in moved.values() for x in copies)
                self.assertGreater(sideways, 1.0)


class Files(ParallelTest):
    def test_frames_in_pieces(self):
        scene = self.write("scene.toml", BODY + LOADS + time_of("verlet", 2e-4, 40) + OUTPUT)
        out, _ = self.run_scene(scene, 3)
        collection = ElementTree.parse(os.path.join(out, "frames.pvd"))
        files = [entry.get("file") for entry in collection.iter("DataSet")]
        self.assertEqual(files, [f"frames/frame_{step:06}.pvtu" for step in (0, 20, 40)])
        for file in files:
            tree = ElementTree.parse(os.path.join(out, file))
            self.assertEqual(tree.find("PUnstructuredGrid").get("GhostLevel"), "0")
            pieces = [piece.get("Source") for piece in tree.iter("Piece")]
            self.assertEqual(len(pieces), 3)
            for piece in pieces:
                self.assertTrue(os.path.exists(os.path.join(out, "frames", piece)))
        # A later run in one process leaves nothing of them.
        self.run_scene(scene, None, out=out)
        left = sorted(os.listdir(os.path.join(out, "frames")))
        self.assertEqual(left, [f"frame_{step:06}.vtu" for step in (0, 20, 40)])
        self.assertNotIn("final.pvtu", os.listdir(out))

    def test_nodal_averages_do_not_depend_on_the_parts(self):
        scene = self.write("scene.toml", BODY + LOADS + time_of("verlet", 2e-4, 40) + OUTPUT)
        serial, _ = self.run_scene(scene)
        expected, _ = points_of(os.path.join(serial, "final.vtu"), "cauchy_stress_nodal")
        size = max(max(abs(x) for x in values[0]) for values in expected.values())
        out, _ = self.run_scene(scene, 4)
        found, _ = points_of(os.path.join(out, "final.pvtu"), "cauchy_stress_nodal")
        for vertex, copies in found.items():
            for copy in copies:
                for a, b in zip(copy, expected[vertex][0]):
                    self.assertLessEqual(abs(a - b), 1e-10 * size)


class Memory(ParallelTest):
    """Peaks of the process with the most, less those of a mesh of six tetrahedra."""

    SCENE = """
[mesh]
%s
[material]
model = "neo-hookean"
youngs_modulus = 1e6
poissons_ratio = 0.3
density = 1000
[time]
integrator = "verlet"
step = 1e-5
end = 2e-5
"""
    CELLS = [96, 24, 24]  # 331,776 tetrahedra

    def peak(self, mesh, processes):
        scene = self.write("scene.toml", self.SCENE % mesh)
        out, _ = self.run_scene(scene, processes, "--threads", "1")
        return summary_of(out)["peak_memory_bytes"]

    def beam(self, cells):
        return f'generate = {{ kind = "beam", size = [4, 1, 1], cells = {cells} }}'

    def need(self, mesh, processes):
        return self.peak(mesh, processes) - self.peak(self.beam([1, 1, 2]), processes)

    def test_no_process_needs_more_than_its_share(self):
        mesh = self.beam(self.CELLS)
        whole = self.need(mesh, None)
        self.assertLessEqual(self.need(mesh, 2), 0.55 * whole)
        # The mesh itself, which the first process has made, is an eighth of the whole run.
        self.assertLessEqual(self.need(mesh, 8), 0.25 * whole)

    def test_reading_needs_less_than_half_of_the_run(self):
        cells = ",".join(str(n) for n in self.CELLS)
        for ending in ("msh", "vtu", "veg"):
            with self.subTest(ending=ending):
                file = self.path("beam." + ending)
                subprocess.run([PROGRAM, "mesh", "generate", "beam", file, "--cells", cells], check=True,
                               capture_output=True)
                whole = self.need(f'file = "{file}"', None)
                self.assertLessEqual(self.need(f'file = "{file}"', 2), 0.6 * whole)


class Checkpoints(ParallelTest):
    """Runs that lose their end go on from the checkpoint after step 30 of 40."""

    def scene(self, rule):
        step = {"verlet": 2e-4, "midpoint": 2e-3}[rule]
        events = "[[event]]\nat = %g\nfix = { select = { plane = { axis = \"x\", at = 0.4 } } }\n" % (12.5 * step)
        return self.write(f"{rule}.toml", BODY + LOADS + PROBES + time_of(rule, step, 40) +
                          OUTPUT.replace("every = 20", "every = 20\ncheckpoint_every = 15") + events)

    def lose_end(self, out):
        os.remove(os.path.join(out, "summary.json"))

    def contents(self, out):
        """What must be the same in a run that was not stopped."""
        names = ["history.csv", "probes.csv", "frames.pvd", "final.pvtu"]
        names += [os.path.join("frames", name) for name in sorted(os.listdir(os.path.join(out, "frames")))]
        result = {}
        for name in names:
            with open(os.path.join(out, name), "rb") as file:
                result[name] = file.read()
        return result

    def test_same_bits(self):
        for rule, extra in (("verlet", []), ("verlet", ["--set", 'time.step="auto"']), ("midpoint", [])):
            with self.subTest(rule=rule, extra=extra):
                out = self.path("same-" + rule + str(len(extra)))
                scene = self.scene(rule)
                self.run_scene(scene, 3, *extra, out=out)
                whole = self.contents(out)
                checkpoints = sorted(os.listdir(os.path.join(out, "checkpoints")))
                self.lose_end(out)
                _, done = self.run_scene(scene, 3, *extra, "--resume", out=out)
                self.assertIn("the run goes on after step", done.stderr)
                again = self.contents(out)
                self.assertEqual(again.keys(), whole.keys())
                self.assertEqual([name for name in whole if again[name] != whole[name]], [])
                self.assertEqual(sorted(os.listdir(os.path.join(out, "checkpoints"))), checkpoints)

    def test_any_number_of_processes(self):
        for rule, tolerance in (("verlet", 1e-12), ("midpoint", 1e-7)):
            scene = self.scene(rule)
            serial, _ = self.run_scene(scene, out=self.path("serial-" + rule))
            names, rows = table(os.path.join(serial, "history.csv"))
            probes, values = table(os.path.join(serial, "probes.csv"))
            for before, after in ((3, 2), (2, 4), (3, 1), (3, None), (None, 3)):
                with self.subTest(rule=rule, before=before, after=after):
                    out = self.path(f"{rule}-{before}-{after}")
                    self.run_scene(scene, before, out=out)
                    self.lose_end(out)
                    _, done = self.run_scene(scene, after, "--resume", out=out)
                    self.assertIn("the run goes on after step 30", done.stderr)
                    self.assertIn("last digits may differ", done.stderr)
                    for name, expected in (("history.csv", rows), ("probes.csv", values)):
                        columns, own = table(os.path.join(out, name))
                        self.assertEqual(columns, names if name == "history.csv" else probes)
                        self.assertEqual(len(own), len(expected))
                        difference, where = largest_difference(columns, expected, own)
                        self.assertLessEqual(difference, tolerance, where)
                    self.assertEqual(summary_of(out)["status"], "ok")
                    self.assert_files_belong_together(out, "final.vtu" if after is None else "final.pvtu")
                    _, done = self.run_scene(scene, after, "--resume", out=out)
                    self.assertIn("complete already", done.stderr)

    def assert_files_belong_together(self, out, final):
        """All frames can be read, and no file is there that none of them names."""
        named = set()
        with open(os.path.join(out, "frames.pvd")) as file:
            frames = [part.split('"')[0] for part in file.read().split('file="')[1:]]
        self.assertEqual(len(frames), 3)
        for name in frames + [final]:
            path = os.path.join(out, name)
            points_of(path, "displacement")
            named.add(os.path.basename(path))
            if name.endswith(".pvtu"):
                with open(path) as file:
                    named |= {os.path.basename(part.split('"')[0])
                              for part in file.read().split('Source="')[1:]}
        named.discard(final)
        self.assertEqual(named, set(os.listdir(os.path.join(out, "frames"))))
        self.assertEqual([name for name in ("final.vtu", "final.pvtu") if os.path.exists(os.path.join(out, name))],
                         [final])

    def test_same_file_as_in_one_process(self):
        # But for the number of processes, times of the clock and last digits, which have a fixed place.
        sizes = set()
        for processes in (None, 1, 3):
            out, _ = self.run_scene(self.scene("verlet"), processes)
            sizes.add(os.path.getsize(os.path.join(out, "checkpoints", "step_000000030.ckpt")))
        self.assertEqual(len(sizes), 1)

    def test_a_stopped_run_goes_on(self):
        scene = self.write("long.toml", BODY + LOADS + time_of("verlet", 1e-4, 100000) + OUTPUT)
        out = self.path("stopped")
        command = [MPIRUN, "-n", "2", PROGRAM, "run", scene, "--out", out]
        run = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                               cwd=self.folder, env=ENVIRONMENT)
        deadline = time.monotonic() + 60
        while time.monotonic() < deadline and not os.path.exists(os.path.join(out, "frames.pvd")):
            time.sleep(0.05)
        time.sleep(0.5)
        run.send_signal(signal.SIGTERM)
        run.communicate(timeout=60)
        steps = summary_of(out)["steps"]
        self.assertGreater(steps, 0)
        last = ["--set", f"time.end={1e-4 * (steps + 3)}", "--force"]
        _, done = self.run_scene(scene, 3, "--resume", *last, out=out)
        self.assertIn(f"the run goes on after step {steps} ", done.stderr)
        self.assertEqual(summary_of(out)["steps"], steps + 3)

    def test_errors_have_one_message(self):
        scene = self.scene("verlet")
        out, _ = self.run_scene(scene, 2)
        self.lose_end(out)
        _, done = self.run_scene(scene, 2, "--resume", "--set", "damping.viscosity=3.0", code=2)
        self.assert_one_message(done, "its inputs have changed since: damping")
        history = os.path.join(out, "history.csv")
        with open(history) as file:
            kept = file.read()
        with open(history, "w") as file:
            file.write(kept.replace("0.0002", "0.0003", 1))
        _, done = self.run_scene(scene, 2, "--resume", code=3)
        self.assert_one_message(done, "its rows have changed since the checkpoint")
        with open(history, "w") as file:
            file.write(kept)
        piece = os.path.join(out, "frames", "frame_000020_0001.vtu")
        os.rename(piece, piece + ".away")
        _, done = self.run_scene(scene, 2, "--resume", code=3)
        self.assert_one_message(done, "it is missing")
        os.rename(piece + ".away", piece)
        newest = os.path.join(out, "checkpoints", "step_000000030.ckpt")
        with open(newest, "r+b") as file:
            file.truncate(1000)
        _, done = self.run_scene(scene, 2, "--resume")
        self.assertIn("it is cut off", done.stderr)
        self.assertIn("the run goes on after step 15", done.stderr)


class Endings(ParallelTest):
    def scene(self, extra="", steps=40):
        return self.write("scene.toml", BODY + LOADS + time_of("verlet", 2e-4, steps) + OUTPUT + extra)

    def start_long_run(self, processes, history_bytes):
        """A run that is under way: its history.csv has so many bytes."""
        scene = self.scene(steps=1000000)
        out = self.path("out")
        run = subprocess.Popen([MPIRUN, "-n", str(processes), PROGRAM, "run", scene, "--out", out],
                               stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True,
                               cwd=self.folder, env=ENVIRONMENT)
        history = os.path.join(out, "history.csv")
        deadline = time.monotonic() + 60
        while time.monotonic() < deadline and not (
                os.path.exists(history) and os.path.getsize(history) >= history_bytes):
            time.sleep(0.1)
        return run, out

    def processes_of(self, run, count):
        children = subprocess.run(["ps", "-o", "pid=", "--ppid", str(run.pid)], capture_output=True,
                                  text=True).stdout.split()
        self.assertEqual(len(children), count)
        return [int(child) for child in children]

    def test_the_message_of_a_failed_step_is_that_of_one_process(self):
        body = """
[mesh]
generate = { kind = "beam", size = [4, 1, 1], cells = [8, 3, 3] }
[material]
model = "neo-hookean"
youngs_modulus = 1.0e5
poissons_ratio = 0.3
[[fix]]
select = { plane = { axis = "x", at = 0.0 } }
[[force]]
select = { nearest = [4, 1, 1] }
vector = [-1.0e6, -3.0e6, 0.0]
"""
        stiff = """
[[material_region]]
select = { box = { min = [2, -1, -1], max = [5, 2, 2] } }
youngs_modulus = 1.0e15
poissons_ratio = 0.3
"""
        scenes = {
            "loads": body + time_of("midpoint", 0.01, 10) + '[solver]\nlinear = "factor"\n',
            "limit": body.replace("e6", "") + time_of("verlet", 0.1, 100),
            "contrast": body.replace("e6", "") + stiff + time_of("midpoint", 0.01, 10) +
                        '[solver]\nlinear = "factor"\nmax_iterations = 1\n'}

        def message(done):
            lines = [line for line in done.stderr.splitlines() if line.startswith("tetraction: step")]
            self.assertEqual(len(lines), 1, done.stderr)
            # The residual may differ in its last digits.
            return re.sub(r"force residual [^ ]* N", "force residual", lines[0])

        for name, text in scenes.items():
            scene = self.write(f"{name}.toml", text)
            _, done = self.run_scene(scene, code=1)
            expected = message(done)
            for processes in (2, 3):
                with self.subTest(name=name, processes=processes):
                    _, done = self.run_scene(scene, processes, code=1)
                    self.assertEqual(message(done), expected)

    def assert_failed_to_write(self, run, out, words):
        messages = run.communicate(timeout=100)[1]
        self.assertEqual(run.returncode, 4, messages)
        lines = [line for line in messages.splitlines() if line.startswith("tetraction: ")]
        self.assertEqual(len(lines), 1, messages)
        self.assertIn(words, lines[0])
        names, rows = table(os.path.join(out, "history.csv"))
        self.assertEqual(len(rows[-1]), len(names))

    def test_a_frame_that_cannot_be_written(self):
        """A file has the name of the folder. history.csv and summary.json are there."""
        run, out = self.start_long_run(3, 2000)
        os.rename(os.path.join(out, "frames"), self.path("away"))
        try:
            with open(os.path.join(out, "frames"), "w"):
                pass
        except IsADirectoryError:  # the run has made it again in between
            os.rename(os.path.join(out, "frames"), self.path("away2"))
            with open(os.path.join(out, "frames"), "w"):
                pass
        self.assert_failed_to_write(run, out, "frames")
        summary = summary_of(out)
        self.assertEqual((summary["status"], summary["exit_status"]), ("failed", 4))
        self.assertIn("frames", summary["message"])

    def test_a_full_disk(self):
        """A small file system in memory, where the machine allows one."""
        disk = self.path("out")
        os.mkdir(disk)
        mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=300k", "tmpfs", disk],
                                 capture_output=True)
        if mounted.returncode != 0:
            self.skipTest("no file system can be mounted")
        try:
            run, out = self.start_long_run(3, 2000)
            self.assert_failed_to_write(run, out, "No space left")
        finally:
            subprocess.run(["umount", disk], check=True)

    def test_the_warning_of_large_steps_names_penalty_springs(self):
        scene = self.write("springs.toml", BODY + """
[[fix]]
select = { nearest = [0.4, 0.1, 0.1] }
mode = "penalty"
penalty = 1.0e9
""" + time_of("verlet", 1e-4, 1) + OUTPUT)
        for processes in (None, 3):
            with self.subTest(processes=processes):
                _, done = self.run_scene(scene, processes, code=1)
                self.assertIn("the springs of fix.mode", done.stderr)

    def test_warnings_of_material_arrays_in_any_part(self):
        scene = self.write("arrays.toml", """
[mesh]
file = "column.msh"
[material]
youngs_modulus = 1.0e5
poissons_ratio = { array = "nu" }
volumetric = "quadratic"
""" + time_of("verlet", 1e-4, 1) + OUTPUT)
        for ratio, text in ((0.49, "a Poisson's ratio of 0.49"), (-0.3, "has a negative lambda")):
            expected = None
            # At both ends of the body, and at one of them.
            for elements in ((3, 470), (3,), (470,)):
                values = "".join(f"{e} {ratio if e in elements else 0.3}\n" for e in range(1, 481))
                self.write("column.msh", symmetric_column(20) + '$ElementData\n1\n"nu"\n1\n0.0\n3\n0\n1\n480\n' +
                           values + "$EndElementData\n")
                if expected is None:
                    expected = summary_of(self.run_scene(scene)[0])["warnings"]
                    self.assertIn(text, " ".join(expected))
                for processes in (2, 4):
                    with self.subTest(ratio=ratio, elements=elements, processes=processes):
                        out, done = self.run_scene(scene, processes)
                        self.assertEqual(summary_of(out)["warnings"], expected)
                        self.assertIn(text, done.stderr)

    def test_forces_after_a_failed_step_are_those_of_the_last_good_one(self):
        scene = self.write("blow.toml", BODY + """
[[fix]]
select = { plane = { axis = "x", at = 0.0 } }
[[force]]
select = { plane = { axis = "x", at = 0.4 } }
total = [-3.0e4, 0.0, 0.0]
amplitude = "ramp"
[[amplitude]]
name = "ramp"
points = [[0.0, 0.0], [0.05, 1.0]]
""" + time_of("explicit", 1e-4, 500) + OUTPUT.replace('"displacement"', '"displacement", "reaction_force"'))
        for processes in (None, 2, 3):
            with self.subTest(processes=processes):
                out, _ = self.run_scene(scene, processes, code=1)
                last = "final.vtu" if processes is None else "final.pvtu"
                forces, _ = points_of(os.path.join(out, last), "reaction_force")
                total = sum(float(copies[0][0]) for copies in forces.values())
                expected = last_value(out, "reaction_x")
                self.assertGreater(abs(expected), 100.0)
                self.assertAlmostEqual(total / expected, 1.0, delta=1e-9)

    def test_bad_input_has_one_message(self):
        scene = self.write("scene.toml", BODY.replace("youngs_modulus", "youngs_module"))
        _, done = self.run_scene(scene, 3, code=2)
        self.assert_one_message(done, "youngs_modul")
        _, done = self.run_scene(self.path("nothing.toml"), 2, code=3)
        self.assert_one_message(done, "nothing.toml")
        scene = self.scene('[[fix]]\nselect = { plane = { axis = "x", at = 7.0 } }\n')
        _, done = self.run_scene(scene, 4, code=2)
        self.assert_one_message(done, "selects no vertex")
        scene = self.scene("[[force]]\nselect = { vertices = [100000] }\nvector = [1, 0, 0]\n")
        _, done = self.run_scene(scene, 2, code=2)
        self.assert_one_message(done, "vertex 100000 is not in the mesh")

        done = subprocess.run([MPIRUN, "-n", "3", PROGRAM, "run", "scene.toml", "--no-such-option"],
                              capture_output=True, text=True, cwd=self.folder, env=ENVIRONMENT)
        self.assertEqual(done.returncode, 2)
        self.assertEqual(done.stderr.count("--no-such-option"), 1, done.stderr)
        for command, argument in (("static", self.scene()), ("modes", self.scene()),
                                  ("study", self.scene()), ("check", self.scene()),
                                  ("new", self.path("new")), ("view", self.scene())):
            done = subprocess.run([MPIRUN, "-n", "2", PROGRAM, command, argument],
                                  capture_output=True, text=True, cwd=self.folder, env=ENVIRONMENT)
            self.assertEqual(done.returncode, 2)
            self.assert_one_message(done, f"tetraction {command} works in one process only")
        self.assertFalse(os.path.exists(self.path("new")))
        # The nearest tetrahedron is that of the whole mesh.
        scene = self.scene('[[probe]]\nname = "out"\npoint = [0.9, 0.05, 0.05]\nquantity = "velocity"\n')
        _, done = self.run_scene(scene, code=2)
        distance = done.stderr[done.stderr.index("outside the body"):]
        _, done = self.run_scene(scene, 3, code=2)
        self.assert_one_message(done, distance.splitlines()[0])

    def test_nothing_of_the_working_directory_is_read_or_loaded(self):
        # Options with which PETSc writes files.
        for name in (".petscrc", "petscrc"):
            self.write(name, f"-log_view :{self.path('from' + name)}\n")
        environment = {**ENVIRONMENT, "PETSC_OPTIONS": f"-log_view :{self.path('from_variable')}",
                       "PETSC_OPTIONS_YAML": f"log_view: ':{self.path('from_yaml')}'"}
        # Files that the loader would take for libraries of the program.
        engine = os.path.join(os.path.dirname(PROGRAM), "tetraction-petsc")
        needed = subprocess.run(["ldd", engine], capture_output=True, text=True, check=True).stdout
        for name in re.findall(r"^\s*(lib\S+) =>", needed, re.MULTILINE):
            self.write(name, "no library")
        scene = self.scene()
        before = set(os.listdir(self.folder))
        for processes in (None, 2):
            with self.subTest(processes=processes):
                command = [PROGRAM, "run", scene, "--out", "out", "--set", 'solver.engine="petsc"']
                if processes is not None:
                    command = [MPIRUN, "-n", str(processes), *command]
                done = subprocess.run(command, capture_output=True, text=True, cwd=self.folder,
                                      env=environment)
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertEqual(set(os.listdir(self.folder)) - before, {"out"})
                self.assertEqual(done.stderr.count("settings that are ignored"), 1, done.stderr)
                self.assertIn("(PETSC_OPTIONS, PETSC_OPTIONS_YAML, .petscrc, petscrc", done.stderr)

    def test_bad_input_in_one_process_ends_all(self):
        # Two targets for vertices that only some processes have.
        scene = self.scene("""
[[fix]]
select = { vertices = [17] }
target = [1.0, 0.0, 0.0]
[[fix]]
select = { vertices = [17] }
target = [2.0, 0.0, 0.0]
""")
        start = time.monotonic()
        _, done = self.run_scene(scene, 4, code=2)
        self.assert_one_message(done, "vertex 17 is fixed twice")
        self.assertLess(time.monotonic() - start, 60)

    def test_failed_elements_of_all_parts(self):
        # The whole end face is torn away, so that elements of several parts fail.
        scene = self.write("torn.toml", BODY + """
[[fix]]
select = { plane = { axis = "x", at = 0.0 } }
[[force]]
select = { all = true }
total = [-3.0e7, 1.0e6, 0.0]
""" + time_of("explicit", 1e-4, 50) + OUTPUT)
        expected = None
        for processes in (None, *PROCESSES):
            with self.subTest(processes=processes):
                out, _ = self.run_scene(scene, processes, code=1)
                points, elements = points_of(os.path.join(out, "failed_elements.vtu"), "displacement")
                expected = expected or (points, elements)
                self.assertGreater(len(elements), 5)
                self.assertEqual(elements, expected[1])
                self.assertEqual(points.keys(), expected[0].keys())
                for vertex, values in points.items():
                    for a, b in zip(values[0], expected[0][vertex][0]):
                        self.assertAlmostEqual(a, b, delta=1e-12)
                _, attempted = points_of(os.path.join(out, "failed_elements.vtu"), "attempted_displacement")
                self.assertEqual(attempted, elements)

    def test_inverted_element_ends_all(self):
        scene = self.scene()
        _, done = self.run_scene(scene, 3, "--set", "time.step=0.02", "--set", "time.end=1.0", code=1)
        own = [line for line in done.stderr.splitlines()
               if line.startswith("tetraction: ") and "warning" not in line]
        self.assertEqual(len(own), 1, done.stderr)
        self.assertIn("stability limit", own[0])

    def test_event_that_cannot_be_made_ends_all(self):
        scene = self.scene("""
[[event]]
at = 2e-3
[event.fix]
select = { nearest = [0.4, 0.0, 0.0] }
target = [-0.4, 0.0, 0.0]
""")
        for processes in (1, 3):
            with self.subTest(processes=processes):
                out, done = self.run_scene(scene, processes, code=1)
                self.assertIn("the event at 0.002 s could not be made", done.stderr)
                self.assertEqual(done.stderr.count("could not be made"), 1, done.stderr)
                self.assertEqual(summary_of(out)["exit_status"], 1)
                self.assertTrue(os.path.exists(os.path.join(out, "final.pvtu")))

    def test_output_that_cannot_be_written(self):
        blocked = self.write("blocked", "a file")
        _, done = self.run_scene(self.scene(), 3, code=4, out=blocked)
        self.assert_one_message(done, "blocked")

    def test_a_closed_pipe(self):
        command = [PROGRAM, "run", self.scene(), "--out", self.path("pipe"), "--json"]
        for engine in ("local", "petsc"):
            with self.subTest(engine=engine):
                read, write = os.pipe()
                os.close(read)
                done = subprocess.run([*command, "--set", f'solver.engine="{engine}"'], stdout=write,
                                      stderr=subprocess.PIPE, text=True, cwd=self.folder, env=ENVIRONMENT)
                os.close(write)
                self.assertEqual(done.returncode, 4)
                self.assert_one_message(done, "cannot be written to standard output")

    def test_signal_ends_the_run_properly(self):
        run, out = self.start_long_run(2, 20000)
        run.send_signal(signal.SIGTERM)
        run.communicate(timeout=60)
        self.assertNotEqual(run.returncode, 0)
        names, rows = table(os.path.join(out, "history.csv"))
        self.assertTrue(all(len(row) == len(names) for row in rows))

    def test_signal_to_one_process_has_its_exit_code(self):
        run, out = self.start_long_run(2, 20000)
        os.kill(self.processes_of(run, 2)[1], signal.SIGQUIT)
        run.communicate(timeout=60)
        self.assertEqual(summary_of(out)["exit_status"], 128 + signal.SIGQUIT)

    def test_killed_process_ends_all(self):
        run, _ = self.start_long_run(3, 0)
        os.kill(self.processes_of(run, 3)[1], signal.SIGKILL)
        run.communicate(timeout=60)
        self.assertNotEqual(run.returncode, 0)

    def test_what_is_not_there_yet(self):
        cases = {
            '[[constraint]]\nkind = "rigid"\nselect = { plane = { axis = "x", at = 0.4 } }\n':
                "[[constraint]]",
            '[[pressure]]\nselect = { faces = { normal = [0, 0, 1] } }\nvalue = 10.0\n': "[[pressure]]",
        }
        for extra, name in cases.items():
            with self.subTest(name=name):
                _, done = self.run_scene(self.scene(extra), 2, code=2)
                self.assert_one_message(done, name)
                self.assertIn('solver.engine = "local"', done.stderr)
        settings = {
            "mesh.volume=\"nodal\"": "mesh.volume",
            "mesh.element=\"quadratic\"": "mesh.element",
            "time.integrator=\"energy-momentum\"": "energy-momentum",
            "solver.kind=\"ceres\"": "ceres",
        }
        for setting, name in settings.items():
            with self.subTest(name=name):
                _, done = self.run_scene(self.scene(), 2, "--set", setting, code=2)
                self.assert_one_message(done, name)
        done = subprocess.run([PROGRAM, "check", self.scene(), "--set", 'solver.engine="petsc"', "--set",
                               'mesh.volume="nodal"'], capture_output=True, text=True, cwd=self.folder)
        self.assertEqual(done.returncode, 2)
        self.assertIn("mesh.volume", done.stderr)
        for command in ("static", "study"):
            steps = ["--steps", "1e-4,2e-4"] if command == "study" else []
            done = subprocess.run([PROGRAM, command, self.scene(), *steps, "--set", 'solver.engine="petsc"'],
                                  capture_output=True, text=True, cwd=self.folder)
            self.assertEqual(done.returncode, 2)
            self.assertIn("is for tetraction run", done.stderr)
            self.assertNotIn("[1/", done.stderr + done.stdout)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]])
