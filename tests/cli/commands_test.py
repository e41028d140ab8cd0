"""The commands themselves: streams that cannot be written, files that must not be lost, advice."""

import json
import os
import shutil
import subprocess
import sys

sys.path.insert(0, f"{sys.path[0]}/..")
from support.program import (PROGRAM, DATA, BEAM_MESH, BEAM, BeamTest, ProgramTest, files_below,
    main, sets)

ENVIRONMENT = {k: v for k, v in os.environ.items() if k != "OPENBLAS_CORETYPE"}
# A step above the stability limit: the run warns of it.
WARNING = ["--set", "time.integrator=verlet", "--set", "time.step=0.0075", "--set", "time.end=0.0075"]


class Streams(BeamTest):
    def shell(self, command, code):
        """The program by a shell, which can close streams; $0 is the program."""
        result = subprocess.run(
            ["bash", "-c", command, PROGRAM], capture_output=True, text=True, timeout=300,
            cwd=self.folder, env=ENVIRONMENT,
        )  # fmt: skip
        self.assertEqual(result.returncode, code, command + "\n" + result.stdout + result.stderr)
        return result

    def test_standard_error_that_cannot_be_written(self):
        warning = " ".join(f"'{word}'" for word in WARNING)
        for stream in ("2>&-", "2>/dev/full"):
            with self.subTest(stream):
                self.shell(f'"$0" run none.toml {stream}', 3)
                self.shell(f'"$0" fly {stream}', 2)
                self.shell(f'"$0" mesh info none.msh {stream}', 3)
                self.shell(f'"$0" run beam.toml --out /dev/null/out {stream}', 4)
                self.shell(f'"$0" run beam.toml --out out {warning} {stream}', 0)
                self.assertEqual(self.read_json("out", "summary.json")["status"], "ok")
                self.shell(f'"$0" study beam.toml --out s --integrators midpoint --steps 0.05 '
                           f"--no-plots {stream}", 0)  # fmt: skip
        # Such a run does warn.
        self.assertIn("warning", self.shell(f'"$0" run beam.toml --out out {warning}', 0).stderr)

    def test_lost_results_are_an_error(self):
        self.run_program("mesh generate box box.msh")
        commands = [
            "--help", "--version", "run --help", "mesh generate box --help",
            "run beam.toml --out out", "run beam.toml --out out --json", "check beam.toml",
            "check beam.toml --json", "mesh info box.msh", "mesh info box.msh --json",
            "mesh convert box.msh out.vtu", "mesh generate cube out.vtu",
            "study beam.toml --out s --integrators midpoint --steps 0.05 --no-plots",
            "study beam.toml --out s --integrators midpoint --steps 0.05 --no-plots --json",
            "modes beam.toml -n 2 --out m", "modes beam.toml -n 2 --out m --json",
        ]  # fmt: skip
        for command in commands:
            for stream in (">/dev/full", ">&-"):
                with self.subTest(command, stream=stream):
                    result = self.shell(f'"$0" {command} {stream}', 4)
                    self.assertIn("standard output", result.stderr)
        # Everything that belongs into files is there, and nothing is said where nothing was lost.
        self.shell('"$0" run beam.toml --out quiet --quiet >&-', 0)
        self.assertTrue(os.path.exists(self.path("quiet", "summary.json")))
        # The reason why a run failed goes before.
        self.shell('"$0" run beam.toml --out failed --set solver.max_iterations=1 --set '
                   "solver.tolerance=1e-13 --set time.step=0.1 >/dev/full", 1)  # fmt: skip

    def test_a_pipe_that_nobody_reads(self):
        for command in ("--help", "check beam.toml --json", "run beam.toml --out out"):
            with self.subTest(command):
                read, write = os.pipe()
                os.close(read)
                result = subprocess.run([PROGRAM, *command.split()], stdout=write, text=True,
                                        stderr=subprocess.PIPE, cwd=self.folder, timeout=300,
                                        env=ENVIRONMENT)  # fmt: skip
                os.close(write)
                self.assertEqual(result.returncode, 4, result.stderr)
                self.assertIn("standard output", result.stderr)

    def test_closed_streams_do_not_end_in_files(self):
        """The first file that is opened must not become standard output."""
        self.shell('"$0" run beam.toml --out out --threads 1', 0)
        before = files_below(self.path("out"))
        for streams in (">&-", "2>&-", ">&- 2>&-", "<&- >&- 2>&-"):
            code = 0 if streams == "2>&-" else 4
            self.shell(f'"$0" run beam.toml --out out --threads 1 {streams}', code)
            after = files_below(self.path("out"))
            self.assertEqual(set(after), set(before))
            for name in after:
                if name != "summary.json":  # which has the wall times
                    self.assertEqual(after[name], before[name], name)


    def test_files_beyond_the_limit_of_the_shell(self):
        for command in ("run beam.toml --out out", "mesh generate cube cube.vtu --cells 20",
                        "mesh generate cube cube.msh --cells 20",
                        "mesh generate cube cube.vtk --cells 20"):  # fmt: skip
            with self.subTest(command):
                result = self.shell(f'ulimit -f 2; "$0" {command}', 4)
                self.assertIn("cannot be written (File too large)", result.stderr)
                self.assertIn("ulimit -f", result.stderr)
                self.assertNotIn("free space", result.stderr)


