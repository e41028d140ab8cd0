"""Plots of a step-size study: python3 plot_study.py STUDY_DIR

Reads study.json and the history.csv of each run; writes PNG and SVG files into STUDY_DIR.
"""

import csv
import json
import math
import os
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402
from matplotlib.lines import Line2D  # noqa: E402

# Okabe and Ito's colours: told apart by colour-blind readers as well.
STYLE = {
    "explicit": ("#D55E00", "o"),
    "verlet": ("#E69F00", "s"),
    "midpoint": ("#0072B2", "^"),
    "backward-euler": ("#009E73", "D"),
}
OTHER = ("#555555", "v")

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


def style(group):
    return STYLE.get(group.split(" ")[0], OTHER)


def number(value):
    return float("nan") if value is None else float(value)


def positive(values):
    return [v for v in values if math.isfinite(v) and v > 0]


def save(figure, folder, name):
    for ending in ("png", "svg"):
        figure.savefig(os.path.join(folder, f"{name}.{ending}"), bbox_inches="tight")
    plt.close(figure)


def read_history(path):
    """Columns of a history.csv as lists of numbers; empty if it cannot be read."""
    try:
        with open(path, newline="") as file:
            rows = list(csv.reader(file))
    except OSError:
        return {}
    if len(rows) < 2:
        return {}
    columns = {name: [] for name in rows[0]}
    for row in rows[1:]:
        if len(row) != len(rows[0]):
            break
        for name, value in zip(rows[0], row):
            columns[name].append(float(value))
    return columns


def step_label(step, stable_step):
    ratio = f" = {step / stable_step:.2g} $h_{{crit}}$" if stable_step else ""
    return f"$h$ = {step:.3g} s{ratio}"


def mark_limit(axes, stable_step):
    if stable_step:
        axes.axvline(stable_step, color="#888888", linestyle="--", linewidth=1)
        axes.annotate(
            "stability limit of\nthe explicit rules",
            (stable_step, 0.02),
            xycoords=("data", "axes fraction"),
            xytext=(4, 0),
            textcoords="offset points",
            fontsize=8,
            color="#666666",
        )


def by_integrator(runs):
    """The runs by integrator, and by variant where there are several."""
    groups = {}
    for run in runs:
        variant = run.get("variant")
        key = f"{run['integrator']} ({variant})" if variant else run["integrator"]
        groups.setdefault(key, []).append(run)
    for group in groups.values():
        group.sort(key=lambda run: run["step"])
    return groups


def over_time(study, folder, name, title, ylabel, value_of, floor=None):
    """One panel an integrator, one curve a step; a logarithmic axis from `floor` up if it is given.

    The axis fits the runs that ended well: a run that blew up leaves the picture.
    """
    groups = by_integrator(study["runs"])
    columns = min(2, len(groups))
    rows = math.ceil(len(groups) / columns)
    figure, panels = plt.subplots(
        rows, columns, figsize=(5.2 * columns, 3.3 * rows), sharex=True, sharey=True, squeeze=False
    )
    steps = sorted({run["step"] for run in study["runs"]})
    shades = plt.get_cmap("viridis")
    color = {h: shades(0.9 * i / max(1, len(steps) - 1)) for i, h in enumerate(steps)}
    highest = 0.0
    for panel, (integrator, runs) in zip(panels.flat, groups.items()):
        panel.set_title(integrator, fontsize=10, fontweight="bold", color=style(integrator)[0])
        if floor:
            panel.set_yscale("log")
        for run in runs:
            history = read_history(os.path.join(folder, run["directory"], "history.csv"))
            if not history:
                continue
            values = [max(v, floor or 0.0) for v in value_of(run, history)]
            dashed = run["status"] != "ok"
            if not dashed:
                highest = max(highest, max(values))
            panel.plot(
                history["time"], values, color=color[run["step"]], linewidth=1.3,
                linestyle="--" if dashed else "-",
            )  # fmt: skip
            if dashed:
                panel.plot(history["time"][-1], values[-1], "x", color=color[run["step"]], ms=7)
    for panel in panels[-1]:
        panel.set_xlabel("time [s]")
    for row in panels:
        row[0].set_ylabel(ylabel)
    for panel in list(panels.flat)[len(groups) :]:
        panel.set_visible(False)
    if floor:
        panels[0][0].set_ylim(bottom=floor, top=30 * highest if highest > floor else None)
    elif highest > 0:
        panels[0][0].set_ylim(0, 1.15 * highest)
    figure.suptitle(title)
    figure.legend(
        [Line2D([], [], color=color[h]) for h in steps],
        [step_label(h, study["stable_step"]) for h in steps],
        loc="lower center",
        bbox_to_anchor=(0.5, -0.04 - 0.02 * (rows == 1)),
        ncol=min(3, len(steps)),
        fontsize=9,
    )
    figure.tight_layout(rect=(0, 0.06, 1, 1))
    save(figure, folder, name)


