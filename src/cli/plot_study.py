"""Plots of a step-size study: python3 plot_study.py STUDY_DIR

Reads study.json and the history.csv and probes.csv of each run; writes PNG and SVG files into
STUDY_DIR.
"""

import csv
import json
import logging
import math
import os
import sys
import warnings

# What matplotlib says of its fonts, its caches or an axis is of no use to who reads the study's table.
warnings.simplefilter("ignore")
logging.getLogger("matplotlib").setLevel(logging.CRITICAL)

if len(sys.argv) == 2:
    sys.argv[1] = os.path.abspath(sys.argv[1])
    os.chdir("/")  # matplotlib takes settings from a file of the working folder

import matplotlib  # noqa: E402

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
import numpy as np  # noqa: E402
from matplotlib.lines import Line2D  # noqa: E402

# Okabe and Ito's colours: told apart by colour-blind readers as well. Explicit rules have large
# hollow markers, implicit ones small full ones: where two curves coincide both stay visible.
STYLE = {
    "explicit": {"color": "#D55E00", "marker": "o", "ms": 10, "mfc": "none", "lw": 3},
    "verlet": {"color": "#E69F00", "marker": "s", "ms": 10, "mfc": "none", "lw": 3},
    "midpoint": {"color": "#0072B2", "marker": "^", "ms": 6, "lw": 1.4},
    "backward-euler": {"color": "#009E73", "marker": "D", "ms": 5, "lw": 1.4},
    "energy-momentum": {"color": "#CC79A7", "marker": "v", "ms": 6, "lw": 1.4},
}
OTHER = {"color": "#555555", "marker": "P", "ms": 6, "lw": 1.4}
GREY = "#666666"
MOST_POINTS = 1500  # of a curve over time, so that SVG files stay small

plt.rcParams.update(
    {
        "font.size": 10,
        "axes.grid": True,
        "grid.color": "#dddddd",
        "grid.linewidth": 0.6,
        "axes.axisbelow": True,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "legend.frameon": False,
        "savefig.dpi": 150,
        "svg.fonttype": "none",
    }
)


class Unusable(Exception):
    """The study cannot be plotted; the text says why."""


def style(integrator, compares_solver=False):
    """Of a curve; another solver is a ring around the point that it should agree with."""
    own = STYLE.get(integrator.split(" (")[0], OTHER)
    return {**own, "marker": "o", "ms": 13, "mfc": "none", "lw": 0} if compares_solver else own


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
    for prefix, factor in (("", 1), ("m", 1e-3), ("µ", 1e-6), ("n", 1e-9)):
        if value >= 0.9999 * factor:
            return f"{value / factor:.3g} {prefix}{unit}"
    return f"{value:.3g} {unit}"


def in_limits(step, limit):
    """The step as a multiple of the stability limit, if that is known."""
    if not usable(limit):
        return ""
    ratio = step / limit
    return f" = {ratio:.0f} $h_{{crit}}$" if 10 <= ratio < 1e5 else f" = {ratio:.2g} $h_{{crit}}$"


def read_study(folder):
    """study.json; variants and solvers that are compared get their names beside the integrator's."""
    try:
        with open(os.path.join(folder, "study.json"), encoding="utf-8") as file:
            study = json.load(file)
    except (OSError, ValueError) as problem:
        raise Unusable(f"study.json cannot be read: {problem}") from problem
    found = study.get("runs") if isinstance(study, dict) else None
    runs = []
    for entry in found if isinstance(found, list) else []:
        if isinstance(entry, dict) and usable(number(entry.get("step"))):
            name, step = str(entry.get("integrator")), number(entry["step"])
            tags = [entry.get("variant"), entry.get("compares_solver") and entry.get("solver")]
            if any(tags):
                name += f" ({', '.join(str(tag) for tag in tags if tag)})"
            directory = os.path.join(folder, str(entry.get("directory")))
            runs.append({**entry, "integrator": name, "step": step, "directory": directory})
    if not runs:
        raise Unusable("study.json names no run with a step")
    variants = {str(run.get("variant")) for run in runs}
    probes = study.get("probes")
    probes = [p for p in probes if usable_probe(p)] if isinstance(probes, list) else []
    return {"runs": runs, "variants": variants, "stable_step": number(study.get("stable_step")),
            "limits": stability_limits(found, study), "probes": probes,
            "error": str(study.get("error", "position"))}  # fmt: skip