class Advice(BeamTest):
    def test_mistyped_commands_and_options(self):
        for arguments, part in (
            (["rnu"], "did you mean run?"),
            (["rnu", "beam.toml", "--out", "out"], "did you mean run?"),
            (["--threads", "1", "stduy", "beam.toml"], "did you mean study?"),
            (["fly"], "run, static, modes, study, check, mesh, keys or view"),
            ([], "run, static, modes, study, check, mesh, keys or view"),
            (["mesh", "inof", "a.msh"], "did you mean info?"),
            (["mesh"], "info, convert or generate"),
            (["mesh", "generate", "bxo", "a.msh"], "did you mean box?"),
            (["run", "beam.toml", "--ot", "out"], "did you mean --out?"),
            (["run", "beam.toml", "--jsn"], "did you mean --json?"),
            (["study", "beam.toml", "--step=1"], "did you mean --steps?"),
            (["run"], "scene is required"),
            (["study"], "scene is required"),
            (["study", "--quiet"], "scene is required"),
        ):
            with self.subTest(arguments):
                self.assertIn(part, self.refused(2, *arguments))

    def test_keys(self):
        one = self.run_program("keys damping").stdout
        self.assertIn("| `viscosity` | number, Pa s | `0` |", one)
        everything = self.run_program("keys").stdout
        self.assertIn(one, everything)
        self.assertIn("[select.plane]", everything)
        # Every section that a scene can have, and every table in it.
        for section, key in (("mesh", "scale"), ("mesh.generate", "cells"), ("material", "c20"),
                             ("material_region", "select"), ("time", "step"),
                             ("solver", "linear"), ("environment", "softening"),
                             ("fix", "target"), ("constraint", "length"), ("force", "until"),
                             ("initial", "stretch"), ("initial.momentum", "value"),
                             ("event", "remove_constraint"), ("shift", "impulse"),
                             ("output", "every"), ("select", "nearest"),
                             ("select.sphere", "radius")):  # fmt: skip
            with self.subTest(section):
                table = self.run_program("keys", section).stdout
                self.assertIn(f"| `{key}` |", table)
                self.assertIn(f"[{section}]\n{table}", everything)
        self.assertIn("did you mean damping?", self.refused(2, "keys dampin"))

    def test_helps(self):
        for command in ("run", "study", "check", "view"):
            self.assertIn("--threads", self.run_program(command, "--help").stdout, command)
        for kind, size, cells in (("beam", "4,1,1", "40,9,9"), ("box", "1,1,1", "4,4,4")):
            text = self.run_program("mesh generate", kind, "--help").stdout
            self.assertRegex(text, rf"--size [^\n]*={size}\s")
            self.assertRegex(text, rf"--cells [^\n]*={cells}\s")
            self.assertEqual("40,9,9" in text, kind == "beam")

    def test_threads_before_and_behind_the_command(self):
        for arguments in (["--threads", "1", "run", "beam.toml"], ["run", "beam.toml", "--threads", "1"],
                          ["run", "--threads=1", "beam.toml"]):  # fmt: skip
            result = self.run_program(*arguments, "--json", "--out", self.path("out"))
            self.assertEqual(json.loads(result.stdout)["threads"], 1)
        self.refused(2, "run beam.toml --threads -1")
        self.run_program("mesh generate box a.msh --threads 1")

    def test_endings_that_no_mesh_has(self):
        self.write("part.stl", "solid")
        self.write("part", "nothing")
        box = self.path("box.msh")
        self.run_program(f"mesh generate box {box}")
        for name in ("part.stl", "part"):
            for arguments in (["mesh", "info", name], ["mesh", "convert", name, "out.msh"],
                              ["mesh", "convert", box, name], ["mesh", "generate", "box", name]):  # fmt: skip
                with self.subTest(arguments):
                    self.assertIn("ending", self.refused(2, *arguments))
        scene = self.write("scene.toml", '[mesh]\nfile = "part.stl"\n[material]\n'
                           "youngs_modulus = 1e5\npoissons_ratio = 0.3\n")  # fmt: skip
        self.assertIn("ending", self.refused(2, f"check {scene}"))

    def test_missing_files(self):
        message = self.refused(3, "mesh info missing.msh")
        self.assertIn("missing.msh: no such file", message)
        self.assertNotIn("scene", message)
        scene = self.write("scene.toml", '[mesh]\nfile = "missing.msh"\n[material]\n'
                           "youngs_modulus = 1e5\npoissons_ratio = 0.3\n")  # fmt: skip
        self.assertIn("mesh.file", self.refused(3, f"check {scene}"))

    def test_quiet_runs_do_not_speak_of_the_blas(self):
        slow = self.slow_blas()
        run = ["run", "beam.toml", "--out", self.path("out"), "--quiet"]
        self.assertEqual(self.run_program(*run, env=slow).stderr, "")
        self.assertIn("OPENBLAS_CORETYPE", self.read_json("out", "summary.json")["warnings"][0])
        # What concerns the results is still told.
        warned = self.run_program(*run, *WARNING, env=slow).stderr
        self.assertIn("h_crit", warned)
        self.assertNotIn("OPENBLAS", warned)
        study = ["study", "beam.toml", "--steps", "0.05", "--integrators", "midpoint", "--no-plots"]
        self.assertEqual(
            self.run_program(*study, "--out", self.path("s"), "--quiet", env=slow).stderr, ""
        )

    def test_scales_that_are_none(self):
        self.run_program("mesh generate box box.msh")
        for scale in ("0", "-1", "nan", "inf", ""):
            with self.subTest(scale):
                message = self.refused(2, "mesh convert box.msh x.msh --scale", scale)
                self.assertLess(len(message), 300)
        for scale in ("1e308", "1e-300"):
            self.refused(3, "mesh convert box.msh x.msh --scale", scale, says="scale")
        self.refused(2, "study beam.toml --reference-step 0 --out s")

    def test_nothing_is_minus_zero(self):
        scene = self.write("beam.toml", BEAM.replace('"gravity"', '"none"'))
        result = self.run_program(f"run {scene} --out out")
        self.assertIn("environment 0,", result.stdout)
        self.assertNotIn(",-0,", self.read("out", "history.csv"))

    def test_the_summary_names_the_directory_of_its_run(self):
        result = self.run_program("run beam.toml --out there --json")
        self.assertEqual(json.loads(result.stdout)["scene"]["output"]["directory"], "there")
        self.assertEqual(self.read_json("there", "summary.json")["scene"]["output"]["directory"], "there")
        self.run_program("study beam.toml --out s --steps 0.05 --integrators midpoint --no-plots")
        directory = self.read_json("s", "midpoint-0.05", "summary.json")["scene"]["output"]["directory"]
        self.assertEqual(directory, "s/midpoint-0.05")

    def test_empty_arguments(self):
        for arguments, code in ((["run", ""], 3), (["run", "beam.toml", "--out", ""], 2),
                                (["study", "beam.toml", "--out", ""], 2), (["mesh", "info", ""], 2),
                                (["study", "beam.toml", "--vary", ""], 2),
                                (["study", "beam.toml", "--integrators", ""], 2),
                                (["check", ""], 3), (["run", "beam.toml", "--set", ""], 2),
                                ([""], 2), (["mesh", "convert", "", ""], 2)):  # fmt: skip
            with self.subTest(arguments):
                self.refused(code, *arguments)
        self.assertFalse(os.path.exists(self.path("out")))


