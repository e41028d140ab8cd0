"""run --resume: what goes on, what is refused, and what is said."""

import glob
import json
import os
import random
import re
import shutil
import signal
import sys
import time
import zlib

sys.path.insert(0, f"{sys.path[0]}/..")
from kill_and_resume import Runs, results_of, ways
from support.program import PROGRAM, BEAM_MESH, ProgramTest, main, sets

SCENE = """
[mesh]
{mesh}
[material]
youngs_modulus = 1.0e6
poissons_ratio = 0.4
[time]
integrator = "{rule}"
step = {step}
end = {end}
[environment]
kind = "gravity"
[[fix]]
select = {{ plane = {{ axis = "x", at = 0.0 }} }}
[[event]]
at = {event}
set = {{ "environment.strength" = 5.0 }}
[[probe]]
name = "tip"
select = {{ nearest = [4, 1, 1] }}
quantity = "displacement"
[output]
every = {every}
checkpoint_every = {checkpoint_every}
"""

OBSTACLE = """
[[obstacle]]
name = "floor"
kind = "plane"
point = [0.0, -1.0, 0.0]
normal = [0.0, 1.0, 0.0]
velocity = [0.0, -1.0, 0.0]
from = 0.2
"""


class ResumeTest(ProgramTest):
    def scene(self, checkpoint_every=50, steps=3000, step=2.0e-4, rule="verlet", mesh=None):
        mesh = mesh or BEAM_MESH
        text = SCENE.format(
            mesh=mesh, rule=rule, step=step, end=steps * step, event=0.02 * steps * step,
            every=steps // 10, checkpoint_every=checkpoint_every,
        )  # fmt: skip
        return self.write("scene.toml", text)

    def checkpoints(self, out="out"):
        return sorted(glob.glob(self.path(out, "checkpoints", "*.ckpt")))

    def stop(self, scene, number, when, out="out"):
        """Starts a run and sends it a signal once `when` returns true."""
        run = self.start(f"run {scene} --out {out} --quiet")
        deadline = time.monotonic() + 120.0
        while not when() and run.poll() is None and time.monotonic() < deadline:
            time.sleep(0.001)
        run.send_signal(number)
        errors = run.communicate()[1]
        self.assertIn(run.returncode, (-number, 130, 143), errors)

    def kill(self, scene, out="out"):
        """Kills a run that has two checkpoints, the newer of which comes after the event."""
        self.stop(scene, signal.SIGKILL,
                  lambda: len(self.checkpoints(out)) >= 2 and "step_000000050" not in
                  self.checkpoints(out)[0], out)  # fmt: skip

    def resume(self, scene, *options, code=0):
        return self.run_program(f"run {scene} --out out --resume", *options, code=code)

    def assert_like_one_run(self, scene):
        if not self.exists("whole"):
            self.run_program(f"run {scene} --out whole --quiet")
        a, b = results_of(self.path("whole")), results_of(self.path("out"))
        self.assertEqual(sorted(k for k in a.keys() | b.keys() if a.get(k) != b.get(k)), [])


