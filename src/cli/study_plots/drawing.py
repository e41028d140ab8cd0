"""All plots of a study as files."""

import contextlib
import functools
import html
import io
import os
import re
import sys
import traceback

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import is_color_like

from .files import Unusable, read_study
from .looks import COLOURS, JOURNAL
from .plots import PLOTS, plot_probe

DEFECT, UNWRITABLE = 1, 4  # exit codes
ENDINGS = ("png", "svg", "pdf")
# What a style file may set. Other keys name files, start LaTeX, or are evaluated as Python.
STYLE_KEYS = re.compile(r"(font|axes|lines|xtick|ytick|grid|text|mathtext|patch|markers|figure|savefig"
                        r"|pdf|svg)\.(?!prop_cycle|hooks|usetex|latex|format|directory|backend|hashsalt|dpi)")


class Unwritable(Unusable):
    """A plot cannot be written."""


def read_style(path):
    """The settings of a style file of matplotlib that cannot run code or name files, and the others' keys."""
    style, others = {}, []
    try:
        with open(path, encoding="utf-8") as file:
            lines = file.read(100000).splitlines()
    except (OSError, ValueError) as problem:
        raise Unusable(f"--style {path}: cannot be read ({problem})") from problem
    for count, line in enumerate(lines, 1):
        key, _, value = re.split(r"(?:^|\s)#", line)[0].partition(":")
        key, value = key.strip(), value.strip().strip('"')
        if not key:
            continue
        if key == "axes.prop_cycle":  # only its colours, which need no evaluation
            colors = [c for c in re.findall(r"['\"]([^'\"]+)['\"]", value) if is_color_like(c)]
            COLOURS[: len(colors)] = colors
        elif not STYLE_KEYS.match(key) or key == "figure.figsize":
            others.append(key)
        else:
            try:
                style[key] = matplotlib.RcParams({key: value})[key]
            except (KeyError, ValueError) as problem:
                raise Unusable(f"--style {path}, line {count}: {problem}") from problem
    return style, others


def write_file(path, content):
    """The file gets its name when it is complete. A link of that name is not followed."""
    temporary = path + ".part"
    try:
        if os.path.lexists(temporary):
            os.remove(temporary)
        # Without a buffer nothing is left that Python would try to write at its end.
        with open(temporary, "xb", buffering=0) as file:
            rest = memoryview(content)
            while rest:
                rest = rest[file.write(rest) :]
        os.replace(temporary, path)
    except OSError as problem:
        with contextlib.suppress(OSError):
            os.remove(temporary)
        raise Unwritable(f"{path}: cannot be written ({problem.strerror})") from problem


def in_xml(text):
    """For an element or an attribute. Viewers of other programs, as study.html, look for "=" in attributes only."""
    return html.escape(str(text).replace(r"\$", "$")).replace("=", "&#61;")


def scale_of(axes):
    """For each axis: the value is a + b p, or the power of ten of that, at the coordinate p of the SVG file."""
    (wide, tall), place = axes.figure.get_size_inches() * 72, axes.get_position()
    text = []
    for axis, begin, length in ((axes.xaxis, place.x0 * wide, place.width * wide),
                                (axes.yaxis, (1 - place.y0) * tall, -place.height * tall)):  # fmt: skip
        low, high = axis.get_transform().transform(np.array(axis.get_view_interval()))
        slope = (high - low) / length
        text.append(f"{low - slope * begin:.9g} {slope:.9g} {int(axis.get_scale() == 'log')}")
    return " ".join(text)


def annotated(svg, prefix, figure):
    """The drawing with what study.html switches and shows under the cursor."""
    parts = re.split(r'(<g id="[^"]*">)', svg)
    notes = getattr(figure, "notes", {})
    for i in range(1, len(parts), 2):
        note = notes.get(parts[i][len(f'<g id="{prefix}') : -2])
        if note is None:
            continue
        tag = parts[i][:-1] + f' data-rule="{in_xml(note["rule"])}"'
        if "run" in note:
            tag += f' data-run="{in_xml(os.path.basename(note["run"]["directory"]))}"'
        if "units" in note:
            tag += f' data-scale="{scale_of(note["axes"])}" data-units="{in_xml("|".join(note["units"]))}"'
        parts[i] = tag + ">" + (f"<title>{in_xml(note['text'])}</title>" if "text" in note else "")
        points = iter(zip(note.get("runs", []), note.get("texts", [])))
        if parts[i + 1].count("<use ") == len(note.get("runs", [])):

            def titled(match, points=points):
                run, text = next(points)
                return (f'{match[1]} data-run="{in_xml(os.path.basename(run["directory"]))}">'
                        f"<title>{in_xml(text)}</title></use>")  # fmt: skip

            parts[i + 1] = re.sub(r"(<use [^>]*?)/>", titled, parts[i + 1])
    return "".join(parts)


