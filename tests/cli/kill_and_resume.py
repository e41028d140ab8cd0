"""Kills runs at random moments, resumes them, and compares all results with those of a run that was
not interrupted, byte for byte.

Usage: python3 kill_and_resume.py PROGRAM [--kills N] [--seed S] [--ways NAME,NAME] [--threads N]
"""

import argparse
import json
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time

SCENE = """
[mesh]
generate = {{ kind = "beam", size = [4, 1, 1], cells = [8, 2, 2] }}
[material]
youngs_modulus = 1.0e6
poissons_ratio = 0.4
[time]
{time}
end = {end}
{solver}
[environment]
kind = "gravity"
[damping]
viscosity = 20.0
mass_damping = 0.1
[[amplitude]]
name = "swell"
sine = {{ frequency = {frequency}, offset = 1.0 }}
[[fix]]
select = {{ plane = {{ axis = "x", at = 0.0 }} }}
[[fix]]
select = {{ nearest = [2, 0.5, 1] }}
mode = "penalty"
penalty = 300.0
velocity = [0.05, 0.0, 0.05]
[[constraint]]
kind = "rigid"
select = {{ plane = {{ axis = "x", at = 4.0 }} }}
angular_velocity = [0.4, 0.0, 0.0]
velocity = [0.02, 0.0, 0.0]
amplitude = "swell"
{distance}
[[pressure]]
select = {{ faces = {{ normal = [0, 1, 0] }} }}
value = 100.0
amplitude = "swell"
[[event]]
at = {first_event}
set = {{ "constraint.0.angular_velocity" = [0.1, 0.2, 0.0], "damping.viscosity" = 30.0 }}
fix = {{ select = {{ nearest = [1, 1, 1] }}, offset = [0.0, 0.001, 0.0] }}
[[event]]
at = {second_event}
set = {{ "environment.strength" = 5.0, "constraint.0.velocity" = [0.0, 0.05, 0.0] }}
unfix = {{ select = {{ all = true }}, fix = 1 }}
[[probe]]
name = "middle"
select = {{ nearest = [2, 1, 1] }}
quantity = "displacement"
[[probe]]
name = "stress"
select = {{ all = true }}
quantity = "von_mises"
every = 3
[output]
every = {every}
history_every = {history_every}
checkpoint_every = {checkpoint_every}
"""

DISTANCE = """
[[constraint]]
kind = "distance"
vertices = [40, 62]
"""


