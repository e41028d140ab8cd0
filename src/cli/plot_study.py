"""Plots of a step-size study: python3 plot_study.py STUDY_DIR

Reads study.json, and history.csv, probes.csv and summary.json of each run. Writes PNG, SVG and PDF
files into STUDY_DIR. Plots over the step are as wide as a column of a journal, plots over time as
wide as a page.
"""

import contextlib
import csv
import io
import json
import logging
import math
import os
import stat
import sys
import textwrap
import warnings

# What matplotlib says of its fonts, its caches or an axis is of no use to who reads the study's table.
warnings.simplefilter("ignore")
logging.getLogger("matplotlib").setLevel(logging.CRITICAL)

if len(sys.argv) == 2:
    sys.argv[1] = os.path.abspath(sys.argv[1])
    os.chdir("/")  # matplotlib takes settings from a file of the working folder

try:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    import numpy as np
    from matplotlib.colors import to_hex, to_rgb
    from matplotlib.lines import Line2D
    from matplotlib.ticker import LogLocator, NullFormatter
except (ImportError, OSError) as problem:  # OSError: there is no room for its caches
    if __name__ != "__main__":
        raise
    sys.exit(f"plot_study: matplotlib cannot be used: {problem}")

# Okabe and Ito's colours, which colour-blind readers tell apart. Markers are hollow and lines differ,
# so that both of two curves that coincide can be seen.
DASHED, DASH_DOT, DOTTED = (0, (4, 1.6)), (0, (4, 1.4, 1, 1.4)), (0, (1, 1.3))
STYLE = {
    "explicit": {"color": "#D55E00", "marker": "o", "ms": 5.5, "ls": "-"},
    "verlet": {"color": "#E69F00", "marker": "s", "ms": 5.0, "ls": DASHED},
    "midpoint": {"color": "#0072B2", "marker": "^", "ms": 5.0, "ls": "-"},
    "backward-euler": {"color": "#009E73", "marker": "D", "ms": 4.0, "ls": DASH_DOT},
    "energy-momentum": {"color": "#CC79A7", "marker": "v", "ms": 5.0, "ls": DASHED},
}
OTHER = {"color": "#555555", "marker": "P", "ms": 5.0, "ls": "-"}
LINES = ["-", DASHED, DASH_DOT, DOTTED, (0, (7, 1.5)), (0, (6, 1, 1, 1, 1, 1))]
GREY, PALE = "#555555", "#ececec"
BEHIND_TEXT = {"fc": "white", "ec": "none", "pad": 0.8}
COLUMN, PAGE = 3.5, 7.2  # widths of figures in inches
MOST_POINTS = 600  # of a curve over time: more than a panel resolves
EPSILON = 2.0**-52
ENDINGS = ("png", "svg", "pdf")
UNWRITABLE = 4  # exit status, as that of the program

plt.rcParams.update(
    {
        "font.size": 8,
        "axes.titlesize": 8,
        "axes.labelsize": 8,
        "xtick.labelsize": 7,
        "ytick.labelsize": 7,
        "legend.fontsize": 7,
        "axes.linewidth": 0.6,
        "lines.linewidth": 1.1,
        "axes.grid": True,
        "grid.color": "#e2e2e2",
        "grid.linewidth": 0.5,
        "axes.axisbelow": True,
        "legend.frameon": False,
        "legend.handlelength": 2.6,
        "legend.columnspacing": 1.2,
        "savefig.dpi": 300,
        "svg.fonttype": "none",
        "svg.hashsalt": "tetraction",
        "pdf.fonttype": 42,
    }
)


class Unusable(Exception):
    """The study cannot be plotted; the text says why."""


class Unwritable(Unusable):
    """A plot cannot be written."""


def number(value):
    """The value as a float; NaN where there is none, which stands for 'not available'."""
    try:
        result = float(value)
    except (TypeError, ValueError):
        return math.nan
    return result if math.isfinite(result) else math.nan


def usable(value):
    return math.isfinite(value) and value > 0


def si(value, unit):
    """3e-05, "s" as 30 µs."""
    for prefix, factor in (("", 0.1), ("m", 1e-3), ("µ", 1e-6), ("n", 1e-9)):
        if value >= 0.9999 * factor:
            return f"{value / (factor if prefix else 1):.3g} {prefix}{unit}"
    return f"{value:.3g} {unit}"


def in_limits(step, limit):
    """The step as a multiple of the stability limit, if that is known."""
    if not usable(limit):
        return ""
    ratio = step / limit
    return f" = {ratio:.0f} $h_{{crit}}$" if 10 <= ratio < 1e5 else f" = {ratio:.2g} $h_{{crit}}$"


