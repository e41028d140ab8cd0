"""The plots of docs/verification.md, made from the program's own files."""

import os

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.ticker import FuncFormatter

from program import Results
from quantities import formula

COLOURS = {"linear": "tab:red", "nodal": "tab:orange", "quadratic": "tab:blue"}
MARKERS = {"linear": "s", "nodal": "D", "quadratic": "o"}
NAMES = {"linear": "linear", "nodal": "linear, nodal volume", "quadratic": "quadratic"}


def only(values, plot):
    return [v for v in values
            if v.quantity == plot.get("quantity", v.quantity)
            and v.variant in plot.get("variants", [v.variant])]


def convergence(plot, values):
    """Magnitude of the deviation over the size of the cells; one panel for each variant or quantity."""
    values = [v for v in only(values, plot) if v.deviation]
    panels = list(dict.fromkeys((v.variant, v.quantity) for v in values))
    figure, axes = plt.subplots(1, len(panels), figsize=(0.8 + 3.6 * len(panels), 3.5), squeeze=False,
                                sharey=True, constrained_layout=True)
    for axis, (variant, quantity) in zip(axes[0], panels):
        for element in COLOURS:
            series = sorted((v for v in values
                             if (v.variant, v.quantity, v.element) == (variant, quantity, element)),
                            key=lambda v: v.cells)
            if not series:
                continue
            h = np.array([series[0].cells[0] / v.cells[0] * 1.0 for v in series])
            h *= min(v.cells[0] for v in values) / series[0].cells[0]
            error = np.array([abs(v.deviation) for v in series])
            label = NAMES[element]
            if len(series) > 1:
                order = np.log(error[-2] / error[-1]) / np.log(h[-2] / h[-1])
                label += f" (slope {order:.1f})"
            axis.loglog(h, error, marker=MARKERS[element], color=COLOURS[element], label=label)
        axis.set_title(" · ".join(filter(None, (variant, quantity))), fontsize=9)
        axis.set_xlabel("size of the cells (coarsest = 1)")
        axis.xaxis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))
        axis.xaxis.set_minor_formatter(FuncFormatter(lambda x, _: ""))
        axis.grid(True, which="both", alpha=0.25)
        axis.legend(fontsize=7.5)
    relative = not values[0].absolute
    axes[0, 0].set_ylabel("|deviation| " + ("from the reference" if relative else ""))
    if relative:
        for axis in axes[0]:
            axis.yaxis.set_major_formatter(FuncFormatter(lambda y, _: f"{100 * y:g} %"))
    return figure


def trajectory(plot, values):
    """A column of probes.csv (or `table`) over another one, a line for each run."""
    variants = list(dict.fromkeys(v.variant for v in only(values, plot)))
    figure, axes = plt.subplots(1, len(variants), figsize=(0.8 + 5.4 * len(variants), 3.5),
                                squeeze=False, constrained_layout=True)
    for axis, variant in zip(axes[0], variants):
        runs = list(dict.fromkeys((v.element, tuple(v.cells), v.tetrahedra, v.folder)
                                  for v in only(values, plot) if v.variant == variant))
        for element in COLOURS:
            mine = [run for run in runs if run[0] == element]
            for n, (_, _, tetrahedra, folder) in enumerate(mine):
                table = Results(folder).table(plot.get("table", "probes.csv"))
                axis.plot(plot.get("x_scale", 1.0) * table[plot["x"]],
                          plot.get("y_scale", 1.0) * table[plot["y"]], color=COLOURS[element],
                          linestyle=[":", "--", "-"][max(0, 3 - len(mine)) + min(n, 2)]
                          if len(mine) <= 3 else "-",
                          alpha=1.0, linewidth=1.4, label=f"{NAMES[element]}, {tetrahedra:,}")
        for x, y in plot.get("points", []):
            axis.plot(x, y, "k+", markersize=10, markeredgewidth=1.6, zorder=5,
                      label="reference" if [x, y] == plot["points"][0] else None)
        axis.set_title(variant, fontsize=9)
        axis.set_xlabel(plot["x_label"])
        axis.set_ylabel(plot["y_label"])
        axis.grid(True, alpha=0.25)
        axis.legend(fontsize=7.5, title="element, tetrahedra", title_fontsize=7.5)
    return figure


def spectrum(plot, values):
    """Frequencies divided by the exact ones, a formula of the number X of the mode."""
    figure, axis = plt.subplots(figsize=(6.4, 3.5), constrained_layout=True)
    runs = list(dict.fromkeys((v.element, tuple(v.cells), v.tetrahedra, v.folder)
                              for v in only(values, plot)))
    styles = {}
    for element, _, tetrahedra, folder in runs:
        modes = Results(folder).modes
        found = modes["frequency"][modes["kind"] == "elastic"]
        numbers = np.arange(1, len(found) + 1)
        exact = formula(plot["exact"], np.column_stack([numbers, numbers, numbers]))
        n = styles.setdefault(element, 0)
        styles[element] += 1
        axis.plot(numbers, 100.0 * (found / exact - 1.0), color=COLOURS[element], linewidth=1.4,
                  linestyle=[":", "--", "-"][min(n, 2)], label=f"{NAMES[element]}, {tetrahedra:,}")
    axis.axhline(0.0, color="black", linewidth=0.8)
    axis.set_xlabel("mode")
    axis.set_ylabel("deviation of the frequency [%]")
    axis.grid(True, alpha=0.25)
    axis.legend(fontsize=7.5, title="element, tetrahedra", title_fontsize=7.5)
    return figure


PLOTS = {function.__name__: function for function in (convergence, trajectory, spectrum)}


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
