"""The numbers that cases compare with their references: one function for each kind.

A function takes the results of one call of the program and the table of the quantity in case.toml.
"""

import numpy as np


def formula(text, points):
    """The value of a formula of X, Y and Z (and of numpy's functions) at points."""
    names = {name: getattr(np, name) for name in ("sin", "cos", "pi", "sqrt", "exp", "hypot")}
    names.update(zip("XYZ", points.T))
    return np.broadcast_to(eval(text, {"__builtins__": {}}, names), len(points))


def vector_field(formulas, points):
    return np.column_stack([formula(text, points) for text in formulas])


def probe(results, table):
    """The last value of a column of probes.csv, or that at the time (or load factor) `at`."""
    times = results.probes["time"]
    row = np.abs(times - table.get("at", times[-1])).argmin()
    if abs(times[row] - table.get("at", times[-1])) > 1e-9 * times[-1]:
        raise ValueError(f"probes.csv has no row at {table['at']}")
    return results.probes[table["column"]][row]


def history(results, table):
    """A value of a column of history.csv: the `last`, or the largest magnitude since the time `since`.

    `of` may also be `change`: the largest difference from the value at `since`; `least`: the least value of
    the rows that have one; `mean`: the mean over the time. Several columns are the components of a vector.
    All is divided by the largest magnitude of `relative_to`, if this is given.
    """
    data = results.history
    if table["of"] == "least":
        return np.nanmin(data[table["columns"][0]])
    if table["of"] == "mean":
        return np.trapz(data[table["columns"][0]], data["time"]) / (data["time"][-1] - data["time"][0])
    values = np.column_stack([data[name] for name in table["columns"]])
    kept = data["time"] >= table.get("since", 0.0) - 1e-9
    if table["of"] == "last":
        return values[-1, 0]
    if table["of"] == "change":
        values = values - values[np.argmax(kept)]
    result = np.linalg.norm(values[kept], axis=1).max()
    if "relative_to" in table:
        scale = np.column_stack([data[name] for name in table["relative_to"]])
        result /= np.linalg.norm(scale, axis=1).max()
    return result


def summary(results, table):
    """A number of summary.json; `key` is its path with dots."""
    value = results.summary
    for part in table["key"].split("."):
        value = value[part]
    return float(value)


def frequency(results, table):
    """The frequency of elastic mode number `number`, in the order of the frequencies, in Hz.

    With `in_plane` only modes count whose motion along z is less than a tenth of all; with `like`, lists of
    three formulas, only those that consist of these shapes to more than four fifths. If there are not so
    many among the modes that were asked for, the result is not a number.
    """
    modes = results.modes
    found = []
    for row in np.flatnonzero(modes["kind"] == "elastic"):
        if "in_plane" in table or "like" in table:
            shape = results.mode_shape(row)
            motion = shape.arrays["mode"]
            if "in_plane" in table and (motion[:, 2] ** 2).sum() > 0.01 * (motion ** 2).sum():
                continue
            if "like" in table:
                basis = np.column_stack([vector_field(f, shape.points).ravel()
                                         for f in table["like"]])
                basis = np.linalg.qr(basis)[0]
                part = np.linalg.norm(basis.T @ motion.ravel()) / np.linalg.norm(motion)
                if part < 0.8:
                    continue
        found.append(modes["frequency"][row])
        if len(found) == table["number"]:
            return found[-1]
    return np.nan


def torque(results, table):
    """The moment about the z axis of the reactions at radius `radius` or more, in the deformed body."""
    grid = results.final
    position = grid.points + grid.arrays["displacement"]
    reaction = grid.arrays["reaction_force"]
    outside = np.hypot(grid.points[:, 0], grid.points[:, 1]) > table["radius"] * (1.0 - 1e-6)
    moment = position[:, 0] * reaction[:, 1] - position[:, 1] * reaction[:, 0]
    return moment[outside].sum()


def field(results, table):
    """How far the last displacements are from formulas: the largest distance (`norm` = "max"), or the
    root of the mean square, both divided by the same of the formulas."""
    grid = results.final
    exact = vector_field(table["displacement"], grid.points)
    difference = np.linalg.norm(grid.arrays["displacement"] - exact, axis=1)
    size = np.linalg.norm(exact, axis=1)
    if table["norm"] == "max":
        return difference.max() / size.max()
    return np.sqrt((difference ** 2).mean() / (size ** 2).mean())


def nodal(results, table):
    """Component number `component` of an array of the last frame at the vertex that rests at `point`."""
    grid = results.final
    distances = np.linalg.norm(grid.points - np.array(table["point"]), axis=1)
    if distances.min() > 1e-9:
        raise ValueError(f"no vertex is at {table['point']}")
    return grid.arrays[table["array"]][distances.argmin(), table["component"]]


def period(results, table):
    """The frequency of a probe in Hz, as summary.json has it."""
    return results.summary["probes"][table["column"]]["frequency"]


def line(results, table):
    """The line through the values of a probe between two times: its `slope`, or its `root` in time."""
    times, values = results.probes["time"], results.probes[table["column"]]
    kept = (times >= table["from"]) & (times <= table["until"])
    slope, offset = np.polyfit(times[kept], values[kept], 1)
    return slope if table["of"] == "slope" else -offset / slope


def peak(results, table):
    """The largest value of a column of probes.csv, or its time with `of` = "time"."""
    values = results.probes[table["column"]]
    return results.probes["time"][values.argmax()] if table.get("of") == "time" else values.max()


