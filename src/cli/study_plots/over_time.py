"""Plots over time."""

import math

import numpy as np
from matplotlib.colors import to_hex, to_rgb

from .files import ended_well, read_columns, read_history, reference_of, summary_of
from .looks import LINES, MOST_LINES, curves_of, heading, looks_of, name_of, note_of_curve, representative
from .over_step import EPSILON, MOST_PANELS, band, finish_small
from .sheet import plot
from .words import number, plain, scaled, si, some, steps_text, usable, with_unit, wrapped

MOST_POINTS = 110  # of a curve over time: as many as a panel of 40 mm shows
# Sections of a scene without influence on the momenta.
INNER = {"mesh", "material", "material_region", "time", "solver", "environment", "damping", "initial",
         "output", "probe", "amplitude"}  # fmt: skip


def thinned(times, values, both=False):
    """Of each of about MOST_POINTS stretches the largest value, or the least and the largest one in their
    order, and the last value."""
    t, v = np.array([times, values], dtype=float)
    t, v = np.array([t, v])[:, np.isfinite(t) & np.isfinite(v)]
    stride = math.ceil(len(t) / MOST_POINTS) * (1 + both)
    if stride <= 1 + both:
        return t, v
    kept = {len(t) - 1}
    for i in range(0, len(t), stride):
        kept |= {i + np.argmax(v[i : i + stride])} | ({i + np.argmin(v[i : i + stride])} if both else set())
    return t[sorted(kept)], v[sorted(kept)]


def over_time(study, sheet, width, value_of, round_off_of, label, unit=""):
    """A panel for each integrator with a curve for each step, on a logarithmic axis that fits the runs
    that ended well: a run that blew up leaves the panel, and is marked at its upper edge. `value_of`
    returns None for a run that has no such number."""
    groups, floors = [], []
    for runs in curves_of([r for r in study["runs"] if not r["solver"]], lambda r: (r["rule"], r["variant"])):
        curves = []
        bad = [r for r in runs if not ended_well(r)]
        good = some([r for r in runs if ended_well(r)], MOST_LINES - (1 if bad else 0))
        for run in good + some(bad, MOST_LINES - len(good)):
            history = read_history(run)
            try:
                values = value_of(run, history)
                times, values = thinned(history["time"], values) if values is not None else ([], [])
                if len(times):
                    curves.append((run, times, values))
                    floors += [round_off_of(run, history)] if ended_well(run) else []
            except (KeyError, IndexError):
                continue
        groups += [curves] if curves else []
    groups = some(groups, MOST_PANELS[width])
    every = [(run, v) for curves in groups for run, _, values in curves for v in values if v > 0]
    good = [v for run, v in every if ended_well(run)] or [v for _, v in every]
    if not good:
        return None
    factor, unit = scaled(max(good), unit) if unit else (1.0, "")
    floor = max((f for f in floors if usable(f)), default=math.nan) / factor
    end = max(times[-1] for curves in groups for _, times, _ in curves)
    second, time_unit = scaled(end, "s")
    sheet = sheet(len(groups), height=34, columns=2 if len(groups) in (2, 4) else 3)
    for i, (panel, curves) in enumerate(zip(sheet.panels, groups)):
        color = looks_of(study, curves[0][0])["color"]
        panel.axes.set_xlim(0, end / second)
        panel.scale("y", [np.percentile(good, 2) / factor, max(good) / factor], least=1.3)
        band(panel, [0, end / second], lambda _: floor, "round-off")
        bad = [(run, times[-1]) for run, times, _ in curves if not ended_well(run)]
        for rank, (run, times, values) in enumerate(reversed(curves)):
            # A logarithmic axis has no zero, as the error of the start is.
            points = [(t / second, v / factor) for t, v in zip(times, values) if v > 0]
            # The coarsest step has the integrator's colour, and finer ones are darker.
            hue = to_hex(np.array(to_rgb(color)) * (1 - 0.7 * rank / max(1, len(curves) - 1)))
            if points:
                panel.line(si(run["step"], "s") if ended_well(run) else "", *zip(*points),
                           note_of_curve(study, run, time_unit, unit), color=hue,
                           ls=LINES[rank % len(LINES)], marker="." if len(points) < 8 else "", ms=3)  # fmt: skip
        if bad:
            kinds = {r.get("status") for r, _ in bad}
            words = f"{'unstable' if kinds == {'unstable'} else 'failed'}: {steps_text([r['step'] for r, _ in bad])}"
            panel.line(wrapped(words, 20), [t / second for _, t in bad], [0.96] * len(bad), color=color,
                       marker="x", ms=4.5, ls="none", clip_on=False, zorder=5,
                       transform=panel.axes.get_xaxis_transform())  # fmt: skip
        finish_small(sheet, i, name_of(study, curves[0][0]), f"time $t$ ({time_unit})", with_unit(label, unit))
    return sheet.finish()


