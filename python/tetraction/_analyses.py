"""Runs, equilibria and normal modes."""

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass

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


def _of(scene: _scene.Scene | _Path) -> _scene.Scene:
    return scene if isinstance(scene, _scene.Scene) else _scene.read_scene(scene)