def plain(text):
    """For titles and labels, in which matplotlib reads $ as the sign of a formula."""
    return str(text).replace("$", r"\$")


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
    """study.json; variants and solvers that are compared get their names beside the integrator's."""
    try:
        with open_regular(folder, "study.json") as file:
            study = json.load(file)
    except (OSError, ValueError, RecursionError) as problem:
        raise Unusable(f"study.json cannot be read: {problem}") from problem
    found = study.get("runs") if isinstance(study, dict) else None
    runs = []
    for entry in found if isinstance(found, list) else []:
        if (isinstance(entry, dict) and usable(number(entry.get("step")))
                and entry.get("role") != "reference"):  # fmt: skip
            rule, step = str(entry.get("integrator")), number(entry["step"])
            tags = [entry.get("variant"), entry.get("compares_solver") and entry.get("solver")]
            name = rule
            if any(tags):
                name += f" ({', '.join(str(tag) for tag in tags if tag)})"
            directory = os.path.join(folder, str(entry.get("directory")))
            runs.append({**entry, "rule": rule, "integrator": name, "step": step,
                         "directory": directory})  # fmt: skip
    if not runs:
        raise Unusable("study.json names no run with a step")
    variants = list(dict.fromkeys(str(run.get("variant")) for run in runs))
    probes = study.get("probes")
    probes = [p for p in probes if usable_probe(p)] if isinstance(probes, list) else []
    reference = study.get("reference")
    reference = reference if isinstance(reference, dict) else {}
    own = study.get("references")
    own = [entry for entry in own if isinstance(entry, dict)] if isinstance(own, list) else []
    return {"runs": runs, "variants": variants, "stable_step": number(study.get("stable_step")),
            "limits": stability_limits(found, study), "probes": probes,
            "scene": plain(study.get("scene", "")), "end": number(study.get("end")),
            "reference_error": number(reference.get("estimated_error")),
            "extrapolated": is_extrapolated(reference),
            "reference": os.path.join(folder, str(reference.get("directory", ""))),
            "of_variants": {str(variant): os.path.join(folder, str(entry.get("directory", "")))
                            for entry in own for variant in entry.get("variants") or []},
            "error": str(study.get("error", "position"))}  # fmt: skip


def is_extrapolated(reference):
    extrapolation = reference.get("extrapolation")
    return isinstance(extrapolation, dict) and extrapolation.get("valid") is True


def usable_probe(probe):
    return (isinstance(probe, dict) and isinstance(probe.get("columns"), list)
            and len(probe["columns"]) > 0
            and "/" not in str(probe.get("name", "/")))  # fmt: skip


def stability_limits(entries, study):
    """[(label, h_crit)] of the explicit rules, which differ with damping, and of other variants where
    they differ from the first."""
    limits = {}
    for entry in entries:
        limit = number(entry.get("stable_step")) if isinstance(entry, dict) else math.nan
        if entry.get("integrator") in ("explicit", "verlet") and usable(limit):
            limits.setdefault(str(entry.get("variant") or ""), {})[entry["integrator"]] = limit
    if not limits:
        limit = number(study.get("stable_step"))
        return [("stability limit", limit)] if usable(limit) else []
    found, first = [], next(iter(limits.values()))
    for variant, rules in limits.items():
        if found and all(abs(limit / first.get(rule, math.inf) - 1) < 1e-3
                         for rule, limit in rules.items()):  # fmt: skip
            continue
        values = list(rules.values())
        tag = f" ({plain(variant)})" if len(limits) > 1 and variant else ""
        if max(values) > 1.001 * min(values):
            found += [(f"limit of {rule}{tag}", limit) for rule, limit in rules.items()]
        else:
            found.append((f"stability limit{tag}", values[0]))
    return found


def read_columns(directory, name):
    """Columns of a CSV file as lists of numbers, up to its first broken row; {} without one."""
    try:
        with open_regular(directory, name, newline="") as file:
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


def read_history(run):
    """Columns of history.csv, and the energy that entered."""
    columns = read_columns(run["directory"], "history.csv")
    if not columns:
        return {}
    try:
        scale = read_json(run["directory"], "summary.json")["energy"]["scale"]
        columns["energy_scale"] = [float(scale)]
    except (KeyError, TypeError, ValueError):
        pass
    return columns


def ended_well(run):
    return run.get("status") == "ok"


def by_integrator(runs):
    groups = {}
    for run in sorted(runs, key=lambda run: run["step"]):
        groups.setdefault(run["integrator"], []).append(run)
    order = list(STYLE)
    rank = {name: order.index(name) for name in order}
    return dict(sorted(groups.items(),
                       key=lambda g: rank.get(g[1][0]["rule"], len(order))))  # fmt: skip


def looks_of(study, runs):
    """Of the curve of these runs: colour and marker are the integrator's. With variants, the line is
    the variant's. Another solver is a ring around the point that it should agree with."""
    own = dict(STYLE.get(runs[0]["rule"], OTHER), mfc="none", mew=1.0)
    if len(study["variants"]) > 1:
        own["ls"] = LINES[study["variants"].index(str(runs[0].get("variant"))) % len(LINES)]
    if any(run.get("compares_solver") for run in runs):
        own.update(marker="o", ms=9, ls="none")
    return own


def shade(color, rank, count):
    """Of a curve over time: the finest step is the darkest, the coarsest has the integrator's colour."""
    dark = 0.6 * (1.0 - rank / max(1, count - 1)) if count > 1 else 0.0
    return to_hex([(1.0 - dark) * c for c in to_rgb(color)])


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


def save(figure, folder, name):
    # No date, so that the same study gives the same files.
    extra = {"png": {}, "svg": {"Date": None}, "pdf": {"CreationDate": None, "ModDate": None}}
    for ending in ENDINGS:
        content = io.BytesIO()
        figure.savefig(content, format=ending, metadata=extra[ending])
        write_file(os.path.join(folder, f"{name}.{ending}"), content.getvalue())
    plt.close(figure)