def energy_scale(run):
    """The energy that entered the run; NaN if it is not known."""
    energy = summary_of(run).get("energy")
    return number(energy.get("scale")) if isinstance(energy, dict) else math.nan


def energy_error(run, history):
    """|energy error| over the energy that entered, at each step."""
    error, scale = np.abs(history["energy_error"]), energy_scale(run)
    return error / scale if scale > 0 else 0.0 * error if scale == 0 else None


def energy_round_off(run, history):
    """At most about one rounding of the energies in each step, over the energy that entered."""
    keys = ("kinetic_energy", "elastic_energy", "environment_energy", "external_work",
            "dissipated_energy")  # fmt: skip
    sums = np.sum([np.abs(history[k]) for k in keys if k in history], axis=0)
    largest = np.max(sums, where=np.isfinite(sums), initial=0.0)
    scale = energy_scale(run)
    return EPSILON * (10 + len(sums)) * largest / scale if scale > 0 else math.nan


def conserved(run, letter):
    """The projection to those components of a momentum ("p" or "l") that the run's scene conserves, or
    None if there are none."""
    scene = summary_of(run).get("scene")
    if not isinstance(scene, dict) or not scene:
        return None
    if any(value for key, value in scene.items() if key not in (*INNER, "pull")):
        return None
    if (scene.get("pull") or {}).get("vertices"):
        return None
    damping = scene.get("damping") or {}
    # Viscosity acts between the vertices, and takes no momentum.
    if any(value for key, value in damping.items() if key != "viscosity"):
        return None
    environment = scene.get("environment") or {"kind": "none"}
    if environment.get("kind") == "none":
        return np.eye(3)
    if environment.get("kind") == "attraction":  # towards the origin
        return np.eye(3) if letter == "l" else None
    direction = np.array(environment.get("direction", [0.0, -1.0, 0.0]), dtype=float)
    along = np.outer(direction, direction) / (direction @ direction)
    return along if letter == "l" else np.eye(3) - along


def momentum_change(letter):
    def value_of(run, history):
        projection = conserved(run, letter)
        if projection is None:
            return None
        vectors = np.array([history[letter + axis] for axis in "xyz"])
        return list(np.linalg.norm(projection @ (vectors - vectors[:, :1]), axis=0))

    return value_of


def momentum_round_off(letter):
    """At most about one rounding of the momentum in each step: of the sum of its magnitudes over the
    vertices, which the kinetic energy T bounds by √(2 M T), or of the magnitude |L|."""

    def round_off_of(run, history):
        rounding = EPSILON * (10 + len(history["time"]))
        if letter == "l":
            sizes = [math.hypot(*v) for v in zip(*(history["l" + axis] for axis in "xyz"))]
            return rounding * max((s for s in sizes if math.isfinite(s)), default=0.0)
        mass = number(summary_of(run).get("mass"))
        energy = max((e for e in history["kinetic_energy"] if math.isfinite(e)), default=0.0)
        return rounding * math.sqrt(2 * mass * energy) if usable(mass) else math.nan

    return round_off_of


@plot
def plot_energy_over_time(study, sheet, width):
    return over_time(study, sheet, width, energy_error, energy_round_off,
                     "relative energy error")  # fmt: skip


