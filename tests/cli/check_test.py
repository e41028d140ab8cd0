"""What `tetraction check` says."""

import itertools
import math
import sys

sys.path.insert(0, f"{sys.path[0]}/..")
from support.program import BEAM, BeamTest, main
from support.scenes import plane, tables


class Check(BeamTest):
    def test_derivatives_are_exact(self):
        report = self.json_of("check beam.toml")
        self.assertEqual(len(report["derivatives"]), 6)
        nodal = self.json_of("check beam.toml --set", 'mesh.volume="nodal"')
        self.assertEqual(nodal["derivatives"][-1]["material"], "nodal volumes")
        for row in report["derivatives"] + nodal["derivatives"]:
            self.assertLess(row["force_error"], 1e-7)
            self.assertLess(row["stiffness_error"], 1e-7)
        self.assertAlmostEqual(report["mass"], 4000.0, delta=1e-9)
        mu, lam = 1e6 / 2.8, 1e6 * 0.4 / (1.4 * 0.2)
        self.assertAlmostEqual(report["wave_speed"], math.sqrt((lam + 2 * mu) / 1000), places=9)
        text = self.run_program("check beam.toml").stdout
        self.assertIn("h_crit", text)

    def test_only_laws_of_the_scene_make_it_fail(self):
        """At this stretch, the limit of gent is exceeded, a law that the scene does not use."""
        self.write("stretched.toml", tables(
            mesh=dict(generate=dict(kind="cube", cells=1)), material=dict(model="stvk", mu=4e5, **{"lambda": 1e6}),
            initial=dict(stretch=[10.0, 0.316, 0.316])))  # fmt: skip
        rows = {row["material"]: row for row in self.json_of("check stretched.toml")["derivatives"]}
        self.assertEqual(rows["gent"], {"material": "gent", "defined": False})
        self.assertTrue(rows["stvk"]["ok"])
        self.assertIn("not defined there", self.run_program("check stretched.toml").stdout)

    def test_derivatives_near_the_limit_of_a_law(self):
        """Differences are taken over a small part of the distance to the limit. The last stretch has
        1 - (I1bar - 3)/jm = 0.01."""
        for jm, initial in ((1e-3, {}), (1.0, dict(stretch=[1.6713, 0.77352, 0.77352]))):
            self.write("gent.toml", tables(
                mesh=dict(generate=dict(kind="cube", cells=1)), material=dict(model="gent", mu=4e5, jm=jm, kappa=1e6),
                initial=initial))  # fmt: skip
            row = self.json_of("check gent.toml")["derivatives"][0]
            self.assertLess(row["force_error"], 1e-7, jm)
            self.assertLess(row["stiffness_error"], 1e-7, jm)


def cubes_msh(places, groups=()):
    """Unit cubes of six tetrahedra each, which share the vertices in which they touch, as an .msh file.

    `groups`: names of physical volumes and the places of their cubes; other cubes have none.
    """
    ids, tetrahedra = {}, []
    for place in places:
        tag = next((i + 1 for i, (_, own) in enumerate(groups) if place in own), 0)
        for axes in itertools.permutations(range(3)):
            is_odd = sum(a > b for a, b in itertools.combinations(axes, 2)) % 2 == 1
            corner = list(place)
            corners = [ids.setdefault(tuple(corner), len(ids) + 1)]
            for axis in axes:
                corner[axis] += 1
                corners.append(ids.setdefault(tuple(corner), len(ids) + 1))
            if is_odd:
                corners[2:] = reversed(corners[2:])
            tetrahedra.append((tag, corners))
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat"]
    if groups:
        lines += ["$PhysicalNames", str(len(groups))]
        lines += [f'3 {i + 1} "{name}"' for i, (name, _) in enumerate(groups)] + ["$EndPhysicalNames"]
    lines += ["$Nodes", str(len(ids))]
    lines += [f"{i} {x} {y} {z}" for (x, y, z), i in ids.items()] + ["$EndNodes", "$Elements"]
    lines.append(str(len(tetrahedra)))
    for i, (tag, corners) in enumerate(tetrahedra):
        lines.append(f"{i + 1} 4 2 {tag} {tag} " + " ".join(map(str, corners)))
    return "\n".join([*lines, "$EndElements", ""])


CUBES = tables(mesh=dict(file="cubes.msh"), material=dict(youngs_modulus=1.0e6, poissons_ratio=0.3))
CLAMP = tables(fix=[dict(select={"box": {"min": [0, 0, 0], "max": [0, 1, 1]}})])


