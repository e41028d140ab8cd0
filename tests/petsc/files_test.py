"""Files and checkpoints of several processes, and their memory."""

import os
import signal
import sys
import time
import xml.etree.ElementTree as ElementTree

sys.path.insert(0, f"{sys.path[0]}/..")
from support.parallel import BODY, LOADS, OUTPUT, PROBES, ParallelTest, points_of, time_of
from support.program import main


class Files(ParallelTest):
    def test_frames_in_pieces(self):
        scene = self.write("scene.toml", BODY + LOADS + time_of("verlet", 2e-4, 40) + OUTPUT)
        out, _ = self.run_scene(scene, 3)
        collection = ElementTree.parse(os.path.join(out, "frames.pvd"))
        files = [entry.get("file") for entry in collection.iter("DataSet")]
        self.assertEqual(files, [f"frames/frame_{step:06}.pvtu" for step in (0, 20, 40)])
        for file in files:
            tree = ElementTree.parse(os.path.join(out, file))
            self.assertEqual(tree.find("PUnstructuredGrid").get("GhostLevel"), "0")
            pieces = [piece.get("Source") for piece in tree.iter("Piece")]
            self.assertEqual(len(pieces), 3)
            for piece in pieces:
                self.assertTrue(self.exists(out, "frames", piece))
        # A later run in one process leaves nothing of them.
        self.run_scene(scene, None, out=out)
        left = sorted(os.listdir(os.path.join(out, "frames")))
        self.assertEqual(left, [f"frame_{step:06}.vtu" for step in (0, 20, 40)])
        self.assertNotIn("final.pvtu", os.listdir(out))

    def test_nodal_averages_do_not_depend_on_the_parts(self):
        scene = self.write("scene.toml", BODY + LOADS + time_of("verlet", 2e-4, 40) + OUTPUT)
        serial, _ = self.run_scene(scene)
        expected, _ = points_of(self.path(serial, "final.vtu"), "cauchy_stress_nodal")
        size = max(max(abs(x) for x in values[0]) for values in expected.values())
        out, _ = self.run_scene(scene, 4)
        found, _ = points_of(self.path(out, "final.pvtu"), "cauchy_stress_nodal")
        for vertex, copies in found.items():
            for copy in copies:
                for a, b in zip(copy, expected[vertex][0]):
                    self.assertLessEqual(abs(a - b), 1e-10 * size)


class Memory(ParallelTest):
    """Peaks of the process with the most, less those of a mesh of six tetrahedra."""

    SCENE = """
[mesh]
%s
[material]
model = "neo-hookean"
youngs_modulus = 1e6
poissons_ratio = 0.3
density = 1000
[time]
integrator = "verlet"
step = 1e-5
end = 2e-5
"""
    CELLS = [96, 24, 24]  # 331,776 tetrahedra

    def peak(self, mesh, processes):
        scene = self.write("scene.toml", self.SCENE % mesh)
        out, _ = self.run_scene(scene, processes, "--threads", "1")
        return self.summary(out)["peak_memory_bytes"]

    def beam(self, cells):
        return f'generate = {{ kind = "beam", size = [4, 1, 1], cells = {cells} }}'

    def need(self, mesh, processes):
        return self.peak(mesh, processes) - self.peak(self.beam([1, 1, 2]), processes)

    def test_no_process_needs_more_than_its_share(self):
        mesh = self.beam(self.CELLS)
        whole = self.need(mesh, None)
        self.assertLessEqual(self.need(mesh, 2), 0.55 * whole)
        # The mesh itself, which the first process has made, is an eighth of the whole run.
        self.assertLessEqual(self.need(mesh, 8), 0.25 * whole)

    def test_reading_needs_less_than_half_of_the_run(self):
        cells = ",".join(str(n) for n in self.CELLS)
        for ending in ("msh", "vtu", "veg"):
            with self.subTest(ending=ending):
                file = self.path("beam." + ending)
                self.run_program("mesh generate beam", file, "--cells", cells)
                whole = self.need(f'file = "{file}"', None)
                self.assertLessEqual(self.need(f'file = "{file}"', 2), 0.6 * whole)