class Overwriting(BeamTest):
    def test_a_conversion_does_not_overwrite_its_input(self):
        self.run_program("mesh generate box a.msh")
        self.run_program("mesh generate box t.node")
        os.symlink("a.msh", self.path("link.msh"))
        os.link(self.path("a.msh"), self.path("hard.msh"))
        os.mkdir(self.path("sub"))
        os.symlink(self.folder, self.path("sub", "up"))
        before = files_below(self.folder)
        for source, target in (
            ("a.msh", "a.msh"), ("a.msh", "./a.msh"), ("a.msh", "sub/../a.msh"),
            ("a.msh", self.path("a.msh")), ("a.msh", "sub/up/a.msh"), ("a.msh", "link.msh"),
            ("link.msh", "a.msh"), ("a.msh", "hard.msh"), ("t.node", "t.ele"), ("t.ele", "t.node"),
            ("t.node", "./t.node"),
        ):  # fmt: skip
            with self.subTest(source, target=target):
                self.assertIn("overwritten", self.refused(2, "mesh convert", source, target))
        self.assertEqual(files_below(self.folder), before)
        self.run_program("mesh convert a.msh b.msh")
        self.run_program("mesh convert a.msh b.msh")  # another file may be

    def groups(self, *arguments):
        info = self.json_of("mesh info", *arguments)
        return {g["name"]: (g["dimension"], g["vertices"], g["tetrahedra"]) for g in info["groups"]}

    def test_conversions_keep_groups_or_say_what_they_lose(self):
        part = os.path.join(DATA, "serpentine_spring.msh")
        before = self.groups(part)
        self.assertEqual(set(before), {"body", "clamp", "tip"})
        result = self.run_program(f"mesh convert {part} out.msh")
        self.assertNotIn("lost", result.stderr)
        self.assertEqual(self.groups("out.msh"), before)
        for ending, lost in (("vtu", set(before)), ("vtk", set(before)), ("node", set(before)),
                             ("veg", {"clamp", "tip"})):  # fmt: skip
            with self.subTest(ending):
                result = self.run_program(f"mesh convert {part}", "out." + ending)
                lines = [l for l in result.stderr.splitlines() if "warning" in l]
                # The elements of a .veg file without named sets have no region.
                self.assertEqual(["regions of" in l for l in lines],
                                 [False, True] if ending == "veg" else [False], result.stderr)  # fmt: skip
                for name in before:
                    self.assertEqual(f"{name}" in lines[0].split("lost", 1)[1].split(".")[0],
                                     name in lost, name)  # fmt: skip
        # A mesh without groups has none to lose.
        self.run_program("mesh generate box box.vtu")
        self.assertEqual(self.run_program("mesh convert box.vtu box.vtk").stderr, "")

    def test_a_run_does_not_overwrite_its_own_mesh(self):
        self.run_program("run beam.toml --out first --quiet")
        again = self.write("again.toml", BEAM.replace(
            BEAM_MESH,
            'file = "first/final.vtu"'))  # fmt: skip
        before = files_below(self.path("first"))
        self.assertIn("overwritten", self.refused(2, f"run {again} --out first"))
        self.assertIn("overwritten", self.refused(2, f"run {again} --out ./first/../first"))
        frame = ["--set", "mesh.file=first/frames/frame_000000.vtu"]
        self.assertIn("overwritten", self.refused(2, f"run {again} --out first", *frame))
        self.assertEqual(files_below(self.path("first")), before)
        self.run_program(f"run {again} --out second --quiet")

    def test_no_input_is_overwritten_whatever_its_name(self):
        body = BEAM.replace(BEAM_MESH,
                            'file = "%s"')  # fmt: skip
        self.run_program("mesh generate beam beam.vtu --cells 8,2,2 --size 4,1,1")
        self.run_program("mesh convert beam.vtu beam.node")
        table = "0,0\n1,1\n"
        ramp = '[[amplitude]]\nname = "ramp"\nfile = "%s"\n'
        field = '[initial.displacement]\nfile = "%s"\n'
        plain = body % "beam.vtu"
        results = ["final.vtu", "failed_elements.vtu", "frames/frame_000003.vtu", "mode_1.vtu",
                   "swing/mode_1_00.vtu", "midpoint-0.05/final.vtu"]  # fmt: skip
        cases = [(body % ("out/" + name), "beam.vtu", name) for name in results]
        cases += [(plain + ramp % ("out/" + name), table, name) for name in
                  ("history.csv", "probes.csv", "summary.json", "frames.pvd", "history.csv.part", ".lock",
                   "checkpoints/step_000000001.ckpt")]  # fmt: skip
        cases += [(plain + field % "out/final.vtu", table, "final.vtu")]
        wall = '[[obstacle]]\nname = "wall"\nkind = "mesh"\nfile = "out/final.vtu"\n'
        cases += [(plain + wall, "beam.vtu", "final.vtu")]
        for scene, source, name in cases:
            commands = [["run"], ["static"], ["modes"],
                        ["study", "--steps", "0.025,0.05", "--integrators", "midpoint"]]  # fmt: skip
            if "midpoint" in name:
                commands = commands[-1:]
            for command in commands:
                with self.subTest(name, command=command[0]):
                    shutil.rmtree(self.path("out"), ignore_errors=True)
                    os.makedirs(os.path.dirname(self.path("out", name)))
                    if source == "beam.vtu":
                        shutil.copy(self.path(source), self.path("out", name))
                    else:
                        self.write(os.path.join("out", name), source)
                    before = files_below(self.path("out"))
                    message = self.refused(2, command[0], self.write("s.toml", scene), "--out", "out",
                                           *command[1:])  # fmt: skip
                    self.assertIn("would be overwritten or deleted", message)
                    self.assertIn(name, message)
                    self.assertEqual(files_below(self.path("out")), before)

    def test_the_same_file_under_another_name(self):
        self.run_program("mesh generate beam beam.node --cells 4,1,1 --size 4,1,1")
        scene = self.write("beam.toml", BEAM.replace(
            BEAM_MESH, 'file = "beam.node"'))  # fmt: skip
        for source in ("beam.toml", "beam.node", "beam.ele"):
            with self.subTest(source):
                os.makedirs(self.path("out"), exist_ok=True)
                os.link(self.path(source), self.path("out", "history.csv"))
                self.assertIn("would be overwritten", self.refused(2, f"run {scene} --out out"))
                shutil.rmtree(self.path("out"))
        # The link is the input, and would be replaced.
        os.makedirs(self.path("out"))
        os.symlink(scene, self.path("out", "summary.json"))
        self.refused(2, "run out/summary.json --out out", says="would be overwritten")
        # This link is not: it is replaced, and what it names stays.
        before = self.read(scene)
        self.run_program(f"run {scene} --out out --quiet")
        self.assertFalse(os.path.islink(self.path("out", "summary.json")))
        self.assertEqual(self.read(scene), before)
        # Inputs beside the results, with names that no result has.
        shutil.copy(scene, self.path("out", "scene.toml"))
        for ending in (".node", ".ele"):
            shutil.copy(self.path("beam" + ending), self.path("out"))
        self.run_program("run out/scene.toml --out out --quiet")

    def test_a_fresh_study_replaces_an_earlier_one(self):
        study = ["study", "beam.toml", "--out", "s"]
        first = self.run_program(*study, "--steps", "0.025,0.05", "--integrators", "midpoint")
        self.assertNotIn("earlier", first.stderr)
        names = set(os.listdir(self.path("s")))
        self.assertIn("midpoint-0.025", names)
        self.assertTrue(any(name.endswith(".png") for name in names))
        # Mistakes cost nothing, and what is not of the study stays.
        before = files_below(self.path("s"))
        self.refused(2, *study, "--steps", "7", "--quiet")
        self.refused(2, *study, "--set", "fix.0.select={all=true}")
        self.refused(3, "study none.toml --out s")
        self.assertEqual(files_below(self.path("s")), before)
        for name in ("notes.txt", os.path.join("midpoint-0.025", "figure.png")):
            self.write(os.path.join("s", name), "mine")
        os.mkdir(self.path("s", "midpoint-0.5"))
        self.write(os.path.join("s", "midpoint-0.5", "history.csv"), "mine")
        second = self.run_program(*study, "--steps", "0.02", "--integrators",
                                  "midpoint,backward-euler", "--no-plots", "--fresh")  # fmt: skip
        self.assertIn("earlier study", second.stderr)
        self.assertEqual(
            {name for name in files_below(self.path("s")) if not name.startswith("midpoint-0.02/")
             and not name.startswith("backward-euler-0.02/") and not name.startswith("midpoint-0.04/")},
            {"study.csv", "study.json", "study.html", "notes.txt", "midpoint-0.025/figure.png",
             "study_runs.csv", "midpoint-0.5/history.csv"},
        )  # fmt: skip
        # A study that is cut off leaves word of what it began, and all that there was.
        process = self.start(*study, "--steps", "1e-5", "--integrators", "midpoint", "--quiet")
        folder = self.path("s", "midpoint-1e-05")
        self.wait_for_file(process, folder, "frames.pvd")
        process.kill()
        process.wait()
        self.assertTrue(os.path.exists(self.path("s", "midpoint-0.02", "study_row.json")))
        self.assertIn("not ended", self.read_json("s", "study.json")["message"])
        # As if it had been killed while it wrote.
        for name in (os.path.join("frames", "frame_000007.vtu.part"), "frames.pvd.part"):
            self.write(os.path.join(folder, name), "half")
        self.run_program(*study, "--steps", "0.02", "--integrators", "midpoint", "--no-plots", "--fresh")
        self.assertFalse(os.path.exists(folder))

    def test_a_linked_run_is_refused_before_anything_changes(self):
        study = ["study", "beam.toml", "--out", "s", "--steps", "0.025,0.05", "--integrators", "midpoint",
                 "--no-plots"]  # fmt: skip
        self.run_program(*study)
        os.rename(self.path("s", "midpoint-0.025"), self.path("elsewhere"))
        os.symlink(self.path("elsewhere"), self.path("s", "midpoint-0.025"))
        before = files_below(self.path("s"))
        for more in ([], ["--fresh"]):
            self.assertIn("this is a link", self.refused(4, *study, *more))
            self.assertEqual(files_below(self.path("s")), before)

    def test_runs_and_studies_do_not_mix(self):
        study = ["study", "beam.toml", "--steps", "0.05", "--integrators", "midpoint", "--no-plots"]
        self.run_program("run beam.toml --out r --quiet")
        before = files_below(self.path("r"))
        self.assertIn("results of a run", self.refused(2, *study, "--out", "r"))
        self.assertEqual(files_below(self.path("r")), before)
        self.run_program("run beam.toml --out r --quiet")  # again: its own it replaces
        self.run_program(*study, "--out", "s", "--quiet")
        self.assertIn("results of a study", self.refused(2, "run beam.toml --out s"))

    def test_a_study_of_the_same_twice(self):
        study = ["study", "beam.toml", "--steps", "0.05", "--out", "s", "--no-plots"]
        self.assertIn("twice", self.refused(2, *study, "--integrators", "midpoint,midpoint"))
        self.assertIn("twice", self.refused(2, *study, "--vary", "material.density=900,900"))