def remove_plot(folder, name):
    """An earlier call of the same study may have drawn it."""
    for ending in ENDINGS:
        path = os.path.join(folder, f"{name}.{ending}")
        if os.path.lexists(path):
            os.remove(path)


class Page:
    """A figure whose axes are placed in inches from its top, so that its width is exact."""

    def __init__(self, width, scene, title, below):
        lines = textwrap.wrap(title, int(width * 17))
        self.width, self.scene, self.lines = width, scene, lines
        self.top, self.below = 0.24 + 0.15 * len(lines), below
        self.rows = []

    def row(self, height, gap=0.0):
        self.rows.append((height, gap))

    def place(self, columns=1, left=0.62, right=0.08, between=0.12):
        """The figure, and its axes as rows of columns."""
        height = self.top + sum(h + gap for h, gap in self.rows) + self.below
        figure = plt.figure(figsize=(self.width, height))
        wide = (self.width - left - right - between * (columns - 1)) / columns
        axes, y = [], height - self.top
        for tall, gap in self.rows:
            y -= gap + tall
            axes.append([
                figure.add_axes([(left + i * (wide + between)) / self.width, y / height,
                                 wide / self.width, tall / height]) for i in range(columns)
            ])  # fmt: skip
        figure.text(0.5, 1 - 0.06 / height, self.scene, ha="center", va="top", weight="bold")
        for i, line in enumerate(self.lines):
            figure.text(0.5, 1 - (0.21 + 0.15 * i) / height, line, ha="center", va="top")
        return figure, axes


def decades(axes, low, high, least=1.3):
    """Sets a logarithmic y axis that has these values, and at least so many decades."""
    span = math.log10(high / low)
    room = max(0.06 * span, 0.5 * (least - span), 0.08)
    axes.set_yscale("log")
    axes.set_ylim(low / 10**room, high * 10**room)
    axes.yaxis.set_major_locator(LogLocator(numticks=7))
    if span + 2 * room > 4:
        axes.yaxis.set_minor_formatter(NullFormatter())


def legend(figure, handles, columns):
    """At the lower edge of the figure."""
    figure.legend(handles=handles, loc="lower center", ncol=columns, bbox_to_anchor=(0.5, 0.0),
                  borderaxespad=0.3)  # fmt: skip


def legend_height(count, columns):
    return 0.12 + 0.147 * math.ceil(count / columns)


def thinned(times, values):
    """At most MOST_POINTS points: of each stretch its largest value, and the last point."""
    points = [(t, v) for t, v in zip(times, values) if math.isfinite(t) and math.isfinite(v)]
    stride = math.ceil(len(points) / MOST_POINTS) or 1
    if stride > 1:
        last = points[-1]
        points = [
            max(points[i : i + stride], key=lambda p: p[1]) for i in range(0, len(points), stride)
        ]
        points += [last] if points[-1] != last else []
    return [p[0] for p in points], [p[1] for p in points]


def both_extremes(times, values):
    """About MOST_POINTS points: of each stretch its least and its largest value in their order."""
    points = [(t, v) for t, v in zip(times, values) if math.isfinite(t) and math.isfinite(v)]
    stride = 2 * math.ceil(len(points) / MOST_POINTS)
    if stride > 2:
        kept = []
        for i in range(0, len(points), stride):
            piece = points[i : i + stride]
            extremes = {min(piece, key=lambda p: p[1]), max(piece, key=lambda p: p[1])}
            kept += sorted(extremes)
        points = kept
    return [p[0] for p in points], [p[1] for p in points]


def time_unit(end):
    return next((u for u in (("s", 1), ("ms", 1e3), ("µs", 1e6)) if end * u[1] >= (0.1 if u[1] == 1 else 1)),
                ("s", 1))


def step_handles(study, steps):
    """Line and shade of each step."""
    return [Line2D([], [], color=shade("#999999", i, len(steps)), ls=LINES[i % len(LINES)],
                   label="$h$ = " + si(h, "s") + in_limits(h, study["stable_step"]))
            for i, h in enumerate(steps)]  # fmt: skip


def end_handle(runs):
    return [] if all(ended_well(r) for r in runs) else [
        Line2D([], [], color=GREY, marker="x", ls="none", ms=4.5, mew=1.2,
               label="upper edge: end of a run that is unstable or failed")
    ]  # fmt: skip


