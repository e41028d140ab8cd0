"""How runs end that do not come to their end: kills, signals, full disks, links, two runs at once.

TETRACTION_KILLS sets the number of random kills (default: 20).
"""

import csv
import fcntl
import json
import os
import random
import resource
import shutil
import signal
import stat
import subprocess
import sys
import time
import xml.etree.ElementTree as ElementTree

sys.path.insert(0, f"{sys.path[0]}/..")
from support.program import PROGRAM, BEAM, BeamTest, main, sets
from support.scenes import tables

PROBES = tables(probe=[dict(name="tip", select={"nearest": [4, 1, 1]}, quantity="displacement"),
                dict(name="stress", select={"all": True}, quantity="von_mises", every=3)])
# A run that never ends of itself, with small steps.
ENDLESS = ["--set", "time.end=1000", "--set", "time.integrator=verlet", "--set", "time.step=1e-4"]
# A run whose first step takes very long.
LONG_STEP = ["--set", "mesh.generate.cells=[48,16,16]", "--set", "environment.strength=300",
             "--set", "time.step=10", "--set", "time.end=1e5", "--set", "probe=[]",
             "--set", "solver.max_iterations=1000000", "--set", "solver.tolerance=1e-13"]  # fmt: skip


class EndingTest(BeamTest):
    def setUp(self):
        super().setUp()
        self.write("beam.toml", BEAM + PROBES)

    def start_run(self, *arguments, out="out", **keywords):
        return self.start(f"run beam.toml --out {out}", *arguments, **keywords)

    def wait_for_frames(self, process, count, out="out"):
        folder = self.path(out, "frames")
        self.wait_for(lambda: os.path.isdir(folder) and len(os.listdir(folder)) > count, process)

    def rows_of(self, path):
        """All lines are whole and have the columns of the header."""
        data = self.read_bytes(path)
        self.assertTrue(data.endswith(b"\n"), (path, data[-100:]))
        rows = list(csv.reader(data.decode().splitlines()))
        self.assertGreater(len(rows), 1, path)
        self.assertEqual({len(row) for row in rows}, {len(rows[0])}, path)
        return [dict(zip(rows[0], row)) for row in rows[1:]]

    def check_complete(self, *out):
        """Every file that has its name is whole, and they fit together. The frames that there are."""
        folder = self.path(*out)
        times = []
        if os.path.exists(self.path(*out, "history.csv")):
            rows = self.rows_of(self.path(*out, "history.csv"))
            self.assertEqual([int(row["step"]) for row in rows], list(range(len(rows))))
            times = [float(row["time"]) for row in rows]
        if os.path.exists(self.path(*out, "probes.csv")):
            self.rows_of(self.path(*out, "probes.csv"))
        if os.path.exists(self.path(*out, "summary.json")):
            self.read_json(*out, "summary.json")
        for root, _, names in os.walk(folder):
            for name in names:
                if name.endswith(".vtu"):
                    data = self.read_bytes(os.path.join(root, name))
                    self.assertTrue(data.startswith(b"<VTKFile"), name)
                    self.assertTrue(data.endswith(b"</VTKFile>\n"), name)
        if not os.path.exists(self.path(*out, "frames.pvd")):
            return []
        sets = ElementTree.parse(self.path(*out, "frames.pvd")).getroot().find("Collection")
        frames = [(float(s.get("timestep")), s.get("file")) for s in sets.findall("DataSet")]
        for at, file in frames:
            self.assertTrue(os.path.exists(os.path.join(folder, file)), file)
            self.assertIn(at, times)
        return frames

    def ends(self, process, code, seconds=60):
        """Its messages when it has ended with this exit code, or one of these."""
        _, messages = process.communicate(timeout=seconds)
        self.assertIn(process.returncode, code if isinstance(code, tuple) else (code,), messages)
        return messages

    def one_message(self, messages):
        lines = [line for line in messages.splitlines() if line.startswith("tetraction: ")]
        self.assertEqual(len(lines), 1, messages)
        return lines[0]

    def identity(self, *names):
        """Of a file; None if it is not there."""
        try:
            found = os.stat(self.path(*names))
            return found.st_ino, found.st_ctime_ns
        except FileNotFoundError:
            return None

    def leftovers(self, *out):
        return [n for _, _, names in os.walk(self.path(*out)) for n in names
                if n.endswith(".part") or n == ".lock"]  # fmt: skip