def usable_probe(probe):
    return (isinstance(probe, dict) and isinstance(probe.get("columns"), list)
            and len(probe["columns"]) > 0
            and "/" not in str(probe.get("name", "/")))  # fmt: skip


def stability_limits(entries, study):
    """[(label, h_crit)] of the explicit rules of the first variant: they differ with damping."""
    limits = {}
    for entry in entries:
        if not isinstance(entry, dict) or entry.get("variant") != entries[0].get("variant"):
            continue
        limit = number(entry.get("stable_step"))
        if entry.get("integrator") in ("explicit", "verlet") and usable(limit):
            limits[entry["integrator"]] = limit
    values = list(limits.values()) or [number(study.get("stable_step"))]
    if max(values) > 1.001 * min(values):
        return [(f"stability limit of {name}", limit) for name, limit in limits.items()]
    return [("stability limit of the explicit steps", values[0])] if usable(values[0]) else []


def read_columns(run, name):
    """Columns of a CSV file as lists of numbers, up to its first broken row; {} without one."""
    try:
        with open(os.path.join(run["directory"], name), newline="") as file:
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
    columns = read_columns(run, "history.csv")
    if not columns:
        return {}
    try:
        with open(os.path.join(run["directory"], "summary.json")) as file:
            columns["energy_scale"] = [float(json.load(file)["energy"]["scale"])]
    except (OSError, ValueError, KeyError, TypeError):
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
    return dict(sorted(groups.items(), key=lambda g: rank.get(g[0].split(" (")[0], len(order))))


def save(figure, folder, name):
    # The box is worked out once for both files, which takes as long as to draw the figure.
    box = figure.get_tightbbox(figure.canvas.get_renderer()).padded(0.1)
    for ending in ("png", "svg"):
        path = os.path.join(folder, f"{name}.{ending}")
        # The picture gets its name when it is complete. A link of that name is not followed.
        temporary = path + ".part"
        if os.path.lexists(temporary):
            os.remove(temporary)
        figure.savefig(temporary, bbox_inches=box, format=ending)
        os.replace(temporary, path)
    plt.close(figure)


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


def probe_over_time(study, folder, probe):
    """One panel for each component, with a curve for each run.

    The axes fit the runs that ended well.
    """
    columns = [str(column) for column in probe["columns"]]
    runs = [run for runs in by_integrator(study["runs"]).values() for run in runs]
    tables = [(run, read_columns(run, "probes.csv")) for run in runs]
    tables = [(run, table) for run, table in tables if all(c in table for c in columns)]
    if not tables:
        return
    steps = sorted({run["step"] for run, _ in tables})
    below = 0.6 + 0.2 * math.ceil(len(tables) / 2)  # inches: time label and legend
    height = 2.1 * len(columns) + 0.5 + below
    figure, panels = plt.subplots(
        len(columns), 1, figsize=(8.0, height), sharex=True, squeeze=False
    )
    name, unit = str(probe["name"]), str(probe.get("unit", ""))
    handles = {}
    for panel, column in zip(panels.flat, columns):
        good = []
        for run, table in tables:
            times, values = both_extremes(table["time"], table[column])
            if not values:
                continue
            looks = style(run["integrator"])
            # Fine steps are full lines, coarse ones are paler.
            rank = steps.index(run["step"]) / max(1, len(steps) - 1)
            (line,) = panel.plot(
                times, values, "-" if ended_well(run) else "--", color=looks["color"],
                lw=1.3, alpha=1.0 - 0.65 * rank, marker="." if len(times) < 8 else "",
            )  # fmt: skip
            handles[f"{run['integrator']}, $h$ = {si(run['step'], 's')}"] = line
            if ended_well(run):
                good += [min(values), max(values)]
        if good:
            room = 0.06 * (max(good) - min(good)) or max(1e-12, 0.1 * abs(good[0]))
            panel.set_ylim(min(good) - room, max(good) + room)
        panel.set_ylabel(f"{column} [{unit}]" if unit else column)
    panels[-1][0].set_xlabel("time [s]")
    figure.suptitle(f"Probe {name}: {str(probe.get('quantity', '')).replace('_', ' ')} "
                    "(dashed: unstable or failed)", fontsize=11)  # fmt: skip
    figure.legend(handles.values(), handles.keys(), loc="lower center", ncol=2, fontsize=9)
    figure.tight_layout(rect=(0, (below - 0.5) / height, 1, 1))
    save(figure, folder, f"probe_{name}")