def energy_over_time(study, folder):
    def relative_error(_, history):
        body = [t + w for t, w in zip(history["kinetic_energy"], history["elastic_energy"])]
        environment = history["environment_energy"]
        scale = body[0] + max(abs(e - environment[0]) for e in environment)
        scale += max(abs(w) for w in history["external_work"])
        return [abs(e) / scale if scale > 0 else 0.0 for e in history["energy_error"]]

    over_time(
        study, folder, "energy_over_time",
        "Energy error over time (dashed, ending in ×: unstable)",
        "|energy error| / energy that entered", relative_error, 1e-12,
    )  # fmt: skip


def momentum_over_time(study, folder):
    def angular(_, history):
        return [math.hypot(*l) for l in zip(history["lx"], history["ly"], history["lz"])]

    def linear(_, history):
        return [math.hypot(*p) for p in zip(history["px"], history["py"], history["pz"])]

    over_time(
        study, folder, "linear_momentum_over_time",
        "Linear momentum (constant only for a body free of outer forces)",
        "$|p|$ [kg m/s]", linear,
    )  # fmt: skip
    over_time(
        study, folder, "angular_momentum_over_time",
        "Angular momentum about the origin (constant only without outer torque)",
        "$|L|$ [kg m²/s]", angular,
    )  # fmt: skip


def scatter(study, folder, name, title, x_of, xlabel, key, ylabel, limit, slopes):
    """key over x, one line an integrator; runs that did not end well as × at the top."""
    figure, axes = plt.subplots(figsize=(6.4, 4.4))
    axes.set_xscale("log")
    axes.set_yscale("log")
    all_x, all_y = [], []
    for integrator, runs in by_integrator(study["runs"]).items():
        good = [r for r in runs if r["status"] == "ok" and number(r[key]) > 0]
        bad = [r for r in runs if r["status"] != "ok"]
        color, marker = style(integrator)
        if good:
            x, y = [x_of(r) for r in good], [number(r[key]) for r in good]
            axes.plot(x, y, color=color, marker=marker, label=integrator, linewidth=1.4)
            all_x += x
            all_y += y
        if bad and limit:
            axes.plot(
                [x_of(r) for r in bad], [0.97 if not integrator.startswith("verlet") else 0.92] * len(bad), "x",
                color=color, markersize=9, markeredgewidth=2, clip_on=False,
                transform=axes.get_xaxis_transform(),
                label=None if good else integrator,
            )  # fmt: skip
    if not positive(all_y):
        plt.close(figure)
        return
    if limit:
        mark_limit(axes, study["stable_step"])
    if slopes:
        low, high = min(all_x), max(all_x)
        if high > low:
            x = [low, low * (high / low) ** 0.45]
            base = max(all_y)
            for slope, dash in ((1, ":"), (2, "-.")):
                y = [base * (v / x[1]) ** slope for v in x]
                axes.plot(x, y, color="#999999", linestyle=dash, linewidth=1, label=f"slope {slope}")
    axes.set_xlabel(xlabel)
    axes.set_ylabel(ylabel)
    axes.set_title(title, fontsize=11)
    axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), fontsize=9)
    if limit and any(r["status"] != "ok" for r in study["runs"]):
        axes.set_ylim(top=axes.get_ylim()[1] * 8)
        axes.annotate("× unstable or failed", (1.02, 0.95), xycoords="axes fraction", fontsize=8)
    save(figure, folder, name)


def main(folder):
    with open(os.path.join(folder, "study.json")) as file:
        study = json.load(file)
    if not study["runs"]:
        raise ValueError("the study has no runs")
    step, cost = (lambda r: r["step"]), (lambda r: max(r["wall_seconds"], 1e-6))
    error = "position error $|q - q_{ref}|/|q_{ref}|$"
    energy_over_time(study, folder)
    momentum_over_time(study, folder)
    scatter(study, folder, "error_over_step", "Error over step size", step, "step $h$ [s]",
            "position_error", error, True, True)  # fmt: skip
    scatter(study, folder, "work_precision", "Work and precision", cost, "wall time of the steps [s]",
            "position_error", error, False, False)  # fmt: skip
    scatter(study, folder, "energy_drift_over_step", "Largest energy error over step size", step,
            "step $h$ [s]", "max_relative_energy_drift", "|energy error| / energy that entered",
            True, False)  # fmt: skip
    scatter(study, folder, "momentum_drift_over_step", "Angular momentum that outer forces do not "
            "explain", step, "step $h$ [s]", "angular_momentum_drift",
            r"$|\Delta L - \mathrm{impulses}| / \Sigma |q \times p|$", True, False)  # fmt: skip


if __name__ == "__main__":
    try:
        main(sys.argv[1])
    except (IndexError, KeyError, OSError, ValueError) as problem:
        sys.exit(f"plot_study: {type(problem).__name__}: {problem}")