class Kills(EndingTest):
    def test_whatever_is_there_is_whole(self):
        chance = random.Random(4711)
        kills = int(os.environ.get("TETRACTION_KILLS", "20"))
        frames = 0
        for i in range(kills):
            every = chance.choice([1, 1, 2, 7])
            before = self.identity("out", "history.csv")
            process = self.start_run(*ENDLESS, "--set", f"output.every={every}")
            # Most kills come while files are written, some while those of the last run are deleted.
            if chance.random() < 0.9:
                self.wait_for(lambda: self.identity("out", "history.csv") not in (None, before),
                              process)  # fmt: skip
            time.sleep(chance.random() * chance.choice([0.01, 0.1, 0.4]))
            process.kill()
            process.wait()
            with self.subTest(i):
                frames += len(self.check_complete("out"))
        self.assertGreater(frames, kills)
        # The next run replaces all of it and leaves nothing of the killed ones.
        os.makedirs(self.path("out", "frames"), exist_ok=True)
        for name in ("history.csv.part", "final.vtu.part", "frames/frame_999999.vtu.part"):
            self.write(os.path.join("out", name), "half")
        self.run_program("run beam.toml --out out --quiet")
        self.assertEqual(self.leftovers("out"), [])
        self.assertEqual(len(self.check_complete("out")), 4)

    def test_a_study_that_is_killed(self):
        chance = random.Random(42)
        for i in range(4):
            process = self.start("study beam.toml --out s --no-plots --quiet --steps 1e-4,2e-4 "
                                 "--integrators verlet,midpoint --frames all --set time.end=0.05")  # fmt: skip
            self.wait_for_file(process, "s", "study.json")
            time.sleep(chance.random())
            process.kill()
            process.wait()
            with self.subTest(i), open(self.path("s", "study.json")) as file:
                for run in json.load(file)["runs"]:
                    self.check_complete("s", run["directory"])


class Signals(EndingTest):
    CODES = ((signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGHUP, 129), (signal.SIGQUIT, 131))

    def test_the_first_one_ends_a_run_properly(self):
        for number, code in self.CODES:
            with self.subTest(number.name):
                out = number.name
                process = self.start_run(*ENDLESS, "--set", "output.every=50", out=out)
                self.wait_for_frames(process, 2, out)
                process.send_signal(number)
                process.send_signal(number)  # at once again, as timeout(1) does
                messages = self.ends(process, code)
                self.assertIn("stopped on request", messages)
                self.check_complete(out)
                self.assertTrue(os.path.exists(self.path(out, "final.vtu")))
                summary = self.summary(out)
                self.assertEqual(summary["status"], "interrupted")
                self.assertEqual(summary["exit_status"], code)
                self.assertEqual(summary["steps"], len(self.rows_of(self.path(out, "history.csv"))) - 1)
                self.assertEqual(self.leftovers(out), [])

    def test_the_first_one_gives_up_a_load_step(self):
        """An equilibrium may have one step only, and a long one."""
        process = self.start("static beam.toml --out out", *LONG_STEP)
        # history.csv is there just before the first step.
        self.wait_for_file(process, "out", "frames.pvd")
        process.send_signal(signal.SIGINT)
        messages = self.ends(process, 130, 120)
        self.assertIn("stopped on request after step 0 (load factor = 0)", messages)
        self.check_complete("out")
        self.assertTrue(os.path.exists(self.path("out", "final.vtu")))
        summary = self.summary("out")
        self.assertEqual(summary["status"], "interrupted")
        self.assertEqual(summary["exit_status"], 130)
        self.assertEqual(summary["steps"], 0)
        self.assertEqual(self.leftovers("out"), [])

    def test_the_second_one_ends_it_at_once(self):
        """Within a step that takes very long, of every solver."""
        cases = {
            "newton": ["run", *LONG_STEP],
            "factor": ["run", *LONG_STEP, "--set", "solver.linear=\"factor\""],
            "ceres": ["run", *LONG_STEP, "--set", "solver.kind=\"ceres\""],
            "root": ["run", *LONG_STEP, "--set", "time.integrator=\"energy-momentum\""],
        }  # fmt: skip
        for name, arguments in cases.items():
            for number, code in self.CODES[:2]:
                with self.subTest(name, signal=number.name):
                    out = f"{name}-{number.name}"
                    process = self.start(arguments[0], "beam.toml", "--out", out, *arguments[1:])
                    # history.csv is there just before the first step.
                    self.wait_for_file(process, out, "frames.pvd")
                    process.send_signal(number)
                    time.sleep(1)
                    self.assertIsNone(process.poll())  # the step goes on
                    process.send_signal(number)
                    try:
                        _, messages = process.communicate(timeout=20)
                    except subprocess.TimeoutExpired:
                        self.fail("still running after the second signal")
                    self.assertEqual(process.returncode, code, messages)
                    self.assertIn("at once", messages)
                    self.check_complete(out)

    def test_an_ignored_hangup_stays_ignored(self):
        process = self.start_run(*ENDLESS, "--set", "output.every=50",
                                 preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN))  # fmt: skip
        self.wait_for_frames(process, 2)
        process.send_signal(signal.SIGHUP)
        before = len(os.listdir(self.path("out", "frames")))
        self.wait_for_frames(process, before + 2)  # it goes on
        process.send_signal(signal.SIGTERM)
        self.assertEqual(process.wait(timeout=60), 143)

    def test_a_study(self):
        process = self.start("study", "beam.toml", "--out", "s", "--no-plots", *ENDLESS[:2],
                             "--steps", "1e-4", "--integrators", "midpoint", "--frames", "all")  # fmt: skip
        self.wait_for_frames(process, 2, out="s/midpoint-0.0001")
        process.send_signal(signal.SIGTERM)
        self.assertEqual(process.wait(timeout=60), 143)
        self.check_complete("s", "midpoint-0.0001")
        self.assertEqual(self.summary("s", "midpoint-0.0001")["exit_status"], 143)
        self.assertEqual([row["status"] for row in self.table("s", "study.csv")], ["interrupted"])


