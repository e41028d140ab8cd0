"""What `tetraction study` writes of each run, and solvers side by side.

Usage: study_test.py PROGRAM DATA_FOLDER [TestCase...]
"""

import csv
import importlib.util
import json
import os
import shutil
import signal
import subprocess
import sys
import time
import unittest

from cli_test import BEAM, CliTest

PROGRAM = os.path.abspath(sys.argv[1])


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
        self.assertIn("s/verlet-0.025/frames.pvd", text.splitlines()[-1])

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
                [PROGRAM, "study", scene, "--out", "s", "--no-plots", "--steps", "1e-5,0.01",
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
            with open(self.path("s", "study.csv"), newline="") as file:
                self.assertEqual([r["status"] for r in csv.DictReader(file)], ["cancelled"])
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


class Plots(StudyTest):
    def test_the_energy_error_is_relative_to_the_scale_of_the_table(self):
        """The work of moving constraints is energy that entered."""
        self.study("--integrators", "midpoint", "--steps", "0.01", "--set", "time.end=0.05",
                   "--set", "fix.0.velocity=[0.0, 0.1, 0.0]")  # fmt: skip
        script = os.path.join(os.path.dirname(__file__), "..", "..", "src", "cli", "plot_study.py")
        spec = importlib.util.spec_from_file_location("plot_study", script)
        plots = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(plots)
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
        self.assertIn("implicit", self.refused_study("--integrators", "verlet", "--steps", "0.005",
                                                     "--also-solver", "ceres@0.005"))  # fmt: skip


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]], verbosity=1)
