"""Probes and frames of studies."""

import glob
import json
import math
import os
import shutil
import signal
import sys
import time

sys.path.insert(0, f"{sys.path[0]}/..")
from support.program import BEAM, main
from support.study import PROBES, StudyTest


class Probes(StudyTest):
    GRID = ("--integrators", "midpoint,verlet", "--steps", "2.5e-3,5e-3", "--out", "s",
            "--reference-step", "2.5e-4")  # fmt: skip

    def trace(self, run, columns):
        rows = [r for r in self.table("s", run, "probes.csv") if r[columns[0]] != ""]
        return [(float(r["time"]), [float(r[c]) for c in columns]) for r in rows]

    def expected_error(self, run, columns):
        """The largest distance from the reference, which is interpolated linearly."""
        reference = self.trace("midpoint-0.00025", columns)
        largest = max(math.hypot(*values) for _, values in reference)
        worst = 0.0
        for time_, values in self.trace(run, columns):
            right = next((i for i, r in enumerate(reference) if r[0] >= time_), len(reference) - 1)
            (t0, low), (t1, high) = reference[max(0, right - 1)], reference[right]
            share = (time_ - t0) / (t1 - t0) if t1 > t0 else 0.0
            at = [(1 - share) * a + share * b for a, b in zip(low, high)]
            worst = max(worst, math.hypot(*(a - b for a, b in zip(values, at))))
        return worst / largest

    def test_a_probe_can_be_the_error(self):
        scene = self.write("probes.toml", PROBES)
        self.run_program(f"study {scene}", *self.GRID, "--no-plots")
        by_position = self.rows()
        self.assertTrue(all(row["probe_error"] == "" for row in by_position))
        for name, columns in (("tip", ["tip_x", "tip_y", "tip_z"]), ("stress", ["stress"])):
            result = self.run_program("study", scene, *self.GRID, "--no-plots", "--all", "--error",
                                      f"probe.{name}")  # fmt: skip
            self.assertIn("probe.err", result.stdout)
            # What the error is does not change the runs.
            self.assertIn("no run was made", result.stderr)
            rows = self.rows()
            self.assertEqual([r["role"] for r in rows].count("run"), 4)
            self.assertEqual(len(rows), 5)
            for row, other in zip(rows, by_position):
                if row["role"] == "reference":
                    self.assertEqual(float(row["probe_error"]), 0.0)
                    continue
                self.assertEqual(row["position_error"], other["position_error"])
                run = f"{row['integrator']}-{float(row['step']):.10g}"
                expected = self.expected_error(run, columns)
                self.assertGreater(expected, 1e-6)
                self.assertAlmostEqual(float(row["probe_error"]) / expected, 1.0, places=6)
            study = self.read_json("s", "study.json")
            self.assertEqual(study["error"], f"probe.{name}")
            self.assertEqual(study["probes"][0]["columns"], ["tip_x", "tip_y", "tip_z"])
            if name == "tip":
                # Of these steps 2.5e-3 s and 5e-3 s the orders are those of the probe's errors.
                e = {(r["integrator"], float(r["step"])): float(r["probe_error"]) for r in rows}
                order = float(next(r for r in rows if r["integrator"] == "verlet"
                                   and float(r["step"]) == 5e-3)["observed_order"])  # fmt: skip
                ratio = e["verlet", 5e-3] / e["verlet", 2.5e-3]
                self.assertAlmostEqual(order, math.log2(ratio), places=6)

    def test_probes_are_drawn(self):
        scene = self.write("probes.toml", PROBES)
        self.run_program(f"study {scene}", *self.GRID, "--error", "probe.tip")
        plots = ("probe_tip", "probe_stress", "error_over_step")
        for name in plots:
            for ending in ("png", "svg"):
                self.assertGreater(os.path.getsize(self.path("s", f"{name}.{ending}")), 3000)
        text = self.read("s", "probe_tip.svg")
        for component in "xyz":
            self.assertRegex(text, rf"tip_{component} \([mµn]?m\)")
        self.assert_parts(text, ("midpoint", "Verlet"))
        self.assertIn("relative error of the probe tip", self.read("s", "error_over_step.svg"))
        # The next study, without probes, deletes the plots and the files of the probes.
        self.write("s/probe_other.png", "mine")
        self.run_program("study", self.write("probes.toml", BEAM), *self.GRID)
        self.assertFalse(self.exists("s", "probe_tip.png"))
        self.assertTrue(self.exists("s", "probe_other.png"))
        self.assertFalse(self.exists("s", "verlet-0.005", "probes.csv"))

    def test_probes_that_are_not_there(self):
        scene = self.write("probes.toml", PROBES)
        study = ["study", scene, "--out", "s", "--no-plots"]
        self.assertIn("did you mean tip?", self.refused(2, *study, "--error", "probe.tipp"))
        self.assertIn("probe.NAME", self.refused(2, *study, "--error", "tip"))
        bare = self.write("beam.toml", BEAM)
        self.refused(2, "study", bare, "--out", "s", "--error", "probe.tip", says="[[probe]]")
        self.assertFalse(self.exists("s"))