def keep_subsets_of_fonts():
    """A PDF file has that part of the font that it uses. To find it takes longer than to draw the rest of the file, so
    that all files get the same part, as long as it has their characters."""
    from matplotlib.backends import _backend_pdf_ps

    usual = set(map(chr, range(32, 127))) | set("·×√µ−⁻⁰¹²³⁴⁵⁶⁷⁸⁹…")
    find_subset = _backend_pdf_ps.get_glyphs_subset

    @functools.lru_cache
    def content_of(font, characters):
        return find_subset(font, characters).getvalue()

    def subset_of(font, characters):
        return io.BytesIO(content_of(font, "".join(sorted(usual.union(characters)))))

    _backend_pdf_ps.get_glyphs_subset = subset_of


def save(figure, folder, name):
    # No date, so that the same study gives the same files.
    extra = {"png": {}, "svg": {"Date": None}, "pdf": {"CreationDate": None, "ModDate": None}}
    for ending in ENDINGS:
        content = io.BytesIO()
        quick = {"pil_kwargs": {"compress_level": 3}} if ending == "png" else {}
        figure.savefig(content, format=ending, metadata=extra[ending], **quick)
        content = content.getvalue()
        if ending == "svg":  # Several plots can stand in one page.
            prefix = re.sub(r"\W", "_", name).encode() + b"-"
            content = re.sub(rb'( id="|href="#|url\(#)', rb"\1" + prefix, content)
            content = re.sub(rb"([MLQ] -?\d+\.\d\d)\d* (-?\d+\.\d\d)\d*", rb"\1 \2", content)
            # The mark that is used has this style already.
            content = re.sub(rb'(<use xlink:href="[^"]*" x="[^"]*" y="[^"]*") style="(?![^"]*fill)[^"]*"', rb"\1", content)
            content = annotated(content.decode(), prefix.decode(), figure).encode()
        write_file(os.path.join(folder, f"{name}.{ending}"), content)


def remove_plot(folder, name):
    """An earlier call of the same study may have drawn it."""
    for ending in ENDINGS:
        path = os.path.join(folder, f"{name}.{ending}")
        if os.path.lexists(path):
            os.remove(path)


def draw_all(arguments):
    """Draws into the directory what the study has. Returns the exit code."""
    if arguments.style:
        style, others = read_style(arguments.style)
        JOURNAL.update(style)
        if others:
            print(f"plot_study: {arguments.style}: not used: {', '.join(others)}", file=sys.stderr)
    study = read_study(arguments.directory)
    plots = {name: (function, {}) for name, function in PLOTS.items()}
    plots.update({f"probe_{p['name']}": (plot_probe, {"name": str(p["name"])}) for p in study["probes"]})
    if matplotlib.__version_info__ < (3, 8):  # later ones have another function
        keep_subsets_of_fonts()
    failures, code = [], 0
    for name, (function, choice) in plots.items():
        try:
            axes = function(study, width=arguments.width, title=arguments.title, **choice)
            if axes is None:
                remove_plot(arguments.directory, name)
            else:
                with matplotlib.rc_context(JOURNAL):
                    save(axes[0].figure, arguments.directory, name)
        except Exception as problem:  # one plot that fails does not take the others away
            says = str(problem)
            if not isinstance(problem, (Unusable, OSError)):
                place = traceback.extract_tb(problem.__traceback__)[-1]
                says = f"{name}: {type(problem).__name__}: {problem} ({place.name}, line {place.lineno})"
            print(f"plot_study: {says}", file=sys.stderr)
            failures.append(name)
            code = max(code, UNWRITABLE if isinstance(problem, (Unwritable, OSError)) else DEFECT)
            with contextlib.suppress(OSError):
                remove_plot(arguments.directory, name)
        plt.close("all")
    if failures and arguments.failures:
        write_file(arguments.failures, "\n".join(failures).encode())
    return code