class Links(EndingTest):
    def test_files_behind_links_are_not_touched(self):
        """A link or a FIFO is replaced by the file."""
        self.run_program("run beam.toml --out out --quiet")
        names = ["history.csv", "probes.csv", "summary.json", "final.vtu", "frames.pvd"]
        os.mkdir(self.path("elsewhere"))
        for name in names:
            self.write(os.path.join("elsewhere", name), "mine")
        for part in ("", ".part"):
            for kind in ("link", "hard link", "fifo"):
                with self.subTest(kind + part):
                    for name in names:
                        path = self.path("out", name + part)
                        if os.path.lexists(path):
                            os.remove(path)
                        if kind == "link":
                            os.symlink(self.path("elsewhere", name), path)
                        elif kind == "hard link":
                            os.link(self.path("elsewhere", name), path)
                        else:
                            os.mkfifo(path)
                    self.run_program("run beam.toml --out out --quiet")
                    for name in names:
                        self.assertEqual(self.read("elsewhere", name), "mine", name)
                        found = os.lstat(self.path("out", name))
                        self.assertTrue(stat.S_ISREG(found.st_mode) and found.st_nlink == 1, name)
                    self.assertEqual(self.leftovers("out"), [])
                    self.check_complete("out")

    def test_a_study_does_not_wait_for_a_pipe(self):
        os.mkdir(self.path("out"))
        for name in ("study.json", "study.csv"):
            os.mkfifo(self.path("out", name))
        self.run_program("study", "beam.toml", "--integrators", "verlet", "--steps", "1e-4", "--out", "out",
                         "--frames", "none")
        for name in ("study.json", "study.csv"):
            self.assertTrue(stat.S_ISREG(os.lstat(self.path("out", name)).st_mode), name)

    def test_linked_folders_are_refused(self):
        frames = self.path("elsewhere")
        os.mkdir(frames)
        self.write("elsewhere/frame_000001.vtu", "mine")
        os.mkdir(self.path("out"))
        self.write("out/history.csv", "mine")
        os.symlink(frames, self.path("out", "frames"))
        message = self.refused(4, "run beam.toml --out out")
        self.assertIn("link", message)
        # The same message appears in the window, which has no such option.
        self.assertIn("choose another directory (on the command line: --out)", message)
        self.assertEqual(os.listdir(frames), ["frame_000001.vtu"])
        self.assertEqual(os.listdir(self.path("out")).sort(), ["history.csv", "frames"].sort())
        # The folders of a study's runs, and that of the modes' pictures.
        os.mkdir(self.path("s"))
        os.symlink(frames, self.path("s", "midpoint-0.05"))
        self.refused(4, "study", "beam.toml", "--out", "s", "--steps", "0.05",
                                           "--integrators", "midpoint", "--quiet", "--no-plots", says="link")  # fmt: skip
        os.mkdir(self.path("m"))
        os.symlink(frames, self.path("m", "swing"))
        self.assertIn("link", self.refused(4, "modes beam.toml --out m -n 1"))
        self.assertEqual(os.listdir(frames), ["frame_000001.vtu"])

    def test_an_output_directory_that_is_a_link(self):
        """The user named it, so it is followed."""
        os.mkdir(self.path("disk"))
        os.symlink(self.path("disk"), self.path("out"))
        self.run_program("run beam.toml --out out --quiet")
        self.assertTrue(os.path.exists(self.path("disk", "summary.json")))


