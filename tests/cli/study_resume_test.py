"""Runs that are kept, studies that were stopped, and several runs at a time."""

import glob
import os
import random
import shutil
import signal
import stat
import sys
import time

sys.path.insert(0, f"{sys.path[0]}/..")
from support.program import BEAM, files_below, main
from support.scenes import tables
from support.study import StudyTest, plot_functions


class KeptRuns(StudyTest):
    GRID = ["--integrators", "verlet,midpoint", "--steps", "0.0005,0.001", "--frames", "none",
            "--repeats", "0", "--set", "time.end=0.5"]  # fmt: skip
    ALL = ("verlet-0.0005", "verlet-0.001", "midpoint-0.0005", "midpoint-0.001")

    def lasting_table(self):
        """All columns but times and the command."""
        rows = self.table("s", "study.csv")
        other = ("wall_seconds", "processor_seconds", "seconds_per_simulated_second", "date", "command")
        return [{k: v for k, v in row.items() if k not in other} for row in rows]

    def written(self, run):
        """Changes whenever a file of the run is written again, even on a file system that uses the number
        of a deleted file again."""
        status = {}
        for name in sorted(os.listdir(self.path("s", run))):
            found = os.stat(self.path("s", run, name))
            status[name] = found.st_ino, found.st_mtime_ns
        self.assertIn("study_track.bin", status)
        return status

    def histories(self):
        return {run: (self.read_bytes("s", run, "history.csv"), self.written(run)) for run in self.runs()}

    def kill_after_two_runs(self, grid):
        """Begins the study and kills it when the reference and one more run are complete. Returns
        the complete runs, or nothing if the study had ended before it was killed."""
        shutil.rmtree(self.path("s"), ignore_errors=True)

        def complete():
            return [r for r in self.ALL if self.exists("s", r, "study_row.json")]

        def complete_in_journal():
            # The journal comes after the row of a run, so that both name these runs.
            try:
                return self.read("s", "study_runs.csv").count(",complete\n")
            except FileNotFoundError:
                return 0

        process = self.start("study beam.toml --out s --no-plots --quiet", *grid)
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
        written = {r: self.written(r) for r in complete}
        self.assertIn(f"{len(complete)} of 4 runs were kept", self.study(*grid).stderr)
        self.assertEqual({r: self.written(r) for r in complete}, written)
        table = self.lasting_table()
        texts = {r: text for r, (text, _) in self.histories().items()}
        self.study(*grid, "--fresh")
        self.assertEqual(table, self.lasting_table())
        self.assertEqual(texts, {r: text for r, (text, _) in self.histories().items()})

    def test_a_study_that_is_ended_at_any_time_goes_on(self):
        study = ["study beam.toml --out s --quiet --width 85", *self.GRID]
        self.run_program(*study)
        table, files = self.lasting_table(), sorted(os.listdir(self.path("s")))
        for number, begun in ((signal.SIGTERM, "midpoint-0.001/history.csv"), (signal.SIGINT, "study.csv"),
                              (signal.SIGKILL, "error_over_step.png")):  # fmt: skip
            shutil.rmtree(self.path("s"))
            process = self.start(*study)
            self.wait_for_file(process, "s", begun)
            time.sleep(random.random() * 0.1)
            process.send_signal(number)
            process.communicate()
            self.assertIn(process.returncode, (-number, 128 + number, 0), begun)
            self.run_program(*study)
            self.assertEqual(self.lasting_table(), table, (number, begun))
            self.assertEqual(sorted(os.listdir(self.path("s"))), files, (number, begun))

    def test_the_same_study_makes_no_run(self):
        self.study(*self.GRID)
        whole, before = self.lasting_table(), self.histories()
        for more in ((), ("--resume",), ("--jobs", "2"), ("--threads", "1"), ("--set", "output.every=3")):
            result = self.study(*self.GRID, *more)
            self.assertIn("the study was complete, and no run was made", result.stderr)
            self.assertEqual((self.lasting_table(), self.histories()), (whole, before))
        # Everything is made anew.
        self.assertIn("deleted", self.study(*self.GRID, "--fresh").stderr)
        self.assertNotEqual(self.histories(), before)
        self.assertEqual(self.lasting_table(), whole)
        self.assertIn("--fresh", self.refused(2, "study beam.toml --out s --resume --fresh"))

    def test_a_run_whose_files_are_damaged_is_made_again(self):
        self.study(*self.GRID)
        whole = self.lasting_table()
        track = self.path("s", "verlet-0.001", "study_track.bin")

        def cut():
            os.truncate(track, os.path.getsize(track) - 8)

        def change():
            with open(track, "r+b") as file:
                file.seek(os.path.getsize(track) // 2)
                byte = file.read(1)
                file.seek(-1, os.SEEK_CUR)
                file.write(bytes([byte[0] ^ 1]))

        def take_another():
            shutil.copy(self.path("s", "midpoint-0.001", "study_track.bin"), track)

        others = {r: self.written(r) for r in self.ALL if r != "verlet-0.001"}
        for damage in (cut, change, take_another, lambda: os.truncate(track, 0), lambda: os.remove(track),
                       lambda: os.remove(self.path("s", "verlet-0.001", "final.vtu")),
                       lambda: self.write("s/verlet-0.001/study_row.json", "{}")):  # fmt: skip
            damage()
            self.assertIn("3 of 4 runs were kept", self.study(*self.GRID).stderr)
            self.assertEqual(self.lasting_table(), whole)
        self.assertEqual({r: self.written(r) for r in others}, others)

    def test_only_what_is_new_is_made(self):
        self.study(*self.GRID)
        before = self.histories()
        errors = {r["step"] + r["integrator"]: r["position_error"] for r in self.rows()}
        # One step more, one rule more.
        steps = [*self.GRID[:2], "--steps", "0.0005,0.001,0.002", *self.GRID[4:]]
        self.assertIn("4 of 6 runs were kept", self.study(*steps).stderr)
        for row in self.rows():
            known = errors.get(row["step"] + row["integrator"], row["position_error"])
            self.assertEqual(row["position_error"], known)
        more = ["--integrators", "verlet,midpoint,explicit", *steps[2:]]
        self.assertIn("6 of 9 runs were kept", self.study(*more).stderr)
        self.assertEqual({r: b for r, b in self.histories().items() if r in before}, before)
        # Another reference: one run, and no other.
        said = self.study(*self.GRID, "--reference-step", "0.00025")
        self.assertIn("4 of 5 runs were kept", said.stderr)
        # Runs that are not asked for any more stay on the disk and are not listed.
        self.study("--integrators midpoint", *self.GRID[2:])
        self.assertEqual({r["directory"] for r in self.result()["runs"]}, {"midpoint-0.0005", "midpoint-0.001"})
        self.assertEqual(len(self.rows()), 2)
        self.assertEqual(len(self.runs()), 10)
        self.assertIn("no run was made", self.study(*self.GRID).stderr)
        self.assertEqual({r: b for r, b in self.histories().items() if r in before}, before)
        # A fresh study deletes all of them.
        self.study(*self.GRID, "--fresh")
        self.assertEqual(set(self.runs()), set(self.ALL))

    def test_an_edited_scene_is_the_same_study(self):
        self.study(*self.GRID)
        for change in (["--set", "material.density=900"], ["--set", "mesh.generate.cells=[9,2,2]"],
                       ["--set", "solver.tolerance=1e-9"], ["--set", "time.end=0.1"]):  # fmt: skip
            with self.subTest(change[1]):
                result = self.study(*self.GRID, *change)
                self.assertIn("0 of 4 runs were kept", result.stderr)
                self.assertEqual(set(self.runs()), set(self.ALL))

    def test_the_study_of_another_scene_is_not_deleted(self):
        self.study(*self.GRID)
        before = files_below(self.path("s"))
        other = self.write("other.toml", BEAM)
        message = self.refused(2, "study", other, "--out", "s", *self.GRID)
        self.assert_parts(message, ("another scene, beam", "--fresh", "--out"))
        self.assertEqual(files_below(self.path("s")), before)
        self.run_program("study", other, "--out", "s", "--no-plots", "--fresh", "--integrators", "verlet",
                         "--steps", "0.002", "--set", "time.end=0.02")  # fmt: skip
        self.assertEqual(set(self.runs()), {"verlet-0.002", "midpoint-0.002", "midpoint-0.004"})
        # Also of one that was cut off.
        process = self.begin("verlet-1e-05", "--fresh --steps 1e-5 --integrators verlet --reference-integrator "
                             "verlet --set time.end=100")  # fmt: skip
        process.kill()
        process.wait()
        self.assertIn("another scene, beam", self.refused(2, "study", other, "--out", "s"))

    def test_folders_that_have_vanished_are_named(self):
        self.study(*self.GRID)
        whole = self.lasting_table()
        shutil.rmtree(self.path("s", "verlet-0.001"))
        result = self.study(*self.GRID)
        self.assertIn("the folder of a complete run is no longer there, and the run is made again: "
                      "verlet-0.001", result.stderr)  # fmt: skip
        self.assertEqual(self.lasting_table(), whole)
        for run in ("verlet-0.001", "midpoint-0.001"):
            shutil.rmtree(self.path("s", run))
        result = self.study(*self.GRID)
        self.assertIn("the folders of 2 complete runs are no longer there", result.stderr)
        self.assertNotIn("no longer there", self.study(*self.GRID).stderr)

    def test_files_of_runs_that_are_no_files(self):
        study = ("study", "beam.toml", "--out", "s", *self.GRID, "--quiet")
        self.study(*self.GRID)
        whole = self.lasting_table()
        history = self.path("s", "verlet-0.001", "history.csv")
        for make in (os.mkfifo, lambda path: os.symlink("/dev/zero", path)):
            os.remove(history)
            make(history)
            self.run_program(*study)
            self.assertEqual(self.lasting_table(), whole)
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
        files = plot_functions("files")
        os.mkfifo(self.path("pipe"))
        os.symlink("/dev/zero", self.path("zero"))
        for name in ("pipe", "zero"):
            self.assertEqual(files.read_json(self.folder, name), {})
            self.assertEqual(files.read_columns(self.folder, name), {})

    def test_folders_that_have_vanished_from_a_study_that_was_killed(self):
        for end in (0.5, 2.0, 8.0, 32.0):
            grid = [*self.GRID, "--set", f"time.end={end}"]
            complete = self.kill_after_two_runs(grid)
            if complete:
                break
        shutil.rmtree(self.path("s", complete[0]))
        self.assertIn(f"made again: {complete[0]}", self.study(*grid).stderr)

    def test_all_folders_of_a_reference_belong_to_the_study(self):
        grid = ("--integrators", "verlet", "--steps", "0.001", "--reference", "richardson",
                "--set", "time.end=0.1")  # fmt: skip
        self.study(*grid)
        self.assertEqual(len(self.runs()), 4)
        self.assertEqual({r["directory"] for r in self.result()["runs"]}, set(self.runs()))
        self.study("--integrators verlet --steps 0.002 --set time.end=0.1 --fresh")
        self.assertEqual(set(self.runs()), {"verlet-0.002", "midpoint-0.002", "midpoint-0.004"})

    def test_what_is_stored_of_a_run_does_not_grow_with_the_study(self):
        """Otherwise the time of a study grows with the square of the number of its variants."""
        grid = ("--integrators", "midpoint", "--steps", "0.01", "--set", "time.end=0.02", "--quiet",
                "--set", "mesh.generate.cells=[2,1,1]")  # fmt: skip
        sizes = []
        for count in (2, 12):
            values = ",".join(str(1000 + i) for i in range(count))
            self.study(*grid, "--fresh", "--vary", f"material.density={values}")
            sizes.append(os.path.getsize(self.path("s", "1001-midpoint-0.01", "study_row.json")))
            journal = [(r["run"], r["state"]) for r in self.table("s", "study_runs.csv")]
            self.assertEqual({run for run, state in journal if state == "complete"},
                             {f"{1000 + i}-midpoint-{h}" for i in range(count) for h in ("0.01", "0.02")})
            self.assertEqual(len(journal), 4 * count)
        self.assertLess(abs(sizes[1] - sizes[0]), 100)  # wall times have more or fewer digits


class Jobs(StudyTest):
    """Several runs at a time. With more threads than cores their wall times do not count."""

    GRID = ("--integrators", "verlet,midpoint,energy-momentum", "--steps", "1e-3,2e-3,4e-3")
    # Runs whose times do not count are not repeated.
    TIMES = ("wall_seconds", "processor_seconds", "seconds_per_simulated_second", "date", "command", "timing",
             "repeats", "time_scatter")

    def lasting_table(self):
        """The whole table but for what depends on the machine's load."""
        return [{k: v for k, v in r.items() if k not in self.TIMES} for r in self.rows()]

    def files(self, name):
        found = {}
        for run in self.runs():
            found[run] = self.read_bytes("s", run, name)
        return found

    def test_the_same_bits_as_one_run_at_a_time(self):
        for more in ((), ("--reference", "richardson"), ("--threads", "1"),
                     ("--vary", "mesh.generate.cells=[8,2,2],[6,2,2]", "--threads", "2")):  # fmt: skip
            with self.subTest(more):
                results = []
                for jobs in ("1", "2", "5"):
                    self.study(*self.GRID, *more, "--jobs", jobs, "--quiet", "--fresh")
                    runs = self.read_json("s", "study.json")["runs"]
                    results.append((
                        self.lasting_table(), self.files("history.csv"), self.files("final.vtu"),
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
            self.study(*grid, "--jobs", jobs, "--threads", "1", "--fresh")
            tables.append((self.lasting_table(), self.files("final.vtu")))
        self.assertEqual(tables[0], tables[1])

    def test_wall_times_of_runs_that_share_cores_do_not_count(self):
        cores = len(os.sched_getaffinity(0))
        said = self.study(*self.GRID, "--jobs", "3", "--threads", str(cores), "--all")
        self.assertIn(f"3 runs at a time with {cores} thread", said.stderr)
        self.assertIn("wall times of runs that share them do not count", said.stderr)
        rows = self.rows()
        self.assertEqual({r["timing"] for r in rows}, {"shared"})
        # It is not known either for which run the threads have worked.
        if cores > 1:
            self.assertEqual({r["processor_seconds"] for r in rows}, {""})
        study = self.read_json("s", "study.json")
        self.assertEqual([r["timing"] for r in study["runs"]], [r["timing"] for r in rows])
        cost = next(c for c in study["conclusions"] if c["topic"] == "Cost of accuracy")
        self.assertEqual(len(cost["sentences"]), 1)
        self.assert_parts(cost["sentences"][0], ("timings are missing", "with --jobs 1"))
        self.assertRegex(said.stdout, r"(?m)^verlet +- +0\.001 .* [0-9.e-]+\* ")
        self.assertIn("wall [s] with *", said.stdout)
        self.assertIn("Wall times with * do not count", self.read("s", "study.html"))
        # The marks stay with runs that are kept. There is no plot of cost.
        self.run_program("study beam.toml --out s", *self.GRID, "--quiet")
        self.assertEqual(self.rows(), [{**r, "command": self.rows()[0]["command"]} for r in rows])
        self.assertFalse(self.exists("s", "work_precision.png"))
        self.assertTrue(self.exists("s", "error_over_step.png"))
        diff = self.json_of("study diff s s")
        self.assertEqual({r["wall_ratio"] for r in diff["runs"]}, {None})
        self.assertIn("--jobs 1", " ".join(diff["notes"]))

    def test_wall_times_of_runs_with_a_core_each_count(self):
        cores = len(os.sched_getaffinity(0))
        said = self.study(*self.GRID, "--jobs", str(cores), "--threads", "1")
        self.assertEqual({r["timing"] for r in self.rows()}, {"alone"})
        for row in self.rows():
            self.assertGreater(float(row["processor_seconds"]), 0.0)
            self.assertLess(float(row["processor_seconds"]), 1.1 * float(row["wall_seconds"]) + 0.01)
        self.assertNotIn("do not count", said.stderr + said.stdout)

    def test_a_run_with_more_threads_than_cores_is_not_alone(self):
        cores = len(os.sched_getaffinity(0))
        said = self.study(*self.GRID, "--threads", str(2 * cores))
        self.assertEqual({r["timing"] for r in self.rows()}, {"shared"})
        self.assertIn(f"With --threads {cores} they would", said.stderr)
        self.study(*self.GRID, "--jobs", "2", "--threads", str(cores + 1), "--quiet", "--fresh")
        self.assertEqual({r["timing"] for r in self.rows()}, {"shared"})

    def test_interrupted_and_resumed(self):
        grid = ["--integrators", "verlet,midpoint", "--steps", "2e-4,4e-4,1e-3", "--frames", "none",
                "--set", "time.end=2", "--threads", "1", "--repeats", "0"]  # fmt: skip

        def complete():
            return set(glob.glob(self.path("s", "*", "study_row.json")))

        process = self.start("study beam.toml --out s --no-plots --jobs 2", *grid)
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
                self.assertTrue(self.exists("s", run, "summary.json"))
        kept = complete()
        written = {path: os.stat(path).st_mtime_ns for path in kept}
        self.study(*grid, "--jobs", "2", "--quiet")
        self.assertEqual({path: os.stat(path).st_mtime_ns for path in kept}, written)
        table, histories = self.lasting_table(), self.files("history.csv")
        self.study(*grid, "--quiet", "--fresh")
        self.assertEqual((table, histories), (self.lasting_table(), self.files("history.csv")))

    def test_the_drawing_of_plots_can_be_interrupted(self):
        """Everything but the plots is there, and the same command draws them."""
        study = "study beam.toml --out s --integrators midpoint --steps 0.01,0.02 --repeats 0"
        process = self.start(study)
        lines = []
        for line in process.stderr:
            lines.append(line)
            if "drawing the plots" in line:
                break
        time.sleep(0.3)
        process.send_signal(signal.SIGINT)
        _, messages = process.communicate(timeout=60)
        if process.returncode != 0:  # a fast machine may have drawn them
            self.assertEqual(process.returncode, 130, messages)
            self.assertIn("the drawing of the plots was interrupted: the same command draws them", messages)
            self.assertNotIn("Traceback", messages)
            self.assertNotIn("warning", messages)
            self.assertIn("their drawing was interrupted", self.read("s", "study.html"))
            self.assertTrue(self.exists("s", "study.csv"))
        said = self.run_program(study)
        self.assertIn("no run was made", said.stderr)
        self.assertTrue(self.exists("s", "error_over_step.png"))

    def test_a_choice_of_steps_that_is_interrupted_makes_no_plan(self):
        process = self.start("study beam.toml --out s --no-plots --integrators verlet,midpoint --frames none",
                             "--set", "time.end=50", "--budget", "1h")  # fmt: skip
        while process.poll() is None and not glob.glob(self.path("s", "*", "history.csv")):
            time.sleep(0.002)
        process.send_signal(signal.SIGINT)
        _, messages = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 130, messages)
        self.assertIn("interrupted while its steps were chosen", messages)
        self.assertNotIn("reference:", messages)
        self.assertFalse(self.exists("s", "study.csv"))
        self.assertFalse(self.exists("s", "study.html"))

    def test_a_run_that_cannot_write_ends_the_others(self):
        """One message, and no further run begins."""
        os.makedirs(self.path("s", "verlet-0.002", "history.csv"))
        message = self.refused(4, "study", "beam.toml", "--out", "s", "--no-plots", "--quiet", *self.GRID,
                               "--set", "time.end=20", "--jobs", "2")  # fmt: skip
        self.assertIn("verlet-0.002/history.csv", message)

    def test_numbers_of_jobs_that_are_wrong(self):
        for text in ("0", "-1", "abc", "1.5", "", "99999"):
            with self.subTest(text):
                self.assertIn("--jobs", self.refused_study(f"--jobs={text}"))


if __name__ == "__main__":
    main()
