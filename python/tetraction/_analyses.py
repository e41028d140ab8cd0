"""Runs, equilibria, normal modes and step-size studies."""

import json
import os
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core, _scene
from ._mesh import Mesh, mesh_of
from ._session import Session

_Path = str | os.PathLike[str]


def run(scene: _scene.Scene | _Path, out: _Path | None = None, *, points: ArrayLike | None = None,
        tetrahedra: ArrayLike | None = None, mesh: Mesh | None = None, copy: bool = True,
        observers: Sequence[Callable[[Session], object]] = ()) -> Session:  # fmt: skip
    """Runs a scene to its end, as ``tetraction run`` does.

    Parameters
    ----------
    scene : Scene or path-like
    out : path-like, optional
        A directory for history.csv, frames, final.vtu and summary.json. Without it no files are written.
    points, tetrahedra, mesh, copy
        As in Session.
    observers : callables
        As in Session.run.

    Returns
    -------
    Session
        At the end of the run; `status` and `message` say how it ended.
    """
    session = Session(scene, points, tetrahedra, mesh=mesh, copy=copy)
    session.run(observers=observers, out=out)
    return session


def static(scene: _scene.Scene | _Path, out: _Path | None = None, *,
           points: ArrayLike | None = None, tetrahedra: ArrayLike | None = None,
           mesh: Mesh | None = None, copy: bool = True, steps: int = 1) -> Session:  # fmt: skip
    """Finds the stable equilibrium of a scene under its loads at t = 0, as ``tetraction static`` does.

    At least `steps` load steps are made. The result is a Session whose `load_path` has the load factor that
    was reached. Raises NumericalError if there is no equilibrium under the full loads.
    """
    if not steps >= 1:
        raise _core.InputError(f"static: the number of load steps must be 1 or more, not {steps}.")
    session = Session(scene, points, tetrahedra, mesh=mesh, copy=copy, _static=True, _increment=1.0 / steps)
    session.run(out=out)
    if session.status != "ok":
        raise _core.NumericalError(session.message)
    return session


@dataclass(frozen=True)
class Modes:
    """Normal modes in the order of their frequencies; one entry for each mode in every array.

    Attributes
    ----------
    frequencies : array (k,)
        Hz. For an unstable mode the rate of growth over 2π.
    kinds : list of str
        "rigid", "mechanism", "elastic", "unstable" or "flutter".
    shapes : array (k, n, 3)
        Displacements with unit modal mass, kg^(-1/2).
    effective_masses : array (k, 3)
        Effective modal masses along x, y and z, kg.
    damping_ratios : array (k,)
        Parts of the critical damping.
    round_off : array (k,)
        Relative errors of the frequencies by round-off, estimated.
    positions : array (n, 3)
        The positions about which the body vibrates, m.
    moved_mass : tuple of 3
        What the effective masses of all modes add up to, kg.
    warning : str
        That round-off spoils frequencies, or empty.
    """

    frequencies: NDArray[np.float64]
    kinds: list[str]
    shapes: NDArray[np.float64]
    effective_masses: NDArray[np.float64]
    damping_ratios: NDArray[np.float64]
    round_off: NDArray[np.float64]
    positions: NDArray[np.float64]
    moved_mass: tuple[float, float, float]
    warning: str


def modes(scene: _scene.Scene | _Path, count: int = 10, *, points: ArrayLike | None = None,
          tetrahedra: ArrayLike | None = None, mesh: Mesh | None = None, copy: bool = True,
          loaded: bool = False) -> Modes:  # fmt: skip
    """The `count` lowest normal modes of the body of a scene.

    They are those about the body at rest or, with `loaded`, about its equilibrium under the loads at t = 0.
    Ctrl-C ends the computation, at the latest after the factorisation of a matrix.
    """
    scene = _of(scene).copy()
    core_mesh, _arrays = mesh_of(points, tetrahedra, mesh, copy)
    compiled = scene._compiled(has_mesh=core_mesh is not None)
    with scene._messages():
        return Modes(**_core.modes(compiled, core_mesh, int(count), bool(loaded)))


