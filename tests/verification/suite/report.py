"""Results as lines of text and as the page docs/verification.md."""

import os

from cases import Order
from plots import NAMES, draw

HEAD = """# Verification

Every case of this page is a scene in [tests/verification/cases](../tests/verification/cases) that goes through the
program's own commands: the scene goes in, and the numbers are read from the files that come out. This page and its
plots are written by `scripts/verify`, which runs all meshes of all cases. A short form with the coarser meshes is part of
the tests (`ctest -L verification`). A scene can be run by hand as its first lines say.

Three kinds of elements are compared: linear tetrahedra, linear tetrahedra with `mesh.volume = "nodal"`, and quadratic
ones (`mesh.element = "quadratic"`). A deviation is relative to the reference, except where the case says otherwise. *Asserted* is
what the suite checks: the largest deviation that it accepts (≤), or the least by which an element must miss (≥). A row
with – is shown for comparison. A mesh is given by its cells along its directions; each cell has six tetrahedra.
"""


def number(value):
    return f"{value:.5g}" if value == value else "–"


def deviation_of(value):
    if value.deviation is None or value.deviation != value.deviation:
        return "–"
    if value.absolute:
        return f"{value.deviation:.1e}"
    if value.deviation > 10.0:
        return f"{1.0 + value.deviation:.3g} times"
    percent = 100.0 * value.deviation
    if abs(percent) < 1e-4:
        return f"{value.deviation:+.0e}"
    return f"{percent:+.3f} %" if abs(percent) < 1.0 else f"{percent:+.3g} %"


def asserted(value):
    bounds = []
    for bound, sign in ((value.within, "≤"), (value.beyond, "≥")):
        if bound is not None:
            plain = value.absolute or bound < 1e-6
            bounds.append(f"{sign} {bound:g}" if plain else f"{sign} {100 * bound:g} %")
    if value.at_least is not None:
        bounds.append(f"value ≥ {value.at_least:g}")
    return ", ".join(bounds) or "–"


def mesh_of(value):
    return " × ".join(map(str, value.cells))


def line_of(result):
    verdict = "" if result.holds else "  OFF"
    if isinstance(result, Order):
        return (f"{result.variant} {result.element} {result.quantity}: order {result.value:.2f} "
                f"(at least {result.at_least:g}){verdict}")
    reference = "" if result.reference is None else f" (reference {result.reference:g})"
    return (f"{result.variant} {result.element} {mesh_of(result)}, {result.tetrahedra} tetrahedra: "
            f"{result.quantity} = {result.value:.7g} {result.unit}{reference}, "
            f"{deviation_of(result)}, asserted {asserted(result)}{verdict}")


def table_of(values):
    """A row for each run, a column for each quantity, and above them the references of each variant."""
    quantities = {}
    for value in values:
        quantities.setdefault(value.quantity, value)
    heads = [f"{name} [{v.unit}]" if v.unit else name for name, v in quantities.items()]
    lines = ["| element | mesh | tetrahedra | unknowns | " + " | ".join(heads) + " | asserted |",
             "| --- " * (len(heads) + 5) + "|"]
    for variant in dict.fromkeys(v.variant for v in values):
        mine = [v for v in values if v.variant == variant]
        references = {v.quantity: v.reference for v in mine if v.reference is not None}
        compared = any(not v.absolute for v in mine)
        title = " ".join(filter(None, (f"**{variant}**" if variant else "",
                                       "reference" if references and compared else "")))
        if title:
            lines.append(f"| {title} | | | | " + " | ".join(
                number(references[q]) if q in references and not quantities[q].absolute else ""
                for q in quantities) + " | |")
        for run in dict.fromkeys((v.element, mesh_of(v)) for v in mine):
            row = {v.quantity: v for v in mine if (v.element, mesh_of(v)) == run}
            first = next(iter(row.values()))
            cells = []
            for name in quantities:
                value = row.get(name)
                if value is None:
                    cells.append("")
                elif value.value != value.value:
                    cells.append("–")
                elif value.absolute:
                    cells.append(f"{value.value:.1e}")
                elif value.deviation is None:
                    cells.append(number(value.value))
                else:
                    cells.append(f"{number(value.value)} ({deviation_of(value)})")
            bounds = {q: asserted(v) for q, v in row.items() if asserted(v) != "–"}
            if not bounds:
                bound = "–"
            elif len(set(bounds.values())) == 1 and len(bounds) == len(row):
                bound = next(iter(bounds.values()))
            else:
                bound = "; ".join(f"{q} {b}" for q, b in bounds.items())
            name = NAMES[first.element] + (", the reference" if first.is_reference else "")
            lines.append(f"| {name} | {run[1]} | {first.tetrahedra:,} | {first.unknowns:,} | "
                         + " | ".join(cells) + f" | {bound} |")
    return "\n".join(lines)


