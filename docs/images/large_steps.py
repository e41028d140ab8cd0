#!/usr/bin/python3
"""Makes large_steps.png of the README: /usr/bin/python3 docs/images/large_steps.py PROGRAM FOLDER

Runs examples/scenes/spinning_block.toml with all integrators and steps of about 1, 10, 100 and 1,000
times the explicit limit, 100 steps each, and draws the total energy over time.
"""

import csv
import json
import os
import subprocess
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

SCENE = os.path.join(os.path.dirname(__file__), "..", "..", "examples", "scenes",
                     "spinning_block.toml")
STEPS = 100
MULTIPLES = (0.95, 10, 100, 1000)
RULES = {
    "explicit": ("tab:red", "-"),
    "verlet": ("tab:orange", "--"),
    "midpoint": ("tab:blue", "-"),
    "backward-euler": ("tab:green", "-"),
    "energy-momentum": ("black", "-"),
}
WELL_ABOVE = 3.0  # the upper end of the axis, in initial energies


def energies(program, folder, rule, step):
    """Numbers of steps and energies, as multiples of the first one, of one run."""
    out = os.path.join(folder, f"{rule}-{step:.3g}")
    command = [program, "run", SCENE, "--out", out, "--quiet",
               "--set", f'time.integrator="{rule}"', "--set", f"time.step={step!r}",
               "--set", f"time.end={STEPS * step!r}", "--set", f"output.every={STEPS}"]
    subprocess.run(command, check=False, stderr=subprocess.DEVNULL)
    with open(os.path.join(out, "history.csv"), newline="") as file:
        total = [float(row["total_energy"]) for row in csv.DictReader(file)]
    return list(range(len(total))), [energy / total[0] for energy in total]


def main():
    program, folder = sys.argv[1:3]
    check = subprocess.run([program, "check", SCENE, "--json"], check=True, capture_output=True)
    limit = json.loads(check.stdout)["stable_step"]
    figure, axes = plt.subplots(1, len(MULTIPLES), figsize=(12, 3.6), sharey=True,
                                constrained_layout=True)
    for axis, multiple in zip(axes, MULTIPLES):
        for rule, (colour, style) in RULES.items():
            steps, energy = energies(program, folder, rule, multiple * limit)
            axis.plot(steps, energy, style, color=colour, label=rule, linewidth=1.6)
            if len(steps) <= STEPS:  # the run stopped
                axis.plot(steps[-1], min(energy[-1], WELL_ABOVE), "x", color=colour,
                          markersize=9, markeredgewidth=2, clip_on=False, zorder=5)
        axis.set_title(f"h = {multiple:g} × limit")
        axis.set_xlabel("step")
        axis.set_xlim(0, STEPS)
        axis.set_ylim(0, WELL_ABOVE)
        axis.grid(alpha=0.3)
    axes[0].set_ylabel("energy / initial energy")
    axes[0].legend(loc="upper left", fontsize=8)
    figure.savefig(os.path.join(os.path.dirname(__file__), "large_steps.png"), dpi=110)


if __name__ == "__main__":
    main()
