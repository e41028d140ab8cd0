"""What `tetraction study` writes of each run, and solvers side by side.

Usage: study_test.py PROGRAM DATA_FOLDER [TestCase...]
"""

import csv
import glob
import importlib.util
import json
import math
import os
import re
import shutil
import signal
import stat
import subprocess
import sys
import time
import unittest

from cli_test import BEAM, CliTest

PROGRAM = os.path.abspath(sys.argv[1])


def plot_script():
    """The program that draws the plots, as a module."""
    script = os.path.join(os.path.dirname(__file__), "..", "..", "src", "cli", "plot_study.py")
    spec = importlib.util.spec_from_file_location("plot_study", script)
    plots = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(plots)
    return plots


class StudyTest(CliTest):
    def study(self, *arguments, **keywords):
        scene = self.write("beam.toml", BEAM)
        return self.run_program("study", scene, "--out", "s", "--no-plots", *arguments, **keywords)

    def refused_study(self, *arguments):
        scene = self.write("beam.toml", BEAM)
        message = self.refused(2, "study", scene, "--out", "s", "--no-plots", *arguments)
        self.assertFalse(os.path.exists(self.path("s")))
        return message

    def runs(self):
        """Folders of runs, and whether each has frames."""
        found = {}
        for name in os.listdir(self.path("s")):
            if os.path.isdir(self.path("s", name)):
                for file in ("history.csv", "final.vtu", "summary.json"):
                    self.assertTrue(os.path.exists(self.path("s", name, file)), (name, file))
                collection = os.path.exists(self.path("s", name, "frames.pvd"))
                self.assertEqual(collection, os.path.exists(self.path("s", name, "frames")))
                found[name] = collection
        return found


class Reference(StudyTest):
    def test_says_how_many_steps_the_reference_takes(self):
        result = self.study("--integrators", "midpoint", "--steps", "2e-2", "--reference-step", "1e-3",
                            "--set", "time.end=0.1")  # fmt: skip
        self.assertIn("note: reference: midpoint with steps of 0.001 s, which makes 100 steps",
                      result.stderr)  # fmt: skip


class StabilityLimit(StudyTest):
    def test_of_a_body_that_cannot_move(self):
        held = self.write("held.toml", BEAM.replace('plane = { axis = "x", at = 0.0 }',
                                                    "all = true"))  # fmt: skip
        for rule in ("midpoint", "verlet"):
            told = self.run_program("study", held, "--steps", "0.05", "--integrators", rule,
                                    "--no-plots", "--out", rule)  # fmt: skip
            self.assertIn("Stability limit: none.", told.stdout)
            with open(self.path(rule, "study.html")) as file:
                page = file.read()
            for text in (told.stdout, page):
                self.assertNotRegex(text, r"h_crit = *([.,;<]|nan|inf)")


class ExtrapolatedReference(StudyTest):
    """The row with h = 2e-5 s is far finer than the three runs of the reference, so that its difference from
    the extrapolation is the error of the extrapolation, up to its own error of 7e-9."""

    GRID = ("--integrators", "midpoint,verlet", "--steps", "2e-5,2e-3,4e-3", "--reference",
            "richardson", "--reference-step", "2e-3")  # fmt: skip

    def result(self):
        with open(self.path("s", "study.json")) as file:
            return json.load(file)

    def runs_of(self, result):
        return {(r["integrator"], r["step"]): r for r in result["runs"]}

    def test_the_estimated_error_is_about_the_real_one(self):
        said = self.study(*self.GRID)
        self.assertIn("midpoint with steps of 0.004, 0.002, 0.001 s, which makes 175 steps together",
                      said.stderr)  # fmt: skip
        self.assertRegex(said.stdout, r"Reference: Richardson extrapolation of midpoint with h = "
                                      r"2e-3 s and 1e-3 s \(ok\), whose own error")  # fmt: skip
        result = self.result()
        found, rows = result["reference"]["extrapolation"], self.runs_of(result)
        self.assertTrue(found["valid"])
        self.assertEqual(found["step"], 2e-3)
        self.assertEqual(result["reference"]["estimated_error"], found["estimated_error_at_end"])
        fine = rows["midpoint", 2e-5]
        for error, estimate in ((fine["position_error"], found["estimated_error_at_end"]),
                                (fine["position_error_rms"], found["estimated_error_over_time"])):  # fmt: skip
            self.assertGreater(error, 0.2 * estimate)
            self.assertLess(error, 1.5 * estimate)
            self.assertLess(error, 0.05 * found["finest_error_at_end"])
        for order in ("order_at_end", "order_over_time"):
            self.assertAlmostEqual(found[order], 2.0, delta=0.05)
        # No run is the reference. Those that it is extrapolated from have errors as well, which
        # are those of their positions.
        self.assertEqual({r["role"] for r in result["runs"]}, {"run"})
        self.assertAlmostEqual(rows["midpoint", 2e-3]["position_error"]
                               / (4 * found["finest_error_at_end"]), 1.0, delta=0.02)  # fmt: skip
        self.assertAlmostEqual(rows["midpoint", 4e-3]["observed_order"], 2.0, delta=0.1)
        with open(self.path("s", "study.csv"), newline="") as file:
            for row in csv.DictReader(file):
                self.assertIn("Richardson extrapolation of midpoint", row["reference"])
                self.assertAlmostEqual(float(row["reference_error"])
                                       / found["estimated_error_at_end"], 1.0, places=6)  # fmt: skip
        with open(self.path("s", "study.html")) as file:
            page = file.read()
        self.assertIn("differences from the reference, the Richardson extrapolation of", page)
        self.assertIn("The three runs show the order", page)
        self.assertEqual(set(self.runs()) - {r["directory"] for r in result["runs"]},
                         {"reference-midpoint-0.001"})  # fmt: skip

    def test_a_kept_study_has_the_same_reference(self):
        self.study(*self.GRID)
        before = self.result()
        said = self.study(*self.GRID, "--resume")
        self.assertIn("the study was complete, and no run was made", said.stderr)
        after = self.result()
        for key in ("reference", "runs", "conclusions"):
            self.assertEqual(before[key], after[key])
        os.remove(self.path("s", "verlet-0.002", "final.vtu"))
        # The three runs of the reference are made again, and verlet-0.002.
        self.assertIn("3 of 7 runs were kept", self.study(*self.GRID, "--resume").stderr)
        self.assertEqual(before["reference"], self.result()["reference"])

    def test_orders_that_do_not_fit_leave_the_finest_run(self):
        # The step 8e-3 s is above the stability limit of 7e-3 s, and the time too short to diverge.
        said = self.study("--integrators", "verlet", "--steps", "1e-3,4e-3", "--reference-integrator",
                          "verlet", "--reference", "richardson", "--reference-step", "4e-3")  # fmt: skip
        self.assertIn("note: the reference is not extrapolated: the observed order over time is",
                      said.stderr)  # fmt: skip
        self.assertIn("while the theoretical order is 2. It is the run with a step of 0.002 s",
                      said.stderr)  # fmt: skip
        result = self.result()
        found = result["reference"]["extrapolation"]
        self.assertFalse(found["valid"])
        self.assertIsNone(found["finest_error_at_end"])
        self.assertEqual(result["reference"]["directory"], "reference-verlet-0.002")
        # Its estimate is that of a single run: the difference between h and h/2, divided by 2^2 - 1.
        coarse = self.runs_of(result)["verlet", 4e-3]["position_error"]
        self.assertAlmostEqual(result["reference"]["estimated_error"] / (coarse / 3), 1.0, places=6)
        self.assertIn("not extrapolated", " ".join(result["remarks"]))
        self.assertIn("uncertain", json.dumps(result["conclusions"]))
        self.assertIn("Reference: verlet with h = 2e-3 s (ok)", said.stdout)

    def test_a_run_that_is_unstable_leaves_the_finest_run(self):
        said = self.study("--integrators", "verlet", "--steps", "5e-3,1e-2", "--reference-integrator",
                          "verlet", "--reference", "richardson", "--reference-step", "5e-3",
                          "--set", "time.end=1")  # fmt: skip
        self.assertIn("not extrapolated: the run with a step of 0.01 s did not reach the end",
                      said.stderr)  # fmt: skip
        rows = self.runs_of(self.result())
        self.assertEqual(rows["verlet", 1e-2]["status"], "unstable")
        self.assertGreater(rows["verlet", 5e-3]["position_error"], 0.0)

    def test_of_a_probe(self):
        scene = self.write("probes.toml", PROBES + """
[[probe]]
name = "speed"
select = { plane = { axis = "x", at = 4.0 } }
quantity = "velocity"
""")  # fmt: skip
        study = ["study", scene, "--out", "s", "--no-plots", "--integrators", "midpoint", "--steps",
                 "1e-3,2e-3,4e-3", "--reference", "richardson", "--reference-step", "2e-3"]  # fmt: skip
        self.run_program(*study, "--error", "probe.tip")
        found, rows = self.result()["reference"], self.runs_of(self.result())
        self.assertTrue(found["extrapolation"]["valid"])
        self.assertAlmostEqual(found["extrapolation"]["order_of_probe"], 2.0, delta=0.1)
        self.assertLess(found["estimated_error"], 0.05 * rows["midpoint", 1e-3]["probe_error"])
        self.assertAlmostEqual(rows["midpoint", 2e-3]["observed_order"], 2.0, delta=0.05)
        # With a step that is no multiple of 1e-3 s the probe is interpolated, which is far less accurate.
        self.run_program(*study, "--error", "probe.tip", "--also-solver", "ceres@0.0016")
        self.assertGreater(self.result()["reference"]["estimated_error"],
                           20 * found["estimated_error"])  # fmt: skip
        # A velocity belongs to the middle of its step, so that its error is of order 1.
        said = self.run_program(*study, "--error", "probe.speed")
        self.assertIn("the reference of the probe speed is not extrapolated: the observed order of the "
                      "probe is", said.stderr)  # fmt: skip
        # That of the positions is, all the same.
        extrapolation = self.result()["reference"]["extrapolation"]
        self.assertTrue(extrapolation["valid"])
        self.assertFalse(extrapolation["probe_valid"])
        self.assertFalse(extrapolation["probe_exact"])
        self.assertLess(extrapolation["estimated_error_at_end"],
                        0.05 * extrapolation["finest_error_at_end"])  # fmt: skip

    def test_differences_of_round_off_show_no_order(self):
        """A body that falls freely: all these rules are exact but for rounding."""
        scene = self.write("fall.toml", BEAM[: BEAM.index("[[fix]]")])
        for rule in ("midpoint", "verlet"):
            said = self.run_program(
                "study", scene, "--out", "s", "--no-plots", "--integrators", rule, "--steps",
                "1e-3,2e-3", "--reference", "richardson", "--reference-integrator", rule,
                "--reference-step", "1e-3", "--set", "time.end=0.02")  # fmt: skip
            self.assertIn("which the tolerance of the solver and round-off explain", said.stderr)
            self.assertNotIn("theoretical order", said.stderr)
            reference = self.result()["reference"]
            self.assertFalse(reference["extrapolation"]["valid"])
            self.assertTrue(reference["extrapolation"]["exact"])
            self.assertLess(reference["estimated_error"], 1e-8)
            self.assertNotIn("uncertain", json.dumps(self.result()["conclusions"]))

    def test_a_probe_of_round_off_leaves_the_positions(self):
        """The linear momentum along x of a free body is conserved to round-off."""
        scene = self.write("free.toml", BEAM[: BEAM.index("[environment]")] + """
[initial]
velocity = { formula = ["1.0", "0.2*X*X", "0.0"] }
[[probe]]
name = "push"
select = { all = true }
quantity = "momentum"
""")  # fmt: skip
        said = self.run_program(
            "study", scene, "--out", "s", "--no-plots", "--integrators", "midpoint", "--steps",
            "5e-4,1e-3,2e-3", "--reference", "richardson", "--reference-step", "1e-3", "--set",
            "time.end=0.02", "--error", "probe.push")  # fmt: skip
        self.assertIn("the reference of the probe push is not extrapolated: the runs differ by",
                      said.stderr)  # fmt: skip
        found = self.result()["reference"]["extrapolation"]
        self.assertTrue(found["valid"])
        self.assertTrue(found["probe_exact"])
        self.assertLess(found["estimated_error_of_probe"], 1e-8)
        self.assertAlmostEqual(found["order_at_end"], 2.0, delta=0.4)

    def test_steps_that_are_too_long(self):
        self.assertIn("Twice the reference step must be positive and at most the end time",
                      self.refused_study("--steps", "0.08", "--reference", "richardson"))  # fmt: skip
        self.assertIn("there are run and richardson", self.refused_study("--reference", "fine"))


