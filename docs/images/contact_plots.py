#!/usr/bin/python3
"""Makes bar_on_wall.png, ball_drop_rules.png and hertz.png of the gallery: /usr/bin/python3 docs/images/contact_plots.py PROGRAM FOLDER

Runs examples/scenes/bar_on_wall.toml with two rules, ball_drop.toml with all five, and hertz.toml, and draws the results
beside closed forms. The runs go to FOLDER; those that are there already are not made again.
"""

import csv
import json
import os
import subprocess
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import vtk
from vtkmodules.util.numpy_support import vtk_to_numpy

HERE = os.path.dirname(os.path.abspath(__file__))
RULES = {
    "explicit": ("tab:red", "-", 1e-4),
    "verlet": ("tab:orange", "--", 1e-4),
    "midpoint": ("tab:blue", "-", 2e-3),
    "backward-euler": ("tab:green", "-", 2e-3),
    "energy-momentum": ("black", "-", 2e-3),
}


def run(program, folder, scene, name, **settings):
    """The columns of history.csv of a run, and its folder."""
    out = os.path.join(folder, name)
    if not os.path.exists(os.path.join(out, "summary.json")):
        command = [program, "run", os.path.join(HERE, "..", "..", "examples", "scenes", scene + ".toml"), "--out", out,
                   "--quiet"]  # fmt: skip
        for key, value in settings.items():
            command += ["--set", f"{key.replace('__', '.')}={json.dumps(value)}"]
        subprocess.run(command, check=True)
    with open(os.path.join(out, "history.csv"), newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    return {key: np.array([float(row[key] or "nan") for row in rows]) for key in rows[0]}, out


def save(figure, name):
    figure.savefig(os.path.join(HERE, name), dpi=110)
    plt.close(figure)


def bar_on_wall(program, folder):
    figure, axis = plt.subplots(figsize=(7.2, 3.4), constrained_layout=True)
    for rule, (colour, style, _) in RULES.items():
        if rule not in ("backward-euler", "energy-momentum"):
            continue
        data, _ = run(program, folder, "bar_on_wall", "bar-" + rule, time__integrator=rule)
        steps = np.diff(data["time"])
        axis.plot(1e3 * (data["time"][:-1] + 0.5 * steps), np.diff(data["px"]) / steps, style, color=colour,
                  linewidth=1.3, label=rule)  # fmt: skip
    length = 2e3 / np.sqrt(1e3)  # 2L/c in ms
    axis.plot([0.0, 0.0, length, length, 95.0], [0.0, 2.5, 2.5, 0.0, 0.0], "--", color="tab:red", linewidth=1.2,
              label="closed form: ρ c v₀ A for 2L/c")  # fmt: skip
    axis.set_xlabel("time [ms]")
    axis.set_ylabel("force of the wall [N]")
    axis.grid(True, alpha=0.25)
    axis.legend(fontsize=8)
    save(figure, "bar_on_wall.png")


def ball_drop(program, folder):
    figure, (heights, energies) = plt.subplots(2, 1, figsize=(7.2, 5.0), sharex=True, constrained_layout=True)
    for rule, (colour, style, step) in RULES.items():
        data, _ = run(program, folder, "ball_drop", "ball-" + rule, time__integrator=rule, time__step=step,
                      output__every=100000)  # fmt: skip
        # Above the lowest place of the middle of the ball at rest on the floor, of 4.0095 kg and 9.81 m/s².
        height = data["environment_energy"] / (4.0095 * 9.81) + 0.3
        heights.plot(data["time"], 1e2 * height, style, color=colour, linewidth=1.3, label=f"{rule}, {1e3 * step:g} ms")
        total = data["total_energy"] - data["total_energy"][0]
        energies.plot(data["time"], total, style, color=colour, linewidth=1.3)
    heights.set_ylabel("height of the centre of mass [cm]")
    energies.set_ylabel("change of the total energy [J]")
    energies.set_xlabel("time [s]")
    heights.legend(fontsize=8, loc="upper right")
    for axis in (heights, energies):
        axis.grid(True, alpha=0.25)
    save(figure, "ball_drop_rules.png")


def hertz(program, folder):
    _, out = run(program, folder, "hertz", "hertz")
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(os.path.join(out, "final.vtu"))
    reader.Update()
    grid = reader.GetOutput()
    points = vtk_to_numpy(grid.GetPoints().GetData())
    pressure = vtk_to_numpy(grid.GetPointData().GetArray("contact_pressure"))
    force = np.abs(vtk_to_numpy(grid.GetPointData().GetArray("contact_force"))[:, 1])
    # Without the corners of quadratic faces, which have a thousandth of the area.
    area = np.divide(force, pressure, out=np.zeros_like(force), where=pressure > 0.0)
    shown = (points[:, 1] > -1e-9) & ((area > 0.01 * area.max()) | (pressure == 0.0))
    radius = np.hypot(points[:, 0], points[:, 2])
    shown &= radius < 0.1
    plane = 1e6 / (1.0 - 0.3**2)
    peak = np.cbrt(6.0 * 4.0 * force.sum() * plane**2 / np.pi**3)
    contact = np.pi * peak / (2.0 * plane)  # a = π p₀ R/(2 E*)
    r = np.linspace(0.0, contact, 400)
    figure, axis = plt.subplots(figsize=(7.2, 3.2), constrained_layout=True)
    axis.plot(1e3 * np.append(r, 100.0e-3), 1e-3 * np.append(peak * np.sqrt(1.0 - (r / contact) ** 2), 0.0), "k-",
              linewidth=1.2, label="Hertz: p₀ √(1 − r²/a²) for the same force")  # fmt: skip
    axis.plot(1e3 * radius[shown], 1e-3 * pressure[shown], "o", color="tab:blue", markersize=4, label="vertices")
    axis.set_xlabel("distance from the axis [mm]")
    axis.set_ylabel("contact pressure [kPa]")
    axis.grid(True, alpha=0.25)
    axis.legend(fontsize=8)
    save(figure, "hertz.png")
    print("largest pressure / p0", pressure[shown].max() / peak, "force", 4.0 * force.sum())


def main():
    if len(sys.argv) != 3:
        sys.exit("usage: contact_plots.py PROGRAM FOLDER")
    for picture in (bar_on_wall, hertz, ball_drop):
        picture(*sys.argv[1:])


if __name__ == "__main__":
    main()
