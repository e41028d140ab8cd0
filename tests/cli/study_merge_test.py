"""`tetraction study open`, `study merge` and `study --part`."""

import glob
import json
import os
import resource
import shutil
import subprocess
import sys

sys.path.insert(0, f"{sys.path[0]}/..")
from support.program import files_below, main
from support.study import PROBES, StudyTest

# The number of repeats depends on the time that a run took.
TIMES = ("wall_seconds", "processor_seconds", "seconds_per_simulated_second", "date", "command", "time_scatter",
         "repeats")


class Stored(StudyTest):
    GRID = ("--no-plots", "--quiet", "--frames", "none", "--threads", "1")

    def make(self, name, *arguments, scene="beam.toml", code=0):
        return self.run_program("study", scene, "--out", name, *self.GRID, *arguments, code=code)

    def lasting(self, name):
        """The rows of study.csv without times, dates and commands."""
        return [{k: v for k, v in row.items() if k not in TIMES} for row in self.table(name, "study.csv")]

    def merge(self, *arguments, code=0):
        return self.run_program("study merge", *arguments, "--no-plots", code=code)

    def refused_merge(self, code, *arguments, says):
        self.refused(code, "study merge", *arguments, "--out", "d", says=says)
        self.assertFalse(glob.glob(self.path("d*")))


class Parts(Stored):
    def test_merged_parts_are_the_undivided_study(self):
        self.write("probes.toml", PROBES)
        for scene, arguments, counts in (
            ("beam.toml", ("--integrators", "verlet,midpoint", "--steps", "1e-3,2e-3,5e-3"), (1, 2, 3)),
            ("probes.toml", ("--steps", "midpoint=2e-3,4e-3", "--reference", "richardson", "--error",
                             "probe.tip", "--vary", "material.density=900,1100"), (3,)),
            # Everything at once: rules with settings, variants, solvers, an energy as the error, repeats.
            ("beam.toml", ("--integrators", "verlet,midpoint,backward-euler", "--steps", "1e-3,2e-3,5e-3",
                           "--rule", "midpoint:solver.tolerance=1e-3", "--rule", "midpoint:time.adapt=error",
                           "--also-solver", "ceres@2e-3", "--also-solver", "ceres@5e-3",
                           "--vary", "material.density=900,1100", "--vary", "solver.kind=newton",
                           "--error", "energy.elastic_energy", "--repeats", "0"), (2, 4)),
            ("probes.toml", ("--integrators", "verlet,midpoint", "--steps", "1e-3,2e-3,4e-3", "--set", "time.end=10",
                             "--rule", "midpoint:solver.tolerance=1e-2", "--error", "frequency.probe.tip"), (3,)),
        ):  # fmt: skip
            self.make("whole", *arguments, scene=scene)
            whole = self.lasting("whole")
            self.assertTrue(any(row["observed_order"] for row in whole))
            for count in counts:
                with self.subTest(scene=scene, count=count):
                    parts = [f"part{k}" for k in range(1, count + 1)]
                    for k, part in enumerate(parts, 1):
                        self.make(part, *arguments, "--part", f"{k}/{count}", scene=scene)
                    made = [row for part in parts for row in self.lasting(part)]
                    self.assertEqual(len(made), len(whole))
                    # A study that is merged with a part that it has already gains nothing.
                    self.merge(*parts, parts[0], "--out", "d")
                    self.assertEqual(self.lasting("d"), whole)
                    self.assertFalse(self.read_json("d", "study.json")["interrupted"])
                    shutil.rmtree(self.path("d"))
                    for part in parts:
                        shutil.rmtree(self.path(part))
            shutil.rmtree(self.path("whole"))

    def test_a_part_says_that_it_is_one(self):
        arguments = ("--integrators", "midpoint", "--steps", "1e-3,2e-3,5e-3")
        for k in (1, 2, 3):
            self.make(f"p{k}", *arguments, "--part", f"{k}/3")
        shown = self.run_program("study open p2")
        self.assertIn("This is a part of a study: 1 of its 3 runs.", shown.stdout)
        self.assertIn("is a run of another part", shown.stdout)
        self.assertIn("tetraction study merge joins the parts", shown.stderr)
        self.assertFalse(self.read_json("p2", "study.json")["interrupted"])
        # Two of three parts are a part, too, and can be merged with the third.
        self.merge("p3", "p1", "--out", "two")
        self.assertIn("a part of a study: 2 of its 3 runs.", self.run_program("study open two").stdout)
        self.merge("two", "p2", "--out", "three")
        self.assertEqual(len(self.lasting("three")), 3)
        self.assertNotIn("a part of", self.run_program("study open three").stdout)
        plan = self.run_program("study beam.toml --plan --part 2/3 --out none", *arguments).stdout
        self.assertIn("1 run to make", plan)

    def test_refused_parts(self):
        for part in ("0/3", "4/3", "2", "2/", "/3", "a/b", "-1/3", "1/3/4", "1.0/3"):
            self.refused_study("--steps 1e-3 --part", part, says="with K from 1 to N")
        self.refused_study("--steps midpoint=1e-3,2e-3 --part 3/3", says="has only 2 runs")
        for steps in (("--integrators", "midpoint"), ("--steps", "midpoint=auto"),
                      ("--target", "1%", "--integrators", "verlet")):  # fmt: skip
            self.refused_study(*steps, "--part", "1/2", says=("--plan", "--steps"))


