"""The plots of docs/verification.md, made from the program's own files."""

import os

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.ticker import FixedLocator, FuncFormatter, MaxNLocator, NullLocator

from program import Results
from quantities import formula

COLOURS = {"linear": "tab:red", "nodal": "tab:orange", "quadratic": "tab:blue"}
MARKERS = {"linear": "s", "nodal": "D", "quadratic": "o"}
NAMES = {"linear": "linear", "nodal": "linear, nodal volume", "quadratic": "quadratic"}


STYLES = ["-", "--", ":"]  # from the finest mesh on


def only(values, plot):
    return [v for v in values
            if v.quantity == plot.get("quantity", v.quantity)
            and v.variant in plot.get("variants", [v.variant])
            and v.element in plot.get("elements", [v.element])
            and v.cells in plot.get("cells", [v.cells])]


def runs_of(values):
    """(element, tetrahedra, folder, style of the line) of the three finest meshes of each element."""
    for element in COLOURS:
        mine = dict.fromkeys((v.tetrahedra, v.folder) for v in values if v.element == element)
        for style, (tetrahedra, folder) in zip(STYLES, sorted(mine, reverse=True)):
            yield element, tetrahedra, folder, style


def legend_beside(axis):
    axis.legend(fontsize=7.5, title="element, tetrahedra", title_fontsize=7.5, loc="center left",
                bbox_to_anchor=(1.0, 0.5))


def convergence(plot, values):
    """Magnitude of the deviation over the cells in a direction; a panel for each variant or quantity."""
    values = [v for v in only(values, plot) if v.deviation and not v.is_reference]
    panels = list(dict.fromkeys((v.variant, v.quantity) for v in values))
    direction = plot.get("direction", 0)
    figure, axes = plt.subplots(1, len(panels), figsize=(1.2 + 3.4 * len(panels), 3.5),
                                squeeze=False, sharey=True, constrained_layout=True)
    for axis, (variant, quantity) in zip(axes[0], panels):
        shown = [v for v in values if (v.variant, v.quantity) == (variant, quantity)]
        for element in COLOURS:
            series = sorted((v for v in shown if v.element == element), key=lambda v: v.cells)
            if not series:
                continue
            cells = np.array([v.cells[direction] for v in series])
            error = np.array([abs(v.deviation) for v in series])
            label = NAMES[element]
            if len(series) > 1:
                order = np.log(error[-2] / error[-1]) / np.log(cells[-1] / cells[-2])
                label += f" (order {order:.1f})"
            axis.loglog(cells, error, marker=MARKERS[element], color=COLOURS[element], label=label)
        axis.set_title(" · ".join(filter(None, (variant, quantity))), fontsize=9)
        axis.set_xlabel(plot.get("x_label", "cells along the first direction"))
        ticks = sorted({v.cells[direction] for v in shown})
        axis.xaxis.set_major_locator(FixedLocator(ticks))
        axis.xaxis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))
        axis.xaxis.set_minor_locator(NullLocator())
        axis.grid(True, which="both", alpha=0.25)
        axis.margins(y=0.2)
        axis.legend(fontsize=7.5)
    if values[0].absolute:
        axes[0, 0].set_ylabel("|error|")
    else:
        axes[0, 0].set_ylabel("|deviation| from the reference")
        axes[0, 0].yaxis.set_major_formatter(FuncFormatter(lambda y, _: f"{100 * y:g} %"))
    return figure


def trajectory(plot, values):
    """A column of probes.csv (or of `table`) over another one, a line for each run."""
    values = only(values, plot)
    variants = list(dict.fromkeys(v.variant for v in values))
    figure, axes = plt.subplots(1, len(variants), figsize=(2.4 + 4.8 * len(variants), 3.5),
                                squeeze=False, constrained_layout=True)
    for axis, variant in zip(axes[0], variants):
        for element, tetrahedra, folder, style in runs_of([v for v in values if v.variant == variant]):
            table = Results(folder).table(plot.get("table", "probes.csv"))
            axis.plot(plot.get("x_scale", 1.0) * table[plot["x"]],
                      plot.get("y_scale", 1.0) * table[plot["y"]], style, color=COLOURS[element],
                      linewidth=1.4, label=f"{NAMES[element]}, {tetrahedra:,}")
        points = np.array(plot.get("points", [])).reshape(-1, 2)
        if len(points):
            axis.plot(*points.T, "k+", markersize=10, markeredgewidth=1.6, zorder=5, label="reference")
        axis.set_title(variant, fontsize=9)
        axis.set_xlabel(plot["x_label"])
        axis.set_ylabel(plot["y_label"])
        if "x_range" in plot:
            axis.set_xlim(plot["x_range"])
        axis.grid(True, alpha=0.25)
    legend_beside(axes[0, -1])
    return figure


def force(plot, values):
    """The force of an obstacle along x, as `impact` of quantities.py has it, a line for each variant."""
    figure, axis = plt.subplots(figsize=(7.2, 3.5), constrained_layout=True)
    last = 0.0
    for variant, folder in dict.fromkeys((v.variant, v.folder) for v in only(values, plot)):
        table = Results(folder).history
        steps = np.diff(table["time"])
        mean = np.diff(table["px"]) / steps - plot.get("other", 0.0)
        axis.plot(table["time"][:-1] + 0.5 * steps, mean, linewidth=1.2, label=variant)
        last = max(last, table["time"][-1])
    times = np.linspace(0.0, last, 4001)
    axis.plot(times, formula(plot["exact"], np.column_stack([times] * 3)), "k--", linewidth=1.0, label="exact")
    axis.set_xlabel(plot["x_label"])
    axis.set_ylabel(plot["y_label"])
    axis.grid(True, alpha=0.25)
    axis.legend(fontsize=7.5)
    return figure


def spectrum(plot, values):
    """Frequencies divided by the exact ones, a formula of the number X of the mode."""
    figure, axis = plt.subplots(figsize=(7.2, 3.5), constrained_layout=True)
    for element, tetrahedra, folder, style in runs_of(only(values, plot)):
        modes = Results(folder).modes
        found = modes["frequency"][modes["kind"] == "elastic"]
        numbers = np.arange(1, min(len(found), plot["modes"]) + 1)
        found = found[:len(numbers)]
        exact = formula(plot["exact"], np.column_stack([numbers, numbers, numbers]))
        axis.plot(numbers, 100.0 * (found / exact - 1.0), style, color=COLOURS[element],
                  linewidth=1.4, label=f"{NAMES[element]}, {tetrahedra:,}")
    axis.axhline(0.0, color="black", linewidth=0.8)
    axis.set_xlabel("number of the mode")
    axis.set_ylabel("deviation of the frequency [%]")
    axis.xaxis.set_major_locator(MaxNLocator(integer=True))
    axis.grid(True, alpha=0.25)
    legend_beside(axis)
    return figure


PLOTS = {function.__name__: function for function in (convergence, trajectory, force, spectrum)}


def draw(folder, case, values):
    """Draws the plots of a case; returns (file name, caption) of each."""
    os.makedirs(folder, exist_ok=True)
    made = []
    for plot in case.table.get("plot", []):
        figure = PLOTS[plot["kind"]](plot, values)
        name = f"{case.name}_{plot['kind']}.png"
        figure.savefig(os.path.join(folder, name), dpi=100)
        plt.close(figure)
        made.append((name, plot["caption"]))
    return made
