"""The plots of a study: their width, the size of their text, their labels, styles and titles."""

import os
import re
import shutil
import subprocess
import sys
import unittest

sys.path.insert(0, f"{sys.path[0]}/..")
from support.program import main, words_of
from support.study import PLOT_PROGRAM, PROBES, StudyTest, plot_functions

try:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
except ImportError:
    matplotlib = None


@unittest.skipUnless(matplotlib, "matplotlib is not installed")
class PlotsTest(StudyTest):
    GRID = "--steps 0.0025,0.005,0.01,0.02,0.05,0.1"

    def made(self, *arguments):
        scene = self.write("probes.toml", PROBES)
        self.run_program("study", scene, "--out", "s", "--no-plots", "--quiet", *words_of(arguments))
        return self.path("s")

    def draw(self, *options, code=0, program=PLOT_PROGRAM):
        drawn = subprocess.run([sys.executable, "-IB", program, *options, "--", self.path("s")],
                               capture_output=True, text=True, cwd=self.folder)  # fmt: skip
        self.assertEqual(drawn.returncode, code, drawn.stderr)
        return drawn.stderr

    def svgs(self):
        return {name: self.read("s", name) for name in sorted(os.listdir(self.path("s")))
                if name.endswith(".svg")}  # fmt: skip


class Files(PlotsTest):
    def test_width_size_and_identifiers(self):
        self.made(self.GRID)
        for width, points in ((85, 240.94), (170, 481.89)):
            self.assertEqual(self.draw("--width", str(width)), "")
            plots = self.svgs()
            for name in ("shapes_at_end", "cost_by_phase", "energy_over_time", "probe_tip", "work_precision"):
                self.assertIn(f"{name}.svg", plots)
            self.assertNotIn("quantity_over_parameter.svg", plots)
            seen = set()
            for name, text in plots.items():
                with self.subTest(name, width=width):
                    found = float(re.search(r'<svg[^>]* width="([\d.]+)pt"', text)[1])
                    self.assertAlmostEqual(found, points, delta=0.02)
                    self.assertLess(len(text), 150000)
                    self.assertNotIn("<text", text)  # text is drawn as paths, which need no font
                    self.assertEqual(set(re.findall(r"scale\((0\S*) -", text)), {"0.08"})
                    own = re.findall(r' id="([^"]*)"', text)
                    used = set(re.findall(r'href="#([^"]*)"|url\(#([^)]*)\)', text))
                    self.assertLessEqual({a or b for a, b in used}, set(own))
                    self.assertFalse(seen & set(own))
                    seen |= set(own)
                    self.assertNotIn("<!-- probes -->", text)  # the name of the scene is no title

    def test_title_and_style(self):
        self.made("--integrators verlet,midpoint --steps 0.0025,0.005")
        self.write("own.mplstyle", "font.size: 9 # points\naxes.labelsize: 9\naxes.linewidth: 1.5\n"
                   "backend: module://csv\ntext.usetex: True\nsavefig.format: svg\n"
                   f"axes.prop_cycle: cycler('color', [open('{self.path('ran')}', 'w')] + ['#123456'])\n"
                   "grid.color: 00ff00\nfigure.hooks: os:abort\ntext.latex.preamble: \\input{/etc/passwd}\n"
                   f"axes.formatter.limits: [open('{self.path('ran')}', 'w'), 3]\n")  # fmt: skip
        said = self.draw("--title", "Bending of a beam", "--style", "own.mplstyle", "--width", "85")
        self.assertIn("not used: backend, text.usetex, savefig.format", said)
        self.assertFalse(self.exists("ran"))
        for name, text in self.svgs().items():
            self.assertIn("<!-- Bending of a beam -->", text)
            if name != "shapes_at_end.svg":
                self.assertIn("scale(0.09 -0.09)", text)
        self.write("own.mplstyle", "\nfont.size: large\n")
        self.assertIn("own.mplstyle, line 2", self.draw("--style", "own.mplstyle", code=2))
        self.assertIn("none.mplstyle", self.draw("--style", "none.mplstyle", code=2))

    def test_exit_codes(self):
        self.made("--integrators midpoint --steps 0.01,0.02")
        study = self.path("s", "study.json")
        text = self.read(study)
        # A defect of one plot does not take the others away.
        begin = "def plot_energy_over_time(study, sheet, width):\n"
        program = shutil.copytree(PLOT_PROGRAM, self.path("study_plots"))
        module = os.path.join(program, "over_time.py")
        text_of_module = self.read(module)
        self.assertIn(begin, text_of_module)
        self.write(module, text_of_module.replace(begin, begin + "    raise KeyError('wrong')\n"))
        said = self.draw("--failures", self.path("failed"), code=1, program=program)
        self.assertEqual(self.read("failed"), "energy_over_time")
        self.assertRegex(said, r"^plot_study: energy_over_time: KeyError: 'wrong' \(plot_energy_over_time, line \d+\)\n$")
        self.assertTrue(self.exists("s", "probe_tip.pdf"))
        self.assertFalse(self.exists("s", "energy_over_time.pdf"))
        self.write(study, "{")
        self.assertIn("study.json cannot be read", self.draw(code=2))
        self.write(study, text)
        os.mkdir(self.path("s", "error_over_step.png.part"))
        self.assertIn("cannot be written", self.draw(code=4))
        self.assertFalse(self.exists("s", "error_over_step.svg"))
        self.assertTrue(self.exists("s", "energy_over_time.svg"))


