"""tetraction view --record: what the window writes, with a real window on a display without a screen."""

import os
import shutil
import signal
import subprocess
import sys

sys.path.insert(0, f"{sys.path[0]}/..")
from support.program import BeamTest, main


class ViewTest(BeamTest):
    def setUp(self):
        super().setUp()
        if shutil.which("Xvfb") is None:
            self.skipTest("there is no Xvfb")
        reading, writing = os.pipe()
        server = subprocess.Popen(
            ["Xvfb", "-displayfd", str(writing), "-screen", "0", "1024x768x24", "-nolisten", "tcp"],
            pass_fds=[writing], stderr=subprocess.DEVNULL)  # fmt: skip
        self.addCleanup(server.wait)
        self.addCleanup(server.kill)
        os.close(writing)
        with os.fdopen(reading) as number:
            display = f":{number.readline().strip()}"
        self.env = {**os.environ, "DISPLAY": display, "XDG_CONFIG_HOME": self.path("config")}

    def view(self, arguments):
        return self.start(f"view {arguments}", env=self.env)

    def end(self, process, signal_number):
        process.send_signal(signal_number)
        self.assertEqual(process.wait(timeout=60), 0, process.stderr.read())

    def rows(self, *names):
        return len(self.read(*names).splitlines()) - 1 if self.exists(*names) else 0

    def check_run(self, out):
        """Every step from the first one on has its row, and the frames are those of the summary."""
        history = self.history(out, "history.csv")
        self.assertEqual([row["step"] for row in history], list(range(len(history))))
        self.assertEqual(history[0]["time"], 0.0)
        self.assertTrue(self.exists(out, "final.vtu"))
        self.assertEqual(self.summary(out)["steps"], len(history) - 1)
        return history

    def test_a_running_window_is_recorded_from_its_first_step_until_a_signal(self):
        for number in (signal.SIGTERM, signal.SIGINT):
            with self.subTest(number):
                out = f"out{number}"
                window = self.view(f"--record {out}")  # the first scene runs
                self.wait_for(lambda: self.rows(out, "history.csv") > 30, window)
                with open(f"/proc/{window.pid}/environ", "rb") as environment:
                    self.assertIn(b"OMP_WAIT_POLICY=", environment.read())
                self.end(window, number)
                self.assertGreater(len(self.check_run(out)), 30)
                self.assertGreater(len(os.listdir(self.path(out, "frames"))), 3)

    def test_a_scene_that_is_paused_has_its_start(self):
        window = self.view("beam.toml --record out")
        self.wait_for_file(window, "out", "frames.pvd")
        self.end(window, signal.SIGTERM)
        recorded = self.check_run("out")
        self.assertEqual(len(recorded), 1)
        # The same numbers as those of tetraction run, which has fewer columns without time.retry.
        self.run_program("run beam.toml --out run --quiet")
        first = self.history("run", "history.csv")[0]
        self.assertEqual({name: recorded[0][name] for name in first}, first)

    def test_a_folder_with_a_run_or_a_finished_run_is_refused(self):
        self.run_program("run beam.toml --out out --quiet")
        self.env["DISPLAY"] = ""
        self.refused(2, "view beam.toml --record out", says=["--record", "already"])
        self.refused(2, "view out --record other", says=["--record", "finished run"])


if __name__ == "__main__":
    main()
