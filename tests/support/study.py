"""Studies of the beam."""

import importlib
import os
import sys

from support.program import BEAM, BeamTest, words_of
from support.scenes import plane, tables

PROBES = BEAM + tables(probe=[dict(name="tip", select=plane("x", 4.0), quantity="displacement"),
                       dict(name="stress", point=[0.3, 0.9, 0.4], quantity="von_mises", every=2)])


PLOT_PROGRAM = os.path.abspath(os.path.join(os.path.dirname(__file__), "..", "..", "src", "cli", "study_plots"))


def plot_functions(module="plots"):
    """A module of the plots; "plots" has the functions of all of them."""
    folder = os.path.dirname(PLOT_PROGRAM)
    if folder not in sys.path:
        sys.path.append(folder)
    return importlib.import_module(f"study_plots.{module}")


class StudyTest(BeamTest):
    def study(self, *arguments, **keywords):
        return self.run_program("study beam.toml --out s --no-plots", *words_of(arguments), **keywords)

    def refused_study(self, *arguments, says=()):
        message = self.refused(2, "study beam.toml --out s --no-plots", *words_of(arguments), says=says)
        self.assertFalse(self.exists("s"))
        return message

    def rows(self, folder="s"):
        return self.table(folder, "study.csv")

    def result(self):
        return self.read_json("s", "study.json")

    def begin(self, run, *arguments):
        """The study in the background, once this run has begun."""
        process = self.start("study beam.toml --out s", *words_of(arguments))
        self.wait_for_file(process, "s", run, "history.csv")
        return process

    def runs(self):
        """Folders of runs, and whether each has frames."""
        found = {}
        for name in os.listdir(self.path("s")):
            if os.path.isdir(self.path("s", name)):
                for file in ("history.csv", "final.vtu", "summary.json"):
                    self.assertTrue(self.exists("s", name, file), (name, file))
                found[name] = self.exists("s", name, "frames.pvd")
                self.assertEqual(found[name], self.exists("s", name, "frames"))
        return found
