"""Variants of the scene in one study."""

import math
import os
import shutil
import sys

sys.path.insert(0, f"{sys.path[0]}/..")
from support.program import BEAM, main
from support.study import PROBES, StudyTest


class Variants(StudyTest):
    GRID = ("--integrators", "verlet,midpoint", "--steps", "2.5e-3,5e-3", "--reference-step",
            "1e-3", "--quiet")  # fmt: skip

    def topics(self, result):
        return {c["topic"]: " ".join(c["sentences"]) for c in result["conclusions"]}

    def test_several_keys_make_all_combinations(self):
        self.study(*self.GRID, "--vary", "material.density=900,1000", "--vary",
                   "solver.kind=newton,ceres")  # fmt: skip
        result = self.result()
        names = [f"density={d}, kind={k}" for d in (900, 1000) for k in ("newton", "ceres")]
        self.assertEqual([v["name"] for v in result["variants"]], names)
        self.assertEqual(result["variants"][1]["values"],
                         {"material.density": "900", "solver.kind": "ceres"})  # fmt: skip
        asked = [r for r in result["runs"] if r["role"] != "reference"]
        self.assertEqual([r["variant"] for r in asked], [name for name in names for _ in range(4)])
        self.assertEqual([r["directory"] for r in result["references"]],
                         [r["directory"] for r in result["runs"] if r["role"] == "reference"])
        # Variants of the solver have the same motion and share a reference.
        self.assertEqual([r["variants"] for r in result["references"]], [names[:2], names[2:]])
        for run in asked:
            scene = self.read_json("s", run["directory"], "summary.json")["scene"]
            values = dict(part.split("=") for part in run["variant"].split(", "))
            self.assertEqual(scene["material"]["density"], float(values["density"]))
            self.assertEqual(scene["solver"]["kind"], values["kind"])
            self.assertEqual(run["role"], "run" if "newton" in run["variant"] else "variant")
            self.assertTrue(run["directory"].startswith(
                run["variant"].replace(", ", "_") + "-"), run["directory"])  # fmt: skip
        self.assertEqual([r["variant"] for r in self.table("s", "study.csv")],
                         [r["variant"] for r in result["runs"]])  # fmt: skip
        page = self.read("s", "study.html")
        for name in names:
            self.assertIn(f">{name}<", page)
        self.assertIn(names[0], self.topics(result)["Variants"])
        self.assertIn("2 references", self.topics(result)["Variants"])

    def test_keys_that_end_in_the_same_word_stay_apart(self):
        self.study("--integrators", "verlet", "--steps", "5e-3", "--quiet", "--set",
                   "probe=[{name='tip',point=[1,1,1],quantity='position'}]", "--vary",
                   "mesh.generate.size.0=4,5", "--vary", "probe.0.point.0=1,2")  # fmt: skip
        self.assertEqual(self.result()["runs"][0]["variant"], "size.0=4, point.0=1")

    def test_each_mesh_has_a_reference_of_its_own(self):
        """Its rows are those of a study of this mesh alone."""
        cells = ("[8,2,2]", "[4,1,1]")
        said = self.study(*self.GRID[:-1], "--all", "--vary", "mesh.generate.cells=" + ",".join(cells))
        self.assertIn("each of the 2 references: midpoint with steps", said.stderr)
        self.assertIn("([4,1,1]) h = ", said.stderr)
        self.assert_parts(said.stdout, ("[4,1,1]: h_crit", "; with a reference of its own"))
        self.assertRegex(said.stdout, r"(?m)^Reference of \[4,1,1\]: midpoint with h = 1e-3 s \(ok\)")
        result = self.result()
        self.assertEqual([m["variants"] for m in result["references"]], [[c] for c in cells])
        self.assertEqual([m["position_difference"] for m in result["references"]], [None, None])
        self.assertIn("2 references", self.topics(result)["Variants"])
        self.assertIn("--error probe.NAME", self.topics(result)["Variants"])
        self.assertEqual([v["name"] for v in result["answer"]["variants"]], list(cells))
        table = self.table("s", "study.csv")
        for number, size in enumerate(cells):
            rows = [r for r in result["runs"] if r["variant"] == size]
            self.assertEqual([r["role"] for r in rows].count("run"), 4)
            errors = [float(r["reference_error"]) for r in table if r["variant"] == size]
            self.study(*self.GRID, "--set", f"mesh.generate.cells={size}")
            alone = self.result()
            self.assertEqual(len(rows), 5)
            self.assertEqual(len(alone["runs"]), 5)
            for row, other in zip(rows, alone["runs"]):
                for key in ("integrator", "step", "position_error", "position_error_rms",
                            "observed_order", "max_relative_energy_drift"):  # fmt: skip
                    self.assertEqual(row[key], other[key], key)
            error = alone["reference"]["estimated_error"]
            self.assertEqual(result["references"][number]["estimated_error"], error)
            for found in errors:
                self.assertAlmostEqual(found / error, 1.0, places=6)

    def test_a_probe_is_compared_between_meshes(self):
        scene = self.write("probes.toml", PROBES)
        study = ["study", scene, "--out", "s", "--no-plots", *self.GRID, "--error", "probe.tip",
                 "--vary", "mesh.element=linear,quadratic"]  # fmt: skip
        self.run_program(*study)
        result = self.result()

        def trace(mesh):
            folder = result["references"][mesh]["directory"]
            return [[float(r[f"tip_{c}"]) for c in "xyz"] for r in self.table("s", folder, "probes.csv")]

        first, second = trace(0), trace(1)
        expected = max(map(math.dist, first, second)) / max(math.hypot(*v) for v in first)
        self.assertGreater(expected, 1e-4)
        found = [m["probe_difference"] for m in result["references"]]
        self.assertIsNone(found[0])
        self.assertAlmostEqual(found[1] / expected, 1.0, places=9)
        self.assertIn("The probe tip differs from that of linear by up to", self.topics(result)["Variants"])
        self.assertEqual(result["answer"]["variants"][1]["difference"], found[1])
        # It is kept, or computed again, when the study goes on.
        self.run_program(*study, "--resume")
        self.assertEqual(self.result()["references"], result["references"])
        os.remove(self.path("s", "quadratic-verlet-0.005", "final.vtu"))
        self.run_program(*study, "--resume")
        after = self.result()
        self.assertEqual(after["references"], result["references"])
        for row, other in zip(after["runs"], result["runs"]):
            self.assertEqual(row["probe_error"], other["probe_error"])

    def test_files_of_meshes_and_tables_as_values(self):
        for name, cells in (("a", "4,1,1"), ("b", "6,1,1")):
            self.run_program(f"mesh generate beam {name}.msh --size 4,1,1 --cells", cells)
        own = BEAM.replace(BEAM.split("[material]")[0], '[mesh]\nfile = "a.msh"\n')
        scene = self.write("files.toml", own)
        study = ["study", scene, "--out", "s", "--no-plots", *self.GRID]
        self.run_program(*study, "--vary", "mesh.file=a.msh,b.msh")
        result = self.result()
        self.assertEqual([v["name"] for v in result["variants"]], ["a.msh", "b.msh"])
        self.assertEqual(len(result["references"]), 2)
        counts = []
        for run in ("a.msh-verlet-0.005", "b.msh-verlet-0.005"):
            counts.append(self.read_json("s", run, "summary.json")["mesh"]["tetrahedra"])
        self.assertEqual(counts[1], counts[0] * 6 // 4)
        shutil.rmtree(self.path("s"))
        values = ['{file = "a.msh"}',
                  '{generate = { kind = "beam", size = [4, 1, 1], cells = [6, 1, 1] }}']  # fmt: skip
        self.run_program(*study, "--vary", "mesh=" + ", ".join(values))
        result = self.result()
        self.assertEqual([v["name"] for v in result["variants"]], values)
        self.assertEqual(len(self.runs()), 10)
        for folder in self.runs():
            self.assertRegex(folder, r"^[\w.=+-]+$")

    def test_initial_fields_belong_to_the_variant(self):
        """They are stored with the mesh, which two variants do not share then."""
        self.study(*self.GRID, "--vary", "initial.velocity={formula=['0','0','X']},"
                   "{formula=['0','0','2*X']}")  # fmt: skip
        runs = {r["variant"][-5:-3]: r for r in self.result()["runs"] if r["integrator"] == "verlet"}
        self.assertEqual(len(runs), 2)
        for run in runs.values():
            self.assertEqual(run["role"], "run")
            self.assertGreater(run["position_error"], 0.0)
        self.assertGreater(self.result()["references"][1]["position_difference"], 0.1)

    def test_each_material_has_the_errors_of_a_study_of_its_own(self):
        """Twice the density is another motion: its differences from the first one are no errors."""
        study = (*self.GRID, "--vary", "material.density=1000,2000")
        self.study(*study)
        result = self.result()
        self.assertEqual({r["role"] for r in result["runs"]}, {"run", "reference"})
        first, second = result["references"]
        self.assertIsNone(first["position_difference"])
        finals = []
        for reference in (first, second):
            finals.append(self.read_json("s", reference["directory"], "summary.json")["scene"]["material"]["density"])
        self.assertEqual(finals, [1000, 2000])
        self.assertGreater(second["position_difference"], 0.01)
        self.assertGreater(second["position_difference_rms"], 0.01)
        self.assertIn("The motion differs from that of 1000 by up to", self.topics(result)["Variants"])
        (sensitivity,) = result["answer"]["sensitivities"]
        self.assertEqual(sensitivity["key"], "material.density")
        self.assertAlmostEqual(sensitivity["value"], second["position_difference"] / math.log(2), places=9)
        rows = [r for r in result["runs"] if r["variant"] == "2000"]
        self.study(*self.GRID, "--set", "material.density=2000")
        alone = self.result()
        self.assertEqual(second["estimated_error"], alone["reference"]["estimated_error"])
        for row, other in zip(rows, alone["runs"]):
            for key in ("position_error", "position_error_rms", "observed_order"):
                self.assertEqual(row[key], other[key], key)
        # The differences do not depend on which runs are kept.
        self.study(*study)
        self.study(*study, "--resume")
        self.assertEqual(self.result()["references"], result["references"])
        os.remove(self.path("s", "2000-verlet-0.005", "final.vtu"))
        self.study(*study, "--resume")
        self.assertEqual(self.result()["references"], result["references"])

    def test_warnings_about_materials_are_told_once(self):
        said = self.study(*self.GRID, "--vary", "material.poissons_ratio=0.3,0.47,0.48,0.49").stderr
        self.assertEqual(said.count("linear tetrahedra lock"), 1)
        self.assertIn("warning: the variant 0.47: a Poisson's ratio of 0.47 is nearly incompressible", said)
        self.assertIn("The same kind of warning applies to 0.48 and 0.49.", said)
        said = self.study(*self.GRID, "--fresh", "--quiet", "--set", "material.poissons_ratio=0.49").stderr
        self.assertIn("warning: a Poisson's ratio of 0.49 is nearly incompressible", said)
        self.assertNotIn("warning", self.study(*self.GRID, "--fresh").stderr)

    def test_a_further_value_keeps_the_runs_of_the_others(self):
        self.study(*self.GRID[:-1], "--vary", "material.density=1000,2000")
        said = self.study(*self.GRID[:-1], "--vary", "material.density=1000,2000,3000", "--resume")
        self.assertIn("10 of 15 runs were kept", said.stderr)

    def test_one_value_makes_one_variant(self):
        self.study(*self.GRID, "--vary", "material.density=900", "--vary", "solver.kind=newton,ceres")
        self.assertEqual([v["name"] for v in self.result()["variants"]],
                         ["density=900, kind=newton", "density=900, kind=ceres"])  # fmt: skip
        self.study(*self.GRID, "--vary", "material.density=900")
        self.assertEqual({r["variant"] for r in self.result()["runs"]}, {"900"})

    def test_two_spellings_of_a_value_are_one(self):
        message = self.refused_study("--vary material.density=900,901,900.0,9e2")
        self.assertIn('the values "900" and "900.0" make the same scene', message)

    def test_messages_name_the_variant(self):
        for arguments, part in (
            (("--vary", "fix.0.mode=exact,penalty"), "--vary fix.0.mode=penalty: "),
            (("--vary", "material.poissons_ratio=0.4,0.6", "--vary", "solver.kind=newton,ceres"),
             "--vary material.poissons_ratio=0.6 --vary solver.kind=newton: "),
            (("--vary", "solver.kind=newton,ceres", "--set", "mesh.volume=nodal"),
             "--vary solver.kind=ceres: "),
        ):  # fmt: skip
            message = self.refused_study(*arguments)
            self.assertIn(part, message)
            self.assertNotIn("--set", message)
        with_file = BEAM.replace(BEAM.split("[material]")[0], '[mesh]\nfile = "a.msh"\n')
        self.run_program("mesh generate beam a.msh --size 4,1,1 --cells 4,1,1")
        self.refused(
            3, "study", self.write("files.toml", with_file), "--vary", "mesh.file=a.msh,b.msh", says="--vary mesh.file=b.msh: ")  # fmt: skip

    def test_variants_have_plots(self):
        scene = self.write("probes.toml", PROBES)
        self.run_program("study", scene, "--out", "s", *self.GRID, "--vary",
                         "mesh.generate.cells=[8,2,2],[4,1,1]")  # fmt: skip
        for plot in ("error_over_step", "work_precision", "probe_tip"):
            self.assertGreater(os.path.getsize(self.path("s", f"{plot}.png")), 3000)
        self.assertIn("midpoint ([4,1,1])", self.read("s", "error_over_step.svg"))

    def test_what_cannot_be_varied(self):
        for text, part in (
            ("material.density=[1,2", "] is missing at the end"),
            ("material.density='1,2", "' is missing at the end"),
            ("material.density", "write KEY=VALUE,VALUE"),
            ("material.density=", "write KEY=VALUE,VALUE"),
            ("material.density=900,", "write KEY=VALUE,VALUE"),
            ("=1,2", "write KEY=VALUE,VALUE"),
            ("material.density=900, 900", "twice"),
            ("output.directory=a,b", "one output directory"),
            ("time.integrator=verlet,midpoint", "sets integrators"),
            ("material.densty=1,2", "did you mean density?"),
            ("material.density=1,-2", "--vary material.density=-2"),
            ("mesh.file=a.msh,b.msh", "generate"),
        ):
            with self.subTest(text):
                self.refused_study("--vary", text, says=part)
        self.refused_study(
            "--vary", "material.density=1,2", "--vary", "material.density=3,4", says="varied twice")  # fmt: skip
        many = ",".join(str(i) for i in range(1, 41))
        self.refused_study(
            "--vary", f"material.density={many}", "--vary", f"solver.max_iterations={many}", says="1000 combinations")  # fmt: skip


if __name__ == "__main__":
    main()