class Merge(Stored):
    def test_repeats_are_those_of_the_parts(self):
        grid = ("--integrators", "midpoint", "--steps", "5e-3,1e-2,2e-2", "--repeats", "1", "--budget", "10min")
        for k in (1, 2):
            self.make(f"part{k}", *grid, "--part", f"{k}/2")
        self.merge("part1", "part2", "--out", "d")
        made = {row["step"]: row for k in (1, 2) for row in self.table(f"part{k}", "study.csv")}
        rows = self.table("d", "study.csv")
        self.assertEqual({row["repeats"] for row in rows if row["role"] == "run"}, {"1"})
        for row in rows:
            for key in ("wall_seconds", "processor_seconds", "repeats", "time_scatter"):
                self.assertEqual(row[key], made[row["step"]][key])

    def test_the_run_on_a_finer_mesh_is_merged(self):
        self.make("a", "--integrators", "midpoint", "--steps", "5e-3,1e-2", "--mesh-check")
        self.make("b", "--integrators", "verlet", "--steps", "1e-3,2e-3")
        for names in (("a", "b"), ("b", "a")):
            self.merge(*names, "--out", "d")
            check = self.read_json("d", "study.json")["mesh_check"]
            self.assertEqual(check, self.read_json("a", "study.json")["mesh_check"])
            self.assertTrue(self.exists("d", check["directory"], "final.vtu"))
            # It is kept in the merged study, which a further one with it goes on.
            again = self.run_program("study beam.toml --out d --no-plots --integrators midpoint --mesh-check",
                                     "--steps", "5e-3,1e-2", "--frames", "none", "--threads", "1")  # fmt: skip
            self.assertIn("no run was made", again.stderr)
            shutil.rmtree(self.path("d"))
        # A part does not know the run that it would be.
        self.refused(2, "study beam.toml --out c --steps midpoint=5e-3,1e-2 --part 1/2 --mesh-check",
                     says="--mesh-check: a part of a study does not know all runs")  # fmt: skip

    def test_other_steps_get_the_finer_reference(self):
        self.make("a", "--integrators", "midpoint,verlet", "--steps", "2e-3,4e-3")
        self.make("b", "--steps", "midpoint=1e-3,4e-3", "--reference-step", "5e-4")
        before = {name: files_below(self.path(name)) for name in "ab"}
        shown = self.merge("a", "b", "--out", "new/d").stdout
        study = self.read_json("new", "d", "study.json")
        self.assertEqual(study["reference"]["step"], 5e-4)
        runs = {(r["integrator"], r["step"]): r for r in study["runs"]}
        self.assertEqual(list(runs), [("midpoint", h) for h in (5e-4, 1e-3, 2e-3, 4e-3)]
                         + [("verlet", h) for h in (2e-3, 4e-3)])  # fmt: skip
        whole = self.read_json("b", "study.json")["runs"]
        for other in whole:  # those of b were compared with the same reference
            own = runs[other["integrator"], other["step"]]
            self.assertEqual(own["position_error"], other["position_error"])
        orders = [r["observed_order"] for r in study["runs"] if r["observed_order"]]
        self.assertGreaterEqual(len(orders), 2)
        for order in orders:
            self.assertAlmostEqual(order, 2.0, delta=0.2)
        # What both have is that of the directory named first.
        row = self.read_json("a", "midpoint-0.004", "study_row.json")["row"]
        self.assertEqual(runs["midpoint", 4e-3]["date"], row["date"])
        self.assertEqual({name: files_below(self.path(name)) for name in "ab"}, before)
        # The directory is a study like others.
        self.assertEqual(self.run_program("study open new/d").stdout, shown)
        kept = self.run_program("study beam.toml --steps midpoint=2e-3 --reference-step 5e-4 --frames none "
                                "--no-plots --out new/d")
        self.assertIn("the study was complete, and no run was made", kept.stderr)

    def test_what_does_not_belong_together(self):
        self.write("probes.toml", PROBES)
        steps = ("--steps", "midpoint=2e-3,4e-3")
        self.make("a", *steps)
        for arguments, says in (
            ((*steps, "--set", "material.density=900"), "scenes"),
            ((*steps, "--set", 'mesh.generate={kind="beam",size=[4,1,1],cells=[4,2,2]}'), "meshes differ"),
            ((*steps, "--set", "time.end=0.2"), "0.1 s and 0.2 s (time.end)"),
            ((*steps, "--vary", "material.density=1000,1100"), "other variants"),
        ):
            self.make("b", *arguments)
            self.refused_merge(2, "a", "b", says=(says, "a and b cannot be merged"))
            shutil.rmtree(self.path("b"))
        self.make("p", *steps, scene="probes.toml")
        self.make("q", *steps, "--error", "probe.tip", scene="probes.toml")
        self.refused_merge(2, "p", "q", says=("position error", "probe.tip"))
        other = self.read_json("a", "study.json")
        other["plan"]["build"] = "0.1 00000000"
        shutil.copytree(self.path("a"), self.path("old"))
        self.write("old/study.json", json.dumps(other))
        self.refused_merge(2, "a", "old", says=("builds", "0.1 00000000"))

    def test_directories_and_files_that_are_refused(self):
        self.make("a", "--steps", "midpoint=2e-3")
        self.make("b", "--steps", "midpoint=5e-3")
        self.refused_merge(2, "a", says="2")
        self.refused_merge(3, "a", "missing", says="no such directory")
        self.refused(2, "study merge a b --out a", says="is one of the studies")
        os.mkdir(self.path("full"))
        self.write("full/file", "")
        self.refused(2, "study merge a b --out full", says="not an empty directory")
        self.assertEqual(os.listdir(self.path("full")), ["file"])
        run = self.path("b", "midpoint-0.005")
        for name, text in (("study_row.json", "{}"), ("study_track.bin", "tetraction track 1\n"),
                           ("history.csv", None)):  # fmt: skip
            whole = self.read_bytes(run, name)
            os.remove(os.path.join(run, name))
            if text is None:
                os.symlink("/etc/passwd", os.path.join(run, name))
            else:
                self.write(os.path.join(run, name), text)
            self.refused_merge(3, "a", "b", says=name)
            os.remove(os.path.join(run, name))
            self.write(os.path.join(run, name), whole)
        self.merge("a", "b", "--out", "d")
        self.assertEqual(sorted(os.listdir(self.path("d", "midpoint-0.005"))),
                         sorted(set(os.listdir(run)) - {".lock"}))  # fmt: skip

    def test_costs_of_other_machines_are_not_compared(self):
        self.make("a", "--steps", "midpoint=1e-3,2e-3")
        self.make("b", "--steps", "verlet=1e-3", "--reference-step", "1e-3")
        row = self.read_json("b", "verlet-0.001", "study_row.json")
        row["row"]["processor"] = "another one"
        self.write("b/verlet-0.001/study_row.json", json.dumps(row))
        self.merge("a", "b", "--out", "d")
        for name, is_known in (("a", True), ("d", False)):
            for target in self.read_json(name, "study.json")["answer"]["targets"]:
                for rule in target["rules"]:
                    self.assertEqual(rule["cost_seconds"] is not None, is_known, (name, rule))

    def limited(self, size, *arguments, code):
        """With files of at most this many bytes, as if the disk were full."""
        result = subprocess.run(
            [sys.argv[1], *arguments], cwd=self.folder, capture_output=True, encoding="utf-8",
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size, size)),
        )  # fmt: skip
        self.assertEqual(result.returncode, code, result.stdout + result.stderr)
        return result.stderr

    def test_a_full_disk(self):
        self.make("a", "--steps", "midpoint=1e-3,2e-3")
        self.make("b", "--steps", "midpoint=4e-3")
        before = {name: files_below(self.path(name)) for name in "ab"}
        sizes = sorted({len(text) for files in before.values() for text in files.values()})
        for size in (sizes[0], sizes[len(sizes) // 2], sizes[-1] - 1):
            message = self.limited(size, *"study merge a b --out d --no-plots".split(), code=4)
            self.assertRegex(message, "cannot be written|cannot write|limit|large|space")
            self.assertFalse(glob.glob(self.path("d*")))
            self.assertEqual({name: files_below(self.path(name)) for name in "ab"}, before)
        self.merge("a", "b", "--out", "d")
        # A study goes on with the same command.
        for size in (200, sizes[len(sizes) // 2], sizes[-1] - 1):
            arguments = ("study", "beam.toml", "--out", "s", *self.GRID, "--steps", "midpoint=1e-3,2e-3")
            self.limited(size, *arguments, code=4)
        self.run_program(*arguments)
        drawn = [a for a in arguments if a != "--no-plots"]
        # Tables find room, and pictures do not.
        message = self.limited(len(self.read("s", "study.json")) + 1000, *drawn, code=4)
        self.assertIn("cannot be written", message)
        self.run_program(*drawn)
        self.assertTrue(self.exists("s", "work_precision.svg"))
        self.assertEqual([r["position_error"] for r in self.lasting("s")],
                         [r["position_error"] for r in self.lasting("a")])  # fmt: skip


class Open(Stored):
    def test_it_prints_what_the_study_printed(self):
        self.write("probes.toml", PROBES)
        for scene, arguments in (
            ("beam.toml", ("--integrators", "verlet,midpoint", "--steps", "1e-3,5e-3,2e-2")),
            ("probes.toml", ("--steps", "midpoint=2e-3,4e-3", "--reference", "richardson", "--error",
                             "peak.probe.tip", "--vary", "material.density=900,1100")),
            ("probes.toml", ("--target", "1%", "--integrators", "verlet,midpoint", "--budget", "5s",
                             "--error", "probe.tip", "--also-solver", "ceres@1e-2")),
        ):  # fmt: skip
            if "peak.probe.tip" in arguments:
                arguments = tuple(a for a in arguments if a not in ("--reference", "richardson"))
            self.run_program("study", scene, "--out", "s", "--no-plots", *arguments, code=(0, 1))
            for view in ((), ("--all",), ("--json",), ("--table", "markdown"), ("--table", "latex")):
                with self.subTest(scene=scene, arguments=arguments, view=view):
                    again = self.run_program("study", scene, "--out", "s", "--no-plots", *arguments, *view)
                    before = files_below(self.path("s"))
                    self.assertEqual(self.run_program("study open s", *view).stdout, again.stdout)
                    self.assertEqual(files_below(self.path("s")), before)
            shutil.rmtree(self.path("s"))

    def test_damaged_and_hostile_studies(self):
        self.make("a", "--integrators", "midpoint", "--steps", "5e-3,1e-2")
        whole = self.read_json("a", "study.json")
        text = self.read("a", "study.json")

        def run(**values):
            return {**whole, "runs": [{**whole["runs"][0], **values}, whole["runs"][1]]}

        def planned(**values):
            plan = whole["plan"]
            return {**whole, "plan": {**plan, "runs": [{**plan["runs"][0], **values}, plan["runs"][1]]}}

        nested = "[" * 100000 + "]" * 100000
        for damaged, says in (
            (text[: len(text) // 2], "not the study.json"),
            (text.replace('"end":', '"end": 1, "end":', 1), "not the study.json"),
            (text.replace('"end": 0.1', '"end": 1e999', 1), "not the study.json"),
            ('{"runs": ' + nested + "}", "not the study.json"),
            (json.dumps({"message": "The study has not ended", "runs": []}), "has not ended"),
            ({**whole, "end": "NaN"}, '"end" is not a number'),
            ({**whole, "end": -1}, '"end" is not a positive number'),
            ({**whole, "version": "0.1", "end": None}, "Another version of the program"),
            ({**whole, "references": [3]}, "not a table"),
            ({**whole, "variants": [{"name": "x", "values": []}]}, "not a table"),
            (run(directory="../a"), "not the name of a folder"),
            (run(directory="/etc"), "not the name of a folder"),
            (run(directory=".."), "not the name of a folder"),
            (run(directory="midpoint-0.01"), "of another run"),
            (run(steps=1e300), '"steps" has an unknown value'),
            (run(steps="many"), '"steps" is not a number'),
            (run(position_error="NaN"), '"position_error" is not a number'),
            (run(variant="x"), "none of the variants"),
            (run(step=1e-7), "there is no run"),
            (planned(directory="a/../../b"), "not the name of a folder"),
            (planned(variant=5), "not in it"),
            (planned(left_out=3), "neither true nor false"),
            ({**whole, "plan": {**whole["plan"], "references": []}}, "no reference"),
            ({**whole, "plan": {**whole["plan"], "reference_of": [7]}}, "not in it"),
        ):
            with self.subTest(says=says):
                self.write("a/study.json", damaged if isinstance(damaged, str) else json.dumps(damaged))
                self.refused(3, "study open a", says=(says, "a"))
        with open(self.path("a", "study.json"), "wb") as file:
            file.truncate(1 << 40)
        self.refused(3, "study open a", says="too large")
        os.remove(self.path("a", "study.json"))
        self.refused(3, "study open a", says="no study.json")
        self.refused(3, "study open missing", says="no such directory")


if __name__ == "__main__":
    main()
