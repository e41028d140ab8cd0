"""One panel of a plot: its curves with their names beside them, and its ticks."""

import math
import os
import re

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import to_hex, to_rgb
from matplotlib.markers import TICKDOWN, TICKLEFT
from matplotlib.ticker import LogLocator, MaxNLocator, NullFormatter, NullLocator

from .looks import GREY, INK, PALE
from .words import power_of_ten, wrapped


def samples(line):
    """Points on a line of matplotlib in pixels, close together."""
    points = line.get_transform().transform(line.get_xydata())
    if len(points) > 1 and line.get_linestyle() not in ("None", "none"):
        steps = np.ceil(np.abs(np.diff(points, axis=0)).max(axis=1) / 3).clip(1, 300)
        at = np.concatenate([i + np.arange(n) / n for i, n in enumerate(steps)] + [[len(points) - 1]])
        points = np.column_stack([np.interp(at, np.arange(len(points)), p) for p in points.T])
    box = line.axes.bbox.padded(1.5)
    (x0, y0), (x1, y1) = box.min, box.max
    x, y = points.T
    return points[(x >= x0) & (x <= x1) & (y >= y0) & (y <= y1)]


def coincide(p, q):
    """Whether a reader cannot tell these points of two curves apart."""
    if not len(p) or not len(q):
        return False
    gaps = np.hypot(*(p[:, None] - q[None]).transpose(2, 0, 1))
    return max(np.percentile(gaps.min(axis=i), 90) for i in (0, 1)) < 1.8


def readable(color):
    """Dark enough for a text on white."""
    rgb = np.array(to_rgb(color))
    while rgb @ (0.2126, 0.7152, 0.0722) > 0.36:
        rgb *= 0.93
    return to_hex(rgb)


def separated(wanted, sizes, low, high):
    """Centres in ascending order as near to the wanted ones as intervals of these sizes allow."""
    centres = np.array(wanted, dtype=float)
    for _ in range(400):
        for i in range(len(centres) - 1):
            lack = (sizes[i] + sizes[i + 1]) / 2 - (centres[i + 1] - centres[i])
            if lack > 0:
                centres[i] -= lack / 2
                centres[i + 1] += lack / 2
        if len(centres):
            centres[0] = max(centres[0], low + sizes[0] / 2)
            centres[-1] = min(centres[-1], high - sizes[-1] / 2)
    return centres


def ticks_to_try(axis):
    """[(values, texts)] for an axis, from many to few."""
    low, high = sorted(axis.get_view_interval())

    def texts(ticks):
        if axis.get_scale() == "linear" or all(1e-3 < t < 2e4 for t in ticks):
            return [f"{0.0 if abs(t) < 1e-9 * high else t:.6g}".replace("-", "−") for t in ticks]
        parts = [(t / 10 ** math.floor(math.log10(t) + 1e-9), math.floor(math.log10(t) + 1e-9))
                 for t in ticks]  # fmt: skip
        return [(f"{m:.0f}·" if round(m) != 1 else "") + power_of_ten(n) for m, n in parts]

    if axis.get_scale() == "linear":
        found = [MaxNLocator(n, steps=[1, 2, 5, 10]).tick_values(low, high) for n in (6, 5, 4, 3, 2, 1)]
    else:
        first, last = math.floor(math.log10(low)), math.ceil(math.log10(high))
        decades = math.floor(math.log10(high)) - math.ceil(math.log10(low)) + 1
        subs = [(1, 2, 5), (1, 3)] if decades < 2 else []
        found = [np.array([s * 10.0**n for n in range(first, last + 1) for s in sub]) for sub in subs]
        found += [10.0 ** np.arange(stride * math.ceil(first / stride), last + 1, stride)
                  for stride in (1, 2, 3, 4, 5, 10)]  # fmt: skip
    for ticks in found:
        room = 1e-9 * (high - low) if axis.get_scale() == "linear" else 1e-9 * low
        ticks = [t for t in ticks if low - room <= t <= high + room]
        if 0 < len(ticks) <= 7:
            yield ticks, texts(ticks)


