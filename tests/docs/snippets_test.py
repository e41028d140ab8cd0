"""The commands and scenes of README.md and of the pages in docs/, with the real program.

Usage: python3 snippets_test.py PROGRAM SOURCE_TREE [unittest arguments]

Each page has a temporary folder. In it are links to examples/, data/ and tests/ of the source tree, and what pages use as
examples: SCENE.toml and part.msh, a small clamped beam with groups and arrays of numbers, and stairs.obj. What
stands in the fenced blocks of a page is taken in its order:

- `sh`: the lines are executed by bash. Each must end with the exit code 0, or N if the line ends with `# exit code N`.
- `toml`: a text with [mesh] and [material] is a scene, any other one takes the place of the sections of SCENE.toml
  that it names. `tetraction check` must accept it.
- `python`: the text is executed in the interpreter that has executed the other such blocks of the page. Blocks that
  import tetraction are left out where the Python package is not built.
- `cpp` is built and run by the tests docs.Cpp (cpp_snippets.py). `cmake` and `text` are not executed.

A comment in the line before a block says what else holds:

- <!-- not run: REASON --> leaves the block out.
- <!-- shortened: run --set time.end=0.1; study --no-plots --> adds arguments to the commands `tetraction run` and
  `tetraction study` of the block.
- <!-- before it: TOML --> is put before the text of a `toml` block.
- <!-- file: NAME --> also writes a scene to this file, which the commands of the page then find.
- <!-- added to: NAME --> puts the text at the end of such a file.

A block that is none of these, and commands in an indented block, make the test fail.
"""

import importlib.util
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

from pages import blocks_of, pages_of

# Executes the files that its input names, one by one, and answers each with a line.
INTERPRETER = """
import os, sys, traceback
answers = os.fdopen(os.dup(1), "w", buffering=1)
os.dup2(2, 1)
names = {"__name__": "__main__"}
for path in map(str.strip, sys.stdin):
    try:
        with open(path, encoding="utf-8") as file:
            exec(compile(file.read(), path, "exec"), names)
        print("done", file=answers)
    except BaseException:
        traceback.print_exc()
        print("failed", file=answers)
    sys.stdout.flush()
"""

PROGRAM, TREE = os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2])
PAGES = pages_of(TREE)
ENVIRONMENT = {**os.environ, "TETRACTION": PROGRAM, "MPLBACKEND": "Agg"}

SCENE = """
[mesh]
file = "part.msh"
[material]
model = "neo-hookean"
youngs_modulus = 1.0e6
poissons_ratio = 0.3
density = 1000.0
[time]
integrator = "midpoint"
step = 0.01
end = 0.1
[environment]
kind = "gravity"
[damping]
viscosity = 10.0
[[fix]]
select = { group = "clamp" }
[[force]]
select = { group = "loaded" }
vector = [0.0, 1.0, 0.0]
[output]
directory = "out"
"""


# Two steps, in cm, below the beam.
STAIRS = """
v -100 -50 -100
v -100 -50 200
v 200 -50 -100
v 200 -50 200
v 200 -80 -100
v 200 -80 200
v 500 -80 -100
v 500 -80 200
f 1 2 3
f 2 4 3
f 3 4 5
f 4 6 5
f 5 6 7
f 6 8 7
"""