class Study:
    """The result of a step-size study.

    Attributes
    ----------
    table : structured array
        One row for each run: integrator, step, status, position_error and all other columns of study.csv
        (docs/outputs.md).
    conclusions : list of str
        What follows from the numbers.
    stable_step : float
        The stability limit of explicit steps, s.
    data : dict
        The content of study.json.
    directory : str or None
        Where its files are.
    """

    def __init__(self, data: dict[str, Any], csv_text: str, text: str, directory: str | None) -> None:
        self.data = data
        self.directory = directory
        sentences = [entry["sentences"] for entry in data.get("conclusions", [])]
        self.conclusions: list[str] = [
            text for part in sentences for text in ([part] if isinstance(part, str) else part)]
        self.stable_step: float | None = data.get("stable_step")
        self.table = _table(csv_text)
        self._text = text

    def __str__(self) -> str:
        return self._text

    def __repr__(self) -> str:
        return f"<Study of {len(self.table)} runs>"

    def plot(self, column: str = "position_error", axes: Any = None) -> Any:
        """Draws a column over the step, a line for each integrator, and returns the axes of matplotlib."""
        import matplotlib.pyplot as plt

        if axes is None:
            _, axes = plt.subplots()
        for integrator in dict.fromkeys(self.table["integrator"]):
            rows = self.table[self.table["integrator"] == integrator]
            rows = rows[(rows["status"] == "ok") & (rows[column] > 0)]
            axes.loglog(rows["step"], rows[column], "o-", label=integrator)
        if self.stable_step:
            axes.axvline(self.stable_step, color="gray", linestyle=":", label="stability limit")
        axes.set_xlabel("step [s]")
        axes.set_ylabel(column.replace("_", " "))
        axes.legend()
        return axes

    def write_plots(self) -> None:
        """Draws the plots of ``tetraction study`` into its directory, as PNG, SVG and PDF files."""
        if self.directory is None:
            raise _core.InputError("The study has no directory: give `out`, since plots need its runs.")
        script = os.path.join(os.path.dirname(__file__), "_plot_study.py")
        subprocess.run([sys.executable, script, self.directory], check=True)


def study(scene: _scene.Scene | _Path,
          integrators: Sequence[str] = (), steps: Sequence[float] = (), *, out: _Path | None = None,
          reference_step: float | None = None, reference_integrator: str = "midpoint",
          reference: str = "run", error_probe: str = "", points: ArrayLike | None = None,
          tetrahedra: ArrayLike | None = None, mesh: Mesh | None = None, copy: bool = True,
          progress: Callable[[int, int, str, float], object] | None = None) -> Study:  # fmt: skip
    """Runs a scene with several integrators and steps, and compares each run with a reference.

    Parameters
    ----------
    scene : Scene or path-like
    integrators : sequence of str
        Without any: all.
    steps : sequence of float
        Seconds. Without any, a ladder of steps is chosen for each integrator, with errors of 0.1 to 10 %.
    out : path-like, optional
        A directory for the files of the runs, study.csv and study.json.
    reference_step : float, optional
        Seconds; by default the finest step.
    reference_integrator : str
    reference : str
        "run", or "richardson": the extrapolation of three runs, with an estimate of its error.
    error_probe : str
        A probe of the scene whose error gives the observed orders, instead of the positions.
    progress : function, optional
        Called before each run with its number, the number of runs, the integrator and the step.

    Returns
    -------
    Study
    """
    scene = _of(scene).copy()
    core_mesh, _arrays = mesh_of(points, tetrahedra, mesh, copy)
    compiled = scene._compiled(has_mesh=core_mesh is not None)
    out = None if out is None else os.fspath(out)
    with scene._messages():
        data, csv_text, text = _core.study(
            compiled, core_mesh, list(integrators), [float(step) for step in steps], reference_step,
            reference_integrator, reference, error_probe, out or "", scene._name, progress)  # fmt: skip
    return Study(json.loads(data), csv_text, text, out)


def _of(scene: _scene.Scene | _Path) -> _scene.Scene:
    return scene if isinstance(scene, _scene.Scene) else _scene.read_scene(scene)


def _table(text: str) -> NDArray[Any]:
    """Comma-separated values as a structured array. Columns of numbers are float64; empty is NaN."""
    import csv
    import io

    rows = list(csv.DictReader(io.StringIO(text)))
    names = list(rows[0]) if rows else []
    columns: list[NDArray[Any]] = []
    for name in names:
        values = [row[name] for row in rows]
        try:
            columns.append(np.array([float(v) if v else np.nan for v in values]))
            if all(not v for v in values):
                columns[-1] = np.array([""] * len(values)) if name in _TEXTS else columns[-1]
        except ValueError:
            columns.append(np.array(values))
    kinds = [(name, column.dtype) for name, column in zip(names, columns)]
    table = np.empty(len(rows), dtype=kinds)
    for name, column in zip(names, columns):
        table[name] = column
    return table


_TEXTS = ("variant", "integrator", "solver", "status", "role", "directory", "message")