class Panel:
    """Axes with curves, whose names are written beside them when the axes have their place."""

    def __init__(self, axes):
        self.axes, self.curves, self.slopes, self.keeps_ticks = axes, [], [], False
        self.extents, self.decades, self.labels = {}, {}, {}

    def line(self, name, x, y, note=None, **looks):
        """A curve with a name at its end, or beside it if it ends far from the right edge."""
        (line,) = self.axes.plot(x, y, **looks)
        self.curves.append((wrapped(name, 24), line))
        self.annotate(line, note)

    def annotate(self, artist, note):
        """Gives an artist an identifier, under which save() finds what study.html shows of it: `rule`, which
        the page switches, `runs` and `texts` of its markers, or `run`, `text` and `units` of a curve over time."""
        if note:
            notes = self.axes.figure.__dict__.setdefault("notes", {})
            name = os.path.basename(note["run"]["directory"]) if "run" in note else note["rule"]
            artist.set_gid(re.sub(r"[^\w.-]", "_", f"{name}-{len(notes)}", flags=re.ASCII))
            notes[artist.get_gid()] = {**note, "axes": self.axes}

    def note_of(self, group):
        """Of the name of some curves that are of one rule, and of one run if they are."""
        notes = [getattr(self.axes.figure, "notes", {}).get(line.get_gid(), {}) for _, line, _ in group]
        if len({n.get("rule", "") for n in notes}) != 1 or "rule" not in notes[0]:
            return None
        run = {"run": notes[0]["run"]} if len(notes) == 1 and "run" in notes[0] else {}
        return {"rule": notes[0]["rule"], **run}

    def scale(self, which, values, top=0.0, least=0.7):
        """Makes an axis logarithmic, with room around the values and, in parts of it, at the top."""
        low, high = min(values), max(values)
        span = math.log10(high / low)
        room = max(0.05 * span, 0.5 * (least - span), 0.05)
        getattr(self.axes, f"set_{which}scale")("log")
        upper = room + top / (1 - top) * (span + 2 * room)
        getattr(self.axes, f"set_{which}lim")(low / 10**room, high * 10**upper)
        axis = self.axes.xaxis if which == "x" else self.axes.yaxis
        self.decades[axis] = span + room + upper
        axis.set_minor_locator(NullLocator())
        axis.set_minor_formatter(NullFormatter())

    def fit_ticks(self, renderer):
        """As many tick labels as fit without touching each other."""
        if self.keeps_ticks or not self.axes.axison:
            return
        box = self.axes.bbox
        for axis, i, length, gap in ((self.axes.xaxis, 0, box.width, 5), (self.axes.yaxis, 1, box.height, 2)):
            of = axis.get_transform().transform
            low, high = of(np.array(axis.get_view_interval()))
            for ticks, texts in ticks_to_try(axis):
                at = (of(np.array(ticks, dtype=float)) - low) / (high - low) * length
                size = matplotlib.rcParams["xy"[i] + "tick.labelsize"]
                sizes = np.array([self.extent(text, renderer, size)[i] for text in texts])
                if (np.abs(np.diff(at)) >= (sizes[1:] + sizes[:-1]) / 2 + gap).all():
                    break
            axis.set_ticks(ticks, texts)

    def fit_labels(self, renderer, below):
        """Breaks the labels of axes that are longer than the place for them."""
        for axis, room in ((self.axes.xaxis, below), (self.axes.yaxis, self.axes.bbox.height)):
            text = self.labels.setdefault(axis, axis.label.get_text())
            size = matplotlib.rcParams["axes.labelsize"]
            length = self.extent(text, renderer, size)[0]
            axis.label.set_text(wrapped(text, int(len(text) * room / length)) if length > room else text)

    def extent(self, text, renderer, size=None):
        """Width and height of a text in pixels."""
        if (text, size) not in self.extents:
            artist = self.axes.text(0, 0, text, transform=None, linespacing=1.0, fontsize=size)
            box = artist.get_window_extent(renderer)
            artist.remove()
            self.extents[text, size] = box.width, box.height
        return self.extents[text, size]

    def draw_minor_ticks(self):
        """As markers, which matplotlib draws much faster than ticks."""
        for axis, decades in self.decades.items():
            if decades >= 6:
                continue
            low, high = axis.get_view_interval()
            ticks = LogLocator(subs=range(2, 10), numticks=99).tick_values(low, high)
            ticks, which = ticks[(ticks > low) & (ticks < high)], axis.axis_name
            places, zeros = ((ticks, 0 * ticks) if which == "x" else (0 * ticks, ticks))
            style = {key: matplotlib.rcParams[f"{which}tick.{key}"] for key in ("minor.size", "minor.width", "color")}
            self.axes.plot(places, zeros, ls="none", marker=TICKDOWN if which == "x" else TICKLEFT, clip_on=False,
                           ms=style["minor.size"], mew=style["minor.width"], color=style["color"],
                           transform=getattr(self.axes, f"get_{which}axis_transform")())  # fmt: skip

    def ends_at_right(self, line):
        points = samples(line)
        box = self.axes.bbox
        return len(points) > 0 and points[-1, 0] > box.x0 + 0.86 * box.width

    def margin(self, renderer):
        """The width of the names at the right edge, in pixels."""
        widths = [self.extent(name, renderer)[0] for name, line in self.curves
                  if name and self.ends_at_right(line)]  # fmt: skip
        return max(widths, default=-10) + 10

    def write_names(self, renderer):
        """Curves that coincide are named together, with a line of text for each."""
        named = [(name, line, samples(line)) for name, line in self.curves]
        taken = [points for *_, points in named if len(points)]
        groups = []
        for entry in named:
            if entry[0] and len(entry[2]):
                group = next((g for g in groups if any(coincide(entry[2], e[2]) for e in g)), None)
                groups.append([entry]) if group is None else group.append(entry)
        boxes, right, inner = [], [], []
        for group in groups:
            names = list(dict.fromkeys(name for name, *_ in group))
            text, color = ",\n".join(names), readable(group[0][1].get_color()) if len(names) == 1 else INK
            entry = (text, color, group[0][2], self.extent(text, renderer), self.note_of(group))
            (right if self.ends_at_right(group[0][1]) else inner).append(entry)
        right.sort(key=lambda entry: entry[2][-1, 1])
        box = self.axes.bbox
        x = max([entry[2][-1, 0] for entry in right], default=0.0) + 6
        centres = separated([e[2][-1, 1] for e in right], [e[3][1] + 1.5 for e in right],
                            box.y0 - 9, box.y1 + 3)  # fmt: skip
        for (text, color, points, (width, height), note), y in zip(right, centres):
            if abs(y - points[-1, 1]) > 4 or x - points[-1, 0] > 12:
                self.annotate(self.leader(points[-1] + (2, 0), (x - 1, y), color), note)
            self.annotate(self.put(text, x, y - height / 2, color), note)
            boxes.append((x, y - height / 2, width, height))
        for text, color, points, size, note in sorted(inner, key=lambda entry: len(entry[2])):
            x, y, far = self.free_place(points, size, taken, boxes)
            if far:
                near = points[np.hypot(*(points - (x + size[0] / 2, y + size[1] / 2)).T).argmin()]
                end = (min(max(near[0], x), x + size[0]), min(max(near[1], y), y + size[1]))
                self.annotate(self.leader(near, end, color), note)
            self.annotate(self.put(text, x, y, color), note)
            boxes.append((x, y, *size))
        if self.slopes:
            self.draw_slopes(np.vstack(taken), boxes)

    def put(self, text, x, y, color, **more):
        """A text whose lower left corner is at this pixel."""
        place = self.axes.transAxes.inverted().transform((x, y))
        return self.axes.text(*place, text, transform=self.axes.transAxes, color=color, va="bottom", linespacing=1.0,
                              zorder=6, **more)  # fmt: skip

    def leader(self, begin, end, color):
        points = self.axes.transAxes.inverted().transform([begin, end])
        return self.axes.plot(*points.T, transform=self.axes.transAxes, color=color, lw=0.5, clip_on=False,
                              marker="", ls="-")[0]  # fmt: skip

    def free_place(self, own, size, taken, boxes):
        """Lower left corner of a text beside its curve, which covers no curve and no other text; and
        whether it is so far away that it needs a line to its curve."""
        (width, height), box = size, self.axes.bbox
        offsets = [(4, -height / 2), (-width - 4, -height / 2), (-width / 2, 4), (-width / 2, -height - 4),
                   (3, 3), (-width - 3, 3), (3, -height - 3), (-width - 3, -height - 3)]  # fmt: skip
        anchors = own[:: -max(1, len(own) // 60)]
        beside = (anchors[:, None] + np.array(offsets)[None]).reshape(-1, 2)
        rank = np.repeat(np.arange(len(anchors)), len(offsets)) + np.tile(np.arange(len(offsets)), len(anchors))
        grid = np.stack(np.meshgrid(np.linspace(box.x0 + 2, box.x1 - width, 40),
                                    np.linspace(box.y0 + 2, box.y1 - height, 30)), axis=-1).reshape(-1, 2)
        foreign = np.vstack([[(-1e3, -1e3)], *(p for p in taken if p is not own)])
        for corners, score in ((beside, 1.0 * rank), (grid, None)):
            def distance(points):
                gap = np.maximum(np.maximum(corners[:, None] - points[None],
                                            points[None] - corners[:, None] - (width, height)), 0)
                return np.hypot(gap[..., 0], gap[..., 1]).min(axis=1)

            mine, others = distance(own), distance(foreign)
            if score is None:
                score = mine
            good = (mine > 1.5) & (others > 2) & (corners >= (box.x0 + 1, box.y0 + 1)).all(axis=1)
            good &= (corners[:, 0] + width <= box.x1 + 4) & (corners[:, 1] + height <= box.y1 + 1)
            for x, y, w, h in boxes:
                good &= ((corners[:, 0] > x + w + 2) | (corners[:, 0] + width < x - 2)
                         | (corners[:, 1] > y + h) | (corners[:, 1] + height < y))  # fmt: skip
            if good.any():
                # Nearer to another curve than to its own, a name would be misread.
                score = np.where(good, score + 4 * np.maximum(0, 9 - others), np.inf)
                best = score.argmin()
                return (*corners[best], mine[best] > 10)
        return (*np.clip(own[-1] + (4, 4), box.min, box.max - size), False)

    def draw_slopes(self, taken, boxes):
        """Triangles of slope 1 and 2 below a part of a curve where at least three runs show the slope."""
        axes, box = self.axes, self.axes.bbox
        (x0, x1), (y0, y1) = axes.get_xlim(), axes.get_ylim()
        # Pixels of a decade: what has slope 1 in the axes has the slope `unit` in pixels.
        unit = (box.height / math.log10(y1 / y0)) / (box.width / math.log10(x1 / x0))
        corners = [(x + w * i / 9, y + h * j / 4) for x, y, w, h in boxes for i in range(10) for j in range(5)]
        taken = np.vstack([taken, *([corners] if corners else [])])
        for slope in (1, 2):
            width = min(28, 28 / (slope * unit))
            height = slope * unit * width
            for part in (p for line in self.slopes for p in straight_parts(line, slope)):
                points = axes.transData.transform(part)
                place = None
                for t in np.linspace(0.5, 0, 12):
                    for at, gap in ((at, gap) for gap in (7, 10, 14, 20) for at in (0.5 - t, 0.5 + t)):
                        x, y = points[0] + at * (points[-1] - points[0]) + np.array(
                            [slope * unit, -1.0]) / math.hypot(1, slope * unit) * gap  # fmt: skip
                        px, py = taken.T
                        inside = ((px > x - 3) & (px < x + width + 12) & (py > y - 15) & (py < y + height + 3)
                                  & (py - y < slope * unit * (px - x) + 3))  # fmt: skip
                        fits = x + width + 10 < box.x1 and y - 14 > box.y0 and y + height < box.y1 and x > box.x0
                        if fits and not inside.any():
                            place = place or (x, y)
                if place is None:
                    continue
                x, y = place
                shape = np.array([(x, y), (x + width, y), (x + width, y + height)])
                axes.add_patch(plt.Polygon(axes.transAxes.inverted().transform(shape), closed=True, fc=PALE,
                                           ec=GREY, lw=0.6, transform=axes.transAxes, zorder=3,
                                           label=f"slope {slope}"))  # fmt: skip
                self.put("1", x + width / 2, y - 13, GREY, ha="center")
                self.put(str(slope), x + width + 3, y + height / 2 - 6, GREY)
                grid = [(x + width * i / 5, y + height * j / 5) for i in range(-2, 8) for j in range(-3, 6)]
                taken = np.vstack([taken, grid])
                break


def straight_parts(line, slope, tolerance=0.15):
    """The longest parts of at least three points of a line on logarithmic axes that have this slope."""
    parts, part = [], []
    for p, q in zip(line, line[1:]):
        own = (math.log(q[1] / p[1]) / math.log(q[0] / p[0])) if q[0] > p[0] else math.inf
        if abs(own - slope) <= tolerance:
            part = (part or [p]) + [q]
            continue
        parts.append(part)
        part = []
    return [part for part in [*parts, part] if len(part) >= 3]
