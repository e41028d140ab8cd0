"""Numbers, their units and names as texts of plots."""

import math
import re
import textwrap

PREFIXES = [(1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n"),
            (1e-12, "p")]  # fmt: skip


def number(value):
    """The value as a float; NaN where there is none, which stands for 'not available'."""
    try:
        result = float(value)
    except (TypeError, ValueError):
        return math.nan
    return result if math.isfinite(result) else math.nan


def usable(value):
    return math.isfinite(value) and value > 0


def scaled(size, unit):
    """The factor to show numbers of this size, and their unit with an SI prefix: 3e-5, "s" gives
    1e-6, "µs". Units that take no prefix get a power of ten."""
    unit = {"kg m/s": "N s"}.get(unit, unit)
    factor, prefix = next((p for p in PREFIXES if abs(size) >= 0.9995 * p[0]), PREFIXES[-1])
    if not size or not unit and 1e-3 <= abs(size) < 1e4:
        return 1.0, unit
    if re.match(r"(?!kg)[A-Za-z]+($|[ /·])", unit):
        return factor, prefix + unit
    exponent = 3 * math.floor(math.log10(abs(size)) / 3 + 1e-6)
    return 10.0**exponent, f"{power_of_ten(exponent)} {unit}".strip()


def power_of_ten(exponent):
    return "10" + str(exponent).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))


def si(value, unit):
    """3e-05, "s" as 30 µs."""
    factor, name = scaled(value, unit)
    return f"{float(f'{value / factor:.3g}'):g}\u00a0{name}"  # is not broken into lines


def steps_text(steps):
    """24 µs, 98 µs and 390 µs as "24, 98, 390 µs"."""
    factor, unit = scaled(max(steps), "s")
    return ", ".join(f"{h / factor:.3g}" for h in sorted(steps)) + f"\u00a0{unit}"  # is not broken into lines


def with_unit(words, unit):
    return f"{words} ({unit})" if unit else words


def plain(text, most=60):
    """For texts, in which matplotlib reads $ as the sign of a formula."""
    text = str(text)
    return (text if len(text) <= most else text[: most - 1] + "…").replace("$", r"\$")


class Wrapper(textwrap.TextWrapper):
    wordsep_re = re.compile(r"( +)|(?<=[_-])")  # names have few blanks


def wrapped(text, most):
    """In lines of at most so many characters, without a break inside of plain()'s \\$."""
    lines = text.replace(r"\$", "\ue000").split("\n")
    return "\n".join(Wrapper(max(most, 5)).fill(line) for line in lines).replace("\ue000", r"\$")


def some(values, most):
    """At most so many, evenly chosen, with the first and the last."""
    values = list(values)
    if len(values) <= most:
        return values
    return [values[round(i * (len(values) - 1) / max(1, most - 1))] for i in range(most)]