PROBES = BEAM + """
[[probe]]
name = "tip"
select = { plane = { axis = "x", at = 4.0 } }
quantity = "displacement"
[[probe]]
name = "stress"
point = [0.3, 0.9, 0.4]
quantity = "von_mises"
every = 2
"""


class Probes(StudyTest):
    GRID = ("--integrators", "midpoint,verlet", "--steps", "2.5e-3,5e-3", "--out", "s",
            "--reference-step", "2.5e-4")  # fmt: skip

    def rows(self):
        with open(self.path("s", "study.csv"), newline="") as file:
            return list(csv.DictReader(file))

    def trace(self, run, columns):
        with open(self.path("s", run, "probes.csv"), newline="") as file:
            rows = [r for r in csv.DictReader(file) if r[columns[0]] != ""]
        return [(float(r["time"]), [float(r[c]) for c in columns]) for r in rows]

    def expected_error(self, run, columns):
        """The largest distance from the reference, which is interpolated linearly."""
        reference = self.trace("reference-midpoint-0.00025", columns)
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
        self.run_program("study", scene, *self.GRID, "--no-plots")
        by_position = self.rows()
        self.assertTrue(all(row["probe_error"] == "" for row in by_position))
        for name, columns in (("tip", ["tip_x", "tip_y", "tip_z"]), ("stress", ["stress"])):
            result = self.run_program("study", scene, *self.GRID, "--no-plots", "--error",
                                      f"probe.{name}")  # fmt: skip
            self.assertIn("probe.err", result.stdout)
            rows = self.rows()
            self.assertEqual(len(rows), 4)
            for row, other in zip(rows, by_position):
                self.assertEqual(row["position_error"], other["position_error"])
                run = f"{row['integrator']}-{float(row['step']):.10g}"
                expected = self.expected_error(run, columns)
                self.assertGreater(expected, 1e-6)
                self.assertAlmostEqual(float(row["probe_error"]) / expected, 1.0, places=6)
            with open(self.path("s", "study.json")) as file:
                study = json.load(file)
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
        self.run_program("study", scene, *self.GRID, "--error", "probe.tip")
        plots = ("probe_tip", "probe_stress", "error_over_step")
        for name in plots:
            for ending in ("png", "svg"):
                self.assertGreater(os.path.getsize(self.path("s", f"{name}.{ending}")), 3000)
        with open(self.path("s", "probe_tip.svg")) as file:
            text = file.read()
        for label in ("tip_x [m]", "tip_y [m]", "tip_z [m]", "midpoint", "verlet"):
            self.assertIn(label, text)
        with open(self.path("s", "error_over_step.svg")) as file:
            self.assertIn("Error of the probe tip over time", file.read())
        # The next study, without probes, deletes the plots and the files of the probes.
        self.write("s/probe_other.png", "mine")
        self.run_program("study", self.write("beam.toml", BEAM), *self.GRID)
        self.assertFalse(os.path.exists(self.path("s", "probe_tip.png")))
        self.assertTrue(os.path.exists(self.path("s", "probe_other.png")))
        self.assertFalse(os.path.exists(self.path("s", "verlet-0.005", "probes.csv")))

    def test_probes_that_are_not_there(self):
        scene = self.write("probes.toml", PROBES)
        study = ["study", scene, "--out", "s", "--no-plots"]
        self.assertIn("did you mean tip?", self.refused(2, *study, "--error", "probe.tipp"))
        self.assertIn("probe.NAME", self.refused(2, *study, "--error", "tip"))
        bare = self.write("beam.toml", BEAM)
        message = self.refused(2, "study", bare, "--out", "s", "--error", "probe.tip")
        self.assertIn("[[probe]]", message)
        self.assertFalse(os.path.exists(self.path("s")))