def write_part(path):
    """A beam of 4 x 1 x 1 m with the groups clamp and loaded and the cell data E, E2 and rho."""
    cells = (6, 2, 2)
    number = lambda i, j, k: 1 + i + (cells[0] + 1) * (j + (cells[1] + 1) * k)
    vertices = [
        (4.0 * i / cells[0], j / cells[1], k / cells[2])
        for k in range(cells[2] + 1) for j in range(cells[1] + 1) for i in range(cells[0] + 1)
    ]  # fmt: skip
    tetrahedra, ends = [], {"clamp": [], "loaded": []}
    orders = [(0, 1, 2), (0, 2, 1), (1, 0, 2), (1, 2, 0), (2, 0, 1), (2, 1, 0)]
    for k in range(cells[2]):
        for j in range(cells[1]):
            for i in range(cells[0]):
                for order in orders:
                    corner, path_of_cell = [i, j, k], [number(i, j, k)]
                    for axis in order:
                        corner[axis] += 1
                        path_of_cell.append(number(*corner))
                    if order not in [(0, 1, 2), (1, 2, 0), (2, 0, 1)]:  # these are of negative volume
                        path_of_cell[2:] = path_of_cell[:1:-1]
                    tetrahedra.append(path_of_cell)
    for tetrahedron in tetrahedra:
        for name, x in (("clamp", 0.0), ("loaded", 4.0)):
            face = [v for v in tetrahedron if vertices[v - 1][0] == x]
            if len(face) == 3:
                ends[name].append(face)
    triangles = [(tag, face) for tag, name in ((1, "clamp"), (2, "loaded")) for face in ends[name]]
    with open(path, "w") as file:
        file.write("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n")
        file.write('$PhysicalNames\n3\n2 1 "clamp"\n2 2 "loaded"\n3 3 "body"\n$EndPhysicalNames\n')
        file.write(f"$Nodes\n{len(vertices)}\n")
        for n, (x, y, z) in enumerate(vertices, 1):
            file.write(f"{n} {x!r} {y!r} {z!r}\n")
        file.write(f"$EndNodes\n$Elements\n{len(triangles) + len(tetrahedra)}\n")
        for n, (tag, face) in enumerate(triangles, 1):
            file.write(f"{n} 2 2 {tag} {tag} {face[0]} {face[1]} {face[2]}\n")
        first = len(triangles) + 1
        for n, t in enumerate(tetrahedra, first):
            file.write(f"{n} 4 2 3 3 {t[0]} {t[1]} {t[2]} {t[3]}\n")
        file.write("$EndElements\n")
        for name, value in (("E", 1.0e6), ("E2", 2.0e6), ("rho", 1000.0)):
            file.write(f'$ElementData\n1\n"{name}"\n1\n0.0\n3\n0\n1\n{len(tetrahedra)}\n')
            for n in range(len(tetrahedra)):
                file.write(f"{first + n} {value}\n")
            file.write("$EndElementData\n")


def sections_of(text):
    """A scene as pairs of the first name of a section and its text."""
    parts = re.split(r"^(?=\[)", text, flags=re.MULTILINE)
    head = re.compile(r"\[+\s*([A-Za-z_]+)")
    return [(head.match(part)[1] if head.match(part) else "", part) for part in parts]


def as_scene(text):
    """The scene that a block stands for."""
    names = {name for name, _ in sections_of(text)}
    if {"mesh", "material"} <= names:
        return text
    kept = [part for name, part in sections_of(SCENE) if name not in names]
    return "".join(kept) + text


def script_of(block):
    """The lines of a block with a check of the exit code after each of them."""
    # Commands of two words, such as `study diff`, are others than the first word alone.
    lines = ["set -u", "tetraction() {", '  command="$1"', '  [ "${2:-}" != diff ] || command="$1 $2"',
             '  case "$command" in']  # fmt: skip
    for part in block.marks.get("shortened", "").split(";"):
        if part.strip():
            command, _, arguments = part.strip().partition(" ")
            lines.append(f'    "{command}") "$TETRACTION" "$@" {arguments} ;;')
    lines += ['    *) "$TETRACTION" "$@" ;;', "  esac", "}"]
    for command in re.sub(r"\\\n", "\\\n", block.text).replace("\\\n", " ").split("\n"):
        if not command.strip() or command.strip().startswith("#"):
            continue
        wanted = re.search(r"# exit code (\d+)", command)
        wanted = int(wanted[1]) if wanted else 0
        # A comment ends with its line.
        quoted = command.replace("'", "'\\''")
        lines += [command, "code=$?",
                  f"[ $code -eq {wanted} ] || "
                  f"{{ echo 'exit code '$code', not {wanted}: {quoted}' >&2; exit 1; }}"]  # fmt: skip
    return "\n".join(lines) + "\n"