class RunWithProbes(StudyTest):
    def test_a_run_writes_probes(self):
        scene = self.write("probes.toml", PROBES)
        self.assertIn("r/probes.csv", self.run_program(f"run {scene} --out r").stdout)
        rows = self.table("r", "probes.csv")
        self.assertEqual(list(rows[0]), ["step", "time", "tip_x", "tip_y", "tip_z", "stress"])
        self.assertEqual(len(rows), 11)
        self.assertEqual([r["stress"] != "" for r in rows], [i % 2 == 0 for i in range(11)])
        summary = self.read_json("r", "summary.json")
        self.assertEqual(summary["probes"]["tip_y"]["final"], float(rows[-1]["tip_y"]))
        self.assertEqual(summary["scene"]["probe"][1]["quantity"], "von_mises")
        self.assertGreater(summary["wall_seconds"]["mesh"], 0.0)
        as_json = self.run_program(f"run {scene} --out r --json").stdout
        self.assertIn("tip_y", json.loads(as_json)["probes"])
        # A run without probes does not leave those of an earlier one.
        self.run_program("run", self.write("beam.toml", BEAM), "--out", "r")
        self.assertFalse(self.exists("r", "probes.csv"))

    def test_probes_at_wrong_places(self):
        for command in ("run", "check", "study"):
            for keys, part in (
                ("point = [9.0, 0.5, 0.5]", "5 m from the nearest element"),
                ('select = { plane = { axis = "x", at = 9.0 } }', "selects no vertex"),
            ):
                scene = self.write("wrong.toml", BEAM + '[[probe]]\nname = "a"\n'
                                   f'quantity = "position"\n{keys}\n')  # fmt: skip
                out = () if command == "check" else ("--out", "w")
                self.refused(2, command, scene, *out, says=(part, "wrong.toml:19:1: probe.0"))
                self.assertFalse(self.exists("w", "study.json"))