class Labels(PlotsTest):
    def check(self, study, plots, width):
        functions = {**plots.PLOTS, "probe": plots.plot_probe}
        for name, function in functions.items():
            with self.subTest(name, width=width):
                axes = function(study, width=width)
                if axes is None:
                    continue
                figure = axes[0].figure
                renderer = figure.canvas.get_renderer()
                texts = [t for t in figure.findobj(matplotlib.text.Text) if t.get_text() and t.get_visible()]
                figure.canvas.draw()
                self.assertEqual({t.get_fontsize() for t in texts}, {8.0})
                self.assertEqual({t.get_fontweight() for t in texts}, {"normal"})
                for panel in axes:
                    for axis in (panel.xaxis, panel.yaxis):
                        boxes = [t.get_window_extent(renderer) for t in axis.get_ticklabels() if t.get_text()
                                 and t.get_visible()]  # fmt: skip
                        for i, box in enumerate(boxes):
                            self.assertFalse(any(box.overlaps(other) for other in boxes[:i]), name)
                    lines = [l for l in panel.get_lines() if l.get_linestyle() not in ("None", "none")
                             and l.get_linewidth() >= 1]  # fmt: skip
                    self.assertLessEqual(len(lines), 5)
                    for text in (panel.xaxis.label, panel.yaxis.label, panel.title, panel._left_title, *panel.texts):
                        box = text.get_window_extent(renderer)
                        inside = (box.x0, figure.bbox.x1 - box.x1, box.y0, figure.bbox.y1 - box.y1)
                        self.assertTrue(not text.get_text() or min(inside) > -1, (name, text.get_text()))
                    boxes = [t.get_window_extent(renderer) for t in panel.texts]
                    for i, box in enumerate(boxes):
                        self.assertFalse(any(box.padded(-1.5).overlaps(other) for other in boxes[:i]), name)
                plt.close(figure)

    def test_of_all_integrators(self):
        plots = plot_functions()
        study = plots.read_study(self.made(self.GRID))
        for width in (85, 170):
            self.check(study, plots, width)

    def test_of_variants(self):
        plots = plot_functions()
        study = self.made("--integrators verlet,midpoint,backward-euler --steps 0.005,0.01 --vary",
                          "material.density=900,1000,1200", "--vary", "solver.tolerance=1e-8,1e-10")
        for width in (85, 170):
            self.check(plots.read_study(study), plots, width)
        axes = plots.plot_quantity_over_parameter(study)
        self.assertEqual(axes[0].get_xlabel(), "material.density")
        self.assertEqual(axes[0].get_ylabel(), "largest |tip| (mm)")

    def test_of_long_names(self):
        plots = plot_functions()
        name = "displacement_of_the_free_end_of_the_long_cantilever_beam_at_x_4"
        scene = self.write("long.toml", PROBES.replace('"tip"', f'"{name}"'))
        self.run_program(f"study {scene} --out s --no-plots --quiet --error peak.probe.{name} {self.GRID}")
        for width in (85, 170):
            self.check(plots.read_study(self.path("s")), plots, width)
        label = plots.plot_error_over_step(self.path("s"), width=85)[0].get_ylabel()
        self.assertEqual(re.sub(r"\s", "", label), f"relativeerrorofthepeakoftheprobe{name}")

    def test_curves_that_coincide_have_one_label(self):
        plots = plot_functions()
        study = plots.read_study(self.made("--integrators midpoint,energy-momentum --steps 0.0025,0.005,0.01"))
        for run in study["runs"]:
            run["position_error"] = run["step"] ** 2
        panel = plots.plot_error_over_step(study)[0]
        self.assertIn("midpoint,\nenergy-momentum", [t.get_text() for t in panel.texts])

    def test_in_axes_of_a_program(self):
        """They keep the settings of the program."""
        plots = plot_functions()
        folder = self.made("--integrators verlet,midpoint --steps 0.0025,0.005")
        before = dict(matplotlib.rcParams)
        _, axes = plt.subplots()
        self.assertIs(plots.plot_error_over_step(folder, axes)[0], axes)
        self.assertEqual({t.get_fontsize() for t in axes.texts}, {matplotlib.rcParams["font.size"]})
        with self.assertRaisesRegex(ValueError, "2 panels"):
            plots.plot_momentum_drift_over_step(folder, axes)
        plots.plot_work_precision(folder)
        self.assertEqual(dict(matplotlib.rcParams), before)


if __name__ == "__main__":
    main()
