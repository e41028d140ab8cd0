"""Plots of a study: python3 plot_study.py [--title TEXT] [--style FILE] [--width 85|170] STUDY_DIR

Reads study.json, and the files of each run. Writes PNG, SVG and PDF files into STUDY_DIR, as wide as a
column or a page of a journal. Each plot has a function plot_NAME(study, axes=None), which Python
programs can call too: it draws into these axes, or into a new figure, and returns the axes, or None if
the study has nothing to draw. `study` is a directory or what read_study() returns.
"""

import argparse
import contextlib
import csv
import functools
import html
import io
import json
import logging
import math
import os
import re
import stat
import sys
import textwrap
import traceback
import warnings

DEFECT, UNUSABLE, NO_MATPLOTLIB, UNWRITABLE = 1, 2, 3, 4  # exit codes; the last one is that of the program
IS_PROGRAM = __name__ == "__main__"


def command_line():
    parser = argparse.ArgumentParser(prog="plot_study", allow_abbrev=False)
    parser.add_argument("directory", type=os.path.abspath)
    parser.add_argument("--title", default="", help="text above each plot")
    parser.add_argument("--style", type=os.path.abspath, help="a style file of matplotlib")
    parser.add_argument("--failures", type=os.path.abspath, help="a file for the names of plots that fail")
    parser.add_argument("--width", type=int, choices=(85, 170), default=170, help="mm")
    return parser.parse_args()


if IS_PROGRAM:
    ARGUMENTS = command_line()
    os.chdir("/")  # matplotlib takes settings from a file of the working folder
    # What matplotlib says of its fonts, its caches or an axis is of no use to who reads the study.
    warnings.simplefilter("ignore")
    logging.getLogger("matplotlib").setLevel(logging.CRITICAL)

try:
    import matplotlib

    if IS_PROGRAM:
        matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    import numpy as np
    from matplotlib.collections import PolyCollection
    from matplotlib.colors import is_color_like, to_hex, to_rgb
    from matplotlib.ticker import LogLocator, MaxNLocator, NullFormatter, NullLocator
except (ImportError, OSError) as problem:  # OSError: there is no room for its caches
    if not IS_PROGRAM:
        raise
    print(f"plot_study: matplotlib cannot be used: {problem}", file=sys.stderr)
    sys.exit(NO_MATPLOTLIB if isinstance(problem, ImportError) else UNWRITABLE)

MM = 1 / 25.4  # in inches
MOST_LINES = 5  # of a panel
MOST_POINTS = 110  # of a curve over time: as many as a panel of 40 mm shows
MOST_PANELS = {85: 6, 170: 9}  # of a figure of this width in mm
EPSILON = 2.0**-52
ENDINGS = ("png", "svg", "pdf")
RULES = {"explicit": "explicit", "verlet": "Verlet", "midpoint": "midpoint",
         "backward-euler": "backward Euler", "energy-momentum": "energy-momentum"}  # fmt: skip
# Okabe and Ito's colours, which colour-blind readers tell apart. Lines and markers differ as well, for
# print in grey. Markers are hollow, so that both of two curves that coincide can be seen.
COLOURS = ["#D55E00", "#E69F00", "#0072B2", "#009E73", "#CC79A7", "#56B4E9", "#000000"]
MARKERS = "os^DvPX"
DASHED, DASH_DOT, DOTTED = (0, (4, 1.6)), (0, (4, 1.4, 1, 1.4)), (0, (1, 1.3))
LINES = ["-", DASHED, DASH_DOT, DOTTED, (0, (7, 1.5)), (0, (6, 1, 1, 1, 1, 1)), "-"]
RULE_LINES = ["-", DASHED, "-", DASH_DOT, DASHED, DOTTED, DASH_DOT]
GREY, PALE, INK = "#5a5a5a", "#e9e9e9", "#1a1a1a"
JOURNAL = {
    "font.size": 8.0, "axes.titlesize": "medium", "axes.labelsize": "medium",
    "xtick.labelsize": "medium", "ytick.labelsize": "medium",
    "axes.titlepad": 3.0, "axes.labelpad": 2.0, "axes.linewidth": 0.6, "lines.linewidth": 1.0,
    "axes.spines.top": False, "axes.spines.right": False, "axes.axisbelow": True,
    "xtick.major.width": 0.6, "ytick.major.width": 0.6, "xtick.minor.size": 1.5,
    "ytick.minor.size": 1.5, "figure.dpi": 100, "savefig.dpi": 300,
    "svg.fonttype": "path",  # so that it looks the same where the font is missing
    "pdf.fonttype": 42, "svg.hashsalt": "tetraction",
}  # fmt: skip
# What a style file may set. Other keys name files, start LaTeX, or are evaluated as Python.
STYLE_KEYS = re.compile(r"(font|axes|lines|xtick|ytick|grid|text|mathtext|patch|markers|figure|savefig"
                        r"|pdf|svg)\.(?!prop_cycle|hooks|usetex|latex|format|directory|backend|hashsalt|dpi)")


class Unusable(Exception):
    """The study cannot be plotted; the text says why."""


class Unwritable(Unusable):
    """A plot cannot be written."""


# ---- numbers and words


def number(value):
    """The value as a float; NaN where there is none, which stands for 'not available'."""
    try:
        result = float(value)
    except (TypeError, ValueError):
        return math.nan
    return result if math.isfinite(result) else math.nan


def usable(value):
    return math.isfinite(value) and value > 0


PREFIXES = [(1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n"),
            (1e-12, "p")]  # fmt: skip


def scaled(size, unit):
    """The factor to show numbers of this size, and their unit with an SI prefix: 3e-5, "s" gives
    1e-6, "µs". Units that take no prefix get a power of ten."""
    unit = {"kg m/s": "N s"}.get(unit, unit)
    factor, prefix = next((p for p in PREFIXES if abs(size) >= 0.9995 * p[0]), PREFIXES[-1])
    if not size or not unit and 1e-3 <= abs(size) < 1e4:
        return 1.0, unit
    if re.match(r"(?!kg)[A-Za-z]+($|[ /·])", unit):
        return factor, prefix + unit
    exponent = 3 * math.floor(math.log10(abs(size)) / 3 + 1e-6)
    return 10.0**exponent, f"{power_of_ten(exponent)} {unit}".strip()


def power_of_ten(exponent):
    return "10" + str(exponent).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))


def si(value, unit):
    """3e-05, "s" as 30 µs."""
    factor, name = scaled(value, unit)
    return f"{float(f'{value / factor:.3g}'):g}\u00a0{name}"  # is not broken into lines


def with_unit(words, unit):
    return f"{words} ({unit})" if unit else words


def plain(text, most=60):
    """For texts, in which matplotlib reads $ as the sign of a formula."""
    text = str(text)
    return (text if len(text) <= most else text[: most - 1] + "…").replace("$", r"\$")


def heading(axes, text):
    axes.set_title("\n".join(textwrap.fill(line, 24) for line in text.split("\n")), loc="left", linespacing=1.0)


def some(values, most):
    """At most so many, evenly chosen, with the first and the last."""
    values = list(values)
    if len(values) <= most:
        return values
    return [values[round(i * (len(values) - 1) / max(1, most - 1))] for i in range(most)]


# ---- the files of a study


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
    """Columns of history.csv, and the energy that entered. They are read once."""
    if "history" not in run:
        columns = run["history"] = read_columns(run["directory"], "history.csv")
        with contextlib.suppress(KeyError, TypeError, ValueError):
            if columns:
                columns["energy_scale"] = [float(summary_of(run)["energy"]["scale"])]
    return run["history"]


def summary_of(run):
    if "summary" not in run:
        run["summary"] = read_json(run["directory"], "summary.json")
    return run["summary"]


def ended_well(run):
    return run.get("status") == "ok"


def reference_of(study, variant):
    return study["places"].get(variant, study["places"][""])


def curves_of(runs, key):
    groups = {}
    for run in runs:
        groups.setdefault(key(run), []).append(run)
    return list(groups.values())


def name_of(study, run, with_variant=True):
    rule = RULES.get(run["rule"], run["rule"].replace("-", " "))
    tags = [plain(run["variant"]) if with_variant and len(study["variants"]) > 1 else "", run["solver"]]
    return rule + (f" ({', '.join(t for t in tags if t)})" if any(tags) else "")


def rule_of(run):
    """As the tables of study.html name it."""
    return run["rule"] + (f" ({run['solver']})" if run["solver"] else "")


def note_of_points(study, points):
    """Of a curve with a marker for each (run, text of its value)."""
    return {"rule": rule_of(points[0][0]), "runs": [run for run, _ in points],
            "texts": [f"{name_of(study, run)}, h = {si(run['step'], 's')}: {text}" for run, text in points]}  # fmt: skip


