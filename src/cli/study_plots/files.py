"""The files of a study."""

import contextlib
import csv
import json
import math
import os
import stat

import numpy as np

from .words import number, usable

RULES = {"explicit": "explicit", "verlet": "Verlet", "midpoint": "midpoint",
         "backward-euler": "backward Euler", "energy-momentum": "energy-momentum"}  # fmt: skip


class Unusable(Exception):
    """The study cannot be plotted; the text says why."""


def open_regular(*path, **keywords):
    """A file of the study for reading; OSError for links, pipes and devices, which could be read for ever."""

    def opener(name, flags):
        descriptor = os.open(name, flags | os.O_NOFOLLOW | os.O_NONBLOCK)
        if not stat.S_ISREG(os.fstat(descriptor).st_mode):
            os.close(descriptor)
            raise OSError(f"{name}: not a regular file")
        return descriptor

    return open(os.path.join(*path), encoding="utf-8", opener=opener, **keywords)


def read_json(*path):
    try:
        with open_regular(*path) as file:
            return json.load(file)
    except (OSError, ValueError, RecursionError):
        return {}


def read_study(folder):
    """study_of() the study.json in a folder."""
    try:
        with open_regular(folder, "study.json") as file:
            study = json.load(file)
    except (OSError, ValueError, RecursionError) as problem:
        raise Unusable(f"study.json cannot be read: {problem}") from problem
    return study_of(study, folder)


def study_of(study, folder):
    """The content of study.json, with a name for the curve of each run: its integrator, its variant where there are
    several, and its solver where solvers are compared. The folders of the runs are in `folder`."""

    def listed(key):
        found = study.get(key) if isinstance(study, dict) else None
        return [e for e in found if isinstance(e, dict)] if isinstance(found, list) else []

    runs = [{**entry, "rule": str(entry.get("integrator")), "step": number(entry["step"]),
             "variant": str(entry.get("variant") or ""),
             "solver": str(entry.get("solver") or "") if entry.get("compares_solver") else "",
             "directory": os.path.join(folder, str(entry.get("directory")))}
            for entry in listed("runs")
            if usable(number(entry.get("step"))) and entry.get("role") not in ("reference", "trial")]  # fmt: skip
    if not runs:
        raise Unusable("study.json names no run with a step")
    rules = list(dict.fromkeys([*RULES, *(run["rule"] for run in runs)]))
    runs.sort(key=lambda run: (rules.index(run["rule"]), run["step"]))
    reference = study.get("reference")
    reference = reference if isinstance(reference, dict) else {}
    places = {"": str(reference.get("directory", ""))}  # of the reference of each variant
    for entry in listed("references"):
        places.update({str(name): str(entry.get("directory")) for name in entry.get("variants") or []})
    probes = [p for p in listed("probes") if isinstance(p.get("columns"), list) and p["columns"]
              and "/" not in str(p.get("name", "/"))]  # fmt: skip
    return {"runs": runs, "rules": rules, "end": number(study.get("end")), "probes": probes,
            "variants": list(dict.fromkeys(run["variant"] for run in runs)),
            "values": {str(v.get("name")): v["values"] for v in listed("variants")
                       if isinstance(v.get("values"), dict)},
            "stable_step": number(study.get("stable_step")), "references": listed("references"),
            "reference_rule": str(reference.get("integrator", "")),
            "reference_error": number(reference.get("estimated_error")),
            "places": {name: os.path.join(folder, place) for name, place in places.items()},
            "error": str(study.get("error", "position"))}  # fmt: skip


def read_columns(directory, name):
    """Columns of a CSV file as lists of numbers, up to its first broken row; {} without one."""
    try:
        with open_regular(directory, name, newline="") as file:
            with contextlib.suppress(ValueError):
                columns = columns_of_numbers(file)
                return columns if "time" in columns else {}
            file.seek(0)
            rows = list(csv.reader(file))
    except (OSError, ValueError, csv.Error):
        return {}
    columns = {name: [] for name in rows[0]} if rows else {}
    for row in rows[1:]:
        if len(row) != len(columns):
            break
        for column, value in zip(columns.values(), row):
            column.append(number(value))
    return columns if columns.get("time") else {}


def columns_of_numbers(file):
    """The same, which is fast, for a file in which each value is a number; ValueError otherwise."""
    names = next(csv.reader([file.readline()]), [])
    values = np.loadtxt(file, delimiter=",", comments=None, ndmin=2)
    if not len(values) or values.shape[1] != len(names) or len(set(names)) != len(names):
        raise ValueError("not a table of numbers")
    values[~np.isfinite(values)] = math.nan
    return dict(zip(names, values.T.tolist()))


def read_history(run):
    """Columns of history.csv. They are read once."""
    if "history" not in run:
        run["history"] = read_columns(run["directory"], "history.csv")
    return run["history"]


def summary_of(run):
    if "summary" not in run:
        run["summary"] = read_json(run["directory"], "summary.json")
    return run["summary"]


def ended_well(run):
    return run.get("status") == "ok"


def reference_of(study, variant):
    return study["places"].get(variant, study["places"][""])