def over_time(study, folder, name, title, ylabel, value_of, floor=None):
    """One panel an integrator, one curve a step; a logarithmic axis from `floor` up if it is given.

    The axis fits the runs that ended well: a run that blew up leaves the picture.
    """
    # Another solver's curves would lie on those that are there.
    groups = by_integrator([run for run in study["runs"] if not run.get("compares_solver")])
    columns = min(2, len(groups))
    rows = math.ceil(len(groups) / columns)
    steps = sorted({run["step"] for run in study["runs"]})
    legend_columns = 3 if columns == 2 else 2
    below = 0.65 + 0.22 * math.ceil(len(steps) / legend_columns)  # inches: time label and legend
    height = 2.75 * rows + 0.6 + below
    figure, panels = plt.subplots(
        rows, columns, figsize=(5.0 * columns, height), sharex=True, sharey=True, squeeze=False
    )
    shades = plt.get_cmap("viridis")
    color = {h: shades(0.9 * i / max(1, len(steps) - 1)) for i, h in enumerate(steps)}
    curves = []
    for panel, (integrator, runs) in zip(panels.flat, groups.items()):
        color_of_name = style(integrator)["color"]
        panel.set_title(integrator, fontsize=10, fontweight="bold", color=color_of_name)
        for run in runs:
            history = read_history(run)
            try:
                times, values = thinned(history["time"], value_of(history))
            except KeyError:
                continue
            if values:
                curves.append((panel, run, times, values))
    end = max((c[2][-1] for c in curves), default=0.0)
    unit, factor = next((u for u in (("s", 1), ("ms", 1e3), ("µs", 1e6)) if end * u[1] >= 1),
                        ("s", 1))  # fmt: skip
    good = [max(c[3]) for c in curves if ended_well(c[1])] or [max(c[3]) for c in curves] or [0.0]
    top = 30 * max(max(good), 10 * floor) if floor else 1.15 * max(good) or 1.0
    panels[0][0].set_yscale("log" if floor else "linear")
    panels[0][0].set_ylim(floor or 0.0, top)
    for panel, run, times, values in curves:
        # What is below the floor, as the exact zero of the start, is not drawn on a log axis.
        kept = [(factor * t, v) for t, v in zip(times, values) if not floor or v >= floor]
        if not kept:
            continue
        x, y = zip(*kept)
        line = "-" if ended_well(run) else "--"
        panel.plot(x, y, line, color=color[run["step"]], lw=1.4, marker="." if len(x) < 8 else "")
        if not ended_well(run):
            # Out of the picture: at its upper edge.
            panel.plot(x[-1], min(y[-1], top), "x", color=color[run["step"]], ms=7, mew=1.8,
                       clip_on=False, zorder=3)  # fmt: skip
    if end > 0:
        panels[0][0].set_xlim(-0.02 * end * factor, 1.02 * end * factor)
    for index, panel in enumerate(panels.flat):
        panel.set_visible(index < len(groups))
        if index + columns >= len(groups):
            panel.set_xlabel(f"time [{unit}]")
            panel.tick_params(labelbottom=True)
    figure.supylabel(ylabel, fontsize=10, x=0.0)
    figure.suptitle(title, fontsize=11, y=1 - 0.12 / height, va="top")
    limit = study["stable_step"]
    figure.legend(
        [Line2D([], [], color=color[h], lw=2) for h in steps],
        ["$h$ = " + si(h, "s") + in_limits(h, limit) for h in steps],
        loc="lower center", ncol=min(legend_columns, len(steps)), fontsize=9,
    )  # fmt: skip
    figure.tight_layout(rect=(0, (below - 0.5) / height, 1, 1))
    save(figure, folder, name)


def energy_error(history):
    """|energy error| over the energy that entered, at each step."""
    error = history["energy_error"]
    if "energy_scale" in history:
        scale = history["energy_scale"][0]
    else:  # a run without a summary
        scale = sum(history[key][0] for key in ("kinetic_energy", "elastic_energy"))
        for key in ("environment_energy", "external_work", "constraint_work", "edit_work"):
            column = history.get(key, [0.0])
            finite = (abs(value - column[0]) for value in column if math.isfinite(value))
            scale += max(finite, default=0.0)
    return [abs(e) / scale if scale > 0 else 0.0 for e in error]


def magnitude(letter):
    return lambda history: [math.hypot(*v) for v in zip(*(history[letter + a] for a in "xyz"))]