def note_of_curve(study, run, *units):
    return {"rule": rule_of(run), "run": run, "units": units,
            "text": f"{name_of(study, run)}, h = {si(run['step'], 's')}"}  # fmt: skip


def looks_of(study, run, varied=True):
    """Of a curve: colour and marker are the integrator's, and the line the variant's, if there are
    several in a panel. Another solver is a ring around the point that it should agree with."""
    rank = study["rules"].index(run["rule"]) % len(COLOURS)
    line = RULE_LINES[rank]
    if varied and len(study["variants"]) > 1:
        line = LINES[study["variants"].index(run["variant"]) % len(LINES)]
    looks = {"color": COLOURS[rank], "marker": MARKERS[rank], "ls": line, "ms": 4.2, "mfc": "none"}
    return {**looks, "marker": "o", "ms": 8, "ls": "none"} if run["solver"] else looks


def parts_of(study):
    """[(heading, curves)]: the panels of a plot with a curve for each integrator. If there are too many
    of them for one panel, each variant has its own."""
    def key(run):
        return run["rule"], run["variant"], run["solver"]

    curves = curves_of(study["runs"], key)
    lines = [c for c in curves if not c[0]["solver"]]  # those of another solver are rings
    if len(lines) <= MOST_LINES:
        return [("", curves)]
    parts = []
    for variant in study["variants"]:
        own = [c for c in lines if c[0]["variant"] == variant]
        count = math.ceil(len(own) / MOST_LINES)
        for i in range(count):
            rules = [(c[0]["rule"], variant) for c in own[i::count]]
            rings = [c for c in curves if c[0]["solver"] and (c[0]["rule"], c[0]["variant"]) in rules]
            parts.append((plain(variant), own[i::count] + rings))
    return parts


def representative(study):
    """The coarsest run of each integrator that ended well, in which errors can be seen."""
    runs = [r for r in study["runs"] if ended_well(r) and not r["solver"]
            and r["variant"] == study["variants"][0]]  # fmt: skip
    return [group[-1] for group in curves_of(runs, lambda run: run["rule"])]


# ---- panels


def samples(line):
    """Points on a line of matplotlib in pixels, close together."""
    points = line.get_transform().transform(line.get_xydata())
    if len(points) > 1 and line.get_linestyle() not in ("None", "none"):
        steps = np.ceil(np.abs(np.diff(points, axis=0)).max(axis=1) / 3).clip(1, 300)
        at = np.concatenate([i + np.arange(n) / n for i, n in enumerate(steps)] + [[len(points) - 1]])
        points = np.column_stack([np.interp(at, np.arange(len(points)), p) for p in points.T])
    box = line.axes.bbox.padded(1.5)
    (x0, y0), (x1, y1) = box.min, box.max
    x, y = points.T
    return points[(x >= x0) & (x <= x1) & (y >= y0) & (y <= y1)]


def coincide(p, q):
    """Whether a reader cannot tell these points of two curves apart."""
    if not len(p) or not len(q):
        return False
    gaps = np.hypot(*(p[:, None] - q[None]).transpose(2, 0, 1))
    return max(np.percentile(gaps.min(axis=i), 90) for i in (0, 1)) < 1.8


def readable(color):
    """Dark enough for a text on white."""
    rgb = np.array(to_rgb(color))
    while rgb @ (0.2126, 0.7152, 0.0722) > 0.36:
        rgb *= 0.93
    return to_hex(rgb)


def separated(wanted, sizes, low, high):
    """Centres in ascending order as near to the wanted ones as intervals of these sizes allow."""
    centres = np.array(wanted, dtype=float)
    for _ in range(400):
        for i in range(len(centres) - 1):
            lack = (sizes[i] + sizes[i + 1]) / 2 - (centres[i + 1] - centres[i])
            if lack > 0:
                centres[i] -= lack / 2
                centres[i + 1] += lack / 2
        if len(centres):
            centres[0] = max(centres[0], low + sizes[0] / 2)
            centres[-1] = min(centres[-1], high - sizes[-1] / 2)
    return centres


def ticks_to_try(axis):
    """[(values, texts)] for an axis, from many to few."""
    low, high = sorted(axis.get_view_interval())

    def texts(ticks):
        if axis.get_scale() == "linear" or all(1e-3 < t < 2e4 for t in ticks):
            return [f"{0.0 if abs(t) < 1e-9 * high else t:.6g}".replace("-", "−") for t in ticks]
        parts = [(t / 10 ** math.floor(math.log10(t) + 1e-9), math.floor(math.log10(t) + 1e-9))
                 for t in ticks]  # fmt: skip
        return [(f"{m:.0f}·" if round(m) != 1 else "") + power_of_ten(n) for m, n in parts]

    if axis.get_scale() == "linear":
        found = [MaxNLocator(n, steps=[1, 2, 5, 10]).tick_values(low, high) for n in (6, 5, 4, 3, 2, 1)]
    else:
        first, last = math.floor(math.log10(low)), math.ceil(math.log10(high))
        decades = math.floor(math.log10(high)) - math.ceil(math.log10(low)) + 1
        subs = [(1, 2, 5), (1, 3)] if decades < 2 else []
        found = [np.array([s * 10.0**n for n in range(first, last + 1) for s in sub]) for sub in subs]
        found += [10.0 ** np.arange(stride * math.ceil(first / stride), last + 1, stride)
                  for stride in (1, 2, 3, 4, 5, 10)]  # fmt: skip
    for ticks in found:
        room = 1e-9 * (high - low) if axis.get_scale() == "linear" else 1e-9 * low
        ticks = [t for t in ticks if low - room <= t <= high + room]
        if 0 < len(ticks) <= 7:
            yield ticks, texts(ticks)