class Resuming(ResumeTest):
    def test_a_killed_run_goes_on(self):
        scene = self.scene()
        self.kill(scene)
        self.assertIn("out: the run goes on after step ", self.resume(scene).stderr)
        self.assert_like_one_run(scene)

    def test_the_frames_of_obstacles_go_on(self):
        """A floor that sinks from 0.2 s on: some frames share a file, others have their own."""
        scene = self.write("scene.toml", self.read(self.scene()) + OBSTACLE)
        self.kill(scene)
        self.resume(scene)
        self.assert_like_one_run(scene)
        files = re.findall('part="1" file="frames/(.*)"', self.read("out", "frames.pvd"))
        self.assertEqual(len(files), 11)
        self.assertEqual(files[:4], ["obstacles_000000.vtu"] * 4)
        self.assertEqual(len(set(files)), 8)

    def test_a_damaged_checkpoint_is_reported_and_the_one_before_it_is_used(self):
        scene = self.scene()
        self.kill(scene)
        older, newest = self.checkpoints()[-2:]  # for a moment after each there are three
        os.truncate(newest, os.path.getsize(newest) - 1000)
        result = self.resume(scene)
        self.assertIn(os.path.basename(newest) + ": not a valid checkpoint (it is cut off)",
                      result.stderr)  # fmt: skip
        step = int(os.path.basename(older)[5:14])
        self.assertIn(f"the run goes on after step {step} ", result.stderr)
        self.assert_like_one_run(scene)

    def test_without_a_valid_checkpoint_it_starts_from_the_beginning(self):
        scene = self.scene()
        self.kill(scene)
        checkpoints = self.checkpoints()
        for path in checkpoints:
            with open(path, "r+b") as file:
                file.seek(200)
                file.write(b"damaged")
        result = self.resume(scene)
        self.assertEqual(result.stderr.count("its check sum is wrong"), len(checkpoints),
                         result.stderr)  # fmt: skip
        self.assertIn("The run starts from the beginning.", result.stderr)
        self.assert_like_one_run(scene)

    def test_a_missing_or_empty_directory_is_a_new_run(self):
        scene = self.scene(steps=200)
        self.assertIn("starts from the beginning", self.resume(scene).stderr)
        shutil.rmtree(self.path("out"))
        os.mkdir(self.path("out"))
        self.assertIn("starts from the beginning", self.resume(scene).stderr)
        self.assert_like_one_run(scene)

    def test_an_interrupted_run_without_checkpoint_every_goes_on(self):
        scene = self.scene(checkpoint_every=0)
        rows = self.path("out", "history.csv")
        self.stop(scene, signal.SIGINT,
                  lambda: os.path.exists(rows) and os.path.getsize(rows) > 200000)  # fmt: skip
        (path,) = self.checkpoints()
        self.assertTrue(os.path.basename(path).startswith("stop_"), path)
        self.assertTrue(self.exists("out", "final.vtu"))
        self.assertIn("made when the run was stopped", self.resume(scene).stderr)
        self.assert_like_one_run(scene)  # the rule is explicit

    def test_with_checkpoint_every_the_checkpoint_of_an_interruption_is_not_used(self):
        scene = self.scene(rule="midpoint", step=2.0e-3, steps=200, checkpoint_every=7)
        self.stop(scene, signal.SIGTERM, lambda: len(self.checkpoints()) == 2)
        names = [os.path.basename(path) for path in self.checkpoints()]
        if len(names) == 3:  # otherwise it was interrupted after a step of a regular one
            self.assertTrue(names[2].startswith("stop_"), names)
        step = int(names[1][5:14])
        self.assertIn(f"goes on after step {step} ", self.resume(scene).stderr)
        self.assert_like_one_run(scene)

    def test_an_interruption_before_the_first_checkpoint_is_told(self):
        scene = self.scene(checkpoint_every=10**8)
        rows = self.path("out", "history.csv")
        self.stop(scene, signal.SIGINT,
                  lambda: os.path.exists(rows) and os.path.getsize(rows) > 200000)  # fmt: skip
        (path,) = self.checkpoints()
        step = int(os.path.basename(path)[5:14])
        self.assertIn(f"stopped after step {step}, before the first checkpoint", self.resume(scene).stderr)
        self.assert_like_one_run(scene)

    def test_a_complete_run_says_so_and_nothing_changes(self):
        scene = self.scene(steps=200)
        self.run_program(f"run {scene} --out out --quiet")
        before = results_of(self.path("out"))
        times = {p: os.stat(p).st_mtime_ns for p in glob.glob(self.path("out", "*"))}
        result = self.resume(scene, "--json")
        self.assertIn("this run is complete already, with 200 steps", result.stderr)
        self.assertEqual(json.loads(result.stdout)["steps"], 200)
        self.assertEqual(results_of(self.path("out")), before)
        self.assertEqual({p: os.stat(p).st_mtime_ns for p in times}, times)
        self.refused(2, "run", scene, "--out", "out", "--resume", "--set",
                                   "material.youngs_modulus=2e6", says="have changed since: material.youngs_modulus.")  # fmt: skip

    def test_a_summary_that_anybody_may_have_written(self):
        scene = self.scene(steps=200)
        self.run_program(f"run {scene} --out out --quiet")
        path = self.path("out", "summary.json")
        whole = self.read_json(path)
        nested = "[" * 200000 + "]" * 200000
        texts = [nested, '{"status": "ok", "scene": ' + nested + "}", "{", "\x00", "[]", "3",
                 json.dumps({"status": "ok"})]  # fmt: skip
        # A summary without the number of its steps or without its time is none of a complete run.
        texts += [json.dumps({**whole, key: value}) for key in ("steps", "time")
                  for value in (1e300, -1, "x", None, [], {}) if (key, value) != ("time", 1e300)]  # fmt: skip
        texts += [json.dumps({**whole, key: value}) for key in ("status", "equilibrium")
                  for value in (1e300, "x", None, [], {})]  # fmt: skip
        for text in texts:
            with self.subTest(text[:60]):
                self.write(path, text)
                result = self.resume(scene, code=(0, 2))
                self.assertNotIn("unexpected", result.stderr)
                self.assertNotIn("complete already", result.stderr)
        for key, value in (("scene", 3), ("scene", None), ("mesh", "x"), ("mesh", {"vertices": []})):
            with self.subTest(key, value=value):
                self.write(path, json.dumps({**whole, key: value}))
                self.refused(2, f"run {scene} --out out --resume", says="have changed since")

    def test_a_forged_checkpoint_with_a_deep_scene(self):
        scene = self.scene()
        self.kill(scene)
        newest = self.checkpoints()[-1]
        content = self.read_bytes(newest)
        # The texts begin after their lengths. The scene is the longest.
        lengths = {found.start(): int.from_bytes(content[found.start() - 8 : found.start()], "little")
                   for found in re.finditer(rb'\{\s*"', content)}  # fmt: skip
        place = max((start for start in lengths if lengths[start] < len(content)), key=lengths.get)
        length = lengths[place]
        self.assertEqual(content[place + length - 1 : place + length], b"}")
        for text in (b'{"event":' + b"[" * 200000 + b"]" * 200000 + b"}", b'{"event":{"a":1}}', b"{}"):
            with self.subTest(text[:20]):
                forged = (content[: place - 8] + len(text).to_bytes(8, "little") + text
                          + content[place + length : -8])  # fmt: skip
                size = forged.index(b"\n") + 1 + 8  # after the name, the format and the byte order
                forged = (forged[:size] + (len(forged) - size - 8).to_bytes(8, "little")
                          + forged[size + 8 :])  # fmt: skip
                forged += zlib.crc32(forged).to_bytes(8, "little")
                self.write(newest, forged)
                for force in ([], ["--force"]):
                    message = self.refused(2, f"run {scene} --out out --resume", *force)
                    self.assertIn("the run cannot go on, because its inputs have changed", message)

    def test_results_of_an_equilibrium_are_refused(self):
        scene = self.scene(steps=200)
        self.run_program(f"static {scene} --out out --quiet")
        before = results_of(self.path("out"))
        resume = ("run", scene, "--out", "out", "--resume")
        self.assertIn("results of tetraction static", self.refused(2, *resume))
        # One that was cut off has no summary.
        os.remove(self.path("out", "summary.json"))
        self.assertIn("results of tetraction static", self.refused(2, *resume))
        before.pop("summary.json", None)
        self.assertEqual(results_of(self.path("out")), before)
        self.run_program(f"run {scene} --out out --quiet")
        self.assertIn("this run is complete already", self.resume(scene).stderr)

    def test_a_new_run_replaces_the_checkpoints_of_an_earlier_one(self):
        scene = self.scene()
        self.kill(scene)
        self.run_program("run", scene, "--out", "out", "--quiet", "--set", "time.end=0.01", "--set",
                         "output.checkpoint_every=0")  # fmt: skip
        self.assertEqual(self.checkpoints(), [])
        self.assertFalse(self.exists("out", "checkpoints"))