def over_time(study, folder, name, title, ylabel, value_of, round_off_of=None):
    """A panel for each integrator with a curve for each step, on a logarithmic axis that fits the runs
    that ended well: a run that blew up leaves the picture. `value_of` returns None for a run that has
    no such number."""
    # Another solver's curves would lie on those that are there.
    shown = [run for run in study["runs"] if not run.get("compares_solver")]
    groups = by_integrator(shown)
    steps = sorted({run["step"] for run in shown})
    curves, floors = [], []
    for index, runs in enumerate(groups.values()):
        for run in runs:
            history = read_history(run)
            try:
                values = value_of(run, history)
            except (KeyError, IndexError):
                continue
            if values is None:
                continue
            times, values = thinned(history["time"], values)
            if not values:
                continue
            curves.append((index, run, times, values))
            if round_off_of and ended_well(run):
                floors.append(round_off_of(run, history))
    good = [v for _, run, _, values in curves if ended_well(run) for v in values if v > 0]
    good = good or [v for *_, values in curves for v in values if v > 0]
    if not good:
        remove_plot(folder, name)
        return
    columns = 2 if len(groups) == 4 else min(3, len(groups))
    handles = step_handles(study, steps) + end_handle(shown)
    floor = max((f for f in floors if usable(f)), default=math.nan)
    low, high = np.percentile(good, 2), max(good)
    is_floor_shown = usable(floor) and floor > low
    if is_floor_shown:
        handles.append(plt.Rectangle((0, 0), 1, 1, fc=PALE, ec="none",
                                     label="round-off of the finest steps"))  # fmt: skip
    legend_columns = 3 if columns == 3 else 2
    page = Page(PAGE if columns > 1 else COLUMN * 1.3, study["scene"], title,
                0.42 + legend_height(len(handles), legend_columns))  # fmt: skip
    count = math.ceil(len(groups) / columns)
    for row in range(count):
        page.row(1.55 if count > 1 else 1.9, 0.2 if row == 0 else 0.3)
    figure, rows = page.place(columns)
    panels = [panel for row in rows for panel in row]
    end = max(times[-1] for _, _, times, _ in curves)
    unit, factor = time_unit(end)
    for index, panel in enumerate(panels):
        if index >= len(groups):
            panel.set_visible(False)
            continue
        integrator, runs = list(groups.items())[index]
        color = STYLE.get(runs[0]["rule"], OTHER)["color"]
        panel.set_title(plain(integrator), weight="bold", color=color, pad=3)
        decades(panel, low, high)
        bottom, top = panel.get_ylim()
        if is_floor_shown:
            panel.axhspan(bottom, min(floor, top), fc=PALE, ec="none", zorder=0)
        for _, run, times, values in (c for c in curves if c[0] == index):
            rank = steps.index(run["step"])
            hue = shade(color, rank, len(steps))
            # A logarithmic axis has no zero, as the error of the start is.
            kept = [(factor * t, v) for t, v in zip(times, values) if v > 0]
            if kept:
                panel.plot(*zip(*kept), ls=LINES[rank % len(LINES)], color=hue,
                           marker="." if len(kept) < 8 else "", ms=3)  # fmt: skip
            if not ended_well(run):
                panel.plot(factor * times[-1], 1.0, "x", color=hue, ms=4.5, mew=1.2, clip_on=False,
                           transform=panel.get_xaxis_transform(), zorder=5)  # fmt: skip
        panel.set_xlim(0, 1.06 * end * factor)
        if index % columns:
            panel.tick_params(labelleft=False)
            panel.yaxis.set_minor_formatter(NullFormatter())
        if index + columns >= len(groups):
            panel.set_xlabel(f"time $t$ [{unit}]", labelpad=2)
        else:
            panel.tick_params(labelbottom=False)
    figure.text(0.02, 0.5 * (1 + page.below / figure.get_figheight() - page.top /
                             figure.get_figheight()), ylabel, rotation=90, va="center")  # fmt: skip
    legend(figure, handles, legend_columns)
    save(figure, folder, name)


def energy_error(history):
    """|energy error| over the energy that entered, at each step."""
    error = history["energy_error"]
    scale = energy_scale(history)
    return [abs(e) / scale if scale > 0 else 0.0 for e in error]


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
    sums = [sum(abs(v) for v in row) for row in zip(*(history[k] for k in keys if k in history))]
    largest = max((s for s in sums if math.isfinite(s)), default=0.0)
    scale = energy_scale(history)
    return EPSILON * (10 + len(sums)) * largest / scale if scale > 0 else math.nan


# Sections of a scene without influence on the momenta.
INNER = {"mesh", "material", "material_region", "time", "solver", "environment", "damping", "initial",
         "output", "probe", "amplitude"}  # fmt: skip


def conserved(run, letter):
    """The projection to those components of a momentum ("p" or "l") that the run's scene conserves, or
    None if there are none."""
    scene = read_json(run["directory"], "summary.json").get("scene")
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
        if letter == "l":
            sizes = [math.hypot(*v) for v in zip(*(history["l" + axis] for axis in "xyz"))]
            largest = max((s for s in sizes if math.isfinite(s)), default=0.0)
            return EPSILON * (10 + len(sizes)) * largest
        mass = number(read_json(run["directory"], "summary.json").get("mass"))
        energy = max((e for e in history["kinetic_energy"] if math.isfinite(e)), default=0.0)
        rounding = EPSILON * (10 + len(history["time"]))
        return rounding * math.sqrt(2 * mass * energy) if usable(mass) else math.nan

    return round_off_of