def order(results, table):
    """The order that a study observed for an integrator between its two smallest steps."""
    study = results.study
    rows = np.flatnonzero((study["integrator"] == table["integrator"])
                          & ~np.isnan(study["observed_order"]))
    return study["observed_order"][rows[study["step"][rows].argmin()]]


def rate(results, table):
    """The mean rate of a column of history.csv between two times."""
    data = results.history
    ends = [table["from"], table["until"]]
    values = np.interp(ends, data["time"], data[table["column"]])
    return (values[1] - values[0]) / (ends[1] - ends[0])


def impact(results, table):
    """The force of an obstacle along x beside `exact`, a formula of the time X since the touch.

    The force of a step is the rate of the momentum minus `other`, the other forces along x. `of` is its
    `mean` between `from` and `until` divided by that of the exact one; `error`, the root mean square of the
    difference there divided by that of the exact one; or `duration`: from where the force first rises above
    half of the exact one at the time 0 to where it falls below half of the exact one at `end`; or `released`:
    the value of `column` at that end.
    """
    data = results.history
    steps = np.diff(data["time"])
    force = np.diff(data["px"]) / steps - table.get("other", 0.0)
    middle = data["time"][:-1] + 0.5 * steps

    def exact(times):
        return formula(table["exact"], np.column_stack([times] * 3))

    if table["of"] in ("duration", "released"):
        first, last = 0.5 * exact(np.array([0.0, table["end"]]))

        def crossing(before, level):
            """Where the line through the forces of two steps has the level."""
            part = (level - force[before]) / (force[before + 1] - force[before])
            return middle[before] + part * (middle[before + 1] - middle[before])

        if force[0] > first:
            start = 0.0
        else:
            start = crossing(np.argmax(force > first) - 1, first)
        after = middle > start + 0.5 * table["end"]
        end = crossing(np.argmax(after & (force < last)) - 1, last)
        return end - start if table["of"] == "duration" else np.interp(end, data["time"], data[table["column"]])
    kept = (middle > table["from"]) & (middle < table["until"])
    weights, wanted = steps[kept], exact(middle[kept])
    if table["of"] == "mean":
        return (weights * force[kept]).sum() / (weights * wanted).sum()
    return np.sqrt((weights * (force[kept] - wanted) ** 2).sum() / (weights * wanted ** 2).sum())


def impacts(results, table):
    """How often the body comes into the layer of an obstacle: rises of the contact energy from zero."""
    touches = results.history["contact_energy"] > 0.0
    return np.count_nonzero(touches[1:] & ~touches[:-1]) + int(touches[0])


def contact(results, table):
    """What obstacles do to the body in the last frame.

    `of` is `force`: component number `component` of the sum of the contact forces; `uneven`: the largest
    relative difference of a contact pressure from `exact` where the formula `where` of the rest positions is
    true; or `peak`: the largest pressure.
    """
    grid = results.final
    if table["of"] == "force":
        return grid.arrays["contact_force"][:, table["component"]].sum()
    pressure = grid.arrays["contact_pressure"]
    if table["of"] == "peak":
        return pressure.max()
    return np.abs(pressure[formula(table["where"], grid.points)] / table["exact"] - 1.0).max()


def distance_under(pressure, thickness, stiffness):
    """The distance at which a contact layer has a pressure (theory.md, formula (31c))."""
    low, high = 0.0, 1.0
    for _ in range(100):
        r = 0.5 * (low + high)
        is_above = stiffness * (2.0 * (r - 1.0) * np.log(r) + (r - 1.0) ** 2 / r) > pressure
        low, high = (r, high) if is_above else (low, r)
    return high * thickness


def hertz(results, table):
    """A rigid ball in a quarter of a block, divided by what Hertz says.

    The corners of quadratic faces, which have a thousandth of the area, do not count for the largest pressure.
    `of` is `force`, at the approach δ: the way of the ball minus the compression of its layer under the
    largest pressure, plus what a half-space sinks at the depth `depth`, where the block is held (Boussinesq:
    F (1 + ν)(3 − 2ν)/(2π E depth)). Or it is `pressure`: the largest pressure, at the force that there is.
    """
    modulus, nu, radius = table["modulus"], table["nu"], table["radius"]
    plane = modulus / (1.0 - nu ** 2)
    forces = np.abs(results.final.arrays["contact_force"][:, 1])
    pressures = results.final.arrays["contact_pressure"]
    areas = np.divide(forces, pressures, out=np.zeros_like(forces), where=pressures > 0.0)
    force, peak = 4.0 * forces.sum(), pressures[areas > 0.01 * areas.max()].max()
    if table["of"] == "pressure":
        return peak / np.cbrt(6.0 * force * plane ** 2 / (np.pi ** 3 * radius ** 2))
    layer = results.summary["scene"]["obstacle"][0]
    thickness, stiffness = layer["thickness"], layer["stiffness"]
    approach = table["way"] - (thickness - distance_under(peak, thickness, stiffness))
    approach += force * (1.0 + nu) * (3.0 - 2.0 * nu) / (2.0 * np.pi * modulus * table["depth"])
    return force / (4.0 / 3.0 * plane * np.sqrt(radius) * approach ** 1.5)


KINDS = {function.__name__: function
         for function in (probe, history, summary, frequency, torque, field, nodal, period, line, peak, order, rate,
                          impact, impacts, contact, hertz)}