class Changes(ResumeTest):
    def test_a_changed_scene_is_refused_unless_forced(self):
        scene = self.scene()
        self.kill(scene)
        change = ["--set", "environment.direction=[0, 0, -1]"]
        before = results_of(self.path("out"))
        message = self.refused(2, f"run {scene} --out out --resume", *change)
        self.assertIn("have changed since: environment.direction. Undo", message)
        self.assertEqual(results_of(self.path("out")), before)
        result = self.resume(scene, "--force", *change)
        self.assertIn("goes on with changed inputs: environment.direction", result.stderr)
        tip = self.history("out", "probes.csv")[-1]
        self.assertLess(float(tip["tip_z"]), -1e-3)

    def test_what_the_state_refers_to_cannot_be_forced(self):
        scene = self.scene()
        self.kill(scene)
        for change in ("fix.0.select={ plane = { axis = \"x\", at = 4.0 } }", "event.0.at=1e-3"):
            self.refused(2, "run", scene, "--out", "out", "--resume", "--force", "--set", change,
                         says="--force does not help here")

    def test_a_later_end_can_be_forced(self):
        scene = self.scene(steps=500)
        self.run_program(f"run {scene} --out out --quiet")
        longer = ["--set", "time.end=0.2"]
        self.assertIn("time.end", self.refused(2, f"run {scene} --out out --resume", *longer))
        self.resume(scene, "--force", *longer)
        last = self.history("out", "history.csv")[-1]
        self.assertEqual((int(last["step"]), float(last["time"])), (1000, 0.2))
        self.run_program(f"run {scene} --out whole --quiet", *longer)
        whole = self.history("whole", "history.csv")[-1]
        self.assertAlmostEqual(float(last["lx"]), float(whole["lx"]), delta=1e-9)

    def test_output_may_change(self):
        scene = self.scene()
        self.kill(scene)
        self.resume(scene, *sets("output.every=1000", "output.history_every=10"))
        self.assertTrue(self.exists("out", "frames", "frame_002000.vtu"))

    def test_a_changed_mesh_is_refused(self):
        self.run_program("mesh generate beam part.vtu --size 4,1,1 --cells 8,2,2")
        scene = self.scene(mesh='file = "part.vtu"')
        self.kill(scene)
        os.remove(self.path("part.vtu"))
        self.run_program("mesh generate beam part.vtu --size 4.001,1,1 --cells 8,2,2")
        self.refused(2, f"run {scene} --out out --resume", says="have changed since: the mesh.")

    def test_changed_results_are_refused(self):
        scene = self.scene()
        self.kill(scene)
        os.truncate(self.path("out", "history.csv"), 3000)
        message = self.refused(3, f"run {scene} --out out --resume")
        self.assertIn("history.csv: it has fewer rows than at the checkpoint", message)
        for path in glob.glob(self.path("out", "checkpoints", "*")):
            # The run may have been killed while it wrote a checkpoint.
            self.assertTrue(path.endswith((".ckpt", ".part")), path)

    def test_a_changed_byte_of_a_table_is_refused(self):
        scene = self.scene()
        self.kill(scene)
        for name in ("history.csv", "probes.csv"):
            path = self.path("out", name)
            with open(path, "r+b") as file:
                whole = file.read()
                place = whole.index(b"\n", len(whole) // 9) - 1  # the last digit of a row
                file.seek(place)
                file.write(b"1" if whole[place : place + 1] != b"1" else b"2")
            message = self.refused(3, f"run {scene} --out out --resume")
            self.assertIn(f"{name}: its rows have changed since the checkpoint", message)
            self.write(path, whole)
        self.resume(scene)
        self.assert_like_one_run(scene)

    def test_a_shortened_frame_is_refused(self):
        scene = self.scene()
        self.kill(scene)
        path = self.path("out", "frames", "frame_000000.vtu")
        os.truncate(path, os.path.getsize(path) // 2)
        message = self.refused(3, f"run {scene} --out out --resume")
        self.assertIn("frame_000000.vtu: it has another size than at the checkpoint", message)

    def test_a_folder_with_the_name_of_a_checkpoint_is_left_alone(self):
        scene = self.scene()
        self.kill(scene)
        newest = self.checkpoints()[-1]
        os.remove(newest)
        os.mkdir(newest)
        self.assertIn("it is no file", self.resume(scene).stderr)
        self.assertTrue(os.path.isdir(newest))
        os.rmdir(newest)
        self.assert_like_one_run(scene)

    def test_a_checkpoint_of_any_size_is_reported(self):
        scene = self.scene()
        self.kill(scene)
        os.truncate(self.checkpoints()[-1], 1 << 40)  # a sparse file
        self.assertIn("its size is wrong", self.resume(scene).stderr)
        self.assert_like_one_run(scene)

    def test_force_needs_resume(self):
        self.assertIn("--resume", self.refused(2, "run", self.scene(), "--force"))


class Kills(ResumeTest):
    """A few; kill_and_resume.py makes as many as one likes."""

    def test_killed_runs_have_the_same_bits_as_one_run(self):
        generator = random.Random(16)
        runs = Runs(PROGRAM, self.folder, 0)
        all_ways = ways()
        for name in ("verlet-distance", "midpoint-auto", "midpoint-error", "energy-momentum-auto",
                     "backward-euler-factor"):  # fmt: skip
            made, completed, _ = runs.kill_and_resume(name, all_ways[name], 2, generator)
            self.assertGreaterEqual(made, 2)
            self.assertGreaterEqual(completed, 1)

    def test_hard_links_keep_what_they_had(self):
        scene = self.scene(steps=100)
        out, copy = self.path("out"), self.path("copy")
        self.run_program(f"run {scene} --out {out} --quiet")
        shutil.copytree(out, copy, copy_function=os.link)

        def contents(folder):
            texts = []
            for name in ("history.csv", "probes.csv"):
                texts.append(self.read(os.path.join(folder, name)))
            return texts

        before = contents(copy)
        self.run_program(f"run {scene} --out {out} --quiet --resume --force --set time.end=0.04")
        self.assertEqual(contents(copy), before)
        for old, longer in zip(before, contents(out)):
            self.assertGreater(len(longer), len(old))


if __name__ == "__main__":
    main()
