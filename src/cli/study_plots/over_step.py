"""Plots over the step or the wall time."""

import math

import numpy as np

from .files import ended_well, summary_of
from .looks import (COLOURS, DASH_DOT, DASHED, DOTTED, GREY, MARKERS, PALE, RULE_LINES, curves_of, heading, looks_of,
                    name_of, note_of_points, parts_of)  # fmt: skip
from .sheet import plot
from .words import number, plain, scaled, si, some, usable, wrapped

EPSILON = 2.0**-52
MOST_PANELS = {85: 6, 170: 9}  # of a figure of this width in mm


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
            panel.line(wrapped(f"{kind}: {', '.join(f[0]['curve'] for f in same)}", 16),
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
        return "probe_error", f"relative error of the {part}probe {plain(name, 200)}"
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