class Lock(EndingTest):
    def test_two_runs_do_not_write_into_one_directory(self):
        first = self.start_run(*ENDLESS, "--set", "output.every=50")
        self.wait_for_frames(first, 1)
        others = [["run"], ["static"]]
        for command in others:
            self.refused(4, *command, "beam.toml", "--out", "out",
                         says=("another run is writing here", f"process {first.pid}"))
        self.assertIsNone(first.poll())
        first.kill()
        first.wait()
        # A run that was killed leaves no lock.
        self.run_program("run beam.toml --out out --quiet")
        self.assertEqual(self.leftovers("out"), [])

    def test_a_study_and_a_run_in_one_of_its_folders(self):
        study = self.start("study", "beam.toml", "--out", "s", "--no-plots", *ENDLESS[:2],
                           "--steps", "1e-4", "--integrators", "midpoint", "--frames", "all")  # fmt: skip
        folder = os.path.join("s", "midpoint-0.0001")
        self.wait_for_frames(study, 1, out=folder)
        arguments = ["--steps", "1e-4", "--integrators", "midpoint", "--no-plots", "--quiet"]
        for command in (["run", "beam.toml", "--out", folder],
                        ["study", "beam.toml", "--out", "s", *arguments]):  # fmt: skip
            self.assertIn("another run", self.refused(4, *command))
        self.assertIsNone(study.poll())
        study.kill()
        study.wait()
        # The run that the study has left is in use.
        run = self.start_run(*ENDLESS, out=folder)
        self.wait_for(lambda: self.locked(folder), run)
        self.refused(4, "study beam.toml --out s", *arguments, says="another run")
        self.assertIsNone(run.poll())

    def locked(self, folder):
        try:
            with open(self.path(folder, ".lock"), "r+") as file:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                return False
        except FileNotFoundError:
            return False
        except BlockingIOError:
            return True

    def test_a_lock_that_is_no_file(self):
        os.mkdir(self.path("out"))
        os.mkfifo(self.path("out", ".lock"))
        self.assertIn(".lock", self.refused(4, "run beam.toml --out out"))
        os.remove(self.path("out", ".lock"))
        os.symlink(self.path("beam.toml"), self.path("out", ".lock"))
        self.assertIn(".lock", self.refused(4, "run beam.toml --out out"))
        os.remove(self.path("out", ".lock"))
        self.write("mine", "not to be emptied")
        os.link(self.path("mine"), self.path("out", ".lock"))
        self.assertIn(".lock", self.refused(4, "run beam.toml --out out"))
        self.assertEqual(self.read("mine"), "not to be emptied")
        self.assertEqual(self.read("beam.toml"), BEAM + PROBES)


