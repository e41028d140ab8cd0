#!/usr/bin/env python3
"""What contact with obstacles costs: steps with an obstacle against the same steps without it.

Usage: benchmarks/contact.py [PROGRAM] [REPETITIONS]

A block of 16 x 16 x 16 cells with 24,576 tetrahedra rests on a floor, with all of its 289 lower vertices in the layer, or
is clamped at a side and bends under its weight. Every run has one thread. The times are processor times of the program
for so many steps, minus those of a run with a tenth of the steps, the least of all repetitions, which take turns, so
that other programs on the machine disturb all of them alike. docs/performance.md has the results.
"""

import os
import subprocess
import sys
import tempfile

PROGRAM = os.path.abspath(sys.argv[1] if len(sys.argv) > 1 else "build/release/bin/tetraction")
REPETITIONS = int(sys.argv[2]) if len(sys.argv) > 2 else 3

SCENE = """
[mesh]
generate = {{ kind = "cube", size = 0.2, cells = 16 }}
[material]
model = "neo-hookean"
youngs_modulus = 1e6
poissons_ratio = 0.3
density = 1000
[environment]
kind = "gravity"
[time]
integrator = "{integrator}"
step = {step}
end = {end}
[output]
every = 1000000
history_every = 1000000
{more}
"""

CLAMP = '[[fix]]\nselect = { plane = { axis = "x", at = 0.0 } }\n'
FACE = "select = { faces = { normal = [0, -1, 0] } }\n"
FLOOR = '[[obstacle]]\nname = "floor"\nkind = "plane"\npoint = [0, -0.0012, 0]\nnormal = [0, 1, 0]\n'
RUBS = "friction = 0.4\n"


def floor_of_triangles(folder, cells):
    """An entry for a floor of squares with two triangles each, 1 m wide."""
    with open(os.path.join(folder, f"floor{cells}.obj"), "w", encoding="utf-8") as file:
        for i in range(cells + 1):
            for j in range(cells + 1):
                file.write(f"v {i / cells - 0.4} -0.0012 {j / cells - 0.4}\n")
        for i in range(cells):
            for j in range(cells):
                a = i * (cells + 1) + j + 1
                b = a + cells + 1
                file.write(f"f {a} {a + 1} {b + 1}\nf {a} {b + 1} {b}\n")
    return f'[[obstacle]]\nname = "floor"\nkind = "mesh"\nfile = "floor{cells}.obj"\n'


def processor_time(folder, rule, step, steps, more):
    path = os.path.join(folder, "scene.toml")
    with open(path, "w", encoding="utf-8") as file:
        file.write(SCENE.format(integrator=rule, step=step, end=step * steps, more=more))
    command = [PROGRAM, "run", path, "--out", os.path.join(folder, "out"), "--threads", "1", "--quiet"]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    _, status, used = os.wait4(process.pid, 0)
    if status != 0:
        raise SystemExit(f"{command} has failed with\n{more}")
    return used.ru_utime + used.ru_stime


def main():
    with tempfile.TemporaryDirectory() as folder:
        kinds = {
            "no obstacle, free": "",
            "no obstacle, clamped, bends": CLAMP,
            "plane": FLOOR + FACE,
            "plane that all faces may touch": FLOOR,
            "plane with friction": FLOOR + FACE + RUBS,
            "2 triangles": floor_of_triangles(folder, 1) + FACE,
            "2,048 triangles": floor_of_triangles(folder, 32) + FACE,
            "2,048 triangles that all faces may touch": floor_of_triangles(folder, 32),
            "131,072 triangles": floor_of_triangles(folder, 256) + FACE,
        }
        print(f"{'rule':15} {'obstacle':41} {'ms per step':>11} {'times that without':>18}")
        for rule, step, steps in (("verlet", 4e-5, 1000), ("backward-euler", 2e-3, 20), ("energy-momentum", 2e-3, 20)):
            best = {}
            for _ in range(REPETITIONS):
                for kind, more in kinds.items():
                    time = (processor_time(folder, rule, step, steps, more)
                            - processor_time(folder, rule, step, steps // 10, more)) / (0.9 * steps)  # fmt: skip
                    best[kind] = min(best.get(kind, time), time)
            beside = best["no obstacle, free" if rule == "verlet" else "no obstacle, clamped, bends"]
            for kind, time in best.items():
                print(f"{rule:15} {kind:41} {1e3 * time:11.2f} {time / beside:18.2f}", flush=True)


if __name__ == "__main__":
    main()