class Frames(StudyTest):
    GRID = ("--integrators", "verlet,midpoint", "--steps", "5e-3,2.5e-2")
    ALL = {"verlet-0.005", "verlet-0.025", "midpoint-0.005", "midpoint-0.025"}

    def with_frames(self, *arguments):
        result = self.study(*self.GRID, *arguments)
        runs = self.runs()
        self.assertEqual(set(runs), self.ALL)
        return {name for name, has_frames in runs.items() if has_frames}, result.stdout

    def test_of_the_run_that_the_last_line_names(self):
        """It is the scene's integrator, at the step nearest to the scene's 0.01 s as a ratio."""
        frames, text = self.with_frames()
        self.assertEqual(frames, {"midpoint-0.005"})
        self.assertIn("s/midpoint-0.005/frames.pvd", text.splitlines()[-1])
        frames, text = self.with_frames("--fresh", "--set", "time.step=0.02", "--set",
                                        "time.integrator=verlet")  # fmt: skip
        self.assertEqual(frames, {"verlet-0.025"})
        self.assertIn("s/verlet-0.025/frames.pvd", text.splitlines()[-1])

    def test_that_are_asked_for(self):
        frames, text = self.with_frames("--frames", "all")
        self.assertEqual(frames, self.ALL)
        self.assertIn("s/midpoint-0.005/frames.pvd", text.splitlines()[-1])
        # Runs that are kept keep their frames.
        self.assertEqual(self.with_frames("--frames", "none")[0], self.ALL)
        frames, text = self.with_frames("--frames", "none", "--fresh")
        self.assertEqual(frames, set())
        self.assertNotIn("frames.pvd", text)
        # The step of a run may be written in another way than its folder's name has it.
        frames, text = self.with_frames("--frames", "verlet-2.5e-2,midpoint-0.025")
        self.assertEqual(frames, {"verlet-0.025", "midpoint-0.025"})
        # The step is far above verlet's limit: its run does not reach the end.
        self.assertIn("s/midpoint-0.025/frames.pvd", text.splitlines()[-1])

    def test_of_the_reference(self):
        self.study("--integrators midpoint --steps 0.01 --reference-integrator verlet "
                   "--reference-step 5e-3 --frames verlet-0.005")  # fmt: skip
        runs = self.runs()
        self.assertEqual([r for r, has_frames in runs.items() if has_frames], ["verlet-0.005"])
        # The second one, for the error of the first, is at a step at which the rule is stable.
        self.assertEqual(len(runs), 3)
        second = [r for r in self.rows() if r["role"] == "reference" and float(r["step"]) > 5e-3]
        self.assertEqual([(r["integrator"], r["status"]) for r in second], [("verlet", "ok")])
        self.assertGreater(self.result()["reference"]["estimated_error"], 0.0)

    def test_of_runs_that_are_not_there(self):
        for name in ("midpoint-0.01", "midpoint", "verlt-0.005", "midpoint-0.005-ceres"):
            self.refused_study(*self.GRID, "--frames", name, says=(name, "midpoint-0.025"))
        self.refused_study(*self.GRID, "--frames", "all,midpoint-0.005", says="cannot be combined")
        self.refused_study(*self.GRID, "--frames", "midpoint-0.005,midpoint-5e-3", says="twice")

    def test_interrupted(self):
        """What was computed is kept; the closing line names no run that has not begun."""
        for frames, named in (("none", False), ("midpoint-0.01", False), ("verlet-1e-5", True)):
            process = self.begin("verlet-1e-05", "--steps 1e-5,0.01 --integrators verlet,midpoint "
                                 "--reference-integrator verlet --set time.end=100 --frames", frames)
            time.sleep(0.2)
            process.send_signal(signal.SIGINT)
            text, messages = process.communicate(timeout=60)
            self.assertEqual(process.returncode, 130, messages)
            self.assertEqual(self.runs(), {"verlet-1e-05": named})
            self.assertEqual("verlet-1e-05/frames.pvd" in text, named)
            # Nobody waits for pictures of a part of a study.
            self.assertEqual(glob.glob(self.path("s", "*.png")), [])
            self.assertIn("the plots were not drawn, because the study was interrupted", messages)
            self.assertEqual([r["status"] for r in self.table("s", "study.csv")], ["interrupted"])
            shutil.rmtree(self.path("s"))

    def test_cut_off_without_frames(self):
        """A fresh study replaces what is left of it."""
        process = self.begin("midpoint-1e-05", "--no-plots --quiet --steps 1e-5 --integrators midpoint "
                             "--frames none --set time.end=100")
        process.kill()
        process.wait()
        self.study(*self.GRID, "--frames", "none", "--fresh")
        self.assertEqual(set(self.runs()), self.ALL)


if __name__ == "__main__":
    main()