class Disk(EndingTest):
    def limited(self, size):
        """Files beyond this size cannot be written, as on a full disk."""
        return lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))

    def test_a_file_that_cannot_grow(self):
        """The history is cut at a whole row; the last state is there all the same."""
        process = self.start_run(*ENDLESS, "--set", "output.every=100000", "--quiet",
                                 preexec_fn=self.limited(200_000))  # fmt: skip
        messages = self.ends(process, 4, 120)
        self.assertIn("history.csv: cannot be written (File too large)", self.one_message(messages))
        self.check_complete("out")
        self.assertTrue(os.path.exists(self.path("out", "final.vtu")))
        summary = self.summary("out")
        self.assertEqual((summary["status"], summary["exit_status"]), ("failed", 4))
        self.assertIn("history.csv", summary["message"])
        self.assertEqual(self.leftovers("out"), [])

    def test_a_frame_that_cannot_be_written(self):
        """The folder of the frames vanishes and a file takes its name: final.vtu is there."""
        process = self.start_run(*ENDLESS, "--set", "output.every=50", "--quiet")
        self.wait_for_frames(process, 3)
        os.rename(self.path("out", "frames"), self.path("away"))
        try:
            self.write("out/frames", "")
        except IsADirectoryError:  # the run has made it again in between
            os.rename(self.path("out", "frames"), self.path("away2"))
            self.write("out/frames", "")
        messages = self.ends(process, 4)
        self.assertIn("out/frames", messages)
        self.assertTrue(self.read_bytes("out", "final.vtu").endswith(b"</VTKFile>\n"))
        self.assertEqual(self.summary("out")["status"], "failed")
        self.rows_of(self.path("out", "history.csv"))

    def test_a_directory_that_vanishes(self):
        for every in ("50", "1000000"):
            with self.subTest(every=every):
                process = self.start_run(*ENDLESS, "--set", f"output.every={every}", "--quiet")
                self.wait_for_file(process, "out", "frames.pvd")
                os.rename(self.path("out"), self.path("away" + every))
                if every != "50":
                    process.send_signal(signal.SIGINT)
                messages = self.ends(process, 4)
                self.one_message(messages)
                self.rows_of(self.path("away" + every, "history.csv"))

    def test_a_full_disk(self):
        """A small file system in memory, where the machine allows one."""
        with self.small_disk("disk", 300):
            process = self.start_run(*ENDLESS, "--set", "output.every=5", "--quiet", out="disk/out")
            messages = self.ends(process, 4, 120)
            self.assertIn("No space left", self.one_message(messages))
            self.assertGreater(len(self.check_complete("disk", "out")), 2)
            self.assertEqual(self.leftovers("disk", "out"), [])

    def test_a_disk_that_is_full_when_plots_are_drawn(self):
        study = ("study", "beam.toml", "--steps", "0.05", "--integrators", "midpoint", "--quiet")
        self.run_program(*study, "--no-plots", "--out", "s")
        plain = sum(os.path.getsize(os.path.join(folder, name)) // 4096 + 2
                    for folder, _, names in os.walk(self.path("s")) for name in names)  # fmt: skip
        for free in (3, 15, 30):  # pages beside the tables and the page of the study
            with self.small_disk("disk", 4 * (plain + free)):
                process = self.start(*study, "--out", "disk/s")
                messages = self.ends(process, (0, 4), 120)
                self.assertIn("No space left", messages)
                for line in messages.splitlines():
                    self.assertRegex(line, "^(tetraction|plot_study): ")
                # The run and the one that tells the error of the reference.
                self.assertEqual(len(self.table("disk", "s", "study.csv")), 2)
                self.assertEqual(self.leftovers("disk", "s"), [])


