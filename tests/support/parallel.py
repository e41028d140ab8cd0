"""Runs in several processes against the same runs in one: mpirun -n N tetraction run.

These tests are called as: python3 NAME_test.py PROGRAM DATA_DIRECTORY MPIRUN [CLASS...]
"""

import csv
import math
import os
import subprocess
import sys

from support.program import PROGRAM, ProgramTest, sets, words_of
from support.scenes import plane, tables

MPIRUN = sys.argv[3]
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
BODY = tables(mesh=dict(generate={"kind": "beam", "size": [0.4, 0.1, 0.1], "cells": [8, 3, 3]}),
              material=dict(model="neo-hookean", youngs_modulus=1.0e6, poissons_ratio=0.3,
                density=1000.0), environment=dict(kind="gravity"))
LOADS = tables(material_region=[{"select": {"box": {"min": [0.2, -1, -1], "max": [1, 1, 1]}},
                 "model": "mooney-rivlin", "mu1": 1.0e5, "mu2": 5.0e4, "lambda": 4.0e5,
                 "density": 1500.0}],
               amplitude=[dict(name="ramp", points=[[0.0, 0.0], [0.01, 1.0]])],
               fix=[dict(select=plane("x", 0.0), velocity=[0.0, 0.05, 0.0]),
               dict(select={"nearest": [0.4, 0.1, 0.1]}, components="z", mode="penalty",
                 penalty=2.0e3)],
               force=[dict(select=plane("x", 0.4), total=[5.0, 0.0, 0.0], amplitude="ramp"),
               dict(select={"vertices": [17, 40]}, vector=[0.0, 0.2, 0.0])],
               traction=[dict(select={"faces": {"normal": [0, 1, 0]}}, vector=[0.0, -200.0, 0.0],
                 until=0.015)], moment=[dict(select=plane("x", 0.4), vector=[0.05, 0.0, 0.0])],
               body_force=[dict(select={"all": True}, vector=[0.0, 0.0, 300.0])])
PROBES = tables(probe=[dict(name="tip", select=plane("x", 0.4), quantity="displacement"),
                dict(name="support", select=plane("x", 0.0), quantity="reaction"),
                dict(name="inside", point=[0.21, 0.04, 0.06], quantity="velocity"),
                dict(name="stress", select={"box": {"min": [0.1, -1, -1], "max": [0.3, 1, 1]}},
                  quantity="von_mises", every=5),
                dict(name="common", point=[0.2, 0.0333333333333, 0.0333333333333],
                  quantity="jacobian")])


def time_of(integrator, step, steps):
    return tables(time=dict(integrator=integrator, step=step, end=step * steps))


OUTPUT = """
[output]
every = 20
fields = ["displacement", "velocity", "cauchy_stress", "cauchy_stress_nodal", "region", "fixed"]
"""


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


class ParallelTest(ProgramTest):
    def mpirun(self, processes, *arguments, code=0, env=ENVIRONMENT, **keywords):
        """The program in so many processes; with None without mpirun."""
        start = [] if processes is None else [MPIRUN, "-n", str(processes)]
        done = subprocess.run([*start, PROGRAM, *words_of(arguments)], text=True, cwd=self.folder, env=env,
                              timeout=500, **{"capture_output": True, **keywords})  # fmt: skip
        self.assertEqual(done.returncode, code, done.stderr)
        return done

    def run_scene(self, scene, processes=None, *arguments, code=0, out=None):
        """One run, and the folder of its results."""
        out = out or self.path("serial" if processes is None else f"out{processes}")
        engine = sets('solver.engine="petsc"') if processes == 1 else []
        return out, self.mpirun(processes, "run", scene, "--out", out, *arguments, *engine, code=code)

    def begin_run(self, scene, processes, when, out="out"):
        """A run in the background, once the condition holds."""
        command = [MPIRUN, "-n", str(processes), PROGRAM, "run", scene, "--out", self.path(out)]
        run = subprocess.Popen(command, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True,
                               cwd=self.folder, env=ENVIRONMENT)  # fmt: skip
        self.wait_for(when, run)
        return run

    def numbers(self, *names):
        """The names of the columns of a table, and its rows."""
        header, *rows = csv.reader(self.read(*names).splitlines())
        return header, [[float(cell) if cell else math.nan for cell in row] for row in rows]

    def last_value(self, out, column):
        return float(self.table(out, "history.csv")[-1][column])

    def assert_like(self, expected, out, tolerance, name="history.csv"):
        """Both folders have the same table, to this share of the size of each kind of column."""
        names, rows = self.numbers(expected, name)
        own_names, own_rows = self.numbers(out, name)
        self.assertEqual(names, own_names)
        self.assertEqual(len(rows), len(own_rows))
        difference, where = largest_difference(names, rows, own_rows)
        self.assertLessEqual(difference, tolerance, where)

    def assert_one_message(self, done, text):
        own = [line for line in done.stderr.splitlines() if line.startswith("tetraction: ")]
        self.assertEqual(len(own), 1, done.stderr)
        self.assertIn(text, own[0])

    def assert_refused(self, code, scene, processes, text, *arguments, out=None):
        """One message, which has this text."""
        _, done = self.run_scene(scene, processes, *arguments, code=code, out=out)
        self.assert_one_message(done, text)
        return done
