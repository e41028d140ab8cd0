"""The curves of a study: which there are, their names, colours and lines."""

import math

from .files import RULES, ended_well
from .words import plain, si, wrapped

MOST_LINES = 5  # of a panel
# Okabe and Ito's colours, which colour-blind readers tell apart. Lines and markers differ as well, for
# print in grey. Markers are hollow, so that both of two curves that coincide can be seen.
COLOURS = ["#D55E00", "#E69F00", "#0072B2", "#009E73", "#CC79A7", "#56B4E9", "#000000"]
MARKERS = "os^DvPX"
DASHED, DASH_DOT, DOTTED = (0, (4, 1.6)), (0, (4, 1.4, 1, 1.4)), (0, (1, 1.3))
LINES = ["-", DASHED, DASH_DOT, DOTTED, (0, (7, 1.5)), (0, (6, 1, 1, 1, 1, 1)), "-"]
RULE_LINES = ["-", DASHED, "-", DASH_DOT, DASHED, DOTTED, DASH_DOT]
GREY, PALE, INK = "#5a5a5a", "#e9e9e9", "#1a1a1a"
JOURNAL = {
    "font.size": 8.0, "axes.titlesize": "medium", "axes.labelsize": "medium",
    "xtick.labelsize": "medium", "ytick.labelsize": "medium",
    "axes.titlepad": 3.0, "axes.titley": 1.0, "axes.labelpad": 2.0, "axes.linewidth": 0.6, "lines.linewidth": 1.0,
    "axes.spines.top": False, "axes.spines.right": False, "axes.axisbelow": True,
    "xtick.major.width": 0.6, "ytick.major.width": 0.6, "xtick.minor.size": 1.5,
    "ytick.minor.size": 1.5, "figure.dpi": 100, "savefig.dpi": 300,
    "svg.fonttype": "path",  # so that it looks the same where the font is missing
    "pdf.fonttype": 42, "svg.hashsalt": "tetraction",
}  # fmt: skip


def curves_of(runs, key):
    groups = {}
    for run in runs:
        groups.setdefault(key(run), []).append(run)
    return list(groups.values())


def name_of(study, run, with_variant=True):
    rule = RULES.get(run["rule"], plain(run["rule"].replace("-", " ")))
    tags = [plain(run["variant"]) if with_variant and len(study["variants"]) > 1 else "", plain(run["solver"])]
    return rule + (f" ({', '.join(t for t in tags if t)})" if any(tags) else "")


def rule_of(run):
    """As the tables of study.html name it."""
    return run["rule"] + (f" ({run['solver']})" if run["solver"] else "")


def note_of_points(study, points):
    """Of a curve with a marker for each (run, text of its value)."""
    return {"rule": rule_of(points[0][0]), "runs": [run for run, _ in points],
            "texts": [f"{name_of(study, run)}, h = {si(run['step'], 's')}: {text}" for run, text in points]}  # fmt: skip


def note_of_curve(study, run, *units):
    return {"rule": rule_of(run), "run": run, "units": units,
            "text": f"{name_of(study, run)}, h = {si(run['step'], 's')}"}  # fmt: skip


def looks_of(study, run, varied=True):
    """Of a curve: colour and marker are the integrator's, and the line the variant's, if there are
    several in a panel. Another solver is a ring around the point that it should agree with."""
    rank = study["rules"].index(run["rule"]) % len(COLOURS)
    line = RULE_LINES[rank]
    if varied and len(study["variants"]) > 1:
        line = LINES[study["variants"].index(run["variant"]) % len(LINES)]
    looks = {"color": COLOURS[rank], "marker": MARKERS[rank], "ls": line, "ms": 4.2, "mfc": "none"}
    return {**looks, "marker": "o", "ms": 8, "ls": "none"} if run["solver"] else looks


def parts_of(study):
    """[(heading, curves)]: the panels of a plot with a curve for each integrator. If there are too many
    of them for one panel, each variant has its own."""
    def key(run):
        return run["rule"], run["variant"], run["solver"]

    curves = curves_of(study["runs"], key)
    lines = [c for c in curves if not c[0]["solver"]]  # those of another solver are rings
    if len(lines) <= MOST_LINES:
        return [("", curves)]
    parts = []
    for variant in study["variants"]:
        own = [c for c in lines if c[0]["variant"] == variant]
        count = math.ceil(len(own) / MOST_LINES)
        for i in range(count):
            rules = [(c[0]["rule"], variant) for c in own[i::count]]
            rings = [c for c in curves if c[0]["solver"] and (c[0]["rule"], c[0]["variant"]) in rules]
            parts.append((plain(variant), own[i::count] + rings))
    return parts


def representative(study):
    """The coarsest run of each integrator that ended well, in which errors can be seen."""
    runs = [r for r in study["runs"] if ended_well(r) and not r["solver"]
            and r["variant"] == study["variants"][0]]  # fmt: skip
    return [group[-1] for group in curves_of(runs, lambda run: run["rule"])]


def heading(axes, text):
    axes.set_title(wrapped(text, 24), loc="left", linespacing=1.0)
