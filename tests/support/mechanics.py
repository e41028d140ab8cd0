"""Runs whose every number is checked."""

import math

from support.program import ProgramTest, own_lines, read_grid, sets


class SceneTest(ProgramTest):
    """Runs of a scene that is written for them."""

    def simulate(self, text, *overrides, out="out", code=0):
        """Runs the scene; its history, whose every number is finite."""
        self.write("scene.toml", text)
        run = f"run scene.toml --quiet --out {out}"
        self.result = self.run_program(run, *sets(*overrides), code=code)
        return self.finite_history(out)

    def finite_history(self, out="out"):
        rows = self.history(out, "history.csv")
        for row in rows:
            for name, value in row.items():
                self.assertTrue(math.isfinite(value), f"{name} of step {row['step']}: {value}")
        return rows

    def messages(self):
        """The lines of stderr, each a message of the program."""
        lines = own_lines(self.result.stderr)
        for line in lines:
            self.assertTrue(line.startswith("tetraction: "), line)
        return lines

    def warnings_of(self):
        return [line for line in self.messages() if "warning" in line]

    def one_warning(self):
        """The only warning of the run."""
        (warning,) = self.warnings_of()
        return warning

    def refused_scene(self, text, *overrides, says=()):
        self.write("scene.toml", text)
        return self.refused(2, "run scene.toml --out refused", *sets(*overrides), says=says)

    def assert_books_close(self, rows):
        largest = max(
            abs(row[name])
            for row in rows
            for name in ("kinetic_energy", "elastic_energy", "environment_energy", "external_work",
                         "dissipated_energy", "constraint_work", "edit_work", "energy_error")
        )  # fmt: skip
        start = rows[0]["total_energy"]
        for row in rows:
            entered = (row["external_work"] - row["dissipated_energy"] + row["constraint_work"]
                       + row["edit_work"] + row["energy_error"])  # fmt: skip
            self.assertAlmostEqual(row["total_energy"] - start, entered, delta=1e-12 * largest)
            parts = row["kinetic_energy"] + row["elastic_energy"] + row["environment_energy"]
            self.assertAlmostEqual(row["total_energy"], parts, delta=1e-12 * largest)
        return largest

    def fields(self, *names):
        """Fields of a VTU file, and the points."""
        return read_grid(self.path(*names))[1:]
