"""Command lines, exit codes and the surroundings of the program."""

import concurrent.futures
import glob
import os
import re
import shutil
import subprocess
import sys
import tempfile

sys.path.insert(0, f"{sys.path[0]}/..")
from support.program import PROGRAM, ProgramTest, main, own_lines
from support.scenes import plane, tables

OUTPUTS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "docs", "outputs.md")

# So small that every command that does run takes a moment.
SCENE = tables(mesh=dict(generate={"kind": "tetrahedron", "size": 1.0}),
               material=dict(youngs_modulus=1.0e5, poissons_ratio=0.3),
               time=dict(integrator="midpoint", step=0.01, end=0.01),
               fix=[dict(select=plane("x", 0.0))])
# What each command needs beside options. Studies: one run, and no plots.
POSITIONALS = {
    ("new",): ["beam"], ("run",): ["scene.toml"], ("static",): ["scene.toml"], ("check",): ["scene.toml"],
    ("modes",): ["scene.toml", "-n", "1"], ("view",): ["box.msh"], ("keys",): ["time"],
    ("study",): ["scene.toml", "--no-plots", "--integrators", "midpoint", "--steps", "0.01"],
    ("study", "diff"): ["a", "b"], ("study", "open"): ["a"], ("study", "merge"): ["a", "b", "--out", "c"],
    ("mesh", "info"): ["box.msh"], ("mesh", "convert"): ["box.msh", "out.msh"],
    ("mesh", "generate", "beam"): ["out.msh"], ("mesh", "generate", "box"): ["out.msh"],
    ("mesh", "generate", "cube"): ["out.msh"], ("mesh", "generate", "tetrahedron"): ["out.msh"],
}  # fmt: skip

NOT_NUMBERS = ["", " ", "abc", "1e", "1.0.0", "1;2", "0.1 s", "nan", "1,,2", "--", "\udcff", "1\n2"]
OUT_OF_RANGE = ["-1", "-1e308", "inf", "-inf", "1e400", "-0.5"]
TOO_LARGE = "99999999999999999999"  # for an integer
TEXTS = ["", " ", "-", "--", "nothing", "a b", "straße", "\udcff\udcfe", "a\nb", "\x1b[2J", "%s%n%x",
         "x" * 100_000, "=", "a=", "=b", "..", "/dev/null/x", ",", "@", "[", "time.step=nan",
         "mesh.generate={", "'\"`$(id)"]  # fmt: skip


class Option:
    def __init__(self, name, rest):
        self.name = name
        self.many = "..." in rest
        self.kind = re.match(r"(INT|FLOAT|TEXT|X,Y,Z|)", rest).group(1)


def options_of(text):
    """The options in a help text, --help and --version apart."""
    found = []
    for line in text.splitlines():
        match = re.match(r"  (?:-\w,)?(--[\w-]+)(?: +(\S.*))?$", line)
        if match and match.group(1) not in ("--help", "--version"):
            # Two blanks or more part the kind of value from what the option is for.
            found.append(Option(match.group(1), re.split(r" {2,}", match.group(2) or "")[0]
                                if not line.startswith("  " + match.group(1) + "  ") else ""))  # fmt: skip
    return found


