"""The program: python3 study_plots [--title TEXT] [--style FILE] [--width 85|170] STUDY_DIR

Reads study.json, and the files of each run. Writes PNG, SVG and PDF files into STUDY_DIR, as wide as a column or a page
of a journal.
"""

import argparse
import logging
import os
import sys
import traceback
import warnings

DEFECT, UNUSABLE, NO_MATPLOTLIB, UNWRITABLE = 1, 2, 3, 4  # exit codes; the last one is that of tetraction


def command_line():
    parser = argparse.ArgumentParser(prog="plot_study", allow_abbrev=False)
    parser.add_argument("directory", type=os.path.abspath)
    parser.add_argument("--title", default="", help="text above each plot")
    parser.add_argument("--style", type=os.path.abspath, help="a style file of matplotlib")
    parser.add_argument("--failures", type=os.path.abspath, help="a file for the names of plots that fail")
    parser.add_argument("--width", type=int, choices=(85, 170), default=170, help="mm")
    return parser.parse_args()


def run():
    """Draws all plots. Returns the exit code."""
    arguments = command_line()
    os.chdir("/")  # matplotlib takes settings from a file of the working folder
    # What matplotlib says of its fonts, its caches or an axis is of no use to who reads the study.
    warnings.simplefilter("ignore")
    logging.getLogger("matplotlib").setLevel(logging.CRITICAL)
    try:
        import matplotlib

        matplotlib.use("Agg")
        from . import drawing
    except (ImportError, OSError) as problem:  # OSError: there is no room for its caches
        print(f"plot_study: matplotlib cannot be used: {problem}", file=sys.stderr)
        return NO_MATPLOTLIB if isinstance(problem, ImportError) else UNWRITABLE
    try:
        return drawing.draw_all(arguments)
    except (drawing.Unusable, OSError) as problem:
        print(f"plot_study: {problem}", file=sys.stderr)
        return UNWRITABLE if isinstance(problem, (drawing.Unwritable, OSError)) else UNUSABLE
    except Exception:
        print("plot_study:", traceback.format_exc().splitlines()[-1], file=sys.stderr)
        return DEFECT