def probe_over_time(study, folder, probe):
    """The values of each component on the left, and the difference from the reference on the right.

    The axes fit the runs that ended well.
    """
    columns = [str(column) for column in probe["columns"]]
    groups = by_integrator(study["runs"])
    runs = [run for group in groups.values() for run in group]
    tables = [(run, read_columns(run["directory"], "probes.csv")) for run in runs]
    tables = [(run, table) for run, table in tables if all(c in table for c in columns)]
    name, unit = str(probe["name"]), str(probe.get("unit", ""))
    if not tables:
        remove_plot(folder, f"probe_{name}")
        return
    # Each mesh has a reference of its own. The values of all of them are drawn.
    places = list(dict.fromkeys([study["reference"], *study["of_variants"].values()]))
    references = {place: read_columns(place, "probes.csv") for place in places}
    references = {place: table for place, table in references.items()
                  if all(c in table for c in columns)}  # fmt: skip
    has_reference = bool(references)
    reference_name = "the finest run of the reference" if study["extrapolated"] else "the reference"
    steps = sorted({run["step"] for run, _ in tables})
    handles = [Line2D([], [], label=plain(key), color=looks_of(study, group)["color"])
               for key, group in groups.items() if not group[0].get("compares_solver")]  # fmt: skip
    if has_reference:
        handles.append(Line2D([], [], label=reference_name.removeprefix("the "), color="#bbbbbb",
                              lw=3))  # fmt: skip
    handles += step_handles(study, steps)
    if not all(ended_well(run) for run, _ in tables):
        handles.append(Line2D([], [], color=GREY, marker="x", ls="none", ms=4.5, mew=1.2,
                              label="end of a run that is unstable or failed"))  # fmt: skip
    quantity = str(probe.get("quantity", "")).replace("_", " ")
    title = f"Probe {plain(name)}: {quantity}" + (f" [{unit}]" if unit else "")
    title += f". Left: values. Right: magnitude of the difference from {reference_name}"
    page = Page(PAGE, study["scene"], title if has_reference else title.split(". Left")[0],
                0.42 + legend_height(len(handles), 3))  # fmt: skip
    for row in range(len(columns)):
        page.row(1.4, 0.06 if row == 0 else 0.12)
    figure, rows = page.place(2 if has_reference else 1, left=0.72, between=0.75)
    end = max((table["time"][-1] for _, table in tables), default=0.0)
    time_name, factor = time_unit(end)
    for panels, column in zip(rows, columns):
        known_of = {}
        for place, table in references.items():
            known_of[place] = [(t, v) for t, v in zip(table["time"], table[column])
                               if math.isfinite(v)]  # fmt: skip
            times, values = both_extremes(*zip(*known_of[place])) if known_of[place] else ([], [])
            panels[0].plot([factor * t for t in times], values, color="#bbbbbb", lw=3)
        good, differences = [], []
        for run, table in tables:
            rank = steps.index(run["step"])
            looks = {"color": shade(looks_of(study, [run])["color"], rank, len(steps)),
                     "ls": LINES[rank % len(LINES)], "lw": 0.9}  # fmt: skip
            times, values = both_extremes(table["time"], table[column])
            if not values:
                continue
            panels[0].plot([factor * t for t in times], values, **looks,
                           marker="." if len(times) < 8 else "", ms=3)  # fmt: skip
            if ended_well(run):
                good += [min(values), max(values)]
            else:
                panels[0].plot(factor * times[-1], values[-1], "x", color=looks["color"], ms=4.5,
                               mew=1.2)  # fmt: skip
            place = study["of_variants"].get(str(run.get("variant")), study["reference"])
            known = known_of.get(place)
            if not known or run["directory"] == place:
                continue
            own = [(t, v) for t, v in zip(table["time"], table[column]) if math.isfinite(v)]
            t, v = np.array(own).T
            times, values = thinned(t, np.abs(v - np.interp(t, *zip(*known))))
            kept = [(factor * t, v) for t, v in zip(times, values) if v > 0]
            if kept:
                panels[1].plot(*zip(*kept), **looks, marker="." if len(kept) < 8 else "", ms=3)
                differences += [v for _, v in kept] if ended_well(run) else []
        if good:
            room = 0.06 * (max(good) - min(good)) or 0.1 * abs(good[0]) or 1.0
            panels[0].set_ylim(min(good) - room, max(good) + room)
        panels[0].set_ylabel(plain(column) + (f" [{unit}]" if unit else ""))
        if has_reference:
            if differences:
                decades(panels[1], np.percentile(differences, 2), max(differences))
            panels[1].set_ylabel("difference" + (f" [{unit}]" if unit else ""))
        for panel in panels:
            panel.set_xlim(0, 1.02 * end * factor)
            if column != columns[-1]:
                panel.tick_params(labelbottom=False)
    for panel in rows[-1]:
        panel.set_xlabel(f"time $t$ [{time_name}]", labelpad=2)
    legend(figure, handles, 3)
    save(figure, folder, f"probe_{name}")


def along(lines):
    """Points on lines through points in pixels, and the slope of the piece that each lies on."""
    points, slopes = [], []
    for line in lines:
        for p, q in zip(line, line[1:] if len(line) > 1 else line):
            piece = p + (q - p) * np.linspace(0, 1, 41)[:, None]
            points.append(piece)
            slopes += [(q - p)[1] / (q - p)[0] if q[0] > p[0] else math.inf] * len(piece)
    return np.vstack(points), np.array(slopes)


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


