"""Runs that are made again for their times, and the run on a finer mesh."""

import sys

sys.path.insert(0, f"{sys.path[0]}/..")
from support.program import main
from support.study import StudyTest


class Repeats(StudyTest):
    GRID = ["--integrators", "verlet,midpoint", "--steps", "0.0005,0.001", "--frames", "none"]

    def test_cheap_runs_are_repeated_once_and_for_all(self):
        self.study(*self.GRID, "--steps", "midpoint=0.01")
        rows = self.rows()
        asked = [row for row in rows if row["role"] == "run"]
        repeated = [row for row in asked if row["repeats"] == "2"]
        self.assertTrue(repeated)
        for row in repeated:
            self.assertGreaterEqual(float(row["time_scatter"]), 0.0)
            self.assertLess(float(row["processor_seconds"]), 0.5)
        for row in rows:
            if row["repeats"] == "0":
                self.assertEqual(row["time_scatter"], "")
        self.study(*self.GRID, "--steps", "midpoint=0.01")
        times = ("repeats", "time_scatter", "wall_seconds", "processor_seconds", "date")
        self.assertEqual([[row[k] for k in times] for row in self.rows()],
                         [[row[k] for k in times] for row in rows])  # fmt: skip

    def test_none_are_made_if_none_are_asked_for_or_allowed(self):
        for options in (["--repeats", "0"], ["--fresh", "--budget", "0.001s"]):
            self.study(*self.GRID, *options)
            self.assertEqual({row["repeats"] for row in self.rows()}, {"0"})


class MeshCheck(StudyTest):
    GRID = ["--integrators", "midpoint", "--steps", "0.005,0.01,0.05", "--frames", "none", "--repeats", "0"]

    def test_the_run_on_the_finer_mesh_is_made_once(self):
        self.study(*self.GRID, "--mesh-check")
        check = self.result()["mesh_check"]
        self.assertEqual((check["integrator"], check["status"]), ("midpoint", "ok"))
        self.assertGreater(check["difference"], 0.001)
        self.assertLess(check["difference"], 1.0)
        self.assertEqual(check["vertices"], 17 * 5 * 5)
        self.assertTrue(self.exists("s", check["directory"], "final.vtu"))
        self.assertNotIn(check["directory"], [row["directory"] for row in self.result()["runs"]])
        again = self.study(*self.GRID, "--mesh-check")
        self.assertIn("no run was made", again.stderr)
        self.assertEqual(self.result()["mesh_check"], check)
        self.study(*self.GRID)
        self.assertNotIn("mesh_check", self.result())

    def test_a_check_that_is_asked_for_later_is_the_only_run(self):
        self.study(*self.GRID)
        later = self.study(*self.GRID, "--mesh-check")
        self.assertNotIn("no run was made", later.stderr)
        self.assertRegex(later.stderr, "([0-9]+) of \\1 runs were kept, and that on the finer mesh was made")

    def test_with_other_options(self):
        """A mesh check of the first variant, with rules, solvers, jobs, threads and a plan."""
        options = [*self.GRID, "--vary", "material.density=900,1100", "--rule", "midpoint:solver.tolerance=1e-6",
                   "--also-solver", "ceres@0.01", "--mesh-check", "--jobs", "2", "--threads", "2"]  # fmt: skip
        plan = self.study(*options, "--plan")
        self.assertIn("at most, on the finer mesh:", plan.stdout)
        self.assertFalse(self.exists("s"))
        self.study(*options)
        check = self.result()["mesh_check"]
        self.assertEqual(check["status"], "ok")
        self.assertGreater(check["difference"], 0.0)
        self.assertIn("no run was made", self.study(*options).stderr)

    def test_explicit_rules_need_half_the_step(self):
        self.refused_study("--integrators", "verlet", "--reference-integrator", "verlet", "--steps", "0.8x",
                           "--mesh-check", says="--mesh-check")  # fmt: skip


if __name__ == "__main__":
    main()