class RunWithProbes(StudyTest):
    def test_a_run_writes_probes(self):
        scene = self.write("probes.toml", PROBES)
        result = self.run_program("run", scene, "--out", "r")
        self.assertIn("r/probes.csv", result.stdout)
        with open(self.path("r", "probes.csv"), newline="") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual(list(rows[0]), ["step", "time", "tip_x", "tip_y", "tip_z", "stress"])
        self.assertEqual(len(rows), 11)
        self.assertEqual([r["stress"] != "" for r in rows], [i % 2 == 0 for i in range(11)])
        with open(self.path("r", "summary.json")) as file:
            summary = json.load(file)
        self.assertEqual(summary["probes"]["tip_y"]["final"], float(rows[-1]["tip_y"]))
        self.assertEqual(summary["scene"]["probe"][1]["quantity"], "von_mises")
        self.assertGreater(summary["wall_seconds"]["mesh"], 0.0)
        as_json = self.run_program("run", scene, "--out", "r", "--json").stdout
        self.assertIn("tip_y", json.loads(as_json)["probes"])
        # A run without probes does not leave those of an earlier one.
        self.run_program("run", self.write("beam.toml", BEAM), "--out", "r")
        self.assertFalse(os.path.exists(self.path("r", "probes.csv")))

    def test_probes_at_wrong_places(self):
        for command in ("run", "check", "study"):
            for keys, part in (
                ("point = [9.0, 0.5, 0.5]", "5 m from the nearest element"),
                ('select = { plane = { axis = "x", at = 9.0 } }', "selects no vertex"),
            ):
                scene = self.write("wrong.toml", BEAM + '[[probe]]\nname = "a"\n'
                                   f'quantity = "position"\n{keys}\n')  # fmt: skip
                out = () if command == "check" else ("--out", "w")
                message = self.refused(2, command, scene, *out)
                self.assertIn(part, message)
                self.assertIn("wrong.toml:19:1: probe.0", message)
                self.assertFalse(os.path.exists(self.path("w", "study.json")))


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
        frames, text = self.with_frames("--set", "time.step=0.02", "--set",
                                        "time.integrator=verlet")  # fmt: skip
        self.assertEqual(frames, {"verlet-0.025"})
        self.assertIn("s/verlet-0.025/frames.pvd", text.splitlines()[-1])

    def test_that_are_asked_for(self):
        frames, text = self.with_frames("--frames", "all")
        self.assertEqual(frames, self.ALL)
        self.assertIn("s/midpoint-0.005/frames.pvd", text.splitlines()[-1])
        # The frames of the earlier study are gone.
        frames, text = self.with_frames("--frames", "none")
        self.assertEqual(frames, set())
        self.assertNotIn("frames.pvd", text)
        # The step of a run may be written in another way than its folder's name has it.
        frames, text = self.with_frames("--frames", "verlet-2.5e-2,midpoint-0.025")
        self.assertEqual(frames, {"verlet-0.025", "midpoint-0.025"})
        # The step is far above verlet's limit: its run does not reach the end.
        self.assertIn("s/midpoint-0.025/frames.pvd", text.splitlines()[-1])

    def test_of_the_reference(self):
        self.study("--integrators", "midpoint", "--steps", "0.01", "--reference-integrator",
                   "verlet", "--reference-step", "5e-3", "--frames",
                   "reference-verlet-0.005")  # fmt: skip
        self.assertEqual(self.runs(), {"midpoint-0.01": False, "reference-verlet-0.005": True})

    def test_of_runs_that_are_not_there(self):
        for name in ("midpoint-0.01", "midpoint", "verlt-0.005", "midpoint-0.005-ceres"):
            message = self.refused_study(*self.GRID, "--frames", name)
            self.assertIn(name, message)
            self.assertIn("midpoint-0.025", message)
        self.assertIn("cannot be combined",
                      self.refused_study(*self.GRID, "--frames", "all,midpoint-0.005"))
        self.assertIn("twice", self.refused_study(*self.GRID, "--frames",
                                                  "midpoint-0.005,midpoint-5e-3"))  # fmt: skip

    def test_interrupted(self):
        """What was computed is kept; the closing line names no run that has not begun."""
        scene = self.write("beam.toml", BEAM)
        for frames, named in (("none", False), ("midpoint-0.01", False), ("verlet-1e-5", True)):
            with subprocess.Popen(
                [PROGRAM, "study", scene, "--out", "s", "--steps", "1e-5,0.01",
                 "--integrators", "verlet,midpoint", "--reference-integrator", "verlet",
                 "--set", "time.end=100", "--frames", frames],
                cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
            ) as process:  # fmt: skip
                history = self.path("s", "verlet-1e-05", "history.csv")
                while process.poll() is None and not os.path.exists(history):
                    time.sleep(0.01)
                time.sleep(0.2)
                process.send_signal(signal.SIGINT)
                text, messages = process.communicate(timeout=60)
            self.assertEqual(process.returncode, 130, messages)
            self.assertEqual(self.runs(), {"verlet-1e-05": named})
            self.assertEqual("verlet-1e-05/frames.pvd" in text, named)
            # Nobody waits for pictures of a part of a study.
            self.assertEqual(glob.glob(self.path("s", "*.png")), [])
            self.assertIn("the plots were not drawn, because the study was interrupted", messages)
            with open(self.path("s", "study.csv"), newline="") as file:
                self.assertEqual([r["status"] for r in csv.DictReader(file)], ["interrupted"])
            shutil.rmtree(self.path("s"))

    def test_cut_off_without_frames(self):
        """The next study replaces what is left of it."""
        scene = self.write("beam.toml", BEAM)
        with subprocess.Popen(
            [PROGRAM, "study", scene, "--out", "s", "--no-plots", "--quiet", "--steps", "1e-5",
             "--integrators", "midpoint", "--frames", "none", "--set", "time.end=100"],
            cwd=self.folder, stderr=subprocess.DEVNULL,
        ) as process:  # fmt: skip
            history = self.path("s", "midpoint-1e-05", "history.csv")
            while process.poll() is None and not os.path.exists(history):
                time.sleep(0.01)
            process.kill()
        self.study(*self.GRID, "--frames", "none")
        self.assertEqual(set(self.runs()), self.ALL)


