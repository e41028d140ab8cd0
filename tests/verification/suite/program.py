"""Calls the program and reads what it writes."""

import csv
import functools
import json
import os
import shutil
import subprocess

import numpy as np


class ProgramError(Exception):
    pass


def toml_value(value):
    """A value as --set takes it."""
    if isinstance(value, dict):
        return "{" + ", ".join(f'"{k}" = {toml_value(v)}' for k, v in value.items()) + "}"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(toml_value(v) for v in value) + "]"
    return json.dumps(value)


class Program:
    def __init__(self, path):
        self.path = os.path.abspath(path)

    def call(self, command, scene, settings, arguments, folder):
        """Runs one command with a scene and returns the results."""
        shutil.rmtree(folder, ignore_errors=True)
        words = [self.path, command, scene, "--quiet", "--out", folder]
        for key, value in settings.items():
            words += ["--set", f"{key}={toml_value(value)}"]
        words += [str(a) for a in arguments]
        done = subprocess.run(words, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise ProgramError(f"{' '.join(words)}\nended with {done.returncode}: {done.stderr}")
        return Results(folder)


class EarlierRuns:
    """Takes the results of earlier calls instead of a program."""

    def call(self, command, scene, settings, arguments, folder):
        if not any(os.path.exists(os.path.join(folder, name))
                   for name in ("summary.json", "study.json")):
            raise ProgramError(f"{folder}: no results")
        return Results(folder)


class Grid:
    """Points, cells and point data of a .vtu file."""

    def __init__(self, path):
        from vtk import vtkXMLUnstructuredGridReader
        from vtk.util.numpy_support import vtk_to_numpy

        reader = vtkXMLUnstructuredGridReader()
        reader.SetFileName(path)
        reader.Update()
        grid = reader.GetOutput()
        self.points = vtk_to_numpy(grid.GetPoints().GetData()).copy()
        data = grid.GetPointData()
        self.arrays = {data.GetArrayName(i): vtk_to_numpy(data.GetArray(i)).copy()
                       for i in range(data.GetNumberOfArrays())}


class Results:
    """The files of one call of the program; each is read when it is asked for."""

    def __init__(self, folder):
        self.folder = folder

    def path(self, name):
        return os.path.join(self.folder, name)

    def table(self, name):
        """The columns of a .csv file: arrays of numbers, or of texts where there are others."""
        with open(self.path(name), newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        columns = {}
        for key in rows[0]:
            values = [row[key] for row in rows]
            try:
                columns[key] = np.array([float(v) if v else np.nan for v in values])
            except ValueError:
                columns[key] = np.array(values)
        return columns

    def json(self, name):
        with open(self.path(name), encoding="utf-8") as file:
            return json.load(file)

    @functools.cached_property
    def summary(self):
        """That of the command; that of its first run if this is a study."""
        if os.path.exists(self.path("study.json")):
            row = self.json("study.json")["runs"][0]
            return self.json(os.path.join(f"{row['integrator']}-{row['step']:g}", "summary.json"))
        return self.json("summary.json")

    @functools.cached_property
    def probes(self):
        return self.table("probes.csv")

    @functools.cached_property
    def history(self):
        return self.table("history.csv")

    @functools.cached_property
    def modes(self):
        return self.table("modes.csv")

    @functools.cached_property
    def study(self):
        return self.table("study.csv")

    @functools.cached_property
    def final(self):
        return Grid(self.path("final.vtu"))

    def mode_shape(self, index):
        """The shape of the mode in row `index` of modes.csv."""
        count = len(self.modes["mode"])
        digits = max(2, len(str(count)))
        return Grid(self.path(f"mode_{int(self.modes['mode'][index]):0{digits}d}.vtu"))
