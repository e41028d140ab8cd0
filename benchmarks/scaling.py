#!/usr/bin/env python3
"""Steps of one process without MPI against those of the engine in 1, 2, ... processes, within one run.

Usage: benchmarks/scaling.py [PROGRAM] [PROCESSES,...] [REPETITIONS]

Every process has one thread. The times are those of the steps, the least of all repetitions; the memory is the
peak of the process with the most, with reading, division and output. The limit is the speed-up of as many runs
without MPI that know nothing of each other: they have the same memory, caches and clock rate to share.
docs/scaling.md has the results.
"""

import json
import os
import subprocess
import sys
import tempfile

PROGRAM = sys.argv[1] if len(sys.argv) > 1 else "build/release/bin/tetraction"
PROCESSES = [int(n) for n in (sys.argv[2] if len(sys.argv) > 2 else "1,2").split(",")]
REPETITIONS = int(sys.argv[3]) if len(sys.argv) > 3 else 3

SCENE = """
[mesh]
generate = {{ kind = "beam", size = [4, 1, 1], cells = {cells} }}
[material]
model = "neo-hookean"
youngs_modulus = 1e6
poissons_ratio = 0.3
density = 1000
[environment]
kind = "gravity"
[[fix]]
select = {{ plane = {{ axis = "x", at = 0.0 }} }}
[time]
integrator = "{integrator}"
step = {step}
end = {end}
[solver]
linear = "matrix-free"
[output]
every = 100000
"""

MESHES = {"M": [36, 9, 10], "L": [72, 18, 19], "XL": [144, 37, 37]}
# Steps below the stability limit, and steps of 20 ms.
RULES = [("verlet", {"M": (5e-5, 1000), "L": (2e-5, 200), "XL": (1e-5, 50)}),
         ("backward-euler", {"M": (0.02, 10), "L": (0.02, 3), "XL": (0.02, 2)})]


def start(folder, processes, out):
    """A run that has begun; with processes None without MPI."""
    command = [PROGRAM, "run", "scene.toml", "--out", out, "--threads", "1", "--quiet"]
    if processes is not None:
        command = ["mpirun", "--oversubscribe", "-n", str(processes), *command,
                   "--set", 'solver.engine="petsc"']  # fmt: skip
    environment = {**os.environ, "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
    return subprocess.Popen(command, cwd=folder, env=environment, stdout=subprocess.DEVNULL,
                            stderr=subprocess.DEVNULL)


def summary(folder, running, out):
    if running.wait() != 0:
        raise SystemExit(f"{running.args} has failed")
    with open(os.path.join(folder, out, "summary.json")) as file:
        return json.load(file)


def run(folder, processes):
    """The summary of a run."""
    return summary(folder, start(folder, processes, "out"), "out")


def stepping_of_runs_at_once(folder, count):
    """The time of the steps of so many runs without MPI at the same time; of the slowest one."""
    names = [f"out{i}" for i in range(count)]
    runs = [start(folder, None, name) for name in names]
    return max(summary(folder, r, name)["wall_seconds"]["stepping"] for r, name in zip(runs, names))


def main():
    global PROGRAM
    PROGRAM = os.path.abspath(PROGRAM)
    print(f"{'mesh':4} {'tetrahedra':>10} {'rule':15} {'processes':>9} {'time':>7} {'speed-up':>8} "
          f"{'limit':>6} {'memory':>7} {'CG iterations':>13}")  # fmt: skip
    for rule, steps in RULES:
        for mesh, cells in MESHES.items():
            step, count = steps[mesh]
            with tempfile.TemporaryDirectory() as folder:
                with open(os.path.join(folder, "scene.toml"), "w") as file:
                    file.write(SCENE.format(cells=cells, integrator=rule, step=step, end=step * count))
                kinds = [None, *PROCESSES]
                best = dict.fromkeys(kinds, float("inf"))
                at_once = dict.fromkeys(PROCESSES, float("inf"))
                last = {}
                for _ in range(REPETITIONS):
                    for count in at_once:
                        if count > 1:
                            at_once[count] = min(at_once[count], stepping_of_runs_at_once(folder, count))
                    for kind in kinds:
                        last[kind] = run(folder, kind)
                        best[kind] = min(best[kind], last[kind]["wall_seconds"]["stepping"])
            for kind in kinds:
                limit = f"{kind * best[None] / at_once[kind]:.2f}" if kind in at_once and kind > 1 else ""
                memory = last[kind]["peak_memory_bytes"] / last[None]["peak_memory_bytes"]
                solver = last[kind]["solver"]
                iterations = f"{solver['cg_iterations'] / max(1, solver['iterations']):.1f}"
                print(f"{mesh:4} {last[kind]['mesh']['tetrahedra']:10} {rule:15} "
                      f"{'no MPI' if kind is None else kind:>9} {best[kind] / best[None]:7.3f} "
                      f"{best[PROCESSES[0]] / best[kind]:8.2f} {limit:>6} {memory:7.2f} "
                      f"{iterations if solver['iterations'] else '':>13}", flush=True)  # fmt: skip


if __name__ == "__main__":
    main()