class Arguments(ProgramTest):
    """Malformed command lines, made from the program's own help: one message and a documented code."""

    def setUp(self):
        super().setUp()
        self.write("scene.toml", SCENE)
        self.run_program("mesh generate box box.msh --cells 1,1,1")

    def commands(self, words=()):
        """Every command, as words, and its options."""
        text = self.run_program(*words, "--help").stdout
        subcommands = re.findall(r"^  (\w+) {2,}", text.partition("Subcommands:")[2], re.MULTILINE)
        # One that takes operands works by itself, whether or not it has further commands.
        if not subcommands or "Positionals:" in text:
            yield words, options_of(text)
        for name in subcommands:
            yield from self.commands((*words, name))

    def answers(self, lines):
        """Exit code, stdout and stderr of each command line; each in a folder of its own."""
        environment = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY")}
        environment["OPENBLAS_NUM_THREADS"] = "1"  # a fifth of the time of a start goes to its threads

        def answer(arguments):
            folder = tempfile.mkdtemp(dir=self.folder)
            for name in ("scene.toml", "box.msh"):
                os.link(self.path(name), os.path.join(folder, name))
            return subprocess.run(
                [PROGRAM, *(a.encode("utf-8", "surrogateescape") for a in arguments)],
                capture_output=True, encoding="utf-8", errors="surrogateescape", timeout=120,
                stdin=subprocess.DEVNULL, cwd=folder, env=environment,
            )  # fmt: skip

        with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
            return zip(lines, pool.map(answer, lines))

    def expect(self, lines, codes):
        for line, result in self.answers(lines):
            with self.subTest([word[:40] for word in line]):
                self.assertIn(result.returncode, codes, result.stderr[:500])
                messages = [
                    text for text in own_lines(result.stderr)
                    if re.match("tetraction: (?!warning|note)", text)
                ]  # fmt: skip
                self.assertEqual(len(messages), 0 if result.returncode == 0 else 1, result.stderr)
                self.assertLess(len(result.stderr), 2000)
                self.assertNotRegex(result.stderr, "[\x00-\x08\x0b-\x1f\x7f]")

    def test_every_option_of_every_command(self):
        malformed, odd = [], []
        found = list(self.commands())
        self.assertEqual({words for words, _ in found}, set(POSITIONALS))
        for words, options in found:
            start = [*words, *POSITIONALS[words]]
            for option in options:
                given = option.name in start
                if option.kind == "":
                    malformed += [[*start, f"{option.name}={v}"] for v in ("maybe", "7e", " ")]
                    odd.append([*start, option.name, option.name])
                    continue
                malformed.append([*start, option.name])
                malformed += [[*start, option.name, word] for word in ("--help", "--json", "--", "-x")]
                malformed += [[*start, f"{option.name}=", word] for word in ("--help", "1", "a")]
                if option.kind == "TEXT":
                    odd += [[*start, f"{option.name}={text}"] for text in TEXTS]
                    if not option.many and not given:
                        malformed.append([*start, option.name, "a", option.name, "b"])
                    continue
                values = NOT_NUMBERS + OUT_OF_RANGE
                if option.kind == "INT":
                    values = [*values, TOO_LARGE]
                if option.kind == "X,Y,Z":
                    values = [f"1,{value},1" for value in values] + ["", "1", "1,1", "1,1,1,1"]
                malformed += [[*start, f"{option.name}={value}"] for value in values]
                if not option.many:
                    malformed.append([*start, option.name, "1", option.name, "1"])
        self.assertGreater(len(malformed), 200)
        self.assertGreater(len(odd), 300)
        self.expect(malformed, {2})
        self.expect(odd, {0, 2, 3, 4})


    def test_a_missing_value_is_named(self):
        for line, words in (
            (["run", "scene.toml", "--out", "--quiet"], "--out needs a value, but --quiet follows"),
            (["run", "scene.toml", "--out=", "--quiet"], "--out has no value"),
            (["study", "scene.toml", "--integrators", "--resume"], "--integrators needs a value"),
            (["--threads", "--quiet", "run", "scene.toml"], "--threads needs a value"),
            (["modes", "scene.toml", "-n", "--static"], "-n needs a value"),
            (["--quiet", "run", "scene.toml"], "write it behind that, as in tetraction run --quiet"),
        ):
            with self.subTest(line):
                self.assertIn(words, self.refused(2, *line))
        self.assertEqual(sorted(os.listdir(self.folder)), ["box.msh", "scene.toml"])
        # Whoever wants such a name can have it, and numbers may have a minus.
        self.run_program("run scene.toml --out=--quiet")
        self.assertTrue(os.path.exists(self.path("--quiet", "summary.json")))
        self.assertIn("not in range 0 to 1024", self.refused(2, "run scene.toml --threads -1"))


class ExitCodes(ProgramTest):
    """Each exit code of the table in docs/outputs.md, from the program itself."""

    def test_every_documented_code(self):
        self.write("scene.toml", SCENE)
        self.write("wrong.toml", "[mesh]\n[materiel]\n")
        endless = ["run", "scene.toml", "--set", "time.end=1e9", "--out", "endless"]
        commands = {
            0: ["run", "scene.toml", "--out", "good"],
            1: ["run", "scene.toml", "--out", "bad", "--set", "solver.max_iterations=1",
                "--set", "time.step=0.1", "--set", "time.end=1", "--set",
                "initial.velocity=[9,9,9]"],
            2: ["run", "wrong.toml"],
            3: ["run", "missing.toml"],
            4: ["run", "scene.toml", "--out", "/dev/null/out"],
            129: endless, 130: endless, 131: endless, 143: endless,
        }  # fmt: skip
        rows = re.findall(r"^\| ([\d, ]+) \|", self.read(OUTPUTS), re.MULTILINE)
        documented = {int(code) for row in rows for code in row.split(",")}
        self.assertLessEqual({0, 1, 2, 3, 4, 130}, documented)
        self.assertLessEqual(documented, set(commands))
        for code in sorted(documented):
            with self.subTest(code):
                if code < 128:
                    self.run_program(*commands[code], code=code)
                    continue
                program = self.start(*commands[code])
                # Two frames: steps are being made.
                self.wait_for(lambda: len(glob.glob(self.path("endless", "frames", "*.vtu"))) >= 2, program)
                program.send_signal(code - 128)
                _, stderr = program.communicate(timeout=120)
                self.assertEqual(program.returncode, code, stderr)
                self.assertTrue(os.path.exists(self.path("endless", "summary.json")))
                shutil.rmtree(self.path("endless"))