def slope_guides(axes, lines, limits):
    """Triangles of slope 1 and 2. Each stands beside a part of a curve where at least three runs show
    its slope, and covers no curve."""
    to_screen, back = axes.transData.transform, axes.transData.inverted().transform
    box = axes.bbox
    (x0, x1), (y0, y1) = axes.get_xlim(), axes.get_ylim()
    inch = axes.figure.dpi
    # Pixels of a decade: what has slope 1 in the axes has the slope `unit` in pixels.
    unit = (box.height / math.log10(y1 / y0)) / (box.width / math.log10(x1 / x0))
    taken, _ = along([to_screen(line) for line in lines])
    for _, limit in limits:
        if x0 < limit < x1:
            taken = np.vstack([taken, along([to_screen([(limit, y0), (limit, y1)])])[0]])
    for slope in (1, 2):
        parts = [part for line in lines for part in straight_parts(line, slope)]
        if not parts:
            continue
        own, _ = along([to_screen(part) for part in parts])
        width = min(0.34 * inch, 0.34 * inch / (slope * unit))
        height, pad = slope * unit * width, 0.1 * inch
        # Places of the lower left corner, row by row, that leave room for the labels.
        x, y = (array.ravel() for array in np.meshgrid(
            box.x0 + np.arange(1, 95) / 100 * box.width,
            box.y0 + np.arange(1, 95) / 100 * box.height))  # fmt: skip
        inside = ((x + width + 1.2 * pad <= box.x1) & (y - 1.3 * pad >= box.y0)
                  & (y + height + 0.3 * pad <= box.y1))  # fmt: skip
        x, y = x[inside, None], y[inside, None]
        px, py = taken.T
        clear = np.hypot(np.maximum(np.maximum(x - px, px - x - width - pad), 0),
                         np.maximum(np.maximum(y - 1.2 * pad - py, py - y - height), 0))  # fmt: skip
        # Curves may pass above the hypotenuse.
        above = py - y - height / width * (px - x) > 0.3 * pad
        free = np.where(above, np.inf, clear).min(axis=1) > 0.3 * pad
        if not free.any():
            continue
        # The hypotenuse is as near to the part of the curve as possible, at both ends.
        x, y = x[free], y[free]
        px, py = own.T
        gap = np.maximum(np.hypot(px - x, py - y).min(axis=1),
                         np.hypot(px - x - width, py - y - height).min(axis=1))  # fmt: skip
        if gap.min() > 0.4 * inch:
            continue
        x, y = x[gap.argmin(), 0], y[gap.argmin(), 0]
        corners = [(x, y), (x + width, y), (x + width, y + height)]
        axes.add_patch(plt.Polygon([back(c) for c in corners], closed=True, fc="#f4f4f4", ec=GREY,
                                   lw=0.7, zorder=3, label=f"slope {slope}"))  # fmt: skip
        axes.annotate("1", back((x + width / 2, y)), (0, -1.5), textcoords="offset points",
                      ha="center", va="top", fontsize=7, color=GREY)  # fmt: skip
        axes.annotate(str(slope), back((x + width, y + height / 2)), (2, 0), color=GREY,
                      textcoords="offset points", va="center", fontsize=7)  # fmt: skip
        grid = [(i / 9, j / 9) for i in range(-3, 14) for j in range(-4, 12)]
        taken = np.vstack([taken, [(x + width * i, y + height * j) for i, j in grid]])


def coinciding(curves):
    """[(curve, curve that it coincides with, [(step, relative difference)])]: those that a reader
    cannot tell apart on a logarithmic axis."""
    found = []
    for i, (name, looks, points) in enumerate(curves):
        for other, _, others in curves[:i]:
            known = dict(others)
            pairs = [(h, v / known[h]) for h, v in points if h in known]
            near = [abs(math.log10(ratio)) < 0.05 for _, ratio in pairs]
            if near and 2 * sum(near) > len(near) and len(near) >= min(2, len(points)):
                found.append((name, looks, other, [(h, abs(r - 1)) for h, r in pairs if r != 1]))
                break
    return [entry for entry in found if entry[3]]


def step_range(steps):
    """The ends of a logarithmic axis with these values."""
    low, high = min(steps), max(steps)
    room = max(0.06 * math.log10(high / low), 0.5 * (0.7 - math.log10(high / low)), 0.05)
    return low / 10**room, high * 10**room


def step_axis(axes, steps):
    low, high = step_range(steps)
    axes.set_xscale("log")
    axes.set_xlim(low, high)
    if math.log10(high / low) > 1.5:
        axes.xaxis.set_minor_formatter(NullFormatter())


def failure_band(axes, failures):
    """Steps of runs that did not reach the end, a line for each curve, in a panel without a scale."""
    axes.set_ylim(0, len(failures) + 1.3)
    axes.set_facecolor("#f6f6f6")
    axes.set_yticks([])
    axes.tick_params(labelbottom=False, bottom=False, which="both")
    axes.grid(False)
    for index, (looks, runs) in enumerate(failures):
        for run in runs:
            axes.plot(run["step"], len(failures) - index - 0.4,
                      "x" if run.get("status") == "unstable" else "+", color=looks["color"],
                      ms=4.5, mew=1.3)  # fmt: skip
    kinds = [text for status, text in (("unstable", "× unstable"), ("failed", "+ failed"))
             if any(r.get("status") == status for _, runs in failures for r in runs)]  # fmt: skip
    axes.text(0.015, len(failures) + 0.62, "did not reach the end: " + ", ".join(kinds), fontsize=6.5,
              color=GREY, va="center", transform=axes.get_yaxis_transform(),
              bbox={**BEHIND_TEXT, "fc": "#f6f6f6"})  # fmt: skip