def along(lines):
    """Points on lines through points in pixels, and the slope of the piece that each lies on."""
    points, slopes = [], []
    for line in lines:
        for p, q in zip(line, line[1:] if len(line) > 1 else line):
            piece = p + (q - p) * np.linspace(0, 1, 41)[:, None]
            points.append(piece)
            slopes += [(q - p)[1] / (q - p)[0] if q[0] > p[0] else math.inf] * len(piece)
    return np.vstack(points), np.array(slopes)


def slope_guides(axes, lines, limits):
    """Triangles of slope 1 and 2, each beside the curves that have its slope, and covering none."""
    to_screen, back = axes.transData.transform, axes.transData.inverted().transform
    box = axes.bbox
    (x0, x1), (y0, y1) = axes.get_xlim(), axes.get_ylim()
    # Pixels of a decade: what has slope 1 in the axes has the slope `unit` in pixels.
    unit = (box.height / math.log10(y1 / y0)) / (box.width / math.log10(x1 / x0))
    curves, slopes = along([to_screen(line) for line in lines])
    taken = curves
    for _, limit in limits:
        if x0 < limit < x1:
            taken = np.vstack([taken, along([to_screen([(limit, y0), (limit, y1)])])[0]])
    decades = min(0.13 * math.log10(x1 / x0), 0.14 * math.log10(y1 / y0))
    width, pad = decades * box.width / math.log10(x1 / x0), 0.07 * box.height
    for slope in (1, 2):
        height = slope * unit * width
        own = curves[np.abs(slopes / unit - slope) < 0.3]
        # Places of the lower left corner, row by row, that leave room for the labels.
        x, y = (array.ravel() for array in np.meshgrid(
            box.x0 + np.arange(2, 88) / 100 * box.width,
            box.y0 + np.arange(3, 80) / 100 * box.height))  # fmt: skip
        inside = (x + width <= box.x1 - pad) & (y + height <= box.y1 - 1.5 * pad)
        x, y = x[inside, None], y[inside, None]
        px, py = taken.T
        clear = np.hypot(np.maximum(np.maximum(x - px, px - x - width - pad / 2), 0),
                         np.maximum(np.maximum(y - pad / 2 - py, py - y - height), 0))  # fmt: skip
        free = clear.min(axis=1) > 0.2 * pad
        if len(own) == 0 or not free.any():
            continue
        # The hypotenuse is as near to the curves of its slope as possible, at both ends.
        x, y = x[free], y[free]
        px, py = own.T
        gap = np.maximum(np.hypot(px - x, py - y).min(axis=1),
                         np.hypot(px - x - width, py - y - height).min(axis=1))  # fmt: skip
        x, y = x[gap.argmin(), 0], y[gap.argmin(), 0]
        corners = [(x, y), (x + width, y), (x + width, y + height)]
        axes.add_patch(plt.Polygon([back(c) for c in corners], closed=True, fc="#f2f2f2", ec=GREY))
        axes.annotate("1", back((x + width / 2, y)), (0, -2), textcoords="offset points",
                      ha="center", va="top", fontsize=8, color=GREY)  # fmt: skip
        axes.annotate(str(slope), back((x + width, y + height / 2)), (3, 0), color=GREY,
                      textcoords="offset points", va="center", fontsize=8)  # fmt: skip
        grid = [(i / 9, j / 9) for i in range(-2, 13) for j in range(-2, 12)]
        taken = np.vstack([taken, [(x + width * i, y + height * j) for i, j in grid]])


