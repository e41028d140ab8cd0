"""All panels of a plot, and how plots are called."""

import functools
import math
import os

import matplotlib
import matplotlib.pyplot as plt
import numpy as np

from .files import read_study
from .looks import JOURNAL
from .panel import Panel
from .words import plain, wrapped

MM = 1 / 25.4  # in inches
PLOTS = {}  # the functions by the names of their files


class Sheet:
    """The panels of a plot, in the caller's axes or in a new figure of the exact width."""

    def __init__(self, count, axes, height, columns=1, narrow=1, width=170, title=""):
        """Columns are those of a figure of 170 mm, `narrow` those of one of 85 mm; height of a panel in mm."""
        self.is_own = axes is None
        self.columns = min(count, columns if width > 100 else narrow)
        self.height, self.title, self.is_shared = height, title, False
        if self.is_own:
            figure = plt.figure(figsize=(width * MM, height * MM))
            axes = [figure.add_axes([0.2, 0.2, 0.6 / self.columns, 0.6], label=str(i)) for i in range(count)]
        axes = np.ravel(axes)
        if len(axes) != count:
            raise ValueError(f"this plot has {count} panels, and needs as many axes")
        self.figure, self.panels = axes[0].figure, [Panel(a) for a in axes]

    def is_first(self, index):
        """Whether a panel is the first of its row."""
        return index % self.columns == 0 or not self.is_own

    def is_last(self, index):
        """Whether a panel is the last of its column."""
        return index + self.columns >= len(self.panels) or not self.is_own

    def finish(self):
        renderer = self.figure.canvas.get_renderer()
        for _ in range(2):  # labels of ticks depend on the size, and the size on these labels
            for panel in self.panels:
                panel.fit_ticks(renderer)
                panel.fit_labels(renderer, self.room_below(panel))
            if self.is_shared:
                for panel in self.panels:
                    panel.axes.set_yticks(self.panels[0].axes.get_yticks())
                    panel.axes.set_xticks(self.panels[-1].axes.get_xticks())
            if self.is_own:
                self.arrange(renderer)
        for panel in self.panels:
            panel.write_names(renderer)
            panel.draw_minor_ticks()
        return np.array([panel.axes for panel in self.panels])

    def room_below(self, panel):
        """The width for the label below a panel, in pixels: it may be longer than the axis."""
        box, width = panel.axes.bbox, self.figure.bbox.width
        centre = (box.x0 + box.x1) / 2
        return max(box.width, min(2 * centre, 2 * (width - centre), width / self.columns) - 8)

    def arrange(self, renderer):
        """Gives all panels the same size, with the room that their labels and names need."""
        dpi, rows = self.figure.dpi, math.ceil(len(self.panels) / self.columns)
        left, right, below, above = (np.zeros(n) for n in (self.columns, self.columns, rows, rows))
        for i, panel in enumerate(self.panels):
            row, column = divmod(i, self.columns)
            # Curves and what stands at them are within the axes, and names have margins of their own.
            others = [] if panel.axes.axison else None
            inner, outer = panel.axes.bbox, panel.axes.get_tightbbox(renderer, bbox_extra_artists=others)
            left[column] = max(left[column], (inner.x0 - outer.x0) / dpi)
            right[column] = max(right[column], (outer.x1 - inner.x1) / dpi, panel.margin(renderer) / dpi)
            below[row] = max(below[row], (inner.y0 - outer.y0) / dpi)
            above[row] = max(above[row], (outer.y1 - inner.y1) / dpi)
        wide, tall, gap, edge = self.figure.get_figwidth(), self.height * MM, 2.5 * MM, 1.0 * MM
        title = wrapped(plain(self.title, 300), int(wide * 14)) if self.title else ""
        head = edge + (0.135 * (title.count("\n") + 1) + 0.04 if title else 0.0)
        each = (wide - 2 * edge - left.sum() - right.sum() - gap * (self.columns - 1)) / self.columns
        height = head + edge + (below + above + tall).sum() + gap * (rows - 1)
        self.figure.set_size_inches(wide, height)
        for i, panel in enumerate(self.panels):
            row, column = divmod(i, self.columns)
            x = edge + left[: column + 1].sum() + right[:column].sum() + column * (each + gap)
            y = height - head - above[: row + 1].sum() - below[:row].sum() - row * gap - (row + 1) * tall
            panel.axes.set_position([x / wide, y / height, each / wide, tall / height])
        for text in list(self.figure.texts):
            text.remove()
        if title:
            self.figure.text(0.5, 1 - edge / height, title, ha="center", va="top")


def plot(function):
    """Makes a function of a plot take a directory, and use the style of a journal for a figure of its own."""

    @functools.wraps(function)
    def drawn(study, axes=None, *, width=170, title="", **choice):
        study = study if isinstance(study, dict) else read_study(os.fspath(study))
        with matplotlib.rc_context(JOURNAL if axes is None else {}):
            return function(study, functools.partial(Sheet, axes=axes, width=width, title=title), width, **choice)

    name = function.__name__[len("plot_") :]
    if name != "probe":  # there is one for each probe
        PLOTS[name] = drawn
    return drawn