class Checkpoints(ParallelTest):
    """Runs that lose their end go on from the checkpoint after step 30 of 40."""

    def scene(self, rule):
        step = {"verlet": 2e-4, "midpoint": 2e-3}[rule]
        events = "[[event]]\nat = %g\nfix = { select = { plane = { axis = \"x\", at = 0.4 } } }\n" % (12.5 * step)
        return self.write(f"{rule}.toml", BODY + LOADS + PROBES + time_of(rule, step, 40) +
                          OUTPUT.replace("every = 20", "every = 20\ncheckpoint_every = 15") + events)

    def lose_end(self, out):
        os.remove(os.path.join(out, "summary.json"))

    def contents(self, out):
        """What must be the same in a run that was not stopped."""
        names = ["history.csv", "probes.csv", "frames.pvd", "final.pvtu"]
        names += [os.path.join("frames", name) for name in sorted(os.listdir(os.path.join(out, "frames")))]
        return {name: self.read_bytes(out, name) for name in names}

    def test_same_bits(self):
        for rule, extra in (("verlet", []), ("verlet", ["--set", 'time.step="auto"']), ("midpoint", [])):
            with self.subTest(rule=rule, extra=extra):
                out = self.path("same-" + rule + str(len(extra)))
                scene = self.scene(rule)
                self.run_scene(scene, 3, *extra, out=out)
                whole = self.contents(out)
                checkpoints = sorted(os.listdir(os.path.join(out, "checkpoints")))
                self.lose_end(out)
                _, done = self.run_scene(scene, 3, *extra, "--resume", out=out)
                self.assertIn("the run goes on after step", done.stderr)
                again = self.contents(out)
                self.assertEqual(again.keys(), whole.keys())
                self.assertEqual([name for name in whole if again[name] != whole[name]], [])
                self.assertEqual(sorted(os.listdir(os.path.join(out, "checkpoints"))), checkpoints)

    def test_any_number_of_processes(self):
        for rule, tolerance in (("verlet", 1e-12), ("midpoint", 1e-7)):
            scene = self.scene(rule)
            serial, _ = self.run_scene(scene, out=self.path("serial-" + rule))
            for before, after in ((3, 2), (2, 4), (3, 1), (3, None), (None, 3)):
                with self.subTest(rule=rule, before=before, after=after):
                    out = self.path(f"{rule}-{before}-{after}")
                    self.run_scene(scene, before, out=out)
                    self.lose_end(out)
                    _, done = self.run_scene(scene, after, "--resume", out=out)
                    self.assertIn("the run goes on after step 30", done.stderr)
                    self.assertIn("last digits may differ", done.stderr)
                    for name in ("history.csv", "probes.csv"):
                        self.assert_like(serial, out, tolerance, name)
                    self.assertEqual(self.summary(out)["status"], "ok")
                    self.assert_files_belong_together(out, "final.vtu" if after is None else "final.pvtu")
                    _, done = self.run_scene(scene, after, "--resume", out=out)
                    self.assertIn("complete already", done.stderr)

    def assert_files_belong_together(self, out, final):
        """All frames can be read, and no file is there that none of them names."""
        named = set()
        frames = [part.split('"')[0] for part in self.read(out, "frames.pvd").split('file="')[1:]]
        self.assertEqual(len(frames), 3)
        for name in frames + [final]:
            path = os.path.join(out, name)
            points_of(path, "displacement")
            named.add(os.path.basename(path))
            if name.endswith(".pvtu"):
                named |= {os.path.basename(part.split('"')[0])
                          for part in self.read(path).split('Source="')[1:]}
        named.discard(final)
        self.assertEqual(named, set(os.listdir(os.path.join(out, "frames"))))
        self.assertEqual([name for name in ("final.vtu", "final.pvtu") if self.exists(out, name)],
                         [final])

    def test_same_file_as_in_one_process(self):
        # But for the number of processes, times of the clock and last digits, which have a fixed place.
        sizes = set()
        for processes in (None, 1, 3):
            out, _ = self.run_scene(self.scene("verlet"), processes)
            sizes.add(os.path.getsize(os.path.join(out, "checkpoints", "step_000000030.ckpt")))
        self.assertEqual(len(sizes), 1)

    def test_a_stopped_run_goes_on(self):
        scene = self.write("long.toml", BODY + LOADS + time_of("verlet", 1e-4, 100000) + OUTPUT)
        out = self.path("stopped")
        run = self.begin_run(scene, 2, lambda: self.exists(out, "frames.pvd"), "stopped")
        time.sleep(0.5)
        run.send_signal(signal.SIGTERM)
        run.communicate(timeout=60)
        steps = self.summary(out)["steps"]
        self.assertGreater(steps, 0)
        last = ["--set", f"time.end={1e-4 * (steps + 3)}", "--force"]
        _, done = self.run_scene(scene, 3, "--resume", *last, out=out)
        self.assertIn(f"the run goes on after step {steps} ", done.stderr)
        self.assertEqual(self.summary(out)["steps"], steps + 3)

    def test_errors_have_one_message(self):
        scene = self.scene("verlet")
        out, _ = self.run_scene(scene, 2)
        self.lose_end(out)
        self.assert_refused(2, scene, 2, "its inputs have changed since: damping",
                            "--resume", "--set", "damping.viscosity=3.0")
        history = os.path.join(out, "history.csv")
        kept = self.read(history)
        self.write(history, kept.replace("0.0002", "0.0003", 1))
        self.assert_refused(3, scene, 2, "its rows have changed since the checkpoint", "--resume")
        self.write(history, kept)
        piece = os.path.join(out, "frames", "frame_000020_0001.vtu")
        os.rename(piece, piece + ".away")
        self.assert_refused(3, scene, 2, "it is missing", "--resume")
        os.rename(piece + ".away", piece)
        os.truncate(self.path(out, "checkpoints", "step_000000030.ckpt"), 1000)
        _, done = self.run_scene(scene, 2, "--resume")
        self.assertIn("it is cut off", done.stderr)
        self.assertIn("the run goes on after step 15", done.stderr)


if __name__ == "__main__":
    main(3)
