"""Installs the build into a folder and uses it as other projects do: with CMake and with pkg-config.

Usage: packages_test.py CMAKE BUILD_FOLDER SOURCE_FOLDER [TestCase...]
"""

import os
import shutil
import subprocess
import sys
import tempfile
import unittest

CMAKE, BUILD, SOURCE = sys.argv[1:4]
HERE = os.path.dirname(os.path.abspath(__file__))


def call(*command, **options):
    result = subprocess.run(command, capture_output=True, text=True, **options)
    if result.returncode != 0:
        raise AssertionError(f"{' '.join(command)}\n{result.stdout}\n{result.stderr}")
    return result.stdout


class Installed(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp(prefix="tetraction installed ")
        cls.prefix = os.path.join(cls.folder, "usr")
        call(CMAKE, "--install", BUILD, "--prefix", cls.prefix)

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.folder)

    def installed(self, *parts):
        return os.path.join(self.prefix, *parts)

    def build(self, name, components, program, *definitions):
        build = os.path.join(self.folder, name)
        call(CMAKE, "-G", "Ninja", "-S", HERE, "-B", build, "-DCMAKE_BUILD_TYPE=Release",
             f"-DCMAKE_PREFIX_PATH={self.prefix}", f"-DCOMPONENTS={components}",
             f"-DPROGRAM={program}", *definitions)  # fmt: skip
        call(CMAKE, "--build", build)
        return os.path.join(build, "my_program")

    def test_cmake_package_of_the_core_needs_no_vtk(self):
        absent = [f"-DCMAKE_DISABLE_FIND_PACKAGE_{name}=TRUE"
                  for name in ("VTK", "Qt5", "nlohmann_json", "tomlplusplus")]  # fmt: skip
        program = self.build("core", "core", os.path.join(SOURCE, "tests/consumer/main.cc"), *absent)
        self.assertEqual(call(program).strip(), "ok")

    def test_cmake_package_with_files(self):
        program = self.build("io", "core;io", os.path.join(HERE, "read_scene.cc"))
        scene = os.path.join(self.folder, "scene.toml")
        with open(scene, "w") as file:
            file.write('[mesh]\ngenerate = { kind = "beam", size = [4, 1, 1], cells = [4, 1, 1] }\n[material]\nyoungs_modulus = 1e5\npoissons_ratio = 0.3\n')
        self.assertRegex(call(program, scene), r"^[1-9]\d* vertices$")

    def test_a_project_without_a_build_type_is_warned(self):
        def told(name, *definitions):
            result = subprocess.run(
                [CMAKE, "-G", "Ninja", "-S", HERE, "-B", os.path.join(self.folder, name),
                 f"-DCMAKE_PREFIX_PATH={self.prefix}", "-DCOMPONENTS=core",
                 f"-DPROGRAM={os.path.join(SOURCE, 'tests/consumer/main.cc')}", *definitions],
                capture_output=True, text=True,
                env={k: v for k, v in os.environ.items() if k not in ("CMAKE_BUILD_TYPE", "CXXFLAGS")})  # fmt: skip
            self.assertEqual(result.returncode, 0, result.stderr)
            return " ".join(result.stderr.split())

        self.assertIn("no build type", told("none"))
        self.assertIn("-DCMAKE_BUILD_TYPE=Release", told("again"))
        for one in ("-DCMAKE_BUILD_TYPE=Release", "-DCMAKE_BUILD_TYPE=Debug", "-DCMAKE_CXX_FLAGS=-O2"):
            self.assertNotIn("build type", told("with" + one[-5:], one))

    def test_a_component_that_is_not_there_is_named(self):
        build = os.path.join(self.folder, "unknown")
        result = subprocess.run(
            [CMAKE, "-G", "Ninja", "-S", HERE, "-B", build, f"-DCMAKE_PREFIX_PATH={self.prefix}",
             "-DCOMPONENTS=core;gpu", "-DPROGRAM=read_scene.cc"],
            capture_output=True, text=True)  # fmt: skip
        self.assertNotEqual(result.returncode, 0)
        self.assertIn("gpu", result.stderr)

    def test_pkg_config(self):
        places = [os.path.join(root, "pkgconfig")
                  for root, folders, _ in os.walk(self.prefix) if "pkgconfig" in folders]  # fmt: skip
        environment = {**os.environ, "PKG_CONFIG_PATH": ":".join(places)}
        # A folder with blanks is quoted by pkg-config, and the shell takes the quotes away.
        flags = call("pkg-config", "--cflags", "--libs", "tetraction", env=environment)
        program = os.path.join(self.folder, "by_pkg_config")
        call("sh", "-c", f'g++ -O2 "$1" -o "$2" {flags}', "sh",
             os.path.join(SOURCE, "tests/consumer/main.cc"), program)  # fmt: skip
        self.assertEqual(call(program).strip(), "ok")

    def test_the_program_and_what_comes_with_it(self):
        program = self.installed("bin", "tetraction")
        version = call(program, "--version")
        for library in ("Eigen", "Ceres", "CHOLMOD", "VTK", "toml++"):
            self.assertRegex(version, rf"{library.replace('+', '.')} [0-9]+\.[0-9]+")
        # Its mesh is in the folder `data` beside the examples.
        scene = self.installed("share/doc/tetraction/examples/scenes/tuning_fork.toml")
        out = os.path.join(self.folder, "out")
        call(program, "run", scene, "--out", out, "--set", "time.end=2e-4", "--quiet")
        for page in ("tetraction", "tetraction-run", "tetraction-mesh-info"):
            path = self.installed("share/man/man1", page + ".1")
            self.assertTrue(os.path.exists(path), page)
        with open(self.installed("share/man/man1/tetraction-run.1")) as file:
            text = file.read()
        for word in ("\\-\\-resume", "\\-\\-set", "EXIT STATUS"):
            self.assertIn(word, text)
        with open(self.installed("share/man/man1/tetraction.1")) as file:
            self.assertNotIn("document", file.read())
        with open(self.installed("share/man/man1/tetraction-study.1")) as file:
            text = file.read()
        self.assertIn(".B tetraction study\n[\\fIscene\\fR]\n[\\fIOPTION\\fR]...\n", text)
        self.assertIn(".B tetraction study\n.I COMMAND\n", text)
        self.assertIn("\\fBtetraction\\-study\\-diff\\fR(1)", text)
        self.assertTrue(os.path.exists(self.installed("share/man/man1/tetraction-study-diff.1")))

    def test_python_package(self):
        folder = self.installed("lib/python3/dist-packages")
        if not os.path.isdir(folder):
            self.skipTest("built without the Python package")
        for name in ("py.typed", "_settings.pyi", "_study_plots/plots.py"):
            self.assertTrue(os.path.exists(os.path.join(folder, "tetraction", name)), name)
        scene = self.installed("share/doc/tetraction/examples/scenes/single_tetrahedron.toml")
        text = "import sys, tetraction as tt; s = tt.Session(sys.argv[1]); print(s.step(5), tt.__file__)"
        steps, _, path = call("/usr/bin/python3", "-c", text, scene, env={**os.environ, "PYTHONPATH": folder}
                              ).strip().partition(" ")  # fmt: skip
        self.assertEqual(steps, "5")
        self.assertTrue(path.startswith(folder))

    def completions(self, *words):
        script = self.installed("share/bash-completion/completions/tetraction")
        quoted = " ".join(f"'{word}'" for word in words)
        return call("bash", "-c", f"source '{script}'; COMP_WORDS=({quoted}); "
                    f"COMP_CWORD={len(words) - 1}; _tetraction; printf '%s\\n' \"${{COMPREPLY[@]}}\""
                    ).split()  # fmt: skip

    def test_completion_of_bash(self):
        self.assertIn("static", self.completions("tetraction", "st"))
        self.assertIn("study", self.completions("tetraction", "st"))
        self.assertEqual(self.completions("tetraction", "mesh", "inf"), ["info"])
        self.assertIn("--resume", self.completions("tetraction", "run", "scene.toml", "--re"))
        self.assertNotIn("--resume", self.completions("tetraction", "modes", "--re"))
        for words in ("run CM", "study CM", "study diff a CM"):
            self.assertIn("CMakeLists.txt", call(
                "bash", "-c", f"cd '{HERE}'; source '{self.installed('share/bash-completion/completions/tetraction')}'; "
                f"COMP_WORDS=(tetraction {words}); COMP_CWORD={len(words.split())}; _tetraction; echo ${{COMPREPLY[@]}}"))  # fmt: skip
        self.assertEqual(self.completions("tetraction", "study", "dif"), ["diff"])
        self.assertEqual(self.completions("tetraction", "mesh", "CM"), [])
        self.assertIn("--json", self.completions("tetraction", "study", "diff", "--js"))
        self.assertNotIn("--steps", self.completions("tetraction", "study", "diff", "--"))

    def test_desktop_entry(self):
        path = self.installed("share/applications/tetraction.desktop")
        if not os.path.exists(path):
            self.skipTest("built without the viewer")
        if shutil.which("desktop-file-validate"):
            call("desktop-file-validate", path)
        self.assertTrue(os.path.exists(self.installed("bin/tetraction-window")))
        self.assertTrue(os.path.exists(
            self.installed("share/icons/hicolor/scalable/apps/tetraction.svg")))  # fmt: skip


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]], verbosity=1)
