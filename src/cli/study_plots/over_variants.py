"""Plots of variants, and of the shapes at the end."""

import math
import os

import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_rgb

from .files import ended_well, open_regular, read_columns, reference_of
from .looks import COLOURS, INK, PALE, heading, name_of, representative
from .sheet import plot
from .words import number, plain, scaled, si, some, with_unit, wrapped

# Of the picture: to the right, upwards and towards the eye. The axis y points upwards.
VIEW = np.array([[0.894, 0.0, -0.447], [-0.183, 0.913, -0.365], [0.408, 0.408, 0.816]])


@plot
def plot_quantity_over_parameter(study, sheet, width):
    """A panel for each probe, or else the difference from the first variant, and each key that is varied, with
    the other keys at their first value. The first variant has a full marker."""
    values = study["values"]
    if len(values) < 2 or len({tuple(v) for v in values.values()}) != 1:
        return None
    first, keys = next(iter(values)), list(next(iter(values.values())))
    sweeps = {key: [name for name, v in values.items() if all(v[k] == values[first][k] for k in keys if k != key)]
              for key in keys}  # fmt: skip
    rows = []
    for probe in study["probes"][:3]:
        found = {name: largest_of_probe(study, name, [str(c) for c in probe["columns"]]) for name in values}
        rows.append((f"largest |{plain(probe['name'])}|", plain(probe.get("unit") or ""), found))
    if not rows:
        found = {str(name): number(entry.get("position_difference")) for entry in study["references"]
                 for name in entry.get("variants") or []}  # fmt: skip
        rows = [("relative difference of the positions from the first variant", "",
                 {**found, first: 0.0} if found else {})]  # fmt: skip
    rows = [row for row in rows if sum(map(math.isfinite, row[2].values())) > 1]
    panels = [(row, key) for row in rows for key in keys if len(sweeps[key]) > 1]
    if not panels:
        return None
    sheet = sheet(len(panels), height=48 if len(panels) == 1 else 40, columns=min(3, len(panels) // len(rows)))
    for i, (panel, ((label, unit, found), key)) in enumerate(zip(sheet.panels, panels)):
        shown = [n for k in keys for n in sweeps[k] if math.isfinite(found.get(n, math.nan))]
        factor, unit = scaled(max(abs(found[n]) for n in shown), unit)
        points = [(name, found[name] / factor) for name in sweeps[key] if math.isfinite(found.get(name, math.nan))]
        x = [number(values[name][key]) for name, _ in points]
        is_number = all(map(math.isfinite, x))
        if not is_number:
            x = list(range(len(points)))
        order = np.argsort(x)
        x, y = np.array(x)[order], np.array([v for _, v in points])[order]
        base = [i for i, j in enumerate(order) if points[j][0] == first]
        color = COLOURS[2]
        panel.line(sensitivity(x, y, base) if is_number else "", x, y, color=color, marker="o", ms=4, mfc="white",
                   ls="-" if is_number else "none")  # fmt: skip
        panel.axes.plot(x[base], y[base], color=color, marker="o", ms=4, ls="none")
        low, high = min(found[n] / factor for n in shown), max(found[n] / factor for n in shown)
        room = max(0.12 * (high - low), 0.02 * abs(high)) or 1.0
        panel.axes.set_ylim(low - room, high + room)
        if is_number and min(x) > 0 and max(x) > 30 * min(x):
            panel.scale("x", x)
        elif not is_number:
            names = [wrapped(plain(values[points[j][0]][key], 60), 14) for j in order]
            panel.axes.set_xticks(x, names, rotation=0 if sum(map(len, names)) < width / 3 else 90)
            panel.axes.set_xlim(-0.5, len(x) - 0.5)
            panel.keeps_ticks = True
        panel.axes.set_xlabel(plain(key, 60))
        panel.axes.set_ylabel(with_unit(label, unit) if i % sheet.columns == 0 else "")
    return sheet.finish()


def largest_of_probe(study, variant, columns):
    """Of its magnitude over time, in the finest run of a variant that ended well."""
    runs = [r for r in study["runs"] if r["variant"] == variant and ended_well(r) and not r["solver"]]
    own = [r for r in runs if r["rule"] == study["reference_rule"]] or runs
    table = read_columns(min(own, key=lambda r: r["step"])["directory"], "probes.csv") if own else {}
    if not all(c in table for c in columns):
        return math.nan
    return np.nanmax(np.linalg.norm([table[c] for c in columns], axis=0), initial=0.0)


def sensitivity(x, y, base):
    """The relative change of a quantity over that of its parameter, around the first variant."""
    around = [i for b in base for i in (b - 1, b + 1) if 0 <= i < len(x)]
    if not around or min(*x, *y) <= 0:
        return ""
    i, j = (around[0], around[-1]) if len(around) > 1 else (around[0], base[0])
    slope = round(math.log(y[j] / y[i]) / math.log(x[j] / x[i]), 2) + 0.0
    return f"sensitivity {slope:g}".replace("-", "−")


def read_surface(directory):
    """Corners of the triangles of the surface in final.vtu, as an array (n, 3, 3); None if there are none."""
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkCommonCore import vtkObject
    from vtkmodules.vtkFiltersCore import vtkTriangleFilter
    from vtkmodules.vtkFiltersGeometry import vtkDataSetSurfaceFilter
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader

    path = os.path.join(directory, "final.vtu")
    try:
        open_regular(path).close()
    except OSError:
        return None
    vtkObject.GlobalWarningDisplayOff()
    reader, surface, triangles = vtkXMLUnstructuredGridReader(), vtkDataSetSurfaceFilter(), vtkTriangleFilter()
    reader.SetFileName(path)
    surface.SetInputConnection(reader.GetOutputPort())
    triangles.SetInputConnection(surface.GetOutputPort())
    triangles.Update()
    found = triangles.GetOutput()
    if found.GetNumberOfPolys() == 0:
        return None
    corners = vtk_to_numpy(found.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    shape = vtk_to_numpy(found.GetPoints().GetData()).astype(float)[corners]
    return shape if np.isfinite(shape).all() else None


@plot
def plot_shapes_at_end(study, sheet, width):
    """The body at the end: the reference, and the coarsest run of each integrator that ended well over it, or
    the references of the variants."""
    if len(study["variants"]) > 1:
        shapes = [(plain(v), reference_of(study, v)) for v in study["variants"] if v in study["places"]]
    else:
        runs = [(f"{name_of(study, r)},\n$h$ = {si(r['step'], 's')}", r["directory"]) for r in representative(study)]
        shapes = [("reference", reference_of(study, study["variants"][0])), *runs]
    try:
        shapes = [(name, read_surface(place)) for name, place in some(shapes, 6)]
    except ImportError:  # python3-vtk9 is not installed
        return None
    shapes = [(name, shape @ VIEW.T) for name, shape in shapes if shape is not None]
    if not shapes:
        return None
    corners = np.vstack([shape.reshape(-1, 3) for _, shape in shapes])
    (x0, y0, _), (x1, y1, _) = corners.min(axis=0), corners.max(axis=0)
    columns = {85: 2, 170: 3}[width] if len(shapes) > 1 else 1
    each = width / columns - 6
    sheet = sheet(len(shapes), height=min(max(each * (y1 - y0) / (x1 - x0), 10), 60), columns=columns, narrow=columns)
    is_large = sum(len(shape) for _, shape in shapes) > 200
    for i, (panel, (name, shape)) in enumerate(zip(sheet.panels, shapes)):
        layers = [(shape, 0.55 + 0.45 * np.abs(normals(shape)[:, 2]))]
        if i > 0 and shapes[0][0] == "reference":
            layers.insert(0, (shapes[0][1], None))
        for triangles, light in layers:
            order = np.argsort(triangles[:, :, 2].mean(axis=1))
            colors = [PALE] if light is None else np.outer(light, to_rgb("#7fb2d9")).clip(0, 1)[order]
            panel.axes.add_collection(PolyCollection(triangles[order][:, :, :2], fc=colors, ec=colors, lw=0.2,
                                                     rasterized=is_large))  # fmt: skip
        panel.axes.set(xlim=(x0, x1), ylim=(y0, y1), aspect="equal", anchor="S")
        panel.axes.axis("off")
        heading(panel.axes, name)
    length = next(s * 10.0**n for n in range(12, -12, -1) for s in (5, 2, 1) if s * 10.0**n < 0.4 * (x1 - x0))
    bar = sheet.panels[0].axes
    bar.plot([x0, x0 + length], [y0, y0], color=INK, lw=1.5, clip_on=False, solid_capstyle="butt")
    bar.annotate(si(length, "m"), (x0 + length / 2, y0), (0, -2), textcoords="offset points", ha="center", va="top")
    return sheet.finish()


def normals(triangles):
    n = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    return n / np.maximum(np.linalg.norm(n, axis=1), 1e-300)[:, None]