@plot
def plot_linear_momentum_over_time(study, sheet, width):
    return over_time(study, sheet, width, momentum_change("p"), momentum_round_off("p"),
                     "change of $p$", "N s")  # fmt: skip


@plot
def plot_angular_momentum_over_time(study, sheet, width):
    return over_time(study, sheet, width, momentum_change("l"), momentum_round_off("l"),
                     "change of $L$", "N m s")  # fmt: skip


@plot
def plot_probe(study, sheet, width, name=None):
    """For each component the values on the left, and the difference from the reference on the right, of the
    coarsest runs that ended well. Values of the run that differs least from the reference may be left out."""
    probe = next((p for p in study["probes"] if name is None or str(p["name"]) == name), None)
    if probe is None:
        return None
    columns, unit = [str(column) for column in probe["columns"]], plain(probe.get("unit") or "")
    runs = [(run, read_columns(run["directory"], "probes.csv")) for run in representative(study)[:MOST_LINES]]
    runs = [(run, table) for run, table in runs if all(c in table for c in columns)]
    if not runs:
        return None
    place = reference_of(study, study["variants"][0])
    reference = read_columns(place, "probes.csv")
    has_reference = all(c in reference for c in columns) and any(run["directory"] != place for run, _ in runs)
    end = max(table["time"][-1] for _, table in runs)
    second, time_unit = scaled(end, "s")
    steps = [run["step"] for run, _ in runs]
    usual = max(steps, key=steps.count)
    sheet = sheet((1 + has_reference) * len(columns), height=36, columns=1 + has_reference)
    for i, column in enumerate(columns):
        values, other = sheet.panels[(1 + has_reference) * i :][:2] if has_reference else (sheet.panels[i], None)
        series, known = [(run, *finite(table, column)) for run, table in runs], finite(reference, column)
        series = [(run, t, v, np.abs(v - np.interp(t, *known)) if has_reference and len(known[0]) else 0 * v)
                  for run, t, v in series if len(t)]  # fmt: skip
        sizes = [np.abs(np.concatenate([s[j] for s in series])) for j in (2, 3)]
        gaps = sizes[1][sizes[1] > 0]
        (factor, shown), (small, small_unit) = (scaled(np.max(s), unit) for s in sizes)
        if has_reference and len(known[0]):
            t, v = thinned(*known, both=True)
            values.line("reference", t / second, v / factor, color="#b0b0b0", lw=2.5)
        least = sorted(series, key=lambda s: np.max(s[3]))[: max(0, len(series) + has_reference - MOST_LINES)]
        for entry in series:
            run, t, v, gap = entry
            words = name_of(study, run, False) + (f" ({si(run['step'], 's')})" if run["step"] != usual else "")
            looks = {**looks_of(study, run, False), "marker": "." if len(t) < 8 else "", "ms": 3}
            if not any(entry is e for e in least):
                x, y = thinned(t, v, both=True)
                values.line(words, x / second, y / factor, note_of_curve(study, run, time_unit, shown), **looks)
            if (gap > 0).any():
                x, y = thinned(t, np.where(gap > 0, gap, np.nan))
                other.line(words, x / second, y / small, note_of_curve(study, run, time_unit, small_unit), **looks)
        for panel, words in [(values, with_unit(plain(column, 200), shown)), (other, with_unit("difference", small_unit))]:
            if panel is not None:
                panel.axes.set(xlim=(0, end / second), ylabel=words,
                               xlabel=f"time $t$ ({time_unit})" if i == len(columns) - 1 else "")  # fmt: skip
                panel.axes.tick_params(labelbottom=i == len(columns) - 1)
        if len(gaps):
            other.scale("y", [np.percentile(gaps, 2) / small, max(gaps) / small], least=1.3)
    heading(sheet.panels[0].axes, f"$h$ = {si(usual, 's')}")
    return sheet.finish()


def finite(table, column):
    pairs = np.array([table["time"], table[column]], dtype=float)
    return pairs[:, np.isfinite(pairs).all(axis=0)]