class Surroundings(ProgramTest):
    """Names of files, the user's environment and the machine."""

    def test_libraries_of_the_window_and_of_several_processes_are_loaded_where_they_are_needed(self):
        libraries = subprocess.run([PROGRAM, "run"], env={**os.environ, "LD_TRACE_LOADED_OBJECTS": "1"},
                                   capture_output=True, text=True).stdout  # fmt: skip
        self.assertIn("libcholmod", libraries)
        for name in ("libQt", "libGL", "libX11", "vtkRendering", "libpetsc", "libmpi"):
            self.assertNotIn(name, libraries)

    def test_a_program_without_its_window_says_so(self):
        alone = self.path("tetraction")
        shutil.copy(PROGRAM, alone)
        result = subprocess.run([alone, "view"], capture_output=True, text=True)
        self.assertEqual(result.returncode, 2)
        self.assertIn("no program tetraction-window", result.stderr)

    def test_names_with_blanks_quotes_and_letters_of_other_languages(self):
        folder = self.path("a b", "ü 数 'q\" $(touch made) ;&")
        os.makedirs(folder)
        scene = os.path.join(folder, "sz ene.toml")
        mesh = os.path.join(folder, "würfel 1.msh")
        self.run_program("mesh generate box", mesh, "--cells", "1,1,1")
        self.write(scene, SCENE.replace('generate = { kind = "tetrahedron", size = 1.0 }',
                                        'file = "würfel 1.msh"'))
        out = os.path.join(folder, "er gebnis")
        self.run_program("run", scene, "--out", out)
        self.run_program("check", scene)
        self.run_program("mesh convert", mesh, os.path.join(folder, "a b.vtu"))
        # The folder goes to the program that draws the plots, too.
        plots = os.path.join(folder, "stu die")
        self.run_program("study", scene, "--out", plots, "--integrators", "midpoint", "--steps",
                         "0.01,0.005", "--set", "environment.kind=gravity")  # fmt: skip
        self.assertTrue(os.path.exists(os.path.join(plots, "energy_over_time.png")), os.listdir(plots))
        for _, _, names in os.walk(self.folder):
            self.assertNotIn("made", names)

    def test_a_line_break_in_a_name_does_not_break_a_message(self):
        for name in ("n\nl.msh", "n\nl.toml", "n\nl.stl"):
            words = ["run", name] if name.endswith("toml") else ["mesh", "info", name]
            result = subprocess.run([PROGRAM, *words], cwd=self.folder, capture_output=True, text=True)
            self.assertEqual(result.stderr.count("\n"), 1, result.stderr)
            self.assertIn("n\\nl", result.stderr)
        result = subprocess.run([PROGRAM, "run", "--a\nb"], cwd=self.folder, capture_output=True,
                                text=True)  # fmt: skip
        self.assertEqual(len(result.stderr.splitlines()), 2, result.stderr)  # and what helps
        self.assertIn("See tetraction run --help.", result.stderr)

    def test_home_locale_and_terminal(self):
        self.write("scene.toml", SCENE)
        self.run_program("run scene.toml --out out")
        history = self.read("out", "history.csv")
        locales = self.path("locales")
        os.mkdir(locales)
        os.mkdir(self.path("home"), 0o500)
        subprocess.run(["localedef", "-i", "de_DE", "-f", "UTF-8", os.path.join(locales, "de_DE.UTF-8")],
                       stderr=subprocess.DEVNULL)  # fmt: skip
        for environment in ({"HOME": None}, {"HOME": "/nonexistent"}, {"HOME": self.path("home")},
                            {"LOCPATH": locales, "LC_ALL": "de_DE.UTF-8"}, {"LC_ALL": "C.UTF-8"},
                            {"LC_ALL": "no_SUCH"}, {"TERM": None}, {"TMPDIR": "/nonexistent"},
                            {"PATH": None}, dict.fromkeys(os.environ)):  # fmt: skip
            with self.subTest(list(environment.items())[:2]):
                self.run_program("run scene.toml --out out", env=environment)
                self.assertEqual(self.read("out", "history.csv"), history)
        # Without a terminal and without streams: a session of its own, as in a batch system.
        subprocess.run([PROGRAM, "run", "scene.toml", "--out", "out"], cwd=self.folder, check=True,
                       stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                       stderr=subprocess.DEVNULL, start_new_session=True, timeout=120)  # fmt: skip


if __name__ == "__main__":
    main()