def over_step(study, folder, name, title, panels, guides=False, floor=None, floor_name=""):
    """A panel for each (key, label of the axis), with a curve for each integrator. Runs that did not
    end well are in a band above. `floor(h)` is a level below which values mean nothing."""
    groups = by_integrator(study["runs"])
    looks = {key: looks_of(study, runs) for key, runs in groups.items()}
    curves = {}
    for key, _ in panels:
        curves[key] = []
        for integrator, runs in groups.items():
            points = [(r["step"], number(r.get(key))) for r in runs if ended_well(r)]
            points = [p for p in points if usable(p[1])]
            if points:
                curves[key].append((integrator, looks[integrator], points))
    failures = [(looks[integrator], bad) for integrator, runs in groups.items()
                if (bad := [r for r in runs if not ended_well(r)])]  # fmt: skip
    if not any(curves.values()):
        remove_plot(folder, name)
        return
    same = coinciding(curves[panels[0][0]]) if len(panels) == 1 else []
    handles = [Line2D([], [], label=plain(integrator), **looks[integrator]) for integrator in groups]
    steps = [run["step"] for run in study["runs"]]
    limit_styles = [DASHED, DOTTED, DASH_DOT]
    for i, (label, limit) in enumerate(study["limits"]):
        low, high = step_range(steps)
        where = "" if low < limit < high else " (not in this range)"
        handles.append(Line2D([], [], color="#333333", ls=limit_styles[i % 3], lw=0.9,
                              label=f"{label}, {si(limit, 's')}{where}"))  # fmt: skip
    page = Page(COLUMN, study["scene"], title, 0.0)
    if failures:
        page.row(0.105 * (len(failures) + 1.3), 0.04)
    for _ in panels:
        page.row(2.0 if len(panels) == 1 else 1.5, 0.06)
    words = []
    if same:
        words = textwrap.wrap("difference of " + "; ".join(
            f"{integrator} from {other}" for integrator, _, other, _ in same), 52)  # fmt: skip
        page.row(0.75 + 0.11 * len(words), 0.06)
    # Placed first without a legend, to know whether the level lies in the picture.
    lows = {key: min(v for *_, points in found for _, v in points)
            for key, found in curves.items() if found}  # fmt: skip
    show_floor = floor is not None and any(
        floor(h) > lows[key] / 1.2 for key in lows for h in (min(steps), max(steps)))  # fmt: skip
    if show_floor:
        handles.append(plt.Rectangle((0, 0), 1, 1, fc=PALE, ec="none", label=floor_name))
    # Long names, of variants and limits, need the whole width.
    columns = 1 if max(len(h.get_label()) for h in handles) > 42 else 2
    page.below = 0.4 + legend_height(len(handles), columns)
    figure, rows = page.place()
    rows = [row[0] for row in rows]
    band = rows.pop(0) if failures else None
    for axes, (key, ylabel) in zip(rows, panels):
        axes.set_ylabel(ylabel)
        step_axis(axes, steps)
        if not curves[key]:
            axes.set_yticks([])
            axes.text(0.5, 0.5, "no run has a value above zero", transform=axes.transAxes,
                      ha="center", color=GREY)  # fmt: skip
            continue
        values = [v for *_, points in curves[key] for _, v in points]
        decades(axes, min(values), max(values))
        if show_floor:
            x = np.geomspace(*axes.get_xlim(), 100)
            bottom = axes.get_ylim()[0]
            axes.fill_between(x, bottom, [max(bottom, floor(h)) for h in x], fc=PALE, ec="none",
                              zorder=0)  # fmt: skip
        for _, style, points in curves[key]:
            axes.plot(*zip(*points), **style)
        zeros = sum(1 for r in study["runs"] if ended_well(r) and number(r.get(key)) == 0
                    and r.get("role") != "reference")  # fmt: skip
        if zeros:
            axes.text(0.02, 0.02, f"not shown: {zeros} run{'s' * (zeros > 1)} with the value 0",
                      transform=axes.transAxes, fontsize=6.5, color=GREY)  # fmt: skip
    if same:
        axes = rows[-1]
        step_axis(axes, steps)
        for integrator, style, other, points in same:
            axes.plot(*zip(*points), **style)
        values = [v for *_, points in same for _, v in points]
        # The ring of another solver needs some room.
        decades(axes, min(values) * (min(values) / max(values)) ** 0.12, max(values))
        axes.yaxis.set_major_locator(LogLocator(numticks=4))
        axes.set_ylabel("$|e/e_0 - 1|$")
        axes.text(0.015, 0.97, plain("\n".join(words)), fontsize=6.5, color=GREY, va="top",
                  transform=axes.transAxes, bbox=BEHIND_TEXT)  # fmt: skip
        # The words stand above the curves.
        low, high = axes.get_ylim()
        part = (0.08 + 0.11 * len(words)) / (0.75 + 0.11 * len(words))
        axes.set_yticks([tick for tick in axes.get_yticks() if low <= tick <= high])
        axes.set_ylim(low, high * (high / low) ** (part / (1 - part)))
    for axes in rows[:-1]:
        axes.tick_params(labelbottom=False, which="both")
    rows[-1].set_xlabel("step $h$ [s]", labelpad=2)
    if band is not None:
        step_axis(band, steps)
        failure_band(band, failures)
    for axes in [*rows, *([band] if band is not None else [])]:
        for i, (_, limit) in enumerate(study["limits"]):
            axes.axvline(limit, color="#333333", ls=limit_styles[i % 3], lw=0.9, zorder=1)
    legend(figure, handles, columns)
    figure.canvas.draw()  # places the axes, which the guides need to know
    if guides and curves[panels[0][0]]:
        slope_guides(rows[0], [points for *_, points in curves[panels[0][0]]], study["limits"])
    save(figure, folder, name)


