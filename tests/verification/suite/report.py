"""Results as lines of text, as files, and as the page docs/verification.md."""

import dataclasses
import json
import os

from cases import Order, Value


def deviation_of(value):
    if value.deviation is None:
        return "–"
    if value.absolute:
        return f"{value.deviation:.1e}"
    percent = 100.0 * value.deviation
    return f"{percent:+.3f} %" if abs(percent) < 1.0 else f"{percent:+.3g} %"


def asserted(value):
    bounds = []
    for bound, sign in ((value.within, "≤"), (value.beyond, "≥")):
        if bound is not None:
            bounds.append(f"{sign} {bound:g}" if value.absolute else f"{sign} {100 * bound:g} %")
    return ", ".join(bounds) or "–"


def line_of(result):
    verdict = "" if result.holds else "  OFF"
    if isinstance(result, Order):
        return (f"{result.variant} {result.element} {result.quantity}: order {result.value:.2f} "
                f"(at least {result.at_least:g}){verdict}")
    reference = "" if result.reference is None else f" (reference {result.reference:g})"
    return (f"{result.variant} {result.element} {'x'.join(map(str, result.cells))}, "
            f"{result.tetrahedra} tetrahedra: {result.quantity} = {result.value:.6g} "
            f"{result.unit}{reference}, {deviation_of(result)}, asserted {asserted(result)}{verdict}")


def results_file(work, name):
    return os.path.join(work, name, "results.json")


def store(work, name, values, orders):
    with open(results_file(work, name), "w", encoding="utf-8") as file:
        json.dump({"values": [dataclasses.asdict(v) for v in values],
                   "orders": [dataclasses.asdict(o) for o in orders]}, file, indent=1)


def stored(work, name):
    if not os.path.exists(results_file(work, name)):
        return None
    with open(results_file(work, name), encoding="utf-8") as file:
        data = json.load(file)
    return [Value(**v) for v in data["values"]], [Order(**o) for o in data["orders"]]


def write_page(root, cases, work):
    pass