class Snippets(unittest.TestCase):
    count = {"run": 0, "marked": 0}

    @classmethod
    def tearDownClass(cls):
        print("blocks: {run} run, {marked} marked as not run".format(**cls.count), file=sys.stderr)

    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="tetraction-docs-")
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        for name in ("examples", "data", "tests"):
            os.symlink(os.path.join(TREE, name), os.path.join(self.folder, name))
        write_part(os.path.join(self.folder, "part.msh"))
        self.write("SCENE.toml", SCENE)
        self.write("u.csv", "vertex,x,y,z\n10,0.01,0,0\n")
        self.write("stairs.obj", STAIRS)
        self.python, self.interpreter = "", None

    def write(self, name, text):
        path = os.path.join(self.folder, name)
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
        return path

    def executed(self, block, *command):
        result = subprocess.run(command, cwd=self.folder, env=ENVIRONMENT, capture_output=True,
                                encoding="utf-8", errors="replace", timeout=300)  # fmt: skip
        self.count["run"] += 1
        output = (result.stdout + result.stderr)[-3000:]
        self.assertEqual(result.returncode, 0, f"{block}:\n{block.text}{output}")

    def executed_in_interpreter(self, block):
        if self.interpreter is None:
            self.output = self.write("python.log", "")
            with open(self.output, "w") as log:
                self.interpreter = subprocess.Popen(
                    [sys.executable, "-c", INTERPRETER], cwd=self.folder, text=True, stdin=subprocess.PIPE,
                    stdout=subprocess.PIPE, stderr=log, env=ENVIRONMENT,
                )  # fmt: skip
            for cleanup in (self.interpreter.stdout.close, self.interpreter.wait, self.interpreter.stdin.close):
                self.addCleanup(cleanup)
        print(self.write(f"line_{block.line}.py", block.text), file=self.interpreter.stdin, flush=True)
        answer = self.interpreter.stdout.readline()
        self.count["run"] += 1
        with open(self.output, encoding="utf-8", errors="replace") as log:
            self.assertEqual(answer, "done\n", f"{block}:\n{block.text}{log.read()[-3000:]}")

    def taken(self, block):
        if "not run" in block.marks:
            self.assertGreater(len(block.marks["not run"]), 10, f"{block}: the reason is missing")
            self.count["marked"] += 1
        elif block.language == "sh":
            self.executed(block, "bash", self.write("snippet.sh", script_of(block)))
        elif block.language == "python":
            self.python += block.text
            if "import tetraction" not in self.python or importlib.util.find_spec("tetraction"):
                self.executed_in_interpreter(block)
        elif block.language == "toml":
            if "added to" in block.marks:
                with open(os.path.join(self.folder, block.marks["added to"]), encoding="utf-8") as file:
                    whole = file.read() + block.text
                self.executed(block, PROGRAM, "check", self.write(block.marks["added to"], whole))
                return
            before = block.marks.get("before it")
            scene = as_scene(before + "\n" + block.text if before else block.text)
            if "file" in block.marks:
                self.write(block.marks["file"], scene)
            scene = self.write("snippet.toml", scene)
            self.executed(block, PROGRAM, "check", scene)
        else:
            self.assertIn(block.language, ("cpp", "cmake", "text"),
                          f"{block}: blocks of this language are not known to the test")  # fmt: skip

    def page(self, name):
        blocks, indented = blocks_of(TREE, name)
        for line in indented:
            with self.subTest(place=f"{name}:{line}"):
                self.fail("these commands are not in a ```sh block")
        for block in blocks:
            with self.subTest(place=str(block)):
                self.taken(block)


def add_test(page):
    name = "test_" + re.sub(r"\W+", "_", page[: -len(".md")])
    setattr(Snippets, name, lambda self: self.page(page))


for one in PAGES:
    add_test(one)

if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
