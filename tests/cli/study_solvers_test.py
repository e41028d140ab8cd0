"""Solvers side by side, and the energy error of the plots."""

import sys

sys.path.insert(0, f"{sys.path[0]}/..")
from support.program import main
from support.study import StudyTest, plot_functions


class Plots(StudyTest):
    def test_the_energy_error_is_relative_to_the_scale_of_the_table(self):
        """The work of moving constraints is energy that entered."""
        self.study("--integrators", "midpoint", "--steps", "0.01", "--set", "time.end=0.05",
                   "--set", "fix.0.velocity=[0.0, 0.1, 0.0]")  # fmt: skip
        run = {"directory": self.path("s", "midpoint-0.01")}
        history = plot_functions("files").read_history(run)
        error = plot_functions("over_time").energy_error
        drift = self.read_json("s", "midpoint-0.01", "summary.json")["max_relative_energy_drift"]
        self.assertGreater(drift, 0.0)
        self.assertAlmostEqual(max(error(run, history)) / drift, 1.0, delta=1e-6)
        self.assertIsNone(error({"directory": self.path("elsewhere")}, history))


class Solvers(StudyTest):
    def test_the_table_says_which_solver_a_row_used(self):
        result = self.study("--integrators", "verlet,midpoint,backward-euler", "--steps",
                            "0.005,0.01", "--also-solver", "ceres@0.01", "--all")  # fmt: skip
        rows = self.rows()
        self.assertEqual(
            [(r["integrator"], float(r["step"]), r["solver"]) for r in rows],
            [("verlet", 0.005, ""), ("verlet", 0.01, ""), ("midpoint", 0.005, "newton"),
             ("midpoint", 0.01, "newton"), ("midpoint", 0.01, "ceres"),
             ("backward-euler", 0.005, "newton"), ("backward-euler", 0.01, "newton")],
        )  # fmt: skip
        newton, ceres = rows[3:5]
        self.assertEqual(ceres["role"], "run")
        self.assertAlmostEqual(float(ceres["position_error"]) / float(newton["position_error"]), 1,
                               delta=1e-6)  # fmt: skip
        self.assertEqual(ceres["observed_order"], "")  # it is not the next step
        self.assertRegex(result.stdout, r"(?m)^integrator +solver +step")
        self.assertRegex(result.stdout, r"(?m)^verlet +- +0\.005")
        self.assertRegex(result.stdout, r"(?m)^midpoint +newton +0\.01")
        self.assertRegex(result.stdout, r"(?m)^midpoint +ceres +0\.01")
        runs = self.read_json("s", "study.json")["runs"]
        self.assertEqual([r["compares_solver"] for r in runs], [False] * 4 + [True] + [False] * 2)
        self.assertEqual(runs[4]["directory"], "midpoint-0.01-ceres")
        self.assertEqual(self.read_json("s", "midpoint-0.01-ceres", "summary.json")["solver"]["kind"], "ceres")

    def test_the_other_solver_has_its_own_linear_solver(self):
        self.study("--integrators", "backward-euler", "--steps", "0.01", "--also-solver",
                   "ceres@0.02,ceres@0.01", "--set", "solver.linear=factor")  # fmt: skip
        self.assertEqual([(float(r["step"]), r["solver"]) for r in self.rows() if r["role"] == "run"],
                         [(0.01, "newton"), (0.02, "ceres"), (0.01, "ceres")])  # fmt: skip
        self.study("--integrators", "midpoint", "--steps", "0.01", "--also-solver", "newton@0.01",
                   "--set", "solver.kind=ceres")  # fmt: skip
        self.assertEqual([r["solver"] for r in self.rows() if r["role"] == "run"], ["ceres", "newton"])

    def test_what_cannot_be_compared(self):
        grid = ("--integrators", "midpoint", "--steps", "0.01")
        for text in ("ceres", "ceres@", "@0.01", "ceres@x", "ceres@0.01s"):
            self.assertIn("SOLVER@STEP", self.refused_study(*grid, "--also-solver", text))
        self.assertIn("newton and ceres", self.refused_study(*grid, "--also-solver", "lbfgs@0.01"))
        self.assertIn("already", self.refused_study(*grid, "--also-solver", "newton@0.01"))
        self.assertIn("end time", self.refused_study(*grid, "--also-solver", "ceres@5"))
        self.assertIn("end time", self.refused_study(*grid, "--also-solver", "ceres@-1"))
        self.assertIn("counted", self.refused_study(*grid, "--also-solver", "ceres@1e-300"))
        self.assertIn("counted", self.refused_study(*grid, "--reference-step", "1e-300"))
        self.assertIn("counted", self.refused_study(*grid[:2], "--steps", "0.01,1e-300"))
        self.refused_study(*grid, "--also-solver", "ceres@0.01,ceres@1e-2", says="twice")
        self.refused_study("--integrators", "verlet", "--steps", "0.005",
                                                     "--also-solver", "ceres@0.005", says="minimises")  # fmt: skip
        # Found before the first run.
        nodal = self.refused_study(*grid, "--also-solver", "ceres@0.01", "--set", "mesh.volume=nodal")
        self.assertIn("Ceres cannot take mesh.volume", nodal)


if __name__ == "__main__":
    main()
