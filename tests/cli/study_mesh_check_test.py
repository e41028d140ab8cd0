"""The error of the mesh, which a run on a finer mesh tells, with everything that a scene can have."""

import itertools
import shutil
import sys

sys.path.insert(0, f"{sys.path[0]}/..")
from support.program import BEAM, BEAM_MESH, main
from support.scenes import plane, tables
from support.study import StudyTest

FACE = plane("x", 4.0)
TIP = {"vertices": [8]}  # a corner of the end
ENDS = {"vertices": [8, 17, 26]}  # all on one edge of it: a finer mesh has vertices between them


def two_cubes(*places):
    """A mesh file of two unit cubes that do not touch, each with six tetrahedra."""
    points, cells = [], []
    for x in places:
        first = len(points)
        points += [(x + i, j, k) for k in (0, 1) for j in (0, 1) for i in (0, 1)]
        for path in itertools.permutations((1, 2, 4)):
            corners = [0, path[0], path[0] + path[1], 7]
            if path not in ((1, 2, 4), (2, 4, 1), (4, 1, 2)):
                corners[2:] = corners[:1:-1]
            cells.append([first + c for c in corners])
    lines = ["# vtk DataFile Version 3.0", "two cubes", "ASCII", "DATASET UNSTRUCTURED_GRID",
             f"POINTS {len(points)} double", *(" ".join(map(str, p)) for p in points),
             f"CELLS {len(cells)} {5 * len(cells)}", *("4 " + " ".join(map(str, c)) for c in cells),
             f"CELL_TYPES {len(cells)}", *["10"] * len(cells)]  # fmt: skip
    return "\n".join(lines) + "\n"


def event(**change):
    return tables(event=[dict(at=0.05, **change)])


def region(select):
    return "[[material_region]]\n" + tables(x=[dict(select=select)]).replace("[[x]]", "").strip() + \
        '\nmodel = "neo-hookean"\nyoungs_modulus = 2e6\npoissons_ratio = 0.3\ndensity = 1000.0\n'  # fmt: skip


# What is added to the scene, and a part of the message if the finer mesh is refused.
TABLE = {
    "gravity": ("", None),
    "quadratic elements": ("mesh.element=quadratic", None),
    "nodal volumes": ("mesh.volume=nodal", None),
    "viscosity": (tables(damping=dict(viscosity=10.0, mass_damping=1.0)), None),
    "drag": (tables(damping=dict(drag=0.1)), "damping.drag acts on every vertex"),
    "drag in an event": (event(set={"damping.drag": 0.1}), "damping.drag acts on every vertex"),
    "an equilibrium": ("initial.static=true", None),
    "a stretch": ("initial.stretch=[1.01,1,1]", None),
    "attraction": ("environment.kind=attraction", "pulls every vertex"),
    "a force on every vertex": (tables(force=[dict(select=FACE, vector=[0.0, -1.0, 0.0])]),
                                "25 of them instead of 9, so that the whole force is another one. Take total"),
    "a total force": (tables(force=[dict(select=FACE, total=[0.0, -9.0, 0.0])]), None),
    "a force on one vertex": (tables(force=[dict(select=TIP, vector=[0.0, -1.0, 0.0])]), None),
    "a force on vertices by number": (tables(force=[dict(select=ENDS, vector=[0.0, -1.0, 0.0])]),
                                      "selected by their numbers"),
    "a total force on vertices by number": (tables(force=[dict(select=ENDS, total=[0.0, -1.0, 0.0])]),
                                            "selected by their numbers"),
    "a force on a nearest vertex": (tables(force=[dict(select={"nearest": [4.0, 0.5, 0.5]}, vector=[0.0, -1.0, 0.0])]),
                                    None),
    "a force on another nearest vertex": (
        tables(force=[dict(select={"nearest": [4.0, 0.3, 0.3]}, vector=[0.0, -1.0, 0.0])]), "another vertex is nearest"),
    "a force in an event": (event(force=dict(select=FACE, vector=[0.0, -1.0, 0.0])), "25 of them instead of 9"),
    "a moment": (tables(moment=[dict(select=FACE, vector=[1.0, 0.0, 0.0])]), None),
    "a traction": (tables(traction=[dict(select=FACE, vector=[0.0, -10.0, 0.0])]), None),
    "a pressure": (tables(pressure=[dict(select=FACE, value=10.0)]), None),
    "a body force": (tables(body_force=[dict(select={"all": True}, acceleration=[1.0, 0.0, 0.0])]), None),
    "a pull of a vertex": ("[pull]\nvertices = [8]\nstiffness = 5.0\n", None),
    "a pull of vertices": ("[pull]\nvertices = [8, 17]\nstiffness = 5.0\n", "selected by their numbers"),
    "a pull in an event": (event(set={"pull.vertices": [8, 17], "pull.stiffness": 5.0}), "selected by their numbers"),
    "vertices held by number": (tables(fix=[dict(select=ENDS, components="z")]), "selected by their numbers"),
    "a named selection by number": ("[selection.end]\nvertices = [8, 17]\n" +
                                    tables(fix=[dict(select="end", components="z")]), "selected by their numbers"),
    "numbers in a set": (tables(fix=[dict(select={"any_of": [FACE, ENDS]}, components="z")]),
                         "selected by their numbers"),
    "one vertex held": (tables(fix=[dict(select=TIP, components="z")]), None),
    "springs": (tables(fix=[dict(select=FACE, components="z", mode="penalty", penalty=100.0)]),
                "so that the whole stiffness is another one"),
    "a spring": (tables(fix=[dict(select=TIP, components="z", mode="penalty", penalty=100.0)]), None),
    "a moving face": (tables(fix=[dict(select=FACE, velocity=[0.1, 0.0, 0.0])]), None),
    "vertices released": (event(unfix=dict(select=plane("x", 0.0))), None),
    "a distance": (tables(constraint=[dict(kind="distance", vertices=[4, 8])]), None),
    "a plane": (tables(constraint=[dict(kind="plane", select=FACE, normal=[0.0, 0.0, 1.0])]), None),
    "a line": (tables(constraint=[dict(kind="line", select=FACE, direction=[0.0, 1.0, 0.0])]), None),
    "a free handle": (tables(constraint=[dict(kind="rigid", select=FACE)]), None),
    "a driven handle": (tables(constraint=[dict(kind="rigid", select=FACE, angular_velocity=[0.5, 0.0, 0.0])]), None),
    "a handle by numbers": (tables(constraint=[dict(kind="rigid", select=ENDS)]), "selected by their numbers"),
    "momenta": (tables(**{"initial.momentum": [dict(select=FACE, value=[0.0, 0.1, 0.0])]}),
                "so that the whole momentum is another one"),
    "a momentum in an event": (event(momentum=dict(select=FACE, value=[0.0, 0.1, 0.0])),
                               "so that the whole momentum is another one"),
    "a shift": (event(shift=dict(vertices=[8], displacement=[[0.0, 0.01, 0.0]])), "a shift moves single vertices"),
    "a region": (region({"box": {"min": [0.0, 0.0, 0.0], "max": [2.0, 1.0, 1.0]}}), None),
    "a region by numbers": (region({"vertices": list(range(81))}), "selected by their numbers"),
}
# Probes as the error: what is added to the scene, the error, and a part of the message.
PROBES = {
    "a displacement": (dict(select=FACE, quantity="displacement"), "probe", None),
    "that of vertices": (dict(select=ENDS, quantity="displacement"), "probe", None),
    "a peak": (dict(select=FACE, quantity="displacement"), "peak.probe", None),
    "a stress": (dict(point=[1.9, 0.5, 0.5], quantity="von_mises"), "probe", None),
    "a reaction": (dict(select=plane("x", 0.0), quantity="reaction"), "probe", None),
    "that of vertices by number": (dict(select={"vertices": [0]}, quantity="reaction"), "probe",
                                   "the reaction of single vertices"),
    "the nearest vertex": (dict(select={"nearest": [2.1, 0.3, 0.3]}, quantity="position"), "probe",
                           "another vertex is nearest"),
}  # fmt: skip
GRID = ["--integrators", "midpoint", "--steps", "0.01,0.02", "--frames", "none", "--repeats", "0", "--mesh-check",
        "--reference-step", "0.005"]  # fmt: skip