class Resume(StudyTest):
    GRID = ["--integrators", "verlet,midpoint", "--steps", "0.0005,0.001", "--frames", "none",
            "--set", "time.end=0.5"]  # fmt: skip
    ALL = ("verlet-0.0005", "verlet-0.001", "midpoint-0.0005", "midpoint-0.001")

    def table(self):
        """All columns but times and the command."""
        with open(self.path("s", "study.csv"), newline="") as file:
            rows = list(csv.DictReader(file))
        other = ("wall_seconds", "seconds_per_simulated_second", "date", "command")
        return [{k: v for k, v in row.items() if k not in other} for row in rows]

    def written(self, run):
        """Changes whenever the run is made again, even on a file system that uses the number of a
        deleted file again."""
        status = os.stat(self.path("s", run, "history.csv"))
        return status.st_ino, status.st_mtime_ns

    def histories(self):
        result = {}
        for run in self.runs():
            with open(self.path("s", run, "history.csv"), "rb") as file:
                result[run] = (file.read(), self.written(run))
        return result

    def kill_after_two_runs(self, grid):
        """Begins the study and kills it when the reference and one more run are complete. Returns
        the complete runs, or nothing if the study had ended before it was killed."""
        shutil.rmtree(self.path("s"), ignore_errors=True)
        scene = self.write("beam.toml", BEAM)

        def complete():
            return [r for r in self.ALL if os.path.exists(self.path("s", r, "study_row.json"))]

        def complete_in_journal():
            # The journal comes after the row of a run, so that both name these runs.
            try:
                with open(self.path("s", "study_runs.csv")) as file:
                    return file.read().count(",complete\n")
            except FileNotFoundError:
                return 0

        with subprocess.Popen(
            [PROGRAM, "study", scene, "--out", "s", "--no-plots", "--quiet", *grid],
            cwd=self.folder, stderr=subprocess.DEVNULL,
        ) as process:  # fmt: skip
            while complete_in_journal() < 2 and process.poll() is None:
                time.sleep(0.001)
            process.kill()
            process.wait()
        runs = complete()
        return runs if 2 <= len(runs) < len(self.ALL) else []

    def test_a_study_that_was_killed_goes_on(self):
        # A longer study if a fast machine had ended the shorter one before it was killed.
        for end in (0.5, 2.0, 8.0, 32.0):
            grid = [*self.GRID, "--set", f"time.end={end}"]
            complete = self.kill_after_two_runs(grid)
            if complete:
                break
        self.assertTrue(complete)
        # The reference is made again, as the errors of the other runs need its positions.
        kept = [r for r in complete if r != "midpoint-0.0005"]
        written = {r: self.written(r) for r in kept}
        result = self.study(*grid, "--resume")
        self.assertIn(f"{len(kept)} of 4 runs were kept", result.stderr)
        self.assertEqual({r: self.written(r) for r in kept}, written)
        table = self.table()
        texts = {r: text for r, (text, _) in self.histories().items()}
        self.study(*grid)
        self.assertEqual(table, self.table())
        self.assertEqual(texts, {r: text for r, (text, _) in self.histories().items()})

    def test_a_complete_study_says_so(self):
        self.study(*self.GRID)
        whole, before = self.table(), self.histories()
        result = self.study(*self.GRID, "--resume")
        self.assertIn("the study was complete, and no run was made", result.stderr)
        self.assertEqual((self.table(), self.histories()), (whole, before))
        # A run whose files are not all there is made again, and the reference with it.
        os.remove(self.path("s", "verlet-0.001", "final.vtu"))
        self.assertIn("2 of 4 runs were kept", self.study(*self.GRID, "--resume").stderr)
        self.assertEqual(self.table(), whole)
        # Without --resume everything is made anew.
        self.assertIn("deleted", self.study(*self.GRID).stderr)
        self.assertNotEqual(self.histories(), before)

    def test_other_inputs_are_noticed(self):
        self.study(*self.GRID)
        for change in (["--set", "material.density=900"], ["--set", "mesh.generate.cells=[9,2,2]"],
                       ["--set", "solver.tolerance=1e-9"], ["--set", "time.end=0.1"]):  # fmt: skip
            with self.subTest(change[1]):
                result = self.study(*self.GRID, *change, "--resume")
                self.assertIn("0 of 4 runs were kept", result.stderr)
        # One integrator more keeps the others; what is in [output] does not matter.
        self.study(*self.GRID)
        more = ["--integrators", "verlet,midpoint,explicit", *self.GRID[2:], "--set", "output.every=3"]
        result = self.study(*more, "--resume")
        self.assertIn("3 of 6 runs were kept", result.stderr)
        # A run that is not of the study any more is deleted.
        result = self.study("--integrators", "midpoint", *self.GRID[2:], "--resume")
        self.assertIn("complete", result.stderr)
        self.assertEqual(set(self.runs()), {"midpoint-0.0005", "midpoint-0.001"})

    def test_folders_that_have_vanished_are_named(self):
        self.study(*self.GRID)
        whole = self.table()
        shutil.rmtree(self.path("s", "verlet-0.001"))
        result = self.study(*self.GRID, "--resume")
        self.assertIn("the folder of a complete run is no longer there, and the run is made again: "
                      "verlet-0.001", result.stderr)  # fmt: skip
        self.assertEqual(self.table(), whole)
        for run in ("verlet-0.001", "midpoint-0.001"):
            shutil.rmtree(self.path("s", run))
        result = self.study(*self.GRID, "--resume")
        self.assertIn("the folders of 2 complete runs are no longer there", result.stderr)
        self.assertNotIn("no longer there", self.study(*self.GRID, "--resume").stderr)
        # What a study itself has deleted is not missed.
        self.study("--integrators", "midpoint", *self.GRID[2:], "--resume")
        self.assertNotIn("no longer there", self.study(*self.GRID, "--resume").stderr)

    def test_files_of_runs_that_are_no_files(self):
        study = ("study", "beam.toml", "--out", "s", *self.GRID, "--quiet", "--resume")
        self.study(*self.GRID)
        whole = self.table()
        history = self.path("s", "verlet-0.001", "history.csv")
        for make in (os.mkfifo, lambda path: os.symlink("/dev/zero", path)):
            os.remove(history)
            make(history)
            self.run_program(*study)
            self.assertEqual(self.table(), whole)
            self.assertTrue(stat.S_ISREG(os.lstat(history).st_mode))
        # The plots are made without what cannot be read.
        self.write("s/verlet-0.001/summary.json", "[" * 100000)
        self.assertEqual(self.run_program(*study).stderr, "")
        # A link may lead to the run of another study.
        folder = self.path("s", "verlet-0.001")
        os.rename(folder, self.path("elsewhere"))
        os.symlink(self.path("elsewhere"), folder)
        self.assertIn("link", self.refused(4, *study))

    def test_plots_read_regular_files_only(self):
        plots = plot_script()
        os.mkfifo(self.path("pipe"))
        os.symlink("/dev/zero", self.path("zero"))
        for name in ("pipe", "zero"):
            self.assertEqual(plots.read_json(self.folder, name), {})
            self.assertEqual(plots.read_columns(self.folder, name), {})

    def test_folders_that_have_vanished_from_a_study_that_was_killed(self):
        for end in (0.5, 2.0, 8.0, 32.0):
            grid = [*self.GRID, "--set", f"time.end={end}"]
            complete = self.kill_after_two_runs(grid)
            if complete:
                break
        lost = next(r for r in complete if r != "midpoint-0.0005")
        shutil.rmtree(self.path("s", lost))
        self.assertIn(f"made again: {lost}", self.study(*grid, "--resume").stderr)

    def test_all_folders_of_a_reference_belong_to_the_study(self):
        """Those of an extrapolated reference are no rows of the table."""
        grid = ("--integrators", "verlet", "--steps", "0.001", "--reference", "richardson",
                "--set", "time.end=0.1")  # fmt: skip
        self.study(*grid)
        self.assertEqual(len(self.runs()), 4)
        self.study("--integrators", "verlet", "--steps", "0.002", "--set", "time.end=0.1")
        self.assertEqual(set(self.runs()), {"verlet-0.002", "reference-midpoint-0.002"})

    def test_what_is_stored_of_a_run_does_not_grow_with_the_study(self):
        """Otherwise the time of a study grows with the square of the number of its variants."""
        grid = ("--integrators", "midpoint", "--steps", "0.01", "--set", "time.end=0.02", "--quiet",
                "--set", "mesh.generate.cells=[2,1,1]")  # fmt: skip
        sizes = []
        for count in (2, 12):
            values = ",".join(str(1000 + i) for i in range(count))
            self.study(*grid, "--vary", f"material.density={values}")
            sizes.append(os.path.getsize(self.path("s", "1001-midpoint-0.01", "study_row.json")))
            with open(self.path("s", "study_runs.csv"), newline="") as file:
                journal = [(r["run"], r["state"]) for r in csv.DictReader(file)]
            self.assertEqual(journal, [(f"{1000 + i}-midpoint-0.01", state) for i in range(count)
                                       for state in ("begun", "complete")])  # fmt: skip
        self.assertLess(abs(sizes[1] - sizes[0]), 100)  # wall times have more or fewer digits