class Security(EndingTest):
    def test_a_scene_does_not_choose_a_directory_elsewhere(self):
        os.mkdir(self.path("work"))
        for directory in ("../away", self.path("away"), "a/../../away", ".."):
            scene = self.write("work/scene.toml", BEAM + f'directory = "{directory}"\n')
            for command in (["run"], ["static"], ["modes"], ["study", "--no-plots"]):
                with self.subTest(directory, command=command[0]):
                    result = self.run_program(*command, scene, code=2, cwd=self.path("work"))
                    self.assertIn("--out", result.stderr)
                    self.assertFalse(os.path.exists(self.path("away")))
                    self.assertEqual(os.listdir(self.path("work")), ["scene.toml"])
        # The command line may.
        for say in (["--out", "../away"], ["--set", "output.directory=../away"]):
            self.run_program(f"run {scene} --quiet", *say, cwd=self.path("work"))
            self.assertTrue(os.path.exists(self.path("away", "summary.json")))
            shutil.rmtree(self.path("away"))

    def test_a_scene_does_not_choose_a_directory_behind_a_link(self):
        work, elsewhere = self.path("work"), self.path("elsewhere")
        os.makedirs(os.path.join(work, "real", "deep"))
        os.makedirs(os.path.join(elsewhere, "deep"))
        os.symlink("../elsewhere", os.path.join(work, "le"))
        os.symlink("../elsewhere/deep", os.path.join(work, "deep"))
        os.symlink("../nothing", os.path.join(work, "dangling"))
        os.symlink("real/deep", os.path.join(work, "own"))
        for directory in ("le", "le/", "le/sub", "new/../le/sub", "deep/../out", "real/../le", "./le",
                          "own/../../le/x", "dangling", "dangling/sub", "a/..", ".", "own/../.."):  # fmt: skip
            scene = self.write("work/scene.toml", BEAM + f'directory = "{directory}"\n')
            for command in (["run"], ["static"], ["modes"], ["study", "--no-plots"]):
                with self.subTest(directory, command=command[0]):
                    result = self.run_program(*command, scene, code=2, cwd=work)
                    self.assertIn("--out", result.stderr)
        self.assertEqual(os.listdir(elsewhere), ["deep"])
        self.assertEqual(os.listdir(os.path.join(elsewhere, "deep")), [])
        self.assertEqual(sorted(os.listdir(work)),
                         ["dangling", "deep", "le", "own", "real", "scene.toml"])  # fmt: skip
        # Links that stay below the working directory, and what the command line says.
        for directory, place in (("own/out", "real/deep/out"), ("own/../out", "real/out"),
                                 ("new/../other", "other")):  # fmt: skip
            scene = self.write("work/scene.toml", BEAM + f'directory = "{directory}"\n')
            self.run_program(f"run {scene} --quiet", cwd=work)
            self.assertTrue(os.path.exists(os.path.join(work, place, "summary.json")), place)
        self.run_program(f"run {scene} --quiet --out le", cwd=work)
        self.assertTrue(os.path.exists(os.path.join(elsewhere, "summary.json")))

    def test_no_shell_sees_the_names(self):
        """The plots get their directory as an argument."""
        name = "s $(touch mine) `touch mine` '; touch mine; \" é"
        self.run_program("study", "beam.toml", "--out", name, "--steps", "0.05", "--integrators",
                         "midpoint", "--quiet")  # fmt: skip
        self.assertFalse(os.path.exists(self.path("mine")))
        self.assertTrue(os.path.exists(self.path(name, "energy_over_time.png")))


class Pipes(EndingTest):
    def shell(self, command, code):
        result = subprocess.run(["bash", "-c", "set -o pipefail; " + command, PROGRAM], timeout=300,
                                capture_output=True, text=True, cwd=self.folder)  # fmt: skip
        self.assertEqual(result.returncode, code, command + "\n" + result.stdout + result.stderr)
        return result.stderr

    def test_every_command_into_a_pipe_that_nobody_reads(self):
        """One rule: exit code 4 and one message; the files are there."""
        self.run_program("mesh generate box box.msh")
        commands = [
            "run beam.toml --out out", "static beam.toml --out st", "check beam.toml", "keys",
            "modes beam.toml -n 2 --out m", "mesh info box.msh", "mesh generate box b.msh",
            "study beam.toml --out s --steps 0.05 --integrators midpoint --no-plots --quiet --json",
        ]  # fmt: skip
        for command in commands:
            with self.subTest(command):
                # The reader is gone before anything is written.
                messages = self.shell(f'(sleep 0.3; "$0" {command}) | true', 4)
                self.assertEqual(messages.count("tetraction: the results cannot be written"), 1)
        self.assertTrue(os.path.exists(self.path("out", "summary.json")))

    def test_little_memory(self):
        """OpenBLAS asks for memory without end, so the program ends before it does."""
        code = self.read_bytes(sys.argv[1])
        if b"__asan_init" in code or b"__tsan_init" in code:
            self.skipTest("sanitizers need a large address space")
        for size in (280_000, 300_000, 350_000):
            for command in ("run beam.toml --out out", "keys"):
                with self.subTest(size=size, command=command):
                    messages = self.shell(f'ulimit -v {size}; "$0" {command}', 1)
                    self.assertEqual(messages.count("tetraction: "), 1, messages)
                    self.assertIn("ulimit -v", messages)
        # Enough of it, also with a thread for each of many cores.
        self.shell('export OPENBLAS_NUM_THREADS=2; ulimit -v 600000; "$0" run beam.toml --out out '
                   "--threads 1", 0)  # fmt: skip


if __name__ == "__main__":
    main()