class CheckFacts(BeamTest):
    """What `check` says of loads, supports, free motions and inertia."""

    def check(self, scene, *arguments):
        return self.json_of(f"check {scene}", *arguments)

    def line(self, text, key):
        lines = [line for line in text.splitlines() if line.startswith(f"  {key}: ")]
        self.assertEqual(len(lines), 1, text)
        return lines[0]

    def test_loads_and_supports_have_a_line_each(self):
        scene = self.write("beam.toml", BEAM + tables(traction=[dict(select=plane("x", 4.0),
                                                        vector=[0.0, -3.0, 0.0])],
                                                      pressure=[dict(select={"surface": True},
                                                        value=1000.0, amplitude="later")],
                                                      amplitude=[dict(name="later",
                                                        points=[[0.5, 0.0], [1.0, 1.0]])],
                                                      fix=[dict(select={"nearest": [4.0, 1.0, 1.0]},
                                                        mode="penalty", penalty=50.0)],
                                                      constraint=[dict(kind="distance",
                                                        vertices=[0, 8])]))  # fmt: skip
        text = self.run_program(f"check {scene}").stdout
        self.assertEqual(
            self.line(text, "traction.0"),
            "  traction.0: 8 triangles, 1 m2, open, its rim has 8 edges, 4 m long, free; resultant "
            "(0, -3, 0) N, moment (1.5, 0, -12) N m",
        )
        self.assertEqual(
            self.line(text, "pressure.0").split("; ")[:2],
            ["  pressure.0: 1000 Pa on 144 triangles, 18 m2, closed around 4 m3",
             "resultant (0, 0, 0) N, moment (0, 0, 0) N m"],
        )  # fmt: skip
        self.assertIn('; factor 0 at t = 0 (amplitude "later")', self.line(text, "pressure.0"))
        self.assertIn("gravity; resultant (0, -39240, 0) N", self.line(text, "environment"))
        self.assertEqual(self.line(text, "fix.0"),
                         "  fix.0: 9 vertices (8 triangles, 1 m2) held in x, y, z")  # fmt: skip
        self.assertIn("springs of 100 N/m", self.line(text, "fix.1"))
        self.assertIn("vertices 0 and 8 stay 4 m apart", self.line(text, "constraint.0"))
        report = self.check(scene)
        traction, pressure = report["loads"]
        self.assertEqual(traction["rim"],
                         {"edges": 8, "length": 4.0, "held_edges": 0, "partly_held_edges": 0})  # fmt: skip
        self.assertEqual((pressure["closed"], pressure["factor"]), (True, 0.0))
        self.assertAlmostEqual(pressure["enclosed_volume"], 4.0, delta=1e-12)
        self.assertEqual([s["kind"] for s in report["supports"]], ["fix", "springs", "distance"])
        self.assertEqual(report["free_motions"], [])
        self.assertAlmostEqual(report["environment"]["resultant"][1], -39240, delta=1e-8)

    def test_free_motions_are_named(self):
        free = BEAM.replace('[[fix]]\nselect = { plane = { axis = "x", at = 0.0 } }', "")
        scene = self.write("free.toml", free)
        text = self.run_program(f"check {scene}").stdout
        self.assertIn("\nsupports: none\n", text)
        self.assertIn("  free motions: move along x, move along y, move along z, rotate about x, "
                      "rotate about y, rotate about z\n", text)  # fmt: skip
        guided = self.write("guided.toml", free + tables(fix=[dict(select=plane("y", 0.0),
                                                           components="y")]))  # fmt: skip
        self.assertEqual(self.check(guided)["free_motions"],
                         ["move along x", "move along z",
                          "rotate about the line through (2, 0.5, 0.5) along y"])  # fmt: skip

    def test_a_pull_is_a_load(self):
        """The spring acts on the mean of its vertices with the force k (target - mean)."""
        beam = dict(kind="beam", size=[0.4, 0.1, 0.1], cells=[4, 1, 1])
        scene = self.write("pulled.toml", tables(
            mesh=dict(generate=beam), material=dict(youngs_modulus=1e6, poissons_ratio=0.3),
            pull=dict(vertices=[0], stiffness=50.0, target=[0.1, -0.2, 0.0])))  # fmt: skip
        pull = self.check(scene)["pull"]
        for value, exact in zip(pull["resultant"] + pull["moment"], (5.0, -10.0, 0.0, 0.0, 0.0, 0.0)):
            self.assertAlmostEqual(value, exact, delta=1e-12)
        text = self.run_program("check pulled.toml").stdout
        self.assertIn("\n  pull: resultant (5, -10, 0) N", text)
        self.assertNotIn("pull", self.check(self.write("beam.toml", BEAM)))

    def test_a_load_on_held_vertices_is_told_of(self):
        scene = self.write("beam.toml", BEAM + tables(traction=[dict(select=plane("x", 0.0),
                                                        vector=[0.0, -3.0, 0.0])]))  # fmt: skip
        result = self.run_program(f"check {scene}")
        self.assertIn("traction.0: all of its vertices are held", result.stderr)

    def test_a_pressure_on_a_group_of_tetrahedra(self):
        groups = [("core", [(1, 0, 0)]), ("rest", [(0, 0, 0), (2, 0, 0)])]
        self.write("cubes.msh", cubes_msh([(0, 0, 0), (1, 0, 0), (2, 0, 0)], groups))
        scene = self.write("scene.toml", CUBES + CLAMP +
                           '[[pressure]]\nselect = { group = "core" }\nvalue = 1.0\n')  # fmt: skip
        said = ('the group "core" consists of tetrahedra. The pressure acts on the 8 triangles of the '
                "body's boundary whose corners are all in the group, and not on the 4 faces of the "
                "group inside the body.")  # fmt: skip
        for command in (["check", scene], ["run", scene, "--out", "r"], ["static", scene, "--out", "s"]):
            with self.subTest(command[0]):
                self.assertEqual(self.run_program(*command).stderr.count(said), 1)
        # Of a group that is the whole body there is nothing to say.
        self.write("cubes.msh", cubes_msh([(0, 0, 0)], [("core", [(0, 0, 0)])]))
        self.assertNotIn("consists of", self.run_program(f"check {scene}").stderr)
        # A group without a triangle of the boundary is refused.
        places = list(itertools.product(range(3), repeat=3))
        self.write("cubes.msh", cubes_msh(places, [("core", [(1, 1, 1)])]))
        self.assertIn("selects no triangle", self.refused(2, f"check {scene}"))

    def test_mechanisms(self):
        self.write("cubes.msh", cubes_msh([(0, 0, 0), (1, 1, 0)]))
        scene = self.write("scene.toml", CUBES + CLAMP)
        place = "touch only in the vertices 3, 4 on the line through (1, 1, 0) along z"
        result = self.run_program(f"check {scene}")
        self.assertIn("the body is a mechanism", result.stderr)
        self.assertIn(place, result.stderr)
        self.assertIn("  mechanism: pieces that share no face", result.stdout)
        self.assertIn(", 1 mechanism mode", result.stdout)
        report = self.check(scene)
        self.assertEqual((report["parts"], report["pieces"]), (1, 2))
        self.assertEqual(report["mechanisms"],
                         [{"vertex": 1, "pieces": 2, "motions": 1, "free_motions": 1,
                           "joints": [3, 4]}])  # fmt: skip
        self.refused(2, f"static {scene} --out s", says=("turn in itself as a mechanism", place))
        result = self.run_program(f"modes {scene} -n 3 --out m")
        self.assertIn("the body is a mechanism", result.stderr)
        rows = self.table("m", "modes.csv")
        self.assertEqual([row["kind"] for row in rows], ["mechanism", "elastic", "elastic"])
        self.assertEqual(float(rows[0]["frequency"]), 0.0)
        # Both cubes are held: it is told of, and nothing warns.
        held = self.write("held.toml", CUBES + CLAMP + CLAMP.replace(
            "min = [0, 0, 0], max = [0, 1, 1]", "min = [2, 2, 0], max = [2, 2, 1]"))  # fmt: skip
        result = self.run_program(f"check {held}")
        self.assertNotIn("mechanism", result.stderr)
        self.assertIn("; the supports hold them", result.stdout)
        self.assertNotIn("mechanism", self.run_program(f"static {held} --out h").stderr)

    def test_inertia(self):
        report = self.check(self.write("beam.toml", BEAM))
        for value, exact in zip(report["inertia"]["moments"], (4000 * 2 / 12, *2 * [4000 * 17 / 12])):
            self.assertAlmostEqual(value, exact, delta=1e-8)
        for product in report["inertia"]["products"]:
            self.assertAlmostEqual(product, 0.0, delta=1e-8)
        self.assertGreater(max(map(abs, report["lumped_inertia"]["products"])), 1.0)
        text = self.run_program("check beam.toml").stdout
        self.assertIn("lumping adds products of inertia", text)

    def test_a_histogram_of_equal_elements(self):
        self.run_program("mesh generate cube cube.vtu --cells 2")
        text = self.run_program("mesh info cube.vtu").stdout
        self.assertRegex(text, r"\n  scaled Jacobian: 0\.\d+ in every element\n")
        self.assertNotIn(" – ", text)
        # Elements that differ a little: each row of the histogram has bounds of its own.
        self.run_program("mesh generate cube cube.msh --cells 2")
        moved = self.read("cube.msh").replace("0.5 0.5 0.5", "0.5 0.5 0.5001")
        self.write("moved.msh", moved)
        text = self.run_program("mesh info moved.msh").stdout
        rows = [line.split()[0] for line in text.splitlines() if " – " in line]
        self.assertEqual(len(rows), 10)
        self.assertEqual(len(set(rows)), 10, text)


if __name__ == "__main__":
    main()