def section(root, case, values, orders, images):
    table = case.table
    parts = [f"## {table['title']}",
             f"[Scene](../{os.path.relpath(case.scene, root)}) · "
             f"[case](../tests/verification/cases/{case.name}/case.toml)",
             f"**Source.** {table['source']}.", f"**Computed.** {table['about']}", table_of(values)]
    if "remarks" in table:
        parts.append(table["remarks"].strip())
    for name, caption in images:
        parts.append(f"![{caption}](images/verification/{name})\n\n*{caption}*")
    return "\n\n".join(parts)


def overview(cases, results):
    """The largest deviation that each kind of element has on its finest mesh."""
    lines = ["| case | linear | nodal volume | quadratic | asserted numbers |",
             "| --- | --- | --- | --- | --- |"]
    for case in cases:
        values, orders = results[case]
        row = []
        for element in NAMES:
            mine = [v for v in values if v.element == element and v.deviation is not None
                    and not v.is_reference]
            if any(not v.absolute for v in mine):
                mine = [v for v in mine if not v.absolute]
            finest = max((v.tetrahedra for v in mine), default=0)
            mine = [v for v in mine if v.tetrahedra == finest]
            row.append(deviation_of(max(mine, key=lambda v: abs(v.deviation))) if mine else "–")
        count = sum(v.is_asserted for v in values) + len(orders)
        title = case.table["title"]
        anchor = "".join(c for c in title.lower().replace(" ", "-") if c.isalnum() or c in "-_")
        lines.append(f"| [{title}](#{anchor}) | " + " | ".join(row) + f" | {count} |")
    return "\n".join(lines)


def orders_table(cases, results):
    lines = ["| case | quantity | element | order | asserted |", "| --- | --- | --- | --- | --- |"]
    for case in cases:
        for order in results[case][1]:
            quantity = ", ".join(filter(None, (order.variant, order.quantity)))
            lines.append(f"| {case.table['title']} | {quantity} | {NAMES[order.element]} | "
                         f"{order.value:.2f} | ≥ {order.at_least:g} |")
    return "\n".join(lines)


def write_page(root, results):
    """`results`: the values and orders of every case."""
    cases = sorted(results, key=lambda case: case.table["place"])
    parts = [HEAD.strip(),
             "## Overview\n\nThe largest deviation of all quantities of a case on the finest mesh of each "
             "element. Where the reference is this program on a finer mesh, that mesh is left out.",
             overview(cases, results),
             "## Orders of convergence in the mesh\n\n"
             "From the two finest meshes of an element: the p of e ~ hᵖ. No more is claimed than is "
             "asserted here. The mass of quadratic elements is consistent in `modes` and `static`. In `run` "
             "it is lumped, and no order above 2 is claimed for them.",
             orders_table(cases, results)]
    for case in cases:
        values, orders = results[case]
        images = draw(os.path.join(root, "docs", "images", "verification"), case, values)
        parts.append(section(root, case, values, orders, images))
    with open(os.path.join(root, "docs", "verification.md"), "w", encoding="utf-8") as file:
        file.write("\n\n".join(parts) + "\n")