class Variants(StudyTest):
    GRID = ("--integrators", "verlet,midpoint", "--steps", "2.5e-3,5e-3", "--reference-step",
            "1e-3", "--quiet")  # fmt: skip

    def result(self):
        with open(self.path("s", "study.json")) as file:
            return json.load(file)

    def topics(self, result):
        return {c["topic"]: " ".join(c["sentences"]) for c in result["conclusions"]}

    def test_several_keys_make_all_combinations(self):
        self.study(*self.GRID, "--vary", "material.density=900,1000", "--vary",
                   "solver.kind=newton,ceres")  # fmt: skip
        result = self.result()
        names = [f"density={d}, kind={k}" for d in (900, 1000) for k in ("newton", "ceres")]
        self.assertEqual([v["name"] for v in result["variants"]], names)
        self.assertEqual(result["variants"][1]["values"],
                         {"material.density": "900", "solver.kind": "ceres"})  # fmt: skip
        self.assertEqual([r["variant"] for r in result["runs"]],
                         [name for name in names for _ in range(4)])  # fmt: skip
        # Variants of the solver have the same motion and share a reference.
        self.assertEqual([r["variants"] for r in result["references"]], [names[:2], names[2:]])
        for run in result["runs"]:
            with open(self.path("s", run["directory"], "summary.json")) as file:
                scene = json.load(file)["scene"]
            values = dict(part.split("=") for part in run["variant"].split(", "))
            self.assertEqual(scene["material"]["density"], float(values["density"]))
            self.assertEqual(scene["solver"]["kind"], values["kind"])
            self.assertEqual(run["role"], "run" if "newton" in run["variant"] else "variant")
            self.assertTrue(run["directory"].startswith(
                run["variant"].replace(", ", "_") + "-"), run["directory"])  # fmt: skip
        with open(self.path("s", "study.csv"), newline="") as file:
            self.assertEqual([r["variant"] for r in csv.DictReader(file)],
                             [r["variant"] for r in result["runs"]])  # fmt: skip
        with open(self.path("s", "study.html")) as file:
            page = file.read()
        for name in names:
            self.assertIn(f">{name}<", page)
        self.assertIn(names[0], self.topics(result)["Variants"])

    def test_keys_that_end_in_the_same_word_stay_apart(self):
        self.study("--integrators", "verlet", "--steps", "5e-3", "--quiet", "--set",
                   "probe=[{name='tip',point=[1,1,1],quantity='position'}]", "--vary",
                   "mesh.generate.size.0=4,5", "--vary", "probe.0.point.0=1,2")  # fmt: skip
        self.assertEqual(self.result()["runs"][0]["variant"], "size.0=4, point.0=1")

    def test_each_mesh_has_a_reference_of_its_own(self):
        """Its rows are those of a study of this mesh alone."""
        cells = ("[8,2,2]", "[4,1,1]")
        said = self.study(*self.GRID[:-1], "--vary", "mesh.generate.cells=" + ",".join(cells))
        self.assertIn("each of the 2 references: midpoint with steps", said.stderr)
        self.assertIn("([4,1,1]) h = ", said.stderr)
        self.assertIn("[4,1,1]: h_crit", said.stdout)
        self.assertIn("; with a reference of its own", said.stdout)
        self.assertRegex(said.stdout, r"(?m)^Reference of \[4,1,1\]: midpoint with h = 1e-3 s \(ok\)")
        result = self.result()
        self.assertEqual([m["variants"] for m in result["references"]], [[c] for c in cells])
        self.assertEqual([m["position_difference"] for m in result["references"]], [None, None])
        self.assertIn("2 references", self.topics(result)["Variants"])
        self.assertIn("--error probe.NAME", self.topics(result)["Variants"])
        self.assertIn("verlet ([4,1,1])", self.topics(result)["Limits of the comparison: [4,1,1]"])
        with open(self.path("s", "study.csv"), newline="") as file:
            table = list(csv.DictReader(file))
        for number, size in enumerate(cells):
            rows = [r for r in result["runs"] if r["variant"] == size]
            self.assertEqual({r["role"] for r in rows}, {"run"})
            errors = [float(r["reference_error"]) for r in table if r["variant"] == size]
            self.study(*self.GRID, "--set", f"mesh.generate.cells={size}")
            alone = self.result()
            self.assertEqual(len(rows), 4)
            for row, other in zip(rows, alone["runs"]):
                for key in ("integrator", "step", "position_error", "position_error_rms",
                            "observed_order", "max_relative_energy_drift"):  # fmt: skip
                    self.assertEqual(row[key], other[key], key)
            error = alone["reference"]["estimated_error"]
            self.assertEqual(result["references"][number]["estimated_error"], error)
            for found in errors:
                self.assertAlmostEqual(found / error, 1.0, places=6)

    def test_a_probe_is_compared_between_meshes(self):
        scene = self.write("probes.toml", PROBES)
        study = ["study", scene, "--out", "s", "--no-plots", *self.GRID, "--error", "probe.tip",
                 "--vary", "mesh.element=linear,quadratic"]  # fmt: skip
        self.run_program(*study)
        result = self.result()

        def trace(mesh):
            folder = result["references"][mesh]["directory"]
            with open(self.path("s", folder, "probes.csv"), newline="") as file:
                return [[float(r[f"tip_{c}"]) for c in "xyz"] for r in csv.DictReader(file)]

        first, second = trace(0), trace(1)
        expected = max(map(math.dist, first, second)) / max(math.hypot(*v) for v in first)
        self.assertGreater(expected, 1e-4)
        found = [m["probe_difference"] for m in result["references"]]
        self.assertIsNone(found[0])
        self.assertAlmostEqual(found[1] / expected, 1.0, places=9)
        self.assertIn("differs by up to", self.topics(result)["Variants"])
        # It is kept, or computed again, when the study goes on.
        self.run_program(*study, "--resume")
        self.assertEqual(self.result()["references"], result["references"])
        os.remove(self.path("s", "quadratic-verlet-0.005", "final.vtu"))
        self.run_program(*study, "--resume")
        after = self.result()
        self.assertEqual(after["references"], result["references"])
        for row, other in zip(after["runs"], result["runs"]):
            self.assertEqual(row["probe_error"], other["probe_error"])

    def test_files_of_meshes_and_tables_as_values(self):
        for name, cells in (("a", "4,1,1"), ("b", "6,1,1")):
            self.run_program("mesh", "generate", "beam", f"{name}.msh", "--size", "4,1,1", "--cells",
                             cells)  # fmt: skip
        own = BEAM.replace(BEAM.split("[material]")[0], '[mesh]\nfile = "a.msh"\n')
        scene = self.write("files.toml", own)
        study = ["study", scene, "--out", "s", "--no-plots", *self.GRID]
        self.run_program(*study, "--vary", "mesh.file=a.msh,b.msh")
        result = self.result()
        self.assertEqual([v["name"] for v in result["variants"]], ["a.msh", "b.msh"])
        self.assertEqual(len(result["references"]), 2)
        counts = []
        for run in ("a.msh-verlet-0.005", "b.msh-verlet-0.005"):
            with open(self.path("s", run, "summary.json")) as file:
                counts.append(json.load(file)["mesh"]["tetrahedra"])
        self.assertEqual(counts[1], counts[0] * 6 // 4)
        shutil.rmtree(self.path("s"))
        values = ['{file = "a.msh"}',
                  '{generate = { kind = "beam", size = [4, 1, 1], cells = [6, 1, 1] }}']  # fmt: skip
        self.run_program(*study, "--vary", "mesh=" + ", ".join(values))
        result = self.result()
        self.assertEqual([v["name"] for v in result["variants"]], values)
        self.assertEqual(len(self.runs()), 10)
        for folder in self.runs():
            self.assertRegex(folder, r"^[\w.=+-]+$")

    def test_initial_fields_belong_to_the_variant(self):
        """They are stored with the mesh, which two variants do not share then."""
        self.study(*self.GRID, "--vary", "initial.velocity={formula=['0','0','X']},"
                   "{formula=['0','0','2*X']}")  # fmt: skip
        runs = {r["variant"][-5:-3]: r for r in self.result()["runs"] if r["integrator"] == "verlet"}
        self.assertEqual(len(runs), 2)
        for run in runs.values():
            self.assertEqual(run["role"], "run")
            self.assertGreater(run["position_error"], 0.0)
        self.assertGreater(self.result()["references"][1]["position_difference"], 0.1)

    def test_each_material_has_the_errors_of_a_study_of_its_own(self):
        """Twice the density is another motion: its differences from the first one are no errors."""
        study = (*self.GRID, "--vary", "material.density=1000,2000")
        self.study(*study)
        result = self.result()
        self.assertEqual({r["role"] for r in result["runs"]}, {"run"})
        first, second = result["references"]
        self.assertIsNone(first["position_difference"])
        finals = []
        for reference in (first, second):
            with open(self.path("s", reference["directory"], "summary.json")) as file:
                finals.append(json.load(file)["scene"]["material"]["density"])
        self.assertEqual(finals, [1000, 2000])
        self.assertGreater(second["position_difference"], 0.01)
        self.assertGreater(second["position_difference_rms"], 0.01)
        self.assertIn("The positions of the reference of 2000 differ from those of 1000 by",
                      self.topics(result)["Variants"])  # fmt: skip
        rows = [r for r in result["runs"] if r["variant"] == "2000"]
        self.study(*self.GRID, "--set", "material.density=2000")
        alone = self.result()
        self.assertEqual(second["estimated_error"], alone["reference"]["estimated_error"])
        for row, other in zip(rows, alone["runs"]):
            for key in ("position_error", "position_error_rms", "observed_order"):
                self.assertEqual(row[key], other[key], key)
        # The differences are kept, or made again with the runs that they need.
        self.study(*study)
        self.study(*study, "--resume")
        self.assertEqual(self.result()["references"], result["references"])
        os.remove(self.path("s", "2000-verlet-0.005", "final.vtu"))
        self.study(*study, "--resume")
        self.assertEqual(self.result()["references"], result["references"])

    def test_a_further_value_keeps_the_runs_of_the_others(self):
        self.study(*self.GRID[:-1], "--vary", "material.density=1000,2000")
        said = self.study(*self.GRID[:-1], "--vary", "material.density=1000,2000,3000", "--resume")
        # The first reference is made again, since the new one is compared with it.
        self.assertIn("9 of 15 runs were kept", said.stderr)

    def test_one_value_makes_one_variant(self):
        self.study(*self.GRID, "--vary", "material.density=900", "--vary", "solver.kind=newton,ceres")
        self.assertEqual([v["name"] for v in self.result()["variants"]],
                         ["density=900, kind=newton", "density=900, kind=ceres"])  # fmt: skip
        self.study(*self.GRID, "--vary", "material.density=900")
        self.assertEqual({r["variant"] for r in self.result()["runs"]}, {"900"})

    def test_two_spellings_of_a_value_are_one(self):
        message = self.refused_study("--vary", "material.density=900,901,900.0,9e2")
        self.assertIn('the values "900" and "900.0" make the same scene', message)

    def test_messages_name_the_variant(self):
        for arguments, part in (
            (("--vary", "fix.0.mode=exact,penalty"), "--vary fix.0.mode=penalty: "),
            (("--vary", "material.poissons_ratio=0.4,0.6", "--vary", "solver.kind=newton,ceres"),
             "--vary material.poissons_ratio=0.6 --vary solver.kind=newton: "),
            (("--vary", "solver.kind=newton,ceres", "--set", "mesh.volume=nodal"),
             "The variant ceres: "),
        ):  # fmt: skip
            message = self.refused_study(*arguments)
            self.assertIn(part, message)
            self.assertNotIn("--set", message)
        with_file = BEAM.replace(BEAM.split("[material]")[0], '[mesh]\nfile = "a.msh"\n')
        self.run_program("mesh", "generate", "beam", "a.msh", "--size", "4,1,1", "--cells", "4,1,1")
        self.assertIn("--vary mesh.file=b.msh: ", self.refused(
            3, "study", self.write("files.toml", with_file), "--vary", "mesh.file=a.msh,b.msh"))  # fmt: skip

    def test_variants_have_plots(self):
        scene = self.write("probes.toml", PROBES)
        self.run_program("study", scene, "--out", "s", *self.GRID, "--vary",
                         "mesh.generate.cells=[8,2,2],[4,1,1]")  # fmt: skip
        for plot in ("error_over_step", "work_precision", "probe_tip"):
            self.assertGreater(os.path.getsize(self.path("s", f"{plot}.png")), 3000)
        with open(self.path("s", "error_over_step.svg")) as file:
            self.assertIn("midpoint ([4,1,1])", file.read())

    def test_what_cannot_be_varied(self):
        for text, part in (
            ("material.density=[1,2", "] is missing at the end"),
            ("material.density='1,2", "' is missing at the end"),
            ("material.density", "write KEY=VALUE,VALUE"),
            ("material.density=", "write KEY=VALUE,VALUE"),
            ("material.density=900,", "write KEY=VALUE,VALUE"),
            ("=1,2", "write KEY=VALUE,VALUE"),
            ("material.density=900, 900", "twice"),
            ("output.directory=a,b", "one output directory"),
            ("time.integrator=verlet,midpoint", "sets integrators"),
            ("material.densty=1,2", "did you mean density?"),
            ("material.density=1,-2", "--vary material.density=-2"),
            ("mesh.file=a.msh,b.msh", "generate"),
        ):
            with self.subTest(text):
                message = self.refused_study("--vary", text)
                self.assertIn(part, message)
        self.assertIn("varied twice", self.refused_study(
            "--vary", "material.density=1,2", "--vary", "material.density=3,4"))  # fmt: skip
        many = ",".join(str(i) for i in range(1, 41))
        self.assertIn("1000 combinations", self.refused_study(
            "--vary", f"material.density={many}", "--vary", f"solver.max_iterations={many}"))  # fmt: skip


class Jobs(StudyTest):
    """Several runs at a time. With more threads than cores their wall times do not count."""

    GRID = ("--integrators", "verlet,midpoint,energy-momentum", "--steps", "1e-3,2e-3,4e-3")
    TIMES = ("wall_seconds", "seconds_per_simulated_second", "date", "command", "timing")

    def rows(self, folder="s"):
        with open(self.path(folder, "study.csv"), newline="") as file:
            return list(csv.DictReader(file))

    def table(self):
        """The whole table but for what depends on the machine's load."""
        return [{k: v for k, v in r.items() if k not in self.TIMES} for r in self.rows()]

    def files(self, name):
        found = {}
        for run in self.runs():
            with open(self.path("s", run, name), "rb") as file:
                found[run] = file.read()
        return found

    def test_the_same_bits_as_one_run_at_a_time(self):
        for more in ((), ("--reference", "richardson"), ("--threads", "1"),
                     ("--vary", "mesh.generate.cells=[8,2,2],[6,2,2]", "--threads", "2")):  # fmt: skip
            with self.subTest(more):
                results = []
                for jobs in ("1", "2", "5"):
                    self.study(*self.GRID, *more, "--jobs", jobs, "--quiet")
                    with open(self.path("s", "study.json")) as file:
                        runs = json.load(file)["runs"]
                    results.append((
                        self.table(), self.files("history.csv"), self.files("final.vtu"),
                        [(r["position_error"], r["probe_error"], r["observed_order"]) for r in runs],
                    ))  # fmt: skip
                    if more == ("--threads", "2"):
                        self.assertEqual({r["threads"] for r in runs}, {2})
                self.assertEqual(results[0], results[1])
                self.assertEqual(results[0], results[2])

    def test_factorisations_at_the_same_time(self):
        """Orderings of large matrices need random numbers, which threads share."""
        grid = ("--integrators", "midpoint", "--steps", "1e-2,2e-2,4e-2", "--set",
                "mesh.generate.cells=[36,9,9]", "--set", "solver.linear=factor", "--set",
                "time.end=0.04", "--quiet")  # fmt: skip
        tables = []
        for jobs in ("1", "3"):
            self.study(*grid, "--jobs", jobs, "--threads", "1")
            tables.append((self.table(), self.files("final.vtu")))
        self.assertEqual(tables[0], tables[1])

    def test_wall_times_of_runs_that_share_cores_do_not_count(self):
        cores = len(os.sched_getaffinity(0))
        said = self.study(*self.GRID, "--jobs", "3", "--threads", str(cores))
        self.assertIn(f"3 runs at a time with {cores} thread", said.stderr)
        self.assertIn("wall times of runs that share them do not count", said.stderr)
        rows = self.rows()
        # The reference is one run, which was alone.
        self.assertEqual([r["timing"] for r in rows],
                         ["alone" if r["role"] == "reference" else "shared" for r in rows])  # fmt: skip
        with open(self.path("s", "study.json")) as file:
            study = json.load(file)
        self.assertEqual([r["timing"] for r in study["runs"]], [r["timing"] for r in rows])
        cost = next(c for c in study["conclusions"] if c["topic"] == "Cost of accuracy")
        self.assertEqual(len(cost["sentences"]), 1)
        self.assertIn("timings are missing", cost["sentences"][0])
        self.assertIn("with --jobs 1", cost["sentences"][0])
        self.assertRegex(said.stdout, r"(?m)^verlet +- +0\.001 .* [0-9.e-]+\* ")
        self.assertIn("wall [s] with *", said.stdout)
        with open(self.path("s", "study.html")) as file:
            self.assertIn("Wall times with * do not count", file.read())
        # The marks stay with runs that are kept. There is no plot of cost.
        self.run_program("study", "beam.toml", "--out", "s", *self.GRID, "--resume", "--quiet")
        self.assertEqual(self.rows(), [{**r, "command": self.rows()[0]["command"]} for r in rows])
        self.assertFalse(os.path.exists(self.path("s", "work_precision.png")))
        self.assertTrue(os.path.exists(self.path("s", "error_over_step.png")))
        diff = json.loads(self.run_program("study", "diff", "s", "s", "--json").stdout)
        self.assertEqual({r["wall_ratio"] for r in diff["runs"]}, {None, 1.0})
        self.assertIn("--jobs 1", " ".join(diff["notes"]))

    def test_wall_times_of_runs_with_a_core_each_count(self):
        cores = len(os.sched_getaffinity(0))
        said = self.study(*self.GRID, "--jobs", str(cores), "--threads", "1")
        self.assertEqual({r["timing"] for r in self.rows()}, {"alone"})
        self.assertNotIn("do not count", said.stderr + said.stdout)

    def test_a_run_with_more_threads_than_cores_is_not_alone(self):
        cores = len(os.sched_getaffinity(0))
        said = self.study(*self.GRID, "--threads", str(2 * cores))
        self.assertEqual({r["timing"] for r in self.rows()}, {"shared"})
        self.assertIn(f"With --threads {cores} they would", said.stderr)
        # Also the reference, beside which no other run is made.
        self.study(*self.GRID, "--jobs", "2", "--threads", str(cores + 1), "--quiet")
        self.assertEqual({r["timing"] for r in self.rows()}, {"shared"})

    def test_interrupted_and_resumed(self):
        grid = ["--integrators", "verlet,midpoint", "--steps", "2e-4,4e-4,1e-3", "--frames", "none",
                "--set", "time.end=2", "--threads", "1"]  # fmt: skip
        scene = self.write("beam.toml", BEAM)

        def complete():
            return set(glob.glob(self.path("s", "*", "study_row.json")))

        with subprocess.Popen(
            [PROGRAM, "study", scene, "--out", "s", "--no-plots", *grid, "--jobs", "2"],
            cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        ) as process:  # fmt: skip
            # The reference is complete, and two runs are being made.
            while process.poll() is None and len(complete()) < 2:
                time.sleep(0.002)
            process.send_signal(signal.SIGINT)
            _, messages = process.communicate(timeout=60)
        if process.returncode != 0:  # a fast machine may have ended the study
            self.assertEqual(process.returncode, 130, messages)
            self.assertIn("the study was interrupted", messages)
            rows = self.rows()
            stopped = [r for r in rows if r["status"] == "interrupted"]
            self.assertTrue(1 <= len(stopped) <= 2 or len(rows) < 6, rows)
            for run in self.runs():
                self.assertTrue(os.path.exists(self.path("s", run, "summary.json")))
        kept = complete() - {self.path("s", "midpoint-0.0002", "study_row.json")}
        written = {path: os.stat(path).st_mtime_ns for path in kept}
        self.study(*grid, "--resume", "--jobs", "2", "--quiet")
        self.assertEqual({path: os.stat(path).st_mtime_ns for path in kept}, written)
        table, histories = self.table(), self.files("history.csv")
        self.study(*grid, "--quiet")
        self.assertEqual((table, histories), (self.table(), self.files("history.csv")))

    def test_a_run_that_cannot_write_ends_the_others(self):
        """One message, and no further run begins."""
        scene = self.write("beam.toml", BEAM)
        os.makedirs(self.path("s", "verlet-0.002", "history.csv"))
        message = self.refused(4, "study", scene, "--out", "s", "--no-plots", "--quiet", *self.GRID,
                               "--set", "time.end=20", "--jobs", "2")  # fmt: skip
        self.assertIn("verlet-0.002/history.csv", message)

    def test_numbers_of_jobs_that_are_wrong(self):
        for text in ("0", "-1", "abc", "1.5", "", "99999"):
            with self.subTest(text):
                self.assertIn("--jobs", self.refused_study(f"--jobs={text}"))


class Diff(StudyTest):
    GRID = ("--no-plots", "--quiet", "--reference-step", "5e-4")

    def make(self, name, *arguments):
        scene = self.write("beam.toml", BEAM)
        self.run_program("study", scene, "--out", name, *self.GRID, *arguments)

    def rows(self, name):
        with open(self.path(name, "study.csv"), newline="") as file:
            return {(r["integrator"], float(r["step"])): r for r in csv.DictReader(file)}

    def two_studies(self):
        self.make("a", "--integrators", "verlet,midpoint", "--steps", "2.5e-3,5e-3")
        self.make("b", "--integrators", "midpoint,backward-euler", "--steps", "2.5e-3,5e-3,1e-2",
                  "--set", "material.density=1100")  # fmt: skip

    def test_numbers_of_the_rows_that_match(self):
        self.two_studies()
        diff = json.loads(self.run_program("study", "diff", "a", "b", "--json").stdout)
        a, b = self.rows("a"), self.rows("b")
        self.assertEqual([(r["integrator"], r["step"]) for r in diff["runs"]],
                         [("midpoint", 2.5e-3), ("midpoint", 5e-3)])  # fmt: skip
        for row in diff["runs"]:
            key = row["integrator"], row["step"]
            for change in ("position_error", "position_error_rms", "max_relative_energy_drift"):
                expected = float(b[key][change]) - float(a[key][change])
                self.assertNotEqual(expected, 0.0)
                self.assertAlmostEqual(row[f"{change}_change"] / expected, 1.0, places=5)
            ratio = float(b[key]["wall_seconds"]) / float(a[key]["wall_seconds"])
            self.assertAlmostEqual(row["wall_ratio"] / ratio, 1.0, places=5)
            self.assertIsNone(row["probe_error_change"])
        self.assertEqual([(r["integrator"], r["step"]) for r in diff["only_in_a"]],
                         [("verlet", 2.5e-3), ("verlet", 5e-3)])  # fmt: skip
        self.assertEqual([(r["integrator"], r["step"]) for r in diff["only_in_b"]],
                         [("midpoint", 1e-2), ("backward-euler", 2.5e-3), ("backward-euler", 5e-3),
                          ("backward-euler", 1e-2)])  # fmt: skip
        self.assertEqual(diff["notes"], [])
        table = self.run_program("study", "diff", "a", "b").stdout
        change = f"{diff['runs'][1]['position_error_change']:+.2e}"
        self.assertRegex(table, rf"(?m)^midpoint +newton +0\.005 +ok .*{re.escape(change)}")
        self.assertRegex(table, r"only in A:\n +verlet +- +0\.0025\n")
        self.assertIn("2 of 4 runs of A and of 6 runs of B match.", table)

    def test_of_a_study_and_itself(self):
        self.make("a", "--integrators", "verlet,midpoint", "--steps", "2.5e-3,5e-3")
        shutil.copy(self.path("a", "study.json"), self.path("saved.json"))
        diff = json.loads(self.run_program("study", "diff", "saved.json", "a", "--json").stdout)
        self.assertEqual(len(diff["runs"]), 4)
        for row in diff["runs"]:
            self.assertEqual(row["position_error_change"], 0.0)
            self.assertEqual(row["wall_ratio"], 1.0)
        self.assertEqual((diff["only_in_a"], diff["only_in_b"]), ([], []))

    def test_what_limits_the_comparison_is_said(self):
        self.make("a", "--integrators", "midpoint", "--steps", "5e-3")
        self.make("b", "--integrators", "midpoint", "--steps", "5e-3", "--reference-integrator",
                  "verlet")  # fmt: skip
        table = self.run_program("study", "diff", "a", "b").stdout
        self.assertIn("different references, midpoint at 0.0005 s and verlet at 0.0005 s", table)
        self.make("c", "--integrators", "midpoint", "--steps", "5e-3", "--threads", "1")
        with open(self.path("c", "study.json")) as file:
            study = json.load(file)
        study["runs"][0]["processor"] = "another one"
        self.write("c.json", json.dumps(study))
        self.assertIn("on different machines", self.run_program("study", "diff", "a", "c.json").stdout)
        self.make("d", "--integrators", "verlet", "--steps", "2e-3")
        self.assertIn("No run of A has the", self.run_program("study", "diff", "a", "d").stdout)

    def test_runs_that_failed_and_the_reference_have_no_change_of_errors(self):
        for name in "ab":
            self.make(name, "--integrators", "verlet,midpoint", "--steps", "5e-4,2e-2",
                      "--set", "time.end=1")  # fmt: skip
        diff = json.loads(self.run_program("study", "diff", "a", "b", "--json").stdout)
        changes = {(r["integrator"], r["step"]): r["position_error_change"] for r in diff["runs"]}
        self.assertEqual(changes, {("verlet", 5e-4): 0.0, ("verlet", 2e-2): None,
                                   ("midpoint", 5e-4): None, ("midpoint", 2e-2): 0.0})  # fmt: skip
        self.assertEqual(next(r for r in diff["runs"] if r["step"] == 2e-2)["a"]["status"], "unstable")

    def test_what_is_no_study(self):
        self.make("a", "--integrators", "midpoint", "--steps", "5e-3")
        self.assertIn("no such directory", self.refused(3, "study", "diff", "a", "missing"))
        os.mkdir(self.path("empty"))
        self.assertIn("there is no study.json.", self.refused(3, "study", "diff", "empty", "a"))
        self.assertIn("but the results of a run",
                      self.refused(3, "study", "diff", "a", "a/midpoint-0.005"))  # fmt: skip
        begun = {"message": "The study has not ended", "runs": [{"directory": "midpoint-0.005"}]}
        for text, part in (("{", "not the study.json"), ("[]", "not the study.json"),
                           ('{"runs": 3}', "not the study.json"), (json.dumps(begun), "--resume"),
                           ('{"runs": [{"integrator": 3}]}', '"scene" is missing')):  # fmt: skip
            self.write("broken.json", text)
            self.assertIn(part, self.refused(3, "study", "diff", "a", "broken.json"))

    def test_texts_of_foreign_studies_do_not_reach_the_terminal_raw(self):
        self.make("a", "--integrators", "midpoint", "--steps", "5e-3,1e-2")
        with open(self.path("a", "study.json")) as file:
            whole = json.load(file)
        bad = "\x1b[31m\x07\u009b2J\u202ered\r\x7f"
        forged = json.loads(json.dumps(whole))
        for key in ("version", "command", "date", "scene"):
            forged[key] = bad
        forged["error"] = "probe." + bad
        forged["reference"]["integrator"] = bad
        for i, run in enumerate(forged["runs"]):
            run.update(variant=bad, solver=bad, processor=bad)
            if i == 0:
                run["integrator"] = bad
        self.write("forged.json", json.dumps(forged))
        for arguments in (("a", "forged.json"), ("forged.json", "a"), ("forged.json", "forged.json")):
            for option in ([], ["--json"]):
                text = self.run_program("study", "diff", *arguments, *option).stdout
                for raw in "\x1b\x07\u009b\u202e\r\x7f":
                    self.assertNotIn(raw, text)
                self.assertIn("[31m", text)
        # As JSON it is the same text.
        diff = json.loads(self.run_program("study", "diff", "forged.json", "a", "--json").stdout)
        self.assertEqual(diff["a"]["scene"], bad)

    def test_nested_deep(self):
        self.make("a", "--integrators", "midpoint", "--steps", "5e-3")
        nested = "[" * 200000 + "]" * 200000
        self.write("deep.json", '{"runs": ' + nested + "}")
        self.assertIn("not the study.json", self.refused(3, "study", "diff", "a", "deep.json"))
        row = self.path("a", "midpoint-0.005", "study_row.json")
        for text in (nested, '{"inputs": ' + nested + "}", '{"row": ' + nested + "}"):
            for path in (row, self.path("a", "study.json"), self.path("a", "midpoint-0.005", "summary.json")):
                with open(path, "w", encoding="utf-8") as file:
                    file.write(text)
            result = self.run_program("study", self.path("beam.toml"), "--out", "a", *self.GRID,
                                      "--integrators", "midpoint", "--steps", "5e-3", "--resume")  # fmt: skip
            self.assertNotIn("unexpected", result.stderr)

    def test_damaged_members(self):
        self.make("a", "--integrators", "midpoint", "--steps", "5e-3")
        with open(self.path("a", "study.json")) as file:
            whole = json.load(file)

        def without(key):
            return {k: v for k, v in whole.items() if k != key}

        def with_run(**values):
            run = {k: v for k, v in {**whole["runs"][0], **values}.items() if v != "missing"}
            return {**whole, "runs": [run]}

        for damaged, part in (
            (without("reference"), '"reference" is missing'),
            (without("scene"), '"scene" is missing'),
            (without("error"), '"error" is missing'),
            ({**whole, "error": 3}, '"error" is not a text'),
            ({**whole, "reference": 3}, 'in "reference", it is not a table'),
            ({**whole, "reference": {"integrator": "midpoint"}}, '"step" is missing'),
            ({**whole, "reference": {"integrator": "midpoint", "step": -1}}, "not a positive number"),
            ({**whole, "runs": []}, '"runs" is empty'),
            ({**whole, "runs": [3]}, 'in entry 1 of "runs", it is not a table'),
            (with_run(status=3), '"status" is not a text'),
            (with_run(status="great"), '"status" is "great", which is none of ok, unstable'),
            (with_run(wall_seconds="x"), '"wall_seconds" is not a number'),
            (with_run(position_error="missing"), '"position_error" is missing'),
            (with_run(step=None), '"step" is not a positive number'),
            (with_run(step="b"), '"step" is not a number'),
            (with_run(integrator=""), '"integrator" is empty'),
            (with_run(role=None), '"role" is not a text'),
            ({**whole, "interrupted": True}, "has not ended: it was interrupted"),
            (with_run(status="interrupted"), "has not ended: it was interrupted"),
        ):
            self.write("broken.json", json.dumps(damaged))
            for arguments in (("a", "broken.json"), ("broken.json", "a")):
                message = self.refused(3, "study", "diff", *arguments)
                self.assertIn(part, message)
                self.assertIn("broken.json: ", message)

    def test_an_interrupted_study_is_refused(self):
        self.make("a", "--integrators", "midpoint", "--steps", "5e-3")
        scene = self.write("beam.toml", BEAM)
        with subprocess.Popen(
            [PROGRAM, "study", scene, "--out", "s", "--no-plots", "--quiet", "--steps", "1e-5",
             "--integrators", "midpoint", "--frames", "none", "--set", "time.end=100"],
            cwd=self.folder, stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
        ) as process:  # fmt: skip
            history = self.path("s", "midpoint-1e-05", "history.csv")
            while process.poll() is None and not os.path.exists(history):
                time.sleep(0.01)
            process.send_signal(signal.SIGINT)
            process.wait(timeout=60)
        message = self.refused(3, "study", "diff", "a", "s")
        self.assertIn("the study has not ended: it was interrupted", message)
        self.assertIn("--resume", message)
        self.assertIn("B is required", self.refused(2, "study", "diff", "a"))

    def test_options_and_scenes_of_a_study(self):
        """They have no meaning for a comparison. A scene may be called diff."""
        self.make("a", "--integrators", "midpoint", "--steps", "5e-3")
        for arguments, part in (
            (("study", "diff", "a", "a", "--steps", "1e-3"), "study diff has no option --steps"),
            (("study", "--resume", "diff", "a", "a"), "study diff has no option --resume"),
            (("study", "beam.toml", "diff", "a", "a"), '"beam.toml" stands before diff'),
        ):
            self.assertIn(part, self.refused(2, *arguments))
        self.run_program("study", "diff", "a", "a", "--threads", "1")
        os.rename(self.path("beam.toml"), self.path("diff"))
        self.run_program("study", "./diff", "--out", "b", "--integrators", "midpoint", "--steps",
                         "5e-3", *self.GRID)  # fmt: skip
        self.assertIn("1 of 1 runs of A and of 1 runs of B match.",
                      self.run_program("study", "diff", "a", "b").stdout)  # fmt: skip


class Plots(StudyTest):
    def test_the_energy_error_is_relative_to_the_scale_of_the_table(self):
        """The work of moving constraints is energy that entered."""
        self.study("--integrators", "midpoint", "--steps", "0.01", "--set", "time.end=0.05",
                   "--set", "fix.0.velocity=[0.0, 0.1, 0.0]")  # fmt: skip
        plots = plot_script()
        history = plots.read_history({"directory": self.path("s", "midpoint-0.01")})
        with open(self.path("s", "midpoint-0.01", "summary.json")) as file:
            summary = json.load(file)
        drift = summary["max_relative_energy_drift"]
        self.assertGreater(drift, 0.0)
        self.assertAlmostEqual(max(plots.energy_error(history)) / drift, 1.0, delta=1e-6)
        del history["energy_scale"]
        self.assertAlmostEqual(max(plots.energy_error(history)) / drift, 1.0, delta=1e-6)


class Solvers(StudyTest):
    def rows(self):
        with open(self.path("s", "study.csv"), newline="") as file:
            return list(csv.DictReader(file))

    def test_the_table_says_which_solver_a_row_used(self):
        result = self.study("--integrators", "verlet,midpoint,backward-euler", "--steps",
                            "0.005,0.01", "--also-solver", "ceres@0.01")  # fmt: skip
        rows = self.rows()
        self.assertEqual(
            [(r["integrator"], float(r["step"]), r["solver"]) for r in rows],
            [("verlet", 0.005, ""), ("verlet", 0.01, ""), ("midpoint", 0.005, "newton"),
             ("midpoint", 0.01, "newton"), ("midpoint", 0.01, "ceres"),
             ("backward-euler", 0.005, "newton"), ("backward-euler", 0.01, "newton")],
        )  # fmt: skip
        newton, ceres = rows[3:5]
        self.assertEqual(ceres["role"], "run")
        self.assertAlmostEqual(float(ceres["position_error"]) / float(newton["position_error"]), 1,
                               delta=1e-6)  # fmt: skip
        self.assertEqual(ceres["observed_order"], "")  # it is not the next step
        self.assertRegex(result.stdout, r"(?m)^integrator +solver +step")
        self.assertRegex(result.stdout, r"(?m)^verlet +- +0\.005")
        self.assertRegex(result.stdout, r"(?m)^midpoint +newton +0\.01")
        self.assertRegex(result.stdout, r"(?m)^midpoint +ceres +0\.01")
        with open(self.path("s", "study.json")) as file:
            runs = json.load(file)["runs"]
        self.assertEqual([r["compares_solver"] for r in runs], [False] * 4 + [True] + [False] * 2)
        self.assertEqual(runs[4]["directory"], "midpoint-0.01-ceres")
        with open(self.path("s", "midpoint-0.01-ceres", "summary.json")) as file:
            self.assertEqual(json.load(file)["solver"]["kind"], "ceres")

    def test_the_other_solver_has_its_own_linear_solver(self):
        self.study("--integrators", "backward-euler", "--steps", "0.01", "--also-solver",
                   "ceres@0.02,ceres@0.01", "--set", "solver.linear=factor")  # fmt: skip
        self.assertEqual([(float(r["step"]), r["solver"]) for r in self.rows()],
                         [(0.01, "newton"), (0.02, "ceres"), (0.01, "ceres")])  # fmt: skip
        self.study("--integrators", "midpoint", "--steps", "0.01", "--also-solver", "newton@0.01",
                   "--set", "solver.kind=ceres")  # fmt: skip
        self.assertEqual([r["solver"] for r in self.rows()], ["ceres", "newton"])

    def test_what_cannot_be_compared(self):
        grid = ("--integrators", "midpoint", "--steps", "0.01")
        for text in ("ceres", "ceres@", "@0.01", "ceres@x", "ceres@0.01s"):
            self.assertIn("SOLVER@STEP", self.refused_study(*grid, "--also-solver", text))
        self.assertIn("newton and ceres", self.refused_study(*grid, "--also-solver", "lbfgs@0.01"))
        self.assertIn("already", self.refused_study(*grid, "--also-solver", "newton@0.01"))
        self.assertIn("end time", self.refused_study(*grid, "--also-solver", "ceres@5"))
        self.assertIn("end time", self.refused_study(*grid, "--also-solver", "ceres@-1"))
        self.assertIn("counted", self.refused_study(*grid, "--also-solver", "ceres@1e-300"))
        self.assertIn("counted", self.refused_study(*grid, "--reference-step", "1e-300"))
        self.assertIn("counted", self.refused_study(*grid[:2], "--steps", "0.01,1e-300"))
        self.assertIn("twice", self.refused_study(*grid, "--also-solver",
                                                  "ceres@0.01,ceres@1e-2"))  # fmt: skip
        self.assertIn("minimises", self.refused_study("--integrators", "verlet", "--steps", "0.005",
                                                     "--also-solver", "ceres@0.005"))  # fmt: skip
        # Found before the first run.
        nodal = self.refused_study(*grid, "--also-solver", "ceres@0.01", "--set", "mesh.volume=nodal")
        self.assertIn("Ceres cannot take mesh.volume", nodal)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]], verbosity=1)