def scene_of(time_keys, solver="", step=4.0e-3, steps=150, distance=DISTANCE):
    end = step * steps
    every = max(1, steps // 15)
    return SCENE.format(
        time=time_keys if "step =" in time_keys else f"{time_keys}\nstep = {step}",
        end=end, solver=f"[solver]\n{solver}" if solver else "", distance=distance,
        frequency=3.0 / end, first_event=0.31 * end, second_event=0.64 * end, every=every,
        history_every=2, checkpoint_every=max(1, steps // 20),
    )  # fmt: skip


def ways():
    explicit = {"step": 2.0e-4, "steps": 1500}
    all_ways = {}
    for rule in ("verlet", "explicit"):
        keys = f'integrator = "{rule}"'
        all_ways[rule] = scene_of(keys, distance="", **explicit)
        all_ways[rule + "-distance"] = scene_of(keys, **explicit)
        all_ways[rule + "-auto"] = scene_of(keys + '\nstep = "auto"', distance="", **explicit)
        all_ways[rule + "-error"] = scene_of(keys + '\nadapt = "error"', distance="", **explicit)
    for rule in ("midpoint", "backward-euler", "energy-momentum"):
        keys = f'integrator = "{rule}"'
        for linear in ("auto", "matrix-free", "cg", "factor"):
            all_ways[f"{rule}-{linear}"] = scene_of(keys, f'linear = "{linear}"')
        if rule != "energy-momentum":
            all_ways[f"{rule}-ceres"] = scene_of(keys, 'kind = "ceres"', steps=60)
        all_ways[f"{rule}-retry"] = scene_of(keys + "\nretry = 6", "max_iterations = 4")
        all_ways[f"{rule}-error"] = scene_of(keys + '\nadapt = "error"\ntolerance = 1e-5')
    all_ways["midpoint-energy"] = scene_of('integrator = "midpoint"\nadapt = "energy"', steps=80)
    return all_ways


def results_of(directory):
    """All results by their names, without what belongs to the machine and the moment."""
    results = {}
    for folder, _, names in os.walk(directory):
        for name in names:
            path = os.path.join(folder, name)
            key = os.path.relpath(path, directory)
            if key.startswith("checkpoints") or key == ".lock":
                continue
            with open(path, "rb") as file:
                results[key] = file.read()
    if "summary.json" in results:
        summary = json.loads(results["summary.json"])
        for key in ("wall_seconds", "peak_memory_bytes"):
            summary.pop(key)
        summary["scene"].pop("output")
        results["summary.json"] = json.dumps(summary).encode()
    return results


def check_what_is_left(directory):
    """What a killed program leaves: whole rows, whole files, and frames that the collection names."""
    for table in ("history.csv", "probes.csv"):
        path = os.path.join(directory, table)
        if os.path.exists(path):
            with open(path) as file:
                lines = file.read()
            assert lines.endswith("\n"), f"{path} ends in the middle of a row"
            columns = {line.count(",") for line in lines.splitlines()}
            assert len(columns) == 1, f"{path} has rows of several lengths"
    collection = os.path.join(directory, "frames.pvd")
    if os.path.exists(collection):
        with open(collection) as file:
            text = file.read()
        assert text.endswith("</VTKFile>\n"), f"{collection} is cut off"
        for name in re.findall(r'file="([^"]*)"', text):
            frame = os.path.join(directory, name)
            with open(frame, "rb") as file:
                assert file.read().rstrip().endswith(b"</VTKFile>"), f"{frame} is cut off"


class Runs:
    def __init__(self, program, folder, threads):
        self.program, self.folder, self.threads = program, folder, threads

    def start(self, scene, out, *options):
        command = [self.program, "run", scene, "--out", out, "--quiet", *options]
        if self.threads:
            command += ["--threads", str(self.threads)]
        return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)

    def compare(self, name, one, other):
        a, b = results_of(one), results_of(other)
        differing = sorted(k for k in a.keys() | b.keys() if a.get(k) != b.get(k))
        assert not differing, f"{name}: these results differ: {', '.join(differing[:10])}"

    def kill_and_resume(self, name, text, kills, generator):
        """Returns the number of kills, and of runs that were resumed to their end."""
        scene = os.path.join(self.folder, name + ".toml")
        with open(scene, "w") as file:
            file.write(text)
        whole = os.path.join(self.folder, name + "-whole")
        begin = time.monotonic()
        run = self.start(scene, whole)
        errors = run.communicate()[1].decode()
        seconds = time.monotonic() - begin
        assert run.returncode == 0, f"{name}: {errors}"
        made = completed = cut = 0
        while made < kills:
            out = os.path.join(self.folder, f"{name}-killed-{completed}")
            options = []
            while True:
                run = self.start(scene, out, *options)
                # The last parts of a run are short: the later, the more often it is let go.
                limit = generator.uniform(0.0, 1.1 * seconds) if made < kills else None
                try:
                    errors = run.communicate(timeout=limit)[1].decode()
                except subprocess.TimeoutExpired:
                    run.send_signal(signal.SIGKILL)
                    run.communicate()
                    made += 1
                    cut += os.path.isdir(os.path.join(out, "checkpoints"))
                    check_what_is_left(out)
                    options = ["--resume"]
                    continue
                assert run.returncode == 0, f"{name}: exit code {run.returncode}: {errors}"
                break
            self.compare(name, whole, out)
            completed += 1
            shutil.rmtree(out)
        shutil.rmtree(whole)
        return made, completed, cut


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("--kills", type=int, default=10)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--ways", default="", help="names, separated by commas; default: all")
    parser.add_argument("--threads", type=int, default=0)
    arguments = parser.parse_args()
    all_ways = ways()
    names = arguments.ways.split(",") if arguments.ways else list(all_ways)
    generator = random.Random(arguments.seed)
    folder = tempfile.mkdtemp(prefix="tetraction-kills-")
    runs = Runs(os.path.abspath(arguments.program), folder, arguments.threads)
    total = completed = cut = 0
    try:
        for i, name in enumerate(names):
            share = arguments.kills * (i + 1) // len(names) - arguments.kills * i // len(names)
            if share == 0:
                continue
            result = runs.kill_and_resume(name, all_ways[name], share, generator)
            total, completed, cut = (a + b for a, b in zip((total, completed, cut), result))
            print(f"{name}: {result[0]} kills, {result[1]} runs compared", flush=True)
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    print(f"{total} kills, {cut} of them after a checkpoint; {completed} runs compared, all the same")
    return 0 if total >= arguments.kills else 1


if __name__ == "__main__":
    sys.exit(main())