class NewProject(ProgramTest):
    def test_everything_in_it_works(self):
        told = self.run_program("new", "my first beam").stdout
        self.assertIn("tetraction check scene.toml", told)
        folder = self.path("my first beam")
        self.assertEqual(sorted(os.listdir(folder)), ["README.md", "beam.msh", "scene.toml"])
        scene = os.path.join(folder, "scene.toml")
        self.run_program("check", scene)
        result = self.run_program("run", scene, "--out", "results", *sets("time.end=0.02"))
        warnings = [line for line in result.stderr.splitlines()
                    if "warning" in line and "OPENBLAS" not in line]  # fmt: skip
        self.assertEqual(warnings, [])
        with open(self.path("results", "probes.csv")) as file:
            self.assertIn("tip_y", file.readline())
        self.run_program("static", scene, "--out", "equilibrium")
        self.assertTrue(self.read(os.path.join(folder, "README.md")).startswith("# my first beam\n"))

    def test_keys_in_comments_can_be_used(self):
        self.run_program("new beam")
        path = self.path("beam", "scene.toml")
        lines = self.read(path).splitlines()
        begin = lines.index("[mesh]")
        comments = [i for i, line in enumerate(lines) if i > begin and line.startswith("# ")]
        self.assertGreater(len(comments), 3)
        for i in comments:
            lines[i] = lines[i][2:].replace('unit = "mm"', 'unit = "m"')
        self.write("all.toml", "\n".join(lines).replace("beam.msh", "beam/beam.msh"))
        self.run_program("check all.toml")

    def test_folders_that_hold_something_stay_as_they_are(self):
        os.mkdir(self.path("taken"))
        self.write("taken/notes.txt", "mine")
        self.assertIn("not an empty folder", self.refused(2, "new taken"))
        self.assertEqual(os.listdir(self.path("taken")), ["notes.txt"])
        self.refused(2, "new taken/notes.txt")
        os.mkdir(self.path("empty"))
        self.run_program("new empty")
        self.refused(4, "new /proc/nowhere")


if __name__ == "__main__":
    main()
