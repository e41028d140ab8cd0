"""`tetraction study diff`."""

import json
import os
import re
import shutil
import signal
import sys

sys.path.insert(0, f"{sys.path[0]}/..")
from support.program import main
from support.study import StudyTest


class Diff(StudyTest):
    GRID = ("--no-plots", "--quiet", "--reference-step", "5e-4")

    def make(self, name, *arguments):
        self.run_program("study beam.toml --out", name, *self.GRID, *arguments)

    def rows(self, name):
        return {(r["integrator"], float(r["step"])): r for r in self.table(name, "study.csv")}

    def two_studies(self):
        self.make("a", "--integrators", "verlet,midpoint", "--steps", "2.5e-3,5e-3")
        self.make("b", "--integrators", "midpoint,backward-euler", "--steps", "2.5e-3,5e-3,1e-2",
                  "--set", "material.density=1100")  # fmt: skip

    def test_numbers_of_the_rows_that_match(self):
        self.two_studies()
        diff = self.json_of("study diff a b")
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
        self.assertEqual(diff["notes"], ["The scenes, or files that they read, differ in other keys than [output]: "
                                         "equal runs compute different motions."])  # fmt: skip
        table = self.run_program("study diff a b").stdout
        change = f"{diff['runs'][1]['position_error_change']:+.2e}"
        self.assertRegex(table, rf"(?m)^midpoint +newton +0\.005 +ok .*{re.escape(change)}")
        self.assertRegex(table, r"only in A:\n +verlet +- +0\.0025\n")
        self.assertIn("2 of 4 runs of A and of 6 runs of B match.", table)

    def test_of_a_study_and_itself(self):
        self.make("a", "--integrators", "verlet,midpoint", "--steps", "2.5e-3,5e-3")
        shutil.copy(self.path("a", "study.json"), self.path("saved.json"))
        diff = self.json_of("study diff saved.json a")
        self.assertEqual(len(diff["runs"]), 4)
        for row in diff["runs"]:
            self.assertEqual(row["position_error_change"], 0.0)
            self.assertEqual(row["wall_ratio"], 1.0)
        self.assertEqual((diff["only_in_a"], diff["only_in_b"]), ([], []))

    def test_what_limits_the_comparison_is_said(self):
        self.make("a", "--integrators", "midpoint", "--steps", "5e-3")
        self.make("b", "--integrators", "midpoint", "--steps", "5e-3", "--reference-integrator",
                  "verlet")  # fmt: skip
        table = self.run_program("study diff a b").stdout
        self.assertIn("different references, midpoint with h = 5e-4 s and verlet with h = 5e-4 s", table)
        self.make("c", "--integrators", "midpoint", "--steps", "5e-3", "--threads", "1")
        study = self.read_json("c", "study.json")
        study["runs"][0]["processor"] = "another one"
        self.write("c.json", json.dumps(study))
        self.assertIn("on different machines", self.run_program("study diff a c.json").stdout)
        self.make("d", "--integrators", "verlet", "--steps", "2e-3")
        self.assertIn("No run of A has the", self.run_program("study diff a d").stdout)

    def test_runs_that_failed_and_the_reference_have_no_change_of_errors(self):
        for name in "ab":
            self.make(name, "--integrators", "verlet,midpoint", "--steps", "5e-4,2e-2",
                      "--set", "time.end=1")  # fmt: skip
        diff = self.json_of("study diff a b")
        changes = {(r["integrator"], r["step"]): r["position_error_change"] for r in diff["runs"]}
        self.assertEqual(changes, {("verlet", 5e-4): 0.0, ("verlet", 2e-2): None,
                                   ("midpoint", 5e-4): None, ("midpoint", 2e-2): 0.0})  # fmt: skip
        self.assertEqual(next(r for r in diff["runs"] if r["step"] == 2e-2)["a"]["status"], "unstable")

    def test_what_is_no_study(self):
        self.make("a", "--integrators", "midpoint", "--steps", "5e-3")
        self.assertIn("no such directory", self.refused(3, "study diff a missing"))
        os.mkdir(self.path("empty"))
        self.assertIn("there is no study.json.", self.refused(3, "study diff empty a"))
        self.refused(3, "study diff a a/midpoint-0.005", says="but the results of a run")
        begun = {"message": "The study has not ended", "runs": [{"directory": "midpoint-0.005"}]}
        for text, part in (("{", "not the study.json"), ("[]", "not the study.json"),
                           ('{"runs": 3}', "not the study.json"), (json.dumps(begun), "with the same command"),
                           ('{"runs": [{"integrator": 3}]}', '"scene" is missing')):  # fmt: skip
            self.write("broken.json", text)
            self.assertIn(part, self.refused(3, "study diff a broken.json"))

    def test_texts_of_foreign_studies_do_not_reach_the_terminal_raw(self):
        self.make("a", "--integrators", "midpoint", "--steps", "5e-3,1e-2")
        whole = self.read_json("a", "study.json")
        bad = "\x1b[31m\x07\u009b2J\u202ered\r\x7f"
        forged = json.loads(json.dumps(whole))
        for key in ("version", "command", "date", "scene"):
            forged[key] = bad
        forged["error"] = "probe." + bad
        del forged["plan"]
        forged["variants"] = [dict(name=bad, values={})]
        for run in forged["runs"]:
            run.update(variant=bad, solver=bad, settings=bad, processor=bad)
        self.write("forged.json", json.dumps(forged))
        for arguments in (("a", "forged.json"), ("forged.json", "a"), ("forged.json", "forged.json")):
            for option in ([], ["--json"]):
                text = self.run_program("study diff", *arguments, *option).stdout
                for raw in "\x1b\x07\u009b\u202e\r\x7f":
                    self.assertNotIn(raw, text)
                self.assertIn("[31m", text)
        # As JSON it is the same text.
        self.assertEqual(self.json_of("study diff forged.json a")["a"]["scene"], bad)
        forged["runs"][0]["status"] = bad
        self.write("forged.json", json.dumps(forged))
        message = self.refused(3, "study diff a forged.json")
        self.assertIn("[31m", message)
        self.assertNotIn("\x1b", message)

    def test_nested_deep(self):
        self.make("a", "--integrators", "midpoint", "--steps", "5e-3")
        nested = "[" * 200000 + "]" * 200000
        self.write("deep.json", '{"runs": ' + nested + "}")
        self.assertIn("not the study.json", self.refused(3, "study diff a deep.json"))
        row = self.path("a", "midpoint-0.005", "study_row.json")
        for text in (nested, '{"inputs": ' + nested + "}", '{"row": ' + nested + "}"):
            for path in (row, self.path("a", "study.json"), self.path("a", "midpoint-0.005", "summary.json")):
                self.write(path, text)
            result = self.run_program("study", self.path("beam.toml"), "--out", "a", *self.GRID,
                                      "--integrators", "midpoint", "--steps", "5e-3", "--resume")  # fmt: skip
            self.assertNotIn("unexpected", result.stderr)

    def test_damaged_members(self):
        self.make("a", "--integrators", "midpoint", "--steps", "5e-3")
        whole = self.read_json("a", "study.json")

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
            (with_run(integrator=""), '"integrator" has an unknown value'),
            (with_run(role=None), '"role" is not a text'),
            ({**whole, "interrupted": True}, "has not ended: it was interrupted"),
            (with_run(status="interrupted"), "has not ended: it was interrupted"),
        ):
            self.write("broken.json", json.dumps(damaged))
            for arguments in (("a", "broken.json"), ("broken.json", "a")):
                self.refused(3, "study diff", *arguments, says=(part, "broken.json: "))

    def test_an_interrupted_study_is_refused(self):
        self.make("a", "--integrators", "midpoint", "--steps", "5e-3")
        process = self.begin("midpoint-1e-05", "--no-plots --quiet --steps 1e-5 --integrators midpoint "
                             "--frames none --set time.end=100")
        process.send_signal(signal.SIGINT)
        process.wait(timeout=60)
        self.refused(3, "study", "diff", "a", "s",
                     says=("the study has not ended: it was interrupted", "with the same command, which keeps"))
        self.assertIn("B is required", self.refused(2, "study diff a"))

    def test_options_and_scenes_of_a_study(self):
        """They have no meaning for a comparison. A scene may be called diff."""
        self.make("a", "--integrators", "midpoint", "--steps", "5e-3")
        for arguments, part in (
            (("study", "diff", "a", "a", "--steps", "1e-3"), "study diff has no option --steps"),
            (("study", "--resume", "diff", "a", "a"), "study diff has no option --resume"),
            (("study", "beam.toml", "diff", "a", "a"), '"beam.toml" stands before diff'),
        ):
            self.assertIn(part, self.refused(2, *arguments))
        self.run_program("study diff a a --threads 1")
        os.rename(self.path("beam.toml"), self.path("diff"))
        self.run_program("study ./diff --out b --integrators midpoint --steps 5e-3", *self.GRID)
        self.assertIn("1 of 1 runs of A and of 1 runs of B match.",
                      self.run_program("study diff a b").stdout)  # fmt: skip


if __name__ == "__main__":
    main()
