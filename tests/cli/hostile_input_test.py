"""Input that is broken on purpose: one short message that is harmless to a terminal, and the exit code."""

import os
import shutil
import sys

sys.path.insert(0, f"{sys.path[0]}/..")
from support.program import BEAM, BeamTest, main
from support.scenes import tables

LONG = "w" * 100_000  # an argument may have 128 kB
ESCAPE = "\x1b[31mred\x07"
NO_DISPLAY = {"DISPLAY": None, "WAYLAND_DISPLAY": None}

TETRAHEDRON = """$MeshFormat
2.2 0 8
$EndMeshFormat
$Nodes
4
1 0 0 0
2 1 0 0
3 0 1 0
4 0 0 1
$EndNodes
$Elements
%d
%s$EndElements
"""


class HostileInput(BeamTest):
    def refused(self, code, *arguments, says=()):
        message = super().refused(code, *arguments, says=says)
        self.assertLess(len(message), 1500)
        self.assertNotIn("\x1b", message)
        self.assertNotIn("\x07", message)
        return message

    def test_long_and_escaped_arguments(self):
        for word in (LONG, ESCAPE):
            part = "w" * 80 if word is LONG else "\\x1b[31mred\\x07"
            for code, arguments in (
                (2, [word]),
                (2, ["run", "beam.toml", "--" + word]),
                (3, ["run", word]),
                (2, ["run", "beam.toml", "--set", "time.step=" + word]),
                (2, ["run", "beam.toml", "--set", word]),
                (2, ["run", "beam.toml", "--set", word + "=1"]),
                (2, ["run", "beam.toml", "--threads", word]),
                (2, ["study", "beam.toml", "--integrators", word]),
                (2, ["keys", word]),
                (2, ["mesh", "info", "mesh." + word]),
                (2, ["run", "beam.toml", "--set", f'fix.0.select={{group="{word}"}}'.replace("\x1b", "\\u001b")
                    .replace("\x07", "\\u0007")]),
            ):  # fmt: skip
                with self.subTest([argument[:20] for argument in arguments]):
                    self.assertIn(part[:60], self.refused(code, *arguments))

    def test_escapes_in_files(self):
        mesh = self.write("mesh.msh", "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n" + ESCAPE + "\n")
        self.assertIn("\\x1b[31mred\\x07", self.refused(3, f"mesh info {mesh}"))
        self.assertIn("mesh.msh:4: ", self.refused(3, f"mesh info {mesh}"))
        names = f'$PhysicalNames\n1\n3 9 "{ESCAPE}"\n$EndPhysicalNames\n'
        named = self.write("named.msh", TETRAHEDRON.replace("$Nodes\n", names + "$Nodes\n", 1)
                           % (1, "1 4 2 9 1 1 2 3 4\n"))  # fmt: skip
        result = self.run_program("mesh info", named)
        self.assertNotIn("\x1b", result.stdout)
        self.assertIn("\\x1b[31mred\\x07", result.stdout)

    def test_pipes_devices_and_folders(self):
        for name in ("pipe.toml", "pipe.msh", "pipe.vtu"):
            os.mkfifo(self.path(name))
        os.mkdir(self.path("folder.msh"))
        self.assertIn("not a regular file", self.refused(3, "run pipe.toml"))
        self.assertIn("not a regular file", self.refused(3, "run /dev/zero"))
        for name in ("pipe.msh", "pipe.vtu", "folder.msh"):
            self.assertIn("not a regular file", self.refused(3, "mesh info", name))
            self.refused(3, "run", self.write("mesh.toml", f'''
[mesh]
file = "{name}"
[material]
youngs_modulus = 1e5
poissons_ratio = 0.3
[time]
step = 1e-3
end = 1e-2
'''), says="not a regular file")  # fmt: skip

    def test_a_hundred_gigabytes_of_holes(self):
        mesh = self.write("sparse.msh", "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n")
        os.truncate(self.path("sparse.msh"), 100_000_000_000)
        self.assertIn("has 1e+05 MB", self.refused(3, f"mesh info {mesh}"))

    def test_a_surface_with_a_flat_triangle(self):
        corners = ["0 0 0", "1 0 0", "0 0 1", "0 0 0", "1 0 0", "2 0 0"]
        loops = ["".join(f"vertex {corner}\n" for corner in corners[k : k + 3]) for k in (0, 3)]
        facets = "".join(f"facet normal 0 1 0\nouter loop\n{loop}endloop\nendfacet\n" for loop in loops)
        self.write("wall.stl", f"solid wall\n{facets}endsolid wall\n")
        scene = self.write("wall.toml", """
[mesh]
generate = { kind = "cube", cells = 1 }

[material]
youngs_modulus = 1.0e5
poissons_ratio = 0.3

[time]
step = 0.001
end = 0.01

[[obstacle]]
name = "wall"
kind = "mesh"
file = "wall.stl"
""")
        message = self.refused(3, f"check {scene}")
        self.assertIn("wall.stl: Triangle 1", message)
        self.assertIn("no area", message)

    def test_repeated_tetrahedra_and_vertices(self):
        elements = "1 4 2 5 1 1 2 3 4\n2 4 2 6 1 1 3 2 4\n"
        mesh = self.write("twice.msh", TETRAHEDRON % (2, elements))
        result = self.run_program(f"mesh info {mesh}")
        self.assertIn("1 tetrahedra with the vertices of an earlier one were left out", result.stdout)
        self.assertIn("1 tetrahedra,", result.stdout)
        nodes = TETRAHEDRON.replace("$Nodes\n4\n", "$Nodes\n8\n").replace(
            "$EndNodes", "5 0 0 0\n6 -1 0 0\n7 0 -1 0\n8 0 0 -1\n$EndNodes"
        )
        mesh = self.write("touching.msh", nodes % (2, "1 4 0 1 2 3 4\n2 4 0 5 6 7 8\n"))
        result = self.run_program(f"mesh info {mesh}")
        self.assertIn("1 vertices are at the place of another one", result.stdout)

    def test_runs_that_the_window_opens(self):
        good = self.path("good")
        self.run_program("run", self.write("beam.toml", BEAM), "--out", good, "--quiet")
        # Without a display a good run is refused with 2, after it was read.
        view = self.run_program("view", good, env=NO_DISPLAY, code=2)
        if "display" not in view.stderr:
            self.skipTest("the program has no window")
        frame = os.path.join("frames", "frame_000000.vtu")
        for name, text, part in (
            ("frames.pvd", "", "frames.pvd:1: Premature end"),
            ("frames.pvd", "<VTKFile></VTKFile>", "lists no frames"),
            ("frames.pvd", "<VTKFile><DataSet timestep='nan' file='a'/></VTKFile>", "without a time"),
            ("frames.pvd", "<VTKFile><DataSet timestep='0' file='none.vtu'/></VTKFile>", "no such file"),
            ("frames.pvd", None, "not a regular file"),
            ("history.csv", "", 'no column "step"'),
            ("history.csv", None, "not a regular file"),
            ("probes.csv", None, "not a regular file"),
            (frame, "", "not a VTU file"),
            (frame, None, "not a regular file"),
        ):
            with self.subTest(name + ": " + part):
                shutil.rmtree(self.path("bad"), ignore_errors=True)
                shutil.copytree(good, self.path("bad"))
                path = self.path("bad", name)
                if text is None:
                    if os.path.exists(path):
                        os.remove(path)
                    os.mkfifo(path)
                else:
                    self.write(os.path.join("bad", name), text)
                result = self.run_program("view bad", env=NO_DISPLAY, code=3)
                self.assertIn(part, result.stderr)
                self.assertLess(len(result.stderr), 1500)

    def test_links_to_themselves(self):
        for name in ("loop.msh", "loop.vtu", "loop.node", "loop.toml", "part.face"):
            os.symlink(name, self.path(name))
        self.write("part.node", "4 3 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n")
        self.write("part.ele", "1 4 0\n1 1 2 3 4\n")
        for name in ("loop.msh", "loop.vtu", "loop.node"):
            self.assertIn("cannot be read", self.refused(3, "mesh info", name))
        self.assertIn("part.face: cannot be read", self.refused(3, "mesh info part.node"))
        self.assertIn("cannot read the scene", self.refused(3, "run loop.toml"))
        os.symlink("loop", self.path("loop"))
        if "display" not in self.run_program("view beam.toml", env=NO_DISPLAY, code=2).stderr:
            self.skipTest("the program has no window")
        # A name without an ending is that of no scene, mesh or folder that can be read.
        for name, code in (("loop.toml", 3), ("loop.vtu", 3), ("loop", 2)):
            result = self.run_program("view", name, env=NO_DISPLAY, code=code)
            self.assertNotIn("unexpected", result.stderr)

    def test_headers_of_many_comments_and_pieces(self):
        # With a check whose time grows with the square of the length, none of these would end.
        start = '<?xml version="1.0"?>\n<VTKFile type="UnstructuredGrid" version="1.0">\n<UnstructuredGrid>\n'
        end = "</UnstructuredGrid>\n</VTKFile>\n"
        piece = '<Piece NumberOfPoints="0" NumberOfCells="0"></Piece>\n'
        array = '<DataArray type="Int8" Name="a" format="ascii"></DataArray>\n'
        comments = self.write("comments.vtu", start + "<!---->" * 2_000_000 + piece + end)
        self.refused(3, "mesh info", comments)
        self.refused(3, "mesh info", self.write("pieces.vtu", start + piece * 400_000 + end))
        self.refused(3, "mesh", "info", self.write("arrays.vtu", start + array * 400_000 + piece + end))

    def test_what_a_conversion_loses(self):
        data = "".join(
            f'${kind}\n1\n"{name}"\n1\n0\n3\n0\n1\n1\n1 5e5\n$End{kind}\n'
            for kind, name in (("ElementData", "E"), ("NodeData", "heat"))
        )
        names = '$PhysicalNames\n3\n3 9 "a \'b\' "c""\n2 1 "skin"\n2 2 "none"\n$EndPhysicalNames\n'
        elements = "1 4 2 9 1 1 2 3 4\n2 2 2 1 1 1 3 2\n3 2 0 1 2 4\n"
        text = TETRAHEDRON.replace("$Nodes\n", names + "$Nodes\n", 1) % (3, elements) + data
        mesh = self.write("part.msh", text)
        result = self.run_program(f"mesh convert {mesh} copy.msh")
        self.assertIn('not used: the groups "none", which have no elements', result.stderr)
        self.assertIn("1 cells of type triangle were left out", result.stderr)
        self.assertIn('these names up to the first quotation mark in them: a \'b\' "c"', result.stderr)
        self.assertNotIn("lost", result.stderr)
        result = self.run_program("mesh info copy.msh")
        self.assertIn('group "a \'b\' "c"" (dimension 3, tag 9)', result.stdout)
        self.assertIn('group "skin" (dimension 2, tag 1): 3 vertices, 1 triangles', result.stdout)
        self.assertIn('point array "heat": a number a vertex, from 500000', result.stdout)
        self.assertIn('cell array "E": a number a tetrahedron, from 500000', result.stdout)
        for ending in ("node", "veg"):
            result = self.run_program(f"mesh convert {mesh}", "copy." + ending)
            self.assertIn("these arrays of " + mesh + " are lost: heat, E", result.stderr)
        result = self.run_program(f"mesh convert {mesh} copy.vtu")
        self.assertNotIn("arrays", result.stderr)
        shown = self.json_of(f"mesh info {mesh}")
        self.assertEqual(shown["not_used"], ['the groups "none", which have no elements'])

    def test_names_of_a_surface_and_a_volume(self):
        names = '$PhysicalNames\n2\n2 1 "part"\n3 1 "part"\n$EndPhysicalNames\n'
        text = TETRAHEDRON.replace("$Nodes\n", names + "$Nodes\n", 1)
        self.write("part.msh", text % (2, "1 4 2 1 1 1 2 3 4\n2 2 2 1 1 1 3 2\n"))
        scene = """
[mesh]
file = "part.msh"
[material]
youngs_modulus = 1e5
poissons_ratio = 0.3
[time]
step = 1e-3
end = 2e-3
[[fix]]
select = { group = "%s" }
[[pressure]]
select = { group = "part" }
value = 10.0
[[material_region]]
select = { group = "part" }
youngs_modulus = 2e5
poissons_ratio = 0.3
"""
        message = self.refused(2, "run", self.write("both.toml", scene % "part"))
        self.assertIn('the group "part" is ambiguous', message)
        self.assertIn('"part (dimension 2)"', message)
        self.assertIn('"part (dimension 3)"', message)
        self.run_program("run", self.write("one.toml", scene % "part (dimension 2)"), "--quiet")

    def test_arrays_of_materials(self):
        data = '$ElementData\n1\n"E"\n1\n0\n3\n0\n1\n1\n7 5e5\n$EndElementData\n'
        self.write("part.msh", TETRAHEDRON % (1, "1 4 0 1 2 3 4\n") + data)
        scene = self.write("part.toml", tables(mesh=dict(file="part.msh"),
                                               material=dict(youngs_modulus={"array": "E"},
                                                 poissons_ratio=0.3),
                                               time=dict(step=1e-3, end=1e-2)))  # fmt: skip
        result = self.run_program(f"run {scene}", code=2)
        self.assertIn('not used: 1 values of the array "E", of elements that the file does not have', result.stderr)
        self.refused(2, "run", scene, "--quiet",
                     says=("material.youngs_modulus", "has no value at tetrahedron 1"))


if __name__ == "__main__":
    main()