def work_precision(study, folder, name, title, key, ylabel):
    """Error over wall time. Full markers are steps above the stability limit of the explicit rules."""
    groups = by_integrator(study["runs"])
    curves = []
    for integrator, runs in groups.items():
        points = [(number(r.get("wall_seconds")), number(r.get(key)), r) for r in runs
                  if ended_well(r) and r.get("timing") != "shared"]  # fmt: skip
        points = [p for p in points if usable(p[0]) and usable(p[1])]
        if points:
            curves.append((integrator, looks_of(study, runs), points))
    if not curves:
        remove_plot(folder, name)
        return
    handles = [Line2D([], [], label=plain(integrator), **looks) for integrator, looks, _ in curves]
    if usable(study["stable_step"]):
        handles += [Line2D([], [], color=GREY, marker="o", ls="none", ms=5, mfc="none",
                           label="step below the stability limit"),
                    Line2D([], [], color=GREY, marker="o", ls="none", ms=5,
                           label="step above it")]  # fmt: skip
    columns = 1 if max(len(h.get_label()) for h in handles) > 42 else 2
    page = Page(COLUMN, study["scene"], title, 0.4 + legend_height(len(handles), columns))
    page.row(2.3, 0.04)
    figure, rows = page.place()
    axes = rows[0][0]
    step_axis(axes, [p[0] for *_, points in curves for p in points])
    values = [p[1] for *_, points in curves for p in points]
    decades(axes, min(values), max(values))
    for _, looks, points in curves:
        # In the order of the steps, so that the curve shows what a smaller step costs and gives.
        axes.plot([p[0] for p in points], [p[1] for p in points], color=looks["color"],
                  ls=looks["ls"])  # fmt: skip
        for wall, error, run in points:
            limit = number(run.get("stable_step"))
            full = usable(limit) and run["step"] > limit and not run.get("compares_solver")
            axes.plot(wall, error, **{**looks, "ls": "none",
                                      "mfc": looks["color"] if full else "none"})  # fmt: skip
    axes.set_xlabel("wall time of the steps [s]", labelpad=2)
    axes.set_ylabel(ylabel)
    legend(figure, handles, columns)
    save(figure, folder, name)


def main(folder):
    study = read_study(folder)
    time = f"$t$ = {si(study['end'], 's')}" if usable(study["end"]) else "the end"
    what = "position error" if len(study["variants"]) < 2 else "position error or difference"
    key, error = "position_error", f"{what} at {time}"
    label = r"$|q - q_{ref}|\,/\,|q_{ref} - X|$ [-]"
    if study["error"].startswith("probe."):
        key = "probe_error"
        error = f"error of the probe {plain(study['error'][len('probe.'):])} over time"
        label = r"$\max|s - s_{ref}|\,/\,\max|s_{ref}|$ [-]"
    error = error[0].upper() + error[1:]
    own = study["reference_error"]
    over_step(study, folder, "error_over_step", error, [(key, label)],
              guides=True, floor=(lambda h: 5 * own) if usable(own) else None,
              floor_name="5 × error of reference")  # fmt: skip
    over_step(study, folder, "rms_error_over_step",
              f"Root mean square of the {what} over time",
              [("position_error_rms", r"rms$(q - q_{ref})\,/\,$rms$(q_{ref} - X)$ [-]")],
              guides=True)  # fmt: skip
    work_precision(study, folder, "work_precision", f"{error} over wall time", key, label)
    over_time(study, folder, "energy_over_time", "Energy error, relative to the energy that entered",
              "relative energy error [-]", lambda _, history: energy_error(history),
              energy_round_off)  # fmt: skip
    over_time(study, folder, "linear_momentum_over_time",
              "Change of the linear momentum, of the components that are conserved",
              r"$|p(t) - p(0)|$ [kg m/s]", momentum_change("p"), momentum_round_off("p"))  # fmt: skip
    over_time(study, folder, "angular_momentum_over_time",
              "Change of the angular momentum about the origin, of the components that are conserved",
              r"$|L(t) - L(0)|$ [kg m²/s]", momentum_change("l"), momentum_round_off("l"))  # fmt: skip
    # Each step adds at most about one rounding.
    rounding = (lambda h: EPSILON * (10 + study["end"] / h)) if usable(study["end"]) else None
    over_step(study, folder, "energy_drift_over_step",
              "Largest energy error, relative to the energy that entered",
              [("max_relative_energy_drift", "relative energy error [-]")],
              guides=True, floor=rounding, floor_name="round-off")  # fmt: skip
    over_step(study, folder, "momentum_drift_over_step",
              "Change of the momenta that no impulse explains",
              [("linear_momentum_drift", "linear, relative [-]"),
               ("angular_momentum_drift", "angular, relative [-]")],
              floor=rounding, floor_name="round-off")  # fmt: skip
    for probe in study["probes"]:
        probe_over_time(study, folder, probe)


if __name__ == "__main__":
    try:
        if len(sys.argv) != 2:
            raise Unusable("usage: plot_study.py STUDY_DIR")
        main(sys.argv[1])
    except (Unusable, OSError) as problem:
        print(f"plot_study: {problem}", file=sys.stderr)
        sys.exit(UNWRITABLE if isinstance(problem, Unwritable) else 1)