class Panel:
    """Axes with curves, whose names are written beside them when the axes have their place."""

    def __init__(self, axes):
        self.axes, self.curves, self.slopes, self.keeps_ticks = axes, [], [], False
        self.extents, self.decades = {}, {}

    def line(self, name, x, y, note=None, **looks):
        """A curve with a name at its end, or beside it if it ends far from the right edge."""
        (line,) = self.axes.plot(x, y, **looks)
        self.curves.append((name, line))
        self.annotate(line, note)

    def annotate(self, artist, note):
        """Gives an artist an identifier, under which save() finds what study.html shows of it: `rule`, which
        the page switches, `runs` and `texts` of its markers, or `run`, `text` and `units` of a curve over time."""
        if note:
            notes = self.axes.figure.__dict__.setdefault("notes", {})
            name = os.path.basename(note["run"]["directory"]) if "run" in note else note["rule"]
            artist.set_gid(re.sub(r"[^\w.-]", "_", f"{name}-{len(notes)}", flags=re.ASCII))
            notes[artist.get_gid()] = {**note, "axes": self.axes}

    def note_of(self, group):
        """Of the name of some curves that are of one rule, and of one run if they are."""
        notes = [getattr(self.axes.figure, "notes", {}).get(line.get_gid(), {}) for _, line, _ in group]
        if len({n.get("rule", "") for n in notes}) != 1 or "rule" not in notes[0]:
            return None
        run = {"run": notes[0]["run"]} if len(notes) == 1 and "run" in notes[0] else {}
        return {"rule": notes[0]["rule"], **run}

    def scale(self, which, values, top=0.0, least=0.7):
        """Makes an axis logarithmic, with room around the values and, in parts of it, at the top."""
        low, high = min(values), max(values)
        span = math.log10(high / low)
        room = max(0.05 * span, 0.5 * (least - span), 0.05)
        getattr(self.axes, f"set_{which}scale")("log")
        upper = room + top / (1 - top) * (span + 2 * room)
        getattr(self.axes, f"set_{which}lim")(low / 10**room, high * 10**upper)
        axis = self.axes.xaxis if which == "x" else self.axes.yaxis
        self.decades[axis] = span + room + upper
        axis.set_minor_locator(NullLocator())
        axis.set_minor_formatter(NullFormatter())

    def fit_ticks(self, renderer):
        """As many tick labels as fit without touching each other."""
        if self.keeps_ticks or not self.axes.axison:
            return
        box = self.axes.bbox
        for axis, i, length, gap in ((self.axes.xaxis, 0, box.width, 5), (self.axes.yaxis, 1, box.height, 2)):
            of = axis.get_transform().transform
            low, high = of(np.array(axis.get_view_interval()))
            for ticks, texts in ticks_to_try(axis):
                at = (of(np.array(ticks, dtype=float)) - low) / (high - low) * length
                size = matplotlib.rcParams["xy"[i] + "tick.labelsize"]
                sizes = np.array([self.extent(text, renderer, size)[i] for text in texts])
                if (np.abs(np.diff(at)) >= (sizes[1:] + sizes[:-1]) / 2 + gap).all():
                    break
            axis.set_ticks(ticks, texts)

    def extent(self, text, renderer, size=None):
        """Width and height of a text in pixels."""
        if (text, size) not in self.extents:
            artist = self.axes.text(0, 0, text, transform=None, linespacing=1.0, fontsize=size)
            box = artist.get_window_extent(renderer)
            artist.remove()
            self.extents[text, size] = box.width, box.height
        return self.extents[text, size]

    def set_minor_ticks(self):
        """They come last, since each pass of the layout would make them again."""
        for axis, decades in self.decades.items():
            axis.set_minor_locator(LogLocator(subs=range(2, 10), numticks=99) if decades < 6 else NullLocator())

    def ends_at_right(self, line):
        points = samples(line)
        box = self.axes.bbox
        return len(points) > 0 and points[-1, 0] > box.x0 + 0.86 * box.width

    def margin(self, renderer):
        """The width of the names at the right edge, in pixels."""
        widths = [self.extent(name, renderer)[0] for name, line in self.curves
                  if name and self.ends_at_right(line)]  # fmt: skip
        return max(widths, default=-10) + 10

    def write_names(self, renderer):
        """Curves that coincide are named together, with a line of text for each."""
        named = [(name, line, samples(line)) for name, line in self.curves]
        taken = [points for *_, points in named if len(points)]
        groups = []
        for entry in named:
            if entry[0] and len(entry[2]):
                group = next((g for g in groups if any(coincide(entry[2], e[2]) for e in g)), None)
                groups.append([entry]) if group is None else group.append(entry)
        boxes, right, inner = [], [], []
        for group in groups:
            names = list(dict.fromkeys(name for name, *_ in group))
            text, color = ",\n".join(names), readable(group[0][1].get_color()) if len(names) == 1 else INK
            entry = (text, color, group[0][2], self.extent(text, renderer), self.note_of(group))
            (right if self.ends_at_right(group[0][1]) else inner).append(entry)
        right.sort(key=lambda entry: entry[2][-1, 1])
        box = self.axes.bbox
        x = max([entry[2][-1, 0] for entry in right], default=0.0) + 6
        centres = separated([e[2][-1, 1] for e in right], [e[3][1] + 1.5 for e in right],
                            box.y0 - 9, box.y1 + 3)  # fmt: skip
        for (text, color, points, (width, height), note), y in zip(right, centres):
            if abs(y - points[-1, 1]) > 4 or x - points[-1, 0] > 12:
                self.annotate(self.leader(points[-1] + (2, 0), (x - 1, y), color), note)
            self.annotate(self.put(text, x, y - height / 2, color), note)
            boxes.append((x, y - height / 2, width, height))
        for text, color, points, size, note in sorted(inner, key=lambda entry: len(entry[2])):
            x, y, far = self.free_place(points, size, taken, boxes)
            if far:
                near = points[np.hypot(*(points - (x + size[0] / 2, y + size[1] / 2)).T).argmin()]
                end = (min(max(near[0], x), x + size[0]), min(max(near[1], y), y + size[1]))
                self.annotate(self.leader(near, end, color), note)
            self.annotate(self.put(text, x, y, color), note)
            boxes.append((x, y, *size))
        if self.slopes:
            self.draw_slopes(np.vstack(taken), boxes)

    def put(self, text, x, y, color, **more):
        """A text whose lower left corner is at this pixel."""
        place = self.axes.transAxes.inverted().transform((x, y))
        return self.axes.text(*place, text, transform=self.axes.transAxes, color=color, va="bottom", linespacing=1.0,
                              zorder=6, **more)  # fmt: skip

    def leader(self, begin, end, color):
        points = self.axes.transAxes.inverted().transform([begin, end])
        return self.axes.plot(*points.T, transform=self.axes.transAxes, color=color, lw=0.5, clip_on=False,
                              marker="", ls="-")[0]  # fmt: skip

    def free_place(self, own, size, taken, boxes):
        """Lower left corner of a text beside its curve, which covers no curve and no other text; and
        whether it is so far away that it needs a line to its curve."""
        (width, height), box = size, self.axes.bbox
        offsets = [(4, -height / 2), (-width - 4, -height / 2), (-width / 2, 4), (-width / 2, -height - 4),
                   (3, 3), (-width - 3, 3), (3, -height - 3), (-width - 3, -height - 3)]  # fmt: skip
        anchors = own[:: -max(1, len(own) // 60)]
        beside = (anchors[:, None] + np.array(offsets)[None]).reshape(-1, 2)
        rank = np.repeat(np.arange(len(anchors)), len(offsets)) + np.tile(np.arange(len(offsets)), len(anchors))
        grid = np.stack(np.meshgrid(np.linspace(box.x0 + 2, box.x1 - width, 40),
                                    np.linspace(box.y0 + 2, box.y1 - height, 30)), axis=-1).reshape(-1, 2)
        foreign = np.vstack([[(-1e3, -1e3)], *(p for p in taken if p is not own)])
        for corners, score in ((beside, 1.0 * rank), (grid, None)):
            def distance(points):
                gap = np.maximum(np.maximum(corners[:, None] - points[None],
                                            points[None] - corners[:, None] - (width, height)), 0)
                return np.hypot(gap[..., 0], gap[..., 1]).min(axis=1)

            mine, others = distance(own), distance(foreign)
            if score is None:
                score = mine
            good = (mine > 1.5) & (others > 2) & (corners >= (box.x0 + 1, box.y0 + 1)).all(axis=1)
            good &= (corners[:, 0] + width <= box.x1 + 4) & (corners[:, 1] + height <= box.y1 + 1)
            for x, y, w, h in boxes:
                good &= ((corners[:, 0] > x + w + 2) | (corners[:, 0] + width < x - 2)
                         | (corners[:, 1] > y + h) | (corners[:, 1] + height < y))  # fmt: skip
            if good.any():
                # Nearer to another curve than to its own, a name would be misread.
                score = np.where(good, score + 4 * np.maximum(0, 9 - others), np.inf)
                best = score.argmin()
                return (*corners[best], mine[best] > 10)
        return (*np.clip(own[-1] + (4, 4), box.min, box.max - size), False)

    def draw_slopes(self, taken, boxes):
        """Triangles of slope 1 and 2 below a part of a curve where at least three runs show the slope."""
        axes, box = self.axes, self.axes.bbox
        (x0, x1), (y0, y1) = axes.get_xlim(), axes.get_ylim()
        # Pixels of a decade: what has slope 1 in the axes has the slope `unit` in pixels.
        unit = (box.height / math.log10(y1 / y0)) / (box.width / math.log10(x1 / x0))
        corners = [(x + w * i / 9, y + h * j / 4) for x, y, w, h in boxes for i in range(10) for j in range(5)]
        taken = np.vstack([taken, *([corners] if corners else [])])
        for slope in (1, 2):
            width = min(28, 28 / (slope * unit))
            height = slope * unit * width
            for part in (p for line in self.slopes for p in straight_parts(line, slope)):
                points = axes.transData.transform(part)
                place = None
                for t in np.linspace(0.5, 0, 12):
                    for at, gap in ((at, gap) for gap in (7, 10, 14, 20) for at in (0.5 - t, 0.5 + t)):
                        x, y = points[0] + at * (points[-1] - points[0]) + np.array(
                            [slope * unit, -1.0]) / math.hypot(1, slope * unit) * gap  # fmt: skip
                        px, py = taken.T
                        inside = ((px > x - 3) & (px < x + width + 12) & (py > y - 15) & (py < y + height + 3)
                                  & (py - y < slope * unit * (px - x) + 3))  # fmt: skip
                        fits = x + width + 10 < box.x1 and y - 14 > box.y0 and y + height < box.y1 and x > box.x0
                        if fits and not inside.any():
                            place = place or (x, y)
                if place is None:
                    continue
                x, y = place
                shape = np.array([(x, y), (x + width, y), (x + width, y + height)])
                axes.add_patch(plt.Polygon(axes.transAxes.inverted().transform(shape), closed=True, fc=PALE,
                                           ec=GREY, lw=0.6, transform=axes.transAxes, zorder=3,
                                           label=f"slope {slope}"))  # fmt: skip
                self.put("1", x + width / 2, y - 13, GREY, ha="center")
                self.put(str(slope), x + width + 3, y + height / 2 - 6, GREY)
                grid = [(x + width * i / 5, y + height * j / 5) for i in range(-2, 8) for j in range(-3, 6)]
                taken = np.vstack([taken, grid])
                break


def straight_parts(line, slope, tolerance=0.15):
    """The longest parts of at least three points of a line on logarithmic axes that have this slope."""
    parts, part = [], []
    for p, q in zip(line, line[1:]):
        own = (math.log(q[1] / p[1]) / math.log(q[0] / p[0])) if q[0] > p[0] else math.inf
        if abs(own - slope) <= tolerance:
            part = (part or [p]) + [q]
            continue
        parts.append(part)
        part = []
    return [part for part in [*parts, part] if len(part) >= 3]


class Sheet:
    """The panels of a plot, in the caller's axes or in a new figure of the exact width."""

    def __init__(self, count, axes, height, columns=1, narrow=1, width=170, title=""):
        """Columns are those of a figure of 170 mm, `narrow` those of one of 85 mm; height of a panel in mm."""
        self.is_own = axes is None
        self.columns = min(count, columns if width > 100 else narrow)
        self.height, self.title, self.is_shared = height, title, False
        if self.is_own:
            figure = plt.figure(figsize=(width * MM, height * MM))
            axes = [figure.add_axes([0.2, 0.2, 0.6 / self.columns, 0.6], label=str(i)) for i in range(count)]
        axes = np.ravel(axes)
        if len(axes) != count:
            raise ValueError(f"this plot has {count} panels, and needs as many axes")
        self.figure, self.panels = axes[0].figure, [Panel(a) for a in axes]

    def is_first(self, index):
        """Whether a panel is the first of its row."""
        return index % self.columns == 0 or not self.is_own

    def is_last(self, index):
        """Whether a panel is the last of its column."""
        return index + self.columns >= len(self.panels) or not self.is_own

    def finish(self):
        renderer = self.figure.canvas.get_renderer()
        for _ in range(2):  # labels of ticks depend on the size, and the size on these labels
            for panel in self.panels:
                panel.fit_ticks(renderer)
            if self.is_shared:
                for panel in self.panels:
                    panel.axes.set_yticks(self.panels[0].axes.get_yticks())
                    panel.axes.set_xticks(self.panels[-1].axes.get_xticks())
            if self.is_own:
                self.arrange(renderer)
        for panel in self.panels:
            panel.write_names(renderer)
            panel.set_minor_ticks()
        return np.array([panel.axes for panel in self.panels])

    def arrange(self, renderer):
        """Gives all panels the same size, with the room that their labels and names need."""
        dpi, rows = self.figure.dpi, math.ceil(len(self.panels) / self.columns)
        left, right, below, above = (np.zeros(n) for n in (self.columns, self.columns, rows, rows))
        for i, panel in enumerate(self.panels):
            row, column = divmod(i, self.columns)
            inner, outer = panel.axes.bbox, panel.axes.get_tightbbox(renderer)
            left[column] = max(left[column], (inner.x0 - outer.x0) / dpi)
            right[column] = max(right[column], (outer.x1 - inner.x1) / dpi, panel.margin(renderer) / dpi)
            below[row] = max(below[row], (inner.y0 - outer.y0) / dpi)
            above[row] = max(above[row], (outer.y1 - inner.y1) / dpi)
        wide, tall, gap, edge = self.figure.get_figwidth(), self.height * MM, 2.5 * MM, 1.0 * MM
        title = textwrap.fill(plain(self.title, 300), int(wide * 14)) if self.title else ""
        head = edge + (0.135 * (title.count("\n") + 1) + 0.04 if title else 0.0)
        each = (wide - 2 * edge - left.sum() - right.sum() - gap * (self.columns - 1)) / self.columns
        height = head + edge + (below + above + tall).sum() + gap * (rows - 1)
        self.figure.set_size_inches(wide, height)
        for i, panel in enumerate(self.panels):
            row, column = divmod(i, self.columns)
            x = edge + left[: column + 1].sum() + right[:column].sum() + column * (each + gap)
            y = height - head - above[: row + 1].sum() - below[:row].sum() - row * gap - (row + 1) * tall
            panel.axes.set_position([x / wide, y / height, each / wide, tall / height])
        for text in list(self.figure.texts):
            text.remove()
        if title:
            self.figure.text(0.5, 1 - edge / height, title, ha="center", va="top")


def plot(function):
    """Makes a function of a plot take a directory, and use the style of a journal for a figure of its own."""

    @functools.wraps(function)
    def drawn(study, axes=None, *, width=170, title="", **choice):
        study = study if isinstance(study, dict) else read_study(os.fspath(study))
        with matplotlib.rc_context(JOURNAL if axes is None else {}):
            return function(study, functools.partial(Sheet, axes=axes, width=width, title=title), width, **choice)

    return drawn


# ---- plots over the step


def over_step(study, sheet, width, panels, slopes=False, floor=None, floor_name=""):
    """A panel for each (key, label of the axis). Runs that did not reach the end are marked at the top.
    Below the level `floor(h)` values mean nothing."""
    parts = some(parts_of(study), 6 // len(panels))

    def values(runs, key):
        return [(r["step"], number(r[key]), r) for r in runs if ended_well(r) and usable(number(r.get(key)))]

    shown = [(key, label, title, curves) for title, curves in parts for key, label in panels
             if any(values(runs, key) for runs in curves)]  # fmt: skip
    if not shown:
        return None
    steps = [run["step"] for run in study["runs"]]
    factor, unit = scaled(math.sqrt(min(steps) * max(steps)), "s")
    sheet = sheet(len(shown), height=62 if len(shown) == 1 else 48, columns=min(2, len(shown)))
    for i, (panel, (key, label, title, curves)) in enumerate(zip(sheet.panels, shown)):
        axes = panel.axes
        drawn = {name_of(study, runs[0], not title): (runs[0], values(runs, key)) for runs in curves}
        sizes = [v for _, points in drawn.values() for _, v, _ in points]
        failures = curves_of([{**r, "curve": name_of(study, r, not title)} for runs in curves for r in runs
                              if not ended_well(r)], lambda r: (r["curve"], r.get("status")))  # fmt: skip
        failures = curves_of(failures, lambda f: (f[0].get("status"), *(r["step"] for r in f)))
        panel.scale("x", [h / factor for h in steps])
        panel.scale("y", sizes, top=min(0.6, 3.6 * len(failures) / sheet.height), least=1.3)
        for name, (run, points) in drawn.items():
            line = [(h / factor, v) for h, v, _ in points]
            if line:
                note = note_of_points(study, [(r, f"{v:.3g}") for _, v, r in points])
                panel.line(name, *zip(*line), note, **looks_of(study, run, not title))
            if slopes and not run["solver"]:
                panel.slopes.append(line)
        for row, same in enumerate(failures):
            kind = "unstable" if same[0][0].get("status") == "unstable" else "failed"
            panel.line(textwrap.fill(f"{kind}: {', '.join(f[0]['curve'] for f in same)}", 16),
                       [r["step"] / factor for r in same[0]], [1 - (row + 0.5) * 3.6 / sheet.height] * len(same[0]),
                       color=looks_of(study, same[0][0])["color"], marker="x", ls="none", ms=4.5, clip_on=False,
                       transform=axes.get_xaxis_transform())  # fmt: skip
        limits = {}
        for run in (runs[0] for runs in curves if runs[0]["rule"] in ("explicit", "verlet")):
            limits.setdefault(f"{number(run.get('stable_step')):.3g}", []).append(run)
        for rank, runs in enumerate(limits.values()):
            names = " and ".join(name_of(study, run, not title) for run in runs)
            limit = number(runs[0].get("stable_step")) / factor
            if axes.get_xlim()[0] < limit < axes.get_xlim()[1]:
                panel.line("stability limit" + (f"\nof {names}" if len(limits) > 1 else ""), [limit] * 2, [0, 1],
                           color=GREY, ls=[DASHED, DOTTED, DASH_DOT][rank % 3], lw=0.8, zorder=1,
                           transform=axes.get_xaxis_transform())  # fmt: skip
        if floor:
            band(panel, np.geomspace(*axes.get_xlim(), 20), lambda h: floor(h * factor), floor_name)
        zeros = sum(1 for runs in curves for r in runs if number(r.get(key)) == 0 and ended_well(r)
                    and r.get("role") != "reference")  # fmt: skip
        axes.set_xlabel(f"step $h$ ({unit})" + (f"; {zeros} run{'s' * (zeros > 1)} with the value 0 not shown"
                                                if zeros else "") if sheet.is_last(i) else "")  # fmt: skip
        axes.set_ylabel(label if sheet.is_first(i) or len(panels) > 1 else "")
        heading(axes, title)
    return sheet.finish()


def band(panel, x, level, name):
    """A grey band below a level, with its name, if the level lies in the panel."""
    bottom, top = panel.axes.get_ylim()
    y = np.array([level(value) for value in x], dtype=float)
    if np.nanmax(np.append(y, 0)) > bottom:
        panel.axes.fill_between(x, bottom, np.clip(y, bottom, top), fc=PALE, ec="none", zorder=0)
        panel.line(name, x, y, color=GREY, ls="-", marker="", lw=0)
        panel.axes.set_ylim(bottom, top)


def error_of(study):
    """Key and words of the error that the orders are of."""
    if study["error"].startswith("energy."):
        return "probe_error", f"relative error of the {plain(study['error'][7:]).replace('_', ' ')}"
    part, found, name = study["error"].partition("probe.")
    if found:
        part = f"{part[:-1]} of the " if part else ""
        return "probe_error", f"relative error of the {part}probe {plain(name)}"
    at = f" at $t$ = {si(study['end'], 's')}" if usable(study["end"]) else " at the end"
    return "position_error", f"relative position error{at}"


@plot
def plot_error_over_step(study, sheet, width):
    own = study["reference_error"]
    return over_step(study, sheet, width, [error_of(study)], True, (lambda h: 5 * own) if usable(own) else None,
                     "5 × error of\nthe reference")  # fmt: skip


@plot
def plot_rms_error_over_step(study, sheet, width):
    return over_step(study, sheet, width, [("position_error_rms", "relative position error, r.m.s. over time")], True)


def round_off_of_steps(study):
    """Each step adds at most about one rounding."""
    return (lambda h: EPSILON * (10 + study["end"] / h)) if usable(study["end"]) else None


@plot
def plot_energy_drift_over_step(study, sheet, width):
    return over_step(study, sheet, width, [("max_relative_energy_drift", "largest relative energy error")], True,
                     round_off_of_steps(study), "round-off")  # fmt: skip


@plot
def plot_momentum_drift_over_step(study, sheet, width):
    return over_step(study, sheet, width, [
        ("linear_momentum_drift", "relative error of\nthe linear momentum"),
        ("angular_momentum_drift", "relative error of\nthe angular momentum")], False,
        round_off_of_steps(study), "round-off")  # fmt: skip


@plot
def plot_work_precision(study, sheet, width):
    """Error over wall time. Full markers are steps above the stability limit of the explicit rules."""
    key, label = error_of(study)
    parts = []
    for title, curves in some(parts_of(study), 6):
        points = [[(number(r.get("wall_seconds")), number(r.get(key)), r) for r in runs
                   if ended_well(r) and r.get("timing") != "shared"] for runs in curves]  # fmt: skip
        points = [[p for p in line if usable(p[0]) and usable(p[1])] for line in points]
        parts += [(title, [line for line in points if line])] if any(points) else []
    if not parts:
        return None
    times = [p[0] for _, lines in parts for line in lines for p in line]
    factor, unit = scaled(math.sqrt(min(times) * max(times)), "s")
    sheet = sheet(len(parts), height=62 if len(parts) == 1 else 48, columns=2)
    for i, (panel, (title, lines)) in enumerate(zip(sheet.panels, parts)):
        panel.scale("x", [t / factor for t in times])
        panel.scale("y", [p[1] for line in lines for p in line], least=1.3)
        for line in lines:
            run, looks = line[0][2], looks_of(study, line[0][2], not title)
            x, y = [p[0] / factor for p in line], [p[1] for p in line]
            # In the order of the steps, so that the curve shows what a smaller step costs and gives.
            note = note_of_points(study, [(r, f"{v:.3g}, {si(t, 's')}") for t, v, r in line[::-1]])
            panel.line(name_of(study, run, not title), x[::-1], y[::-1], note, **looks)
            full = [i for i, p in enumerate(line) if not run["solver"]
                    and 0 < number(p[2].get("stable_step")) < p[2]["step"]]  # fmt: skip
            (marks,) = panel.axes.plot([x[i] for i in full], [y[i] for i in full],
                                       **{**looks, "ls": "none", "mfc": looks["color"]})  # fmt: skip
            panel.annotate(marks, {"rule": note["rule"], "runs": [line[i][2] for i in full],
                                   "texts": [note["texts"][::-1][i] for i in full]})  # fmt: skip
        panel.axes.set_xlabel(f"wall time of the steps ({unit})" if sheet.is_last(i) else "")
        panel.axes.set_ylabel(label if sheet.is_first(i) else "")
        heading(panel.axes, title)
    return sheet.finish()


@plot
def plot_cost_by_phase(study, sheet, width):
    """A panel for each integrator, with a curve for each phase."""
    phases = {"stepping": "steps", "output": "output", "setup": "set-up", "stability": "stability",
              "mesh": "mesh"}  # fmt: skip
    groups = []
    for runs in curves_of(study["runs"], lambda run: (run["rule"], run["variant"])):
        table = []
        for run in runs:
            times = summary_of(run).get("wall_seconds")
            if isinstance(times, dict) and run.get("timing") != "shared" and ended_well(run) and not run["solver"]:
                table.append((run["step"], {key: number(times.get(key)) for key in phases}))
        groups += [(name_of(study, runs[0]), table)] if table else []
    groups = some(groups, MOST_PANELS[width])
    times = [t for _, table in groups for _, row in table for t in row.values() if usable(t)]
    if not times:
        return None
    steps = [h for _, table in groups for h, _ in table]
    (x_factor, x_unit), (factor, unit) = (scaled(math.sqrt(min(v) * max(v)), "s") for v in (steps, times))
    sheet = sheet(len(groups), height=36, columns=2 if len(groups) in (2, 4) else 3)
    for i, (panel, (name, table)) in enumerate(zip(sheet.panels, groups)):
        panel.scale("x", [h / x_factor for h in steps])
        panel.scale("y", [max(t, 1e-6 * max(times)) / factor for t in times], least=1.3)
        for rank, (key, words) in enumerate(phases.items()):
            points = [(h / x_factor, row[key] / factor) for h, row in table if usable(row[key])]
            if points:
                panel.line(words, *zip(*points), color=COLOURS[[2, 0, 3, 4, 1][rank]], marker=MARKERS[rank],
                           ms=3.5, mfc="none", ls=RULE_LINES[rank])  # fmt: skip
        finish_small(sheet, i, name, f"step $h$ ({x_unit})", f"wall time ({unit})")
    return sheet.finish()


def finish_small(sheet, index, title, x_label, y_label):
    """Axes of many panels with equal scales have labels at the left and below only."""
    axes, sheet.is_shared = sheet.panels[index].axes, True
    heading(axes, title)
    axes.set_xlabel(x_label if sheet.is_last(index) else "")
    axes.set_ylabel(y_label if sheet.is_first(index) else "")
    axes.tick_params(labelleft=sheet.is_first(index), labelbottom=sheet.is_last(index))


# ---- plots over time


def thinned(times, values, both=False):
    """Of each of about MOST_POINTS stretches the largest value, or the least and the largest one in their
    order, and the last value."""
    t, v = np.array([times, values], dtype=float)
    t, v = np.array([t, v])[:, np.isfinite(t) & np.isfinite(v)]
    stride = math.ceil(len(t) / MOST_POINTS) * (1 + both)
    if stride <= 1 + both:
        return t, v
    kept = {len(t) - 1}
    for i in range(0, len(t), stride):
        kept |= {i + np.argmax(v[i : i + stride])} | ({i + np.argmin(v[i : i + stride])} if both else set())
    return t[sorted(kept)], v[sorted(kept)]


def over_time(study, sheet, width, value_of, round_off_of, label, unit=""):
    """A panel for each integrator with a curve for each step, on a logarithmic axis that fits the runs
    that ended well: a run that blew up leaves the panel, and is marked at its upper edge. `value_of`
    returns None for a run that has no such number."""
    groups, floors = [], []
    for runs in curves_of([r for r in study["runs"] if not r["solver"]], lambda r: (r["rule"], r["variant"])):
        curves = []
        bad = [r for r in runs if not ended_well(r)]
        good = some([r for r in runs if ended_well(r)], MOST_LINES - (1 if bad else 0))
        for run in good + some(bad, MOST_LINES - len(good)):
            history = read_history(run)
            try:
                values = value_of(run, history)
                times, values = thinned(history["time"], values) if values is not None else ([], [])
                if len(times):
                    curves.append((run, times, values))
                    floors += [round_off_of(run, history)] if ended_well(run) else []
            except (KeyError, IndexError):
                continue
        groups += [curves] if curves else []
    groups = some(groups, MOST_PANELS[width])
    every = [(run, v) for curves in groups for run, _, values in curves for v in values if v > 0]
    good = [v for run, v in every if ended_well(run)] or [v for _, v in every]
    if not good:
        return None
    factor, unit = scaled(max(good), unit) if unit else (1.0, "")
    floor = max((f for f in floors if usable(f)), default=math.nan) / factor
    end = max(times[-1] for curves in groups for _, times, _ in curves)
    second, time_unit = scaled(end, "s")
    sheet = sheet(len(groups), height=34, columns=2 if len(groups) in (2, 4) else 3)
    for i, (panel, curves) in enumerate(zip(sheet.panels, groups)):
        color = looks_of(study, curves[0][0])["color"]
        panel.axes.set_xlim(0, end / second)
        panel.scale("y", [np.percentile(good, 2) / factor, max(good) / factor], least=1.3)
        band(panel, [0, end / second], lambda _: floor, "round-off")
        bad = [(run, times[-1]) for run, times, _ in curves if not ended_well(run)]
        for rank, (run, times, values) in enumerate(reversed(curves)):
            # A logarithmic axis has no zero, as the error of the start is.
            points = [(t / second, v / factor) for t, v in zip(times, values) if v > 0]
            # The coarsest step has the integrator's colour, and finer ones are darker.
            hue = to_hex(np.array(to_rgb(color)) * (1 - 0.7 * rank / max(1, len(curves) - 1)))
            if points:
                panel.line(si(run["step"], "s") if ended_well(run) else "", *zip(*points),
                           note_of_curve(study, run, time_unit, unit), color=hue,
                           ls=LINES[rank % len(LINES)], marker="." if len(points) < 8 else "", ms=3)  # fmt: skip
        if bad:
            kinds = {r.get("status") for r, _ in bad}
            words = f"{'unstable' if kinds == {'unstable'} else 'failed'}: {steps_text([r['step'] for r, _ in bad])}"
            panel.line(textwrap.fill(words, 20), [t / second for _, t in bad], [0.96] * len(bad), color=color,
                       marker="x", ms=4.5, ls="none", clip_on=False, zorder=5,
                       transform=panel.axes.get_xaxis_transform())  # fmt: skip
        finish_small(sheet, i, name_of(study, curves[0][0]), f"time $t$ ({time_unit})", with_unit(label, unit))
    return sheet.finish()


def steps_text(steps):
    """24 µs, 98 µs and 390 µs as "24, 98, 390 µs"."""
    factor, unit = scaled(max(steps), "s")
    return ", ".join(f"{h / factor:.3g}" for h in sorted(steps)) + f"\u00a0{unit}"  # is not broken into lines


def energy_error(history):
    """|energy error| over the energy that entered, at each step."""
    error, scale = np.abs(history["energy_error"]), energy_scale(history)
    return error / scale if scale > 0 else 0.0 * error


def energy_scale(history):
    if "energy_scale" in history:
        return history["energy_scale"][0]
    # a run without a summary
    scale = sum(history[key][0] for key in ("kinetic_energy", "elastic_energy"))
    for key in ("environment_energy", "external_work", "constraint_work", "edit_work"):
        column = history.get(key, [0.0])
        finite = (abs(value - column[0]) for value in column if math.isfinite(value))
        scale += max(finite, default=0.0)
    return scale


def energy_round_off(run, history):
    """At most about one rounding of the energies in each step, over the energy that entered."""
    keys = ("kinetic_energy", "elastic_energy", "environment_energy", "external_work",
            "dissipated_energy")  # fmt: skip
    sums = np.sum([np.abs(history[k]) for k in keys if k in history], axis=0)
    largest = np.max(sums, where=np.isfinite(sums), initial=0.0)
    scale = energy_scale(history)
    return EPSILON * (10 + len(sums)) * largest / scale if scale > 0 else math.nan


# Sections of a scene without influence on the momenta.
INNER = {"mesh", "material", "material_region", "time", "solver", "environment", "damping", "initial",
         "output", "probe", "amplitude"}  # fmt: skip


def conserved(run, letter):
    """The projection to those components of a momentum ("p" or "l") that the run's scene conserves, or
    None if there are none."""
    scene = summary_of(run).get("scene")
    if not isinstance(scene, dict) or not scene:
        return None
    if any(value for key, value in scene.items() if key not in INNER):
        return None
    damping = scene.get("damping") or {}
    # Viscosity acts between the vertices, and takes no momentum.
    if any(value for key, value in damping.items() if key != "viscosity"):
        return None
    environment = scene.get("environment") or {"kind": "none"}
    if environment.get("kind") == "none":
        return np.eye(3)
    if environment.get("kind") == "attraction":  # towards the origin
        return np.eye(3) if letter == "l" else None
    direction = np.array(environment.get("direction", [0.0, -1.0, 0.0]), dtype=float)
    along = np.outer(direction, direction) / (direction @ direction)
    return along if letter == "l" else np.eye(3) - along


def momentum_change(letter):
    def value_of(run, history):
        projection = conserved(run, letter)
        if projection is None:
            return None
        vectors = np.array([history[letter + axis] for axis in "xyz"])
        return list(np.linalg.norm(projection @ (vectors - vectors[:, :1]), axis=0))

    return value_of


def momentum_round_off(letter):
    """At most about one rounding of the momentum in each step: of the sum of its magnitudes over the
    vertices, which the kinetic energy T bounds by √(2 M T), or of the magnitude |L|."""

    def round_off_of(run, history):
        rounding = EPSILON * (10 + len(history["time"]))
        if letter == "l":
            sizes = [math.hypot(*v) for v in zip(*(history["l" + axis] for axis in "xyz"))]
            return rounding * max((s for s in sizes if math.isfinite(s)), default=0.0)
        mass = number(summary_of(run).get("mass"))
        energy = max((e for e in history["kinetic_energy"] if math.isfinite(e)), default=0.0)
        return rounding * math.sqrt(2 * mass * energy) if usable(mass) else math.nan

    return round_off_of


@plot
def plot_energy_over_time(study, sheet, width):
    return over_time(study, sheet, width, lambda _, history: energy_error(history), energy_round_off,
                     "relative energy error")  # fmt: skip


@plot
def plot_linear_momentum_over_time(study, sheet, width):
    return over_time(study, sheet, width, momentum_change("p"), momentum_round_off("p"),
                     "change of $p$", "N s")  # fmt: skip


@plot
def plot_angular_momentum_over_time(study, sheet, width):
    return over_time(study, sheet, width, momentum_change("l"), momentum_round_off("l"),
                     "change of $L$", "N m s")  # fmt: skip


@plot
def plot_probe(study, sheet, width, name=None):
    """For each component the values on the left, and the difference from the reference on the right, of the
    coarsest runs that ended well. Values of the run that differs least from the reference may be left out."""
    probe = next((p for p in study["probes"] if name is None or str(p["name"]) == name), None)
    if probe is None:
        return None
    columns, unit = [str(column) for column in probe["columns"]], str(probe.get("unit") or "")
    runs = [(run, read_columns(run["directory"], "probes.csv")) for run in representative(study)[:MOST_LINES]]
    runs = [(run, table) for run, table in runs if all(c in table for c in columns)]
    if not runs:
        return None
    place = reference_of(study, study["variants"][0])
    reference = read_columns(place, "probes.csv")
    has_reference = all(c in reference for c in columns) and any(run["directory"] != place for run, _ in runs)
    end = max(table["time"][-1] for _, table in runs)
    second, time_unit = scaled(end, "s")
    steps = [run["step"] for run, _ in runs]
    usual = max(steps, key=steps.count)
    sheet = sheet((1 + has_reference) * len(columns), height=36, columns=1 + has_reference)
    for i, column in enumerate(columns):
        values, other = sheet.panels[(1 + has_reference) * i :][:2] if has_reference else (sheet.panels[i], None)
        series, known = [(run, *finite(table, column)) for run, table in runs], finite(reference, column)
        series = [(run, t, v, np.abs(v - np.interp(t, *known)) if has_reference and len(known[0]) else 0 * v)
                  for run, t, v in series if len(t)]  # fmt: skip
        sizes = [np.abs(np.concatenate([s[j] for s in series])) for j in (2, 3)]
        gaps = sizes[1][sizes[1] > 0]
        (factor, shown), (small, small_unit) = (scaled(np.max(s), unit) for s in sizes)
        if has_reference and len(known[0]):
            t, v = thinned(*known, both=True)
            values.line("reference", t / second, v / factor, color="#b0b0b0", lw=2.5)
        least = sorted(series, key=lambda s: np.max(s[3]))[: max(0, len(series) + has_reference - MOST_LINES)]
        for entry in series:
            run, t, v, gap = entry
            words = name_of(study, run, False) + (f" ({si(run['step'], 's')})" if run["step"] != usual else "")
            looks = {**looks_of(study, run, False), "marker": "." if len(t) < 8 else "", "ms": 3}
            if not any(entry is e for e in least):
                x, y = thinned(t, v, both=True)
                values.line(words, x / second, y / factor, note_of_curve(study, run, time_unit, shown), **looks)
            if (gap > 0).any():
                x, y = thinned(t, np.where(gap > 0, gap, np.nan))
                other.line(words, x / second, y / small, note_of_curve(study, run, time_unit, small_unit), **looks)
        for panel, words in [(values, with_unit(plain(column), shown)), (other, with_unit("difference", small_unit))]:
            if panel is not None:
                panel.axes.set(xlim=(0, end / second), ylabel=words,
                               xlabel=f"time $t$ ({time_unit})" if i == len(columns) - 1 else "")  # fmt: skip
                panel.axes.tick_params(labelbottom=i == len(columns) - 1)
        if len(gaps):
            other.scale("y", [np.percentile(gaps, 2) / small, max(gaps) / small], least=1.3)
    heading(sheet.panels[0].axes, f"$h$ = {si(usual, 's')}")
    return sheet.finish()


def finite(table, column):
    pairs = np.array([table["time"], table[column]], dtype=float)
    return pairs[:, np.isfinite(pairs).all(axis=0)]


# ---- plots of variants and of shapes


@plot
def plot_quantity_over_parameter(study, sheet, width):
    """A panel for each probe, or else the difference from the first variant, and each key that is varied, with
    the other keys at their first value. The first variant has a full marker."""
    values = study["values"]
    if len(values) < 2 or len({tuple(v) for v in values.values()}) != 1:
        return None
    first, keys = next(iter(values)), list(next(iter(values.values())))
    sweeps = {key: [name for name, v in values.items() if all(v[k] == values[first][k] for k in keys if k != key)]
              for key in keys}  # fmt: skip
    rows = []
    for probe in study["probes"][:3]:
        found = {name: largest_of_probe(study, name, [str(c) for c in probe["columns"]]) for name in values}
        rows.append((f"largest |{plain(probe['name'])}|", str(probe.get("unit") or ""), found))
    if not rows:
        found = {str(name): number(entry.get("position_difference")) for entry in study["references"]
                 for name in entry.get("variants") or []}  # fmt: skip
        rows = [("relative difference of the positions from the first variant", "",
                 {**found, first: 0.0} if found else {})]  # fmt: skip
    rows = [row for row in rows if sum(map(math.isfinite, row[2].values())) > 1]
    panels = [(row, key) for row in rows for key in keys if len(sweeps[key]) > 1]
    if not panels:
        return None
    sheet = sheet(len(panels), height=48 if len(panels) == 1 else 40, columns=min(3, len(panels) // len(rows)))
    for i, (panel, ((label, unit, found), key)) in enumerate(zip(sheet.panels, panels)):
        shown = [n for k in keys for n in sweeps[k] if math.isfinite(found.get(n, math.nan))]
        factor, unit = scaled(max(abs(found[n]) for n in shown), unit)
        points = [(name, found[name] / factor) for name in sweeps[key] if math.isfinite(found.get(name, math.nan))]
        x = [number(values[name][key]) for name, _ in points]
        is_number = all(map(math.isfinite, x))
        if not is_number:
            x = list(range(len(points)))
        order = np.argsort(x)
        x, y = np.array(x)[order], np.array([v for _, v in points])[order]
        base = [i for i, j in enumerate(order) if points[j][0] == first]
        color = COLOURS[2]
        panel.line(sensitivity(x, y, base) if is_number else "", x, y, color=color, marker="o", ms=4, mfc="white",
                   ls="-" if is_number else "none")  # fmt: skip
        panel.axes.plot(x[base], y[base], color=color, marker="o", ms=4, ls="none")
        low, high = min(found[n] / factor for n in shown), max(found[n] / factor for n in shown)
        room = max(0.12 * (high - low), 0.02 * abs(high)) or 1.0
        panel.axes.set_ylim(low - room, high + room)
        if is_number and min(x) > 0 and max(x) > 30 * min(x):
            panel.scale("x", x)
        elif not is_number:
            names = [textwrap.fill(plain(values[points[j][0]][key], 60), 14) for j in order]
            panel.axes.set_xticks(x, names, rotation=0 if sum(map(len, names)) < width / 3 else 90)
            panel.axes.set_xlim(-0.5, len(x) - 0.5)
            panel.keeps_ticks = True
        panel.axes.set_xlabel(plain(key, 60))
        panel.axes.set_ylabel(with_unit(textwrap.fill(label, 30), unit) if i % sheet.columns == 0 else "")
    return sheet.finish()


def largest_of_probe(study, variant, columns):
    """Of its magnitude over time, in the finest run of a variant that ended well."""
    runs = [r for r in study["runs"] if r["variant"] == variant and ended_well(r) and not r["solver"]]
    own = [r for r in runs if r["rule"] == study["reference_rule"]] or runs
    table = read_columns(min(own, key=lambda r: r["step"])["directory"], "probes.csv") if own else {}
    if not all(c in table for c in columns):
        return math.nan
    return np.nanmax(np.linalg.norm([table[c] for c in columns], axis=0), initial=0.0)


def sensitivity(x, y, base):
    """The relative change of a quantity over that of its parameter, around the first variant."""
    around = [i for b in base for i in (b - 1, b + 1) if 0 <= i < len(x)]
    if not around or min(*x, *y) <= 0:
        return ""
    i, j = (around[0], around[-1]) if len(around) > 1 else (around[0], base[0])
    slope = round(math.log(y[j] / y[i]) / math.log(x[j] / x[i]), 2) + 0.0
    return f"sensitivity {slope:g}".replace("-", "−")


def read_surface(directory):
    """Corners of the triangles of the surface in final.vtu, as an array (n, 3, 3); None if there are none."""
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkCommonCore import vtkObject
    from vtkmodules.vtkFiltersCore import vtkTriangleFilter
    from vtkmodules.vtkFiltersGeometry import vtkDataSetSurfaceFilter
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

    path = os.path.join(directory, "final.vtu")
    try:
        open_regular(path).close()
    except OSError:
        return None
    vtkObject.GlobalWarningDisplayOff()
    reader, surface, triangles = vtkXMLUnstructuredGridReader(), vtkDataSetSurfaceFilter(), vtkTriangleFilter()
    reader.SetFileName(path)
    surface.SetInputConnection(reader.GetOutputPort())
    triangles.SetInputConnection(surface.GetOutputPort())
    triangles.Update()
    found = triangles.GetOutput()
    if found.GetNumberOfPolys() == 0:
        return None
    corners = vtk_to_numpy(found.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    shape = vtk_to_numpy(found.GetPoints().GetData()).astype(float)[corners]
    return shape if np.isfinite(shape).all() else None


# Of the picture: to the right, upwards and towards the eye. The axis y points upwards.
VIEW = np.array([[0.894, 0.0, -0.447], [-0.183, 0.913, -0.365], [0.408, 0.408, 0.816]])


@plot
def plot_shapes_at_end(study, sheet, width):
    """The body at the end: the reference, and the coarsest run of each integrator that ended well over it, or
    the references of the variants."""
    if len(study["variants"]) > 1:
        shapes = [(plain(v), reference_of(study, v)) for v in study["variants"] if v in study["places"]]
    else:
        runs = [(f"{name_of(study, r)},\n$h$ = {si(r['step'], 's')}", r["directory"]) for r in representative(study)]
        shapes = [("reference", reference_of(study, study["variants"][0])), *runs]
    try:
        shapes = [(name, read_surface(place)) for name, place in some(shapes, 6)]
    except ImportError:  # python3-vtk9 is not installed
        return None
    shapes = [(name, shape @ VIEW.T) for name, shape in shapes if shape is not None]
    if not shapes:
        return None
    corners = np.vstack([shape.reshape(-1, 3) for _, shape in shapes])
    (x0, y0, _), (x1, y1, _) = corners.min(axis=0), corners.max(axis=0)
    columns = {85: 2, 170: 3}[width] if len(shapes) > 1 else 1
    each = width / columns - 6
    sheet = sheet(len(shapes), height=min(max(each * (y1 - y0) / (x1 - x0), 10), 60), columns=columns, narrow=columns)
    is_large = sum(len(shape) for _, shape in shapes) > 200
    for i, (panel, (name, shape)) in enumerate(zip(sheet.panels, shapes)):
        layers = [(shape, 0.55 + 0.45 * np.abs(normals(shape)[:, 2]))]
        if i > 0 and shapes[0][0] == "reference":
            layers.insert(0, (shapes[0][1], None))
        for triangles, light in layers:
            order = np.argsort(triangles[:, :, 2].mean(axis=1))
            colors = [PALE] if light is None else np.outer(light, to_rgb("#7fb2d9")).clip(0, 1)[order]
            panel.axes.add_collection(PolyCollection(triangles[order][:, :, :2], fc=colors, ec=colors, lw=0.2,
                                                     rasterized=is_large))  # fmt: skip
        panel.axes.set(xlim=(x0, x1), ylim=(y0, y1), aspect="equal", anchor="S")
        panel.axes.axis("off")
        heading(panel.axes, name)
    length = next(s * 10.0**n for n in range(12, -12, -1) for s in (5, 2, 1) if s * 10.0**n < 0.4 * (x1 - x0))
    bar = sheet.panels[0].axes
    bar.plot([x0, x0 + length], [y0, y0], color=INK, lw=1.5, clip_on=False, solid_capstyle="butt")
    bar.annotate(si(length, "m"), (x0 + length / 2, y0), (0, -2), textcoords="offset points", ha="center", va="top")
    return sheet.finish()


def normals(triangles):
    n = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    return n / np.maximum(np.linalg.norm(n, axis=1), 1e-300)[:, None]


PLOTS = {name[len("plot_"):]: function for name, function in list(globals().items())
         if name.startswith("plot_") and name != "plot_probe"}  # fmt: skip


# ---- the program


def read_style(path):
    """The settings of a style file of matplotlib that cannot run code or name files, and the others' keys."""
    style, others = {}, []
    try:
        with open(path, encoding="utf-8") as file:
            lines = file.read(100000).splitlines()
    except (OSError, ValueError) as problem:
        raise Unusable(f"--style {path}: cannot be read ({problem})") from problem
    for count, line in enumerate(lines, 1):
        key, _, value = re.split(r"(?:^|\s)#", line)[0].partition(":")
        key, value = key.strip(), value.strip().strip('"')
        if not key:
            continue
        if key == "axes.prop_cycle":  # only its colours, which need no evaluation
            colors = [c for c in re.findall(r"['\"]([^'\"]+)['\"]", value) if is_color_like(c)]
            COLOURS[: len(colors)] = colors
        elif not STYLE_KEYS.match(key) or key == "figure.figsize":
            others.append(key)
        else:
            try:
                style[key] = matplotlib.RcParams({key: value})[key]
            except (KeyError, ValueError) as problem:
                raise Unusable(f"--style {path}, line {count}: {problem}") from problem
    return style, others


def write_file(path, content):
    """The file gets its name when it is complete. A link of that name is not followed."""
    temporary = path + ".part"
    try:
        if os.path.lexists(temporary):
            os.remove(temporary)
        # Without a buffer nothing is left that Python would try to write at its end.
        with open(temporary, "xb", buffering=0) as file:
            rest = memoryview(content)
            while rest:
                rest = rest[file.write(rest) :]
        os.replace(temporary, path)
    except OSError as problem:
        with contextlib.suppress(OSError):
            os.remove(temporary)
        raise Unwritable(f"{path}: cannot be written ({problem.strerror})") from problem


def in_xml(text):
    """For an element or an attribute. Viewers of other programs, as study.html, look for "=" in attributes only."""
    return html.escape(str(text).replace(r"\$", "$")).replace("=", "&#61;")


def scale_of(axes):
    """For each axis: the value is a + b p, or the power of ten of that, at the coordinate p of the SVG file."""
    (wide, tall), place = axes.figure.get_size_inches() * 72, axes.get_position()
    text = []
    for axis, begin, length in ((axes.xaxis, place.x0 * wide, place.width * wide),
                                (axes.yaxis, (1 - place.y0) * tall, -place.height * tall)):  # fmt: skip
        low, high = axis.get_transform().transform(np.array(axis.get_view_interval()))
        slope = (high - low) / length
        text.append(f"{low - slope * begin:.9g} {slope:.9g} {int(axis.get_scale() == 'log')}")
    return " ".join(text)


def annotated(svg, prefix, figure):
    """The drawing with what study.html switches and shows under the cursor."""
    parts = re.split(r'(<g id="[^"]*">)', svg)
    notes = getattr(figure, "notes", {})
    for i in range(1, len(parts), 2):
        note = notes.get(parts[i][len(f'<g id="{prefix}') : -2])
        if note is None:
            continue
        tag = parts[i][:-1] + f' data-rule="{in_xml(note["rule"])}"'
        if "run" in note:
            tag += f' data-run="{in_xml(os.path.basename(note["run"]["directory"]))}"'
        if "units" in note:
            tag += f' data-scale="{scale_of(note["axes"])}" data-units="{in_xml("|".join(note["units"]))}"'
        parts[i] = tag + ">" + (f"<title>{in_xml(note['text'])}</title>" if "text" in note else "")
        points = iter(zip(note.get("runs", []), note.get("texts", [])))
        if parts[i + 1].count("<use ") == len(note.get("runs", [])):

            def titled(match, points=points):
                run, text = next(points)
                return (f'{match[1]} data-run="{in_xml(os.path.basename(run["directory"]))}">'
                        f"<title>{in_xml(text)}</title></use>")  # fmt: skip

            parts[i + 1] = re.sub(r"(<use [^>]*?)/>", titled, parts[i + 1])
    return "".join(parts)


def save(figure, folder, name):
    # No date, so that the same study gives the same files.
    extra = {"png": {}, "svg": {"Date": None}, "pdf": {"CreationDate": None, "ModDate": None}}
    for ending in ENDINGS:
        content = io.BytesIO()
        figure.savefig(content, format=ending, metadata=extra[ending])
        content = content.getvalue()
        if ending == "svg":  # Several plots can stand in one page.
            prefix = re.sub(r"\W", "_", name).encode() + b"-"
            content = re.sub(rb'( id="|href="#|url\(#)', rb"\1" + prefix, content)
            content = re.sub(rb"([MLQ] -?\d+\.\d\d)\d* (-?\d+\.\d\d)\d*", rb"\1 \2", content)
            # The mark that is used has this style already.
            content = re.sub(rb'(<use xlink:href="[^"]*" x="[^"]*" y="[^"]*") style="(?![^"]*fill)[^"]*"', rb"\1", content)
            content = annotated(content.decode(), prefix.decode(), figure).encode()
        write_file(os.path.join(folder, f"{name}.{ending}"), content)


def remove_plot(folder, name):
    """An earlier call of the same study may have drawn it."""
    for ending in ENDINGS:
        path = os.path.join(folder, f"{name}.{ending}")
        if os.path.lexists(path):
            os.remove(path)


def main(arguments):
    if arguments.style:
        style, others = read_style(arguments.style)
        JOURNAL.update(style)
        if others:
            print(f"plot_study: {arguments.style}: not used: {', '.join(others)}", file=sys.stderr)
    study = read_study(arguments.directory)
    plots = {name: (function, {}) for name, function in PLOTS.items()}
    plots.update({f"probe_{p['name']}": (plot_probe, {"name": str(p["name"])}) for p in study["probes"]})
    failures, code = [], 0
    for name, (function, choice) in plots.items():
        try:
            axes = function(study, width=arguments.width, title=arguments.title, **choice)
            if axes is None:
                remove_plot(arguments.directory, name)
            else:
                with matplotlib.rc_context(JOURNAL):
                    save(axes[0].figure, arguments.directory, name)
        except Exception as problem:  # one plot that fails does not take the others away
            says = str(problem)
            if not isinstance(problem, (Unusable, OSError)):
                line = traceback.extract_tb(problem.__traceback__)[-1].lineno
                says = f"{name}: {type(problem).__name__}: {problem} (line {line})"
            print(f"plot_study: {says}", file=sys.stderr)
            failures.append(name)
            code = max(code, UNWRITABLE if isinstance(problem, (Unwritable, OSError)) else DEFECT)
            with contextlib.suppress(OSError):
                remove_plot(arguments.directory, name)
        plt.close("all")
    if failures and arguments.failures:
        write_file(arguments.failures, "\n".join(failures).encode())
    return code


if IS_PROGRAM:
    try:
        sys.exit(main(ARGUMENTS))
    except (Unusable, OSError) as problem:
        print(f"plot_study: {problem}", file=sys.stderr)
        sys.exit(UNWRITABLE if isinstance(problem, (Unwritable, OSError)) else UNUSABLE)
    except Exception:
        print("plot_study:", traceback.format_exc().splitlines()[-1], file=sys.stderr)
        sys.exit(DEFECT)