def scatter(study, folder, name, title, xlabel, x_key, key, ylabel, floor=0.0, guides=False):
    """key over x_key, one line an integrator; over the step also the explicit rules' limit, and the
    runs that did not end well as × at the top."""
    groups, over_step = by_integrator(study["runs"]), x_key == "step"
    figure, axes = plt.subplots(figsize=(6.4, 4.4))
    axes.set_xscale("log")
    axes.set_yscale("log")
    handles, lines, rows = [], [], []
    for integrator, runs in groups.items():
        looks = style(integrator, any(run.get("compares_solver") for run in runs))
        points = [(number(r.get(x_key)), max(number(r.get(key)), floor)) for r in runs
                  if ended_well(r)]  # fmt: skip
        points = [p for p in points if usable(p[0]) and usable(p[1])]
        if points:
            lines.append(points)
            axes.plot(*zip(*points), **looks, mew=1.6)
        handles.append(Line2D([], [], label=integrator, mew=1.6, **looks))
        bad = [r["step"] for r in runs if not ended_well(r)]
        if bad and over_step:
            rows.append((looks["color"], bad))
    if not lines:
        axes.text(0.5, 0.5, "no run has this number", transform=axes.transAxes, ha="center")
        axes.set_yticks([])
    (low, high), room = axes.get_ylim(), 0.065 * len(rows)
    if len(lines) > 0 and high / low < 100:  # a short axis would have no labelled tick
        middle = math.sqrt(low * high)
        low, high = middle / 10, middle * 10
    axes.set_ylim(low, high * (high / low) ** (room / (1 - room)))
    for index, (color, bad) in enumerate(rows):
        axes.plot(bad, [0.97 - 0.065 * index] * len(bad), "x", color=color, ms=8, mew=2,
                  transform=axes.get_xaxis_transform())  # fmt: skip
    limits = study["limits"] if over_step else []
    for _, limit in limits:
        axes.axvline(limit, color=GREY, linestyle="--", linewidth=1, zorder=1)
    low, high = axes.get_xlim()
    if high / low < 10:
        middle = math.sqrt(low * high)
        low, high = middle / 10**0.6, middle * 10**0.6
    axes.set_xlim(low, high)
    # Two labels stand on two lines, the larger limit above.
    for line, (label, limit) in enumerate(sorted(limits, key=lambda named: named[1])):
        place = math.log(limit / low) / math.log(high / low)
        edge = 0.3 * len(label) / 36  # half of its width
        axes.annotate(label, (min(max(place, edge), 1 - edge), 1.015 + 0.035 * line),
                      xycoords="axes fraction", ha="center", fontsize=8, color=GREY)  # fmt: skip
    if rows:
        handles.append(Line2D([], [], color=GREY, marker="x", ls="", ms=8, mew=2,
                              label="unstable or failed"))  # fmt: skip
    axes.set_xlabel(xlabel)
    axes.set_ylabel(ylabel)
    axes.set_title(title, fontsize=11, pad=8 + 12 * len(limits))
    axes.legend(handles=handles, loc="center left", bbox_to_anchor=(1.01, 0.5), fontsize=9)
    figure.canvas.draw()  # places the axes, which the guides need to know
    if guides and lines:
        slope_guides(axes, lines, limits)
    save(figure, folder, name)


def main(folder):
    study = read_study(folder)
    over_time(study, folder, "energy_over_time", "Energy error over time (dashed, ending in ×: "
              "unstable)", "|energy error| / energy that entered", energy_error, 1e-16)  # fmt: skip
    over_time(study, folder, "linear_momentum_over_time", "Linear momentum (constant only for a "
              "body free of outer forces)", "$|p|$ [kg m/s]", magnitude("p"))  # fmt: skip
    over_time(study, folder, "angular_momentum_over_time", "Angular momentum about the origin "
              "(constant only without outer torque)", "$|L|$ [kg m²/s]", magnitude("l"))  # fmt: skip
    step = "step $h$ [s]"
    what = "position error" if len(study["variants"]) < 2 else "position error or difference"
    error = what + r" at the end $|q - q_{ref}|\,/\,|q_{ref} - X|$"
    key = "position_error"
    if study["error"].startswith("probe."):
        key = "probe_error"
        name = study["error"][len("probe."):]
        error = f"error of the probe {name}" + r" $\max|s - s_{ref}|\,/\,\max|s_{ref}|$"
    scatter(study, folder, "error_over_step", "Error over step size", step, "step",
            key, error, guides=True)  # fmt: skip
    scatter(study, folder, "rms_error_over_step", "Error of the whole motion over step size", step,
            "step", "position_error_rms", f"root mean square of the {what} over time",
            guides=True)  # fmt: skip
    scatter(study, folder, "work_precision", "Work and precision", "wall time of the run [s]",
            "wall_seconds", key, error)  # fmt: skip
    scatter(study, folder, "energy_drift_over_step", "Largest energy error over step size", step,
            "step", "max_relative_energy_drift", "|energy error| / energy that entered",
            1e-17)  # fmt: skip
    scatter(study, folder, "momentum_drift_over_step", "Angular momentum that outer forces do not "
            "explain", step, "step", "angular_momentum_drift",
            r"$|\Delta L - \mathrm{impulses}|\,/\,\Sigma |q \times p|$", 1e-17)  # fmt: skip
    for probe in study["probes"]:
        probe_over_time(study, folder, probe)


if __name__ == "__main__":
    try:
        if len(sys.argv) != 2:
            raise Unusable("usage: plot_study.py STUDY_DIR")
        main(sys.argv[1])
    except (Unusable, OSError) as problem:
        sys.exit(f"plot_study: {problem}")