class MeshCheckTable(StudyTest):
    def expect(self, scene, options, says):
        """A run on the finer mesh that reached the end, or a refusal before the first run."""
        self.write("beam.toml", scene)
        if says is not None:
            self.assertIn("--mesh-check: ", self.refused_study(*GRID, *options, says=says))
            return
        self.study(*GRID, *options, "--fresh")
        check = self.result()["mesh_check"]
        self.assertEqual(check["status"], "ok")
        self.assertEqual(check["tetrahedra"], 8 * 8 * 2 * 2 * 6)
        self.assertGreater(check["difference"], 0.0)
        self.assertLess(check["difference"], 1.0)
        self.assertAlmostEqual(check["estimated_error"] / check["difference"], 4.0 / 3.0)
        shutil.rmtree(self.path("s"))

    def test_every_part_of_a_scene(self):
        for name, (added, says) in TABLE.items():
            with self.subTest(name):
                is_setting = "\n" not in added and added != ""
                self.expect(BEAM + ("" if is_setting else added), ["--set", added] if is_setting else [], says)

    def test_every_kind_of_error(self):
        for name, (probe, error, says) in PROBES.items():
            with self.subTest(name):
                self.expect(BEAM + tables(probe=[dict(name="p", **probe)]), ["--error", f"{error}.p"], says)
        with self.subTest("an energy"):
            self.expect(BEAM, ["--error", "energy.elastic_energy"], None)

    def test_a_body_of_two_parts(self):
        self.write("two.vtk", two_cubes(0.0, 3.0))
        held = tables(fix=[dict(select=plane("x", 3.0))])
        self.write("beam.toml", BEAM.replace(BEAM_MESH, 'file = "two.vtk"') + held)
        self.study(*GRID)
        check = self.result()["mesh_check"]
        self.assertEqual((check["status"], check["tetrahedra"]), ("ok", 8 * 12))
        self.assertGreater(check["difference"], 0.0)

    def test_a_field_by_a_formula_is_exact_on_the_finer_mesh(self):
        """That of a file is interpolated there: other numbers follow only where the formula is curved."""
        for formula, is_curved in (("0.01*X", False), ("0.01*X^2", True)):
            differences = []
            points = [i / 2 for i in range(9)]
            rows = [f"{0.01 * x ** (2 if is_curved else 1):.17g},0,0" for _ in range(9) for x in points]
            self.write("u.csv", "x,y,z\n" + "\n".join(rows) + "\n")
            for field in (dict(formula=[formula, "0", "0"]), dict(file="u.csv")):
                self.write("beam.toml", BEAM + tables(initial=dict(displacement=field)))
                self.study(*GRID, "--fresh", "--set", "environment.kind=none")
                differences.append(self.result()["mesh_check"]["difference"])
            ratio = differences[0] / differences[1]
            self.assertAlmostEqual(ratio, 1.0, places=6) if not is_curved else self.assertGreater(abs(ratio - 1.0), 1e-3)


if __name__ == "__main__":
    main()
