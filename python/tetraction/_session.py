"""Sessions: runs that are stepped, looked at and changed."""

import os
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core, _scene
from ._edits import Edit, SetMaterial
from ._mesh import Mesh, mesh_of


class Session:
    """Moves one body through time: make steps, read the state, make edits.

    Parameters
    ----------
    scene : Scene or path-like
        What to run. Later changes of the object have no effect on the session.
    points : array (n, 3), float64, optional
        Rest positions, m, instead of the scene's mesh. The array is not copied and must not change while the
        session lives.
    tetrahedra : array (m, 4), int32 or int64, optional
        The vertices of each tetrahedron, from 0, with positive volumes. The array is not copied.
    mesh : Mesh, optional
        Instead of both.
    history : bool
        Whether to store the history and the probes of each step.

    Raises
    ------
    InputError
        For errors in the scene or in the mesh.
    FileError
        For a file that is missing or malformed.
    """

    def __init__(self, scene: "_scene.Scene | str | os.PathLike[str]", points: ArrayLike | None = None,
                 tetrahedra: ArrayLike | None = None, *, mesh: Mesh | None = None,
                 history: bool = True, _static: bool = False, _increment: float = 1.0) -> None:  # fmt: skip
        if not isinstance(scene, _scene.Scene):
            scene = _scene.read_scene(scene)
        self._scene = scene.copy()
        self._tables = self._scene.to_dict()
        self._own_events: list[dict[str, Any]] = []
        core_mesh, arrays = mesh_of(points, tetrahedra, mesh)
        self._has_mesh = core_mesh is not None
        compiled = self._scene._compiled(self._tables, has_mesh=self._has_mesh)
        with self._scene._messages():
            self._core = _core.Session(compiled, core_mesh, _static, _increment, history, arrays)

    # Steps

    def step(self, count: int = 1) -> int:
        """Makes up to `count` steps and returns how many were made.

        Fewer are made at the end of the run and if a step fails; `status` and `message` say which. Other
        threads of Python run meanwhile, and Ctrl-C raises KeyboardInterrupt between two steps.
        """
        return self._core.step(count)

    def run(self, *, observers: Sequence[Callable[["Session"], object]] = (),
            out: str | os.PathLike[str] | None = None) -> str:  # fmt: skip
        """Steps to the end of the run and returns the status.

        Parameters
        ----------
        observers : callables
            Each is called with the session after each step. The run ends if one returns False. An
            exception ends the run and passes through.
        out : path-like, optional
            A directory for the files that ``tetraction run`` writes.
        """
        out = "" if out is None else os.fspath(out)
        self._core.run(list(observers), out, self)
        return self.status

    def apply(self, edit: Edit | dict[str, Any]) -> None:
        """Makes an edit, which takes effect with the next step.

        The balance records the jump of the energy as edit work. Raises InputError, and changes nothing, if
        the body does not allow the edit.
        """
        if isinstance(edit, dict):
            edit = Edit(edit)
        if isinstance(edit, SetMaterial) and edit.custom is not None:
            self._core.set_material(edit.region, edit.custom._core)
            return
        entry = {"at": self.time, **_without_none(edit.entry)}
        # Events of the same time happen in the order of the list: those of the scene that are still to
        # come follow.
        own = [*self._own_events, entry]
        events = [*own, *self._tables.get("event", [])]
        order = sorted(range(len(events)), key=lambda i: events[i]["at"])
        compiled = self._scene._compiled({**self._tables, "event": events}, has_mesh=self._has_mesh)
        with self._scene._messages():
            self._core.apply(compiled, order.index(len(own) - 1))
        self._own_events = own

    def set(self, values: dict[str, Any] | None = None, /, **sections: Any) -> None:
        """Changes keys of the scene: ``session.set({"damping.viscosity": 20.0})``."""
        self.apply(Edit({"set": {**(values or {}), **sections}}))

    def checkpoint(self) -> object:
        """All that a session of the same scene and mesh needs to go on from here with the same bits."""
        return self._core.checkpoint(), list(self._own_events)

    def restore(self, checkpoint: Any) -> None:
        """Goes on from a checkpoint of this session, or of one of the same scene and mesh."""
        core, events = checkpoint
        self._core.restore(core)
        self._own_events = list(events)

    def go_back(self) -> None:
        """Makes the last good state the present one after a step that failed."""
        self._core.go_back()

    # State

    @property
    def positions(self) -> NDArray[np.float64]:
        """Present positions, m: a view (n, 3) that follows the run and cannot be written to."""
        return self._core.positions

    @property
    def velocities(self) -> NDArray[np.float64]:
        """Velocities of the last step, m/s: a view (n, 3) that cannot be written to."""
        return self._core.velocities

    @property
    def momenta(self) -> NDArray[np.float64]:
        """Momenta, kg m/s: a view (n, 3) that cannot be written to."""
        return self._core.momenta

    @property
    def displacements(self) -> NDArray[np.float64]:
        """Present positions less rest positions, m (n, 3)."""
        return self.positions - self.rest_positions

    @property
    def rest_positions(self) -> NDArray[np.float64]:
        """Rest positions, m (n, 3)."""
        return self._core.rest_positions

    @property
    def tetrahedra(self) -> NDArray[np.integer[Any]]:
        """The vertices of each tetrahedron: (m, 4), or (m, 10) for quadratic ones in the order of VTK."""
        return self._core.tetrahedra

    @property
    def masses(self) -> NDArray[np.float64]:
        """The mass of each vertex, kg (n,)."""
        return self._core.masses

    @property
    def reactions(self) -> NDArray[np.float64]:
        """Forces of constraints on the vertices in the last step, N (n, 3)."""
        return self._core.reactions

    @property
    def external_forces(self) -> NDArray[np.float64]:
        """User forces on the vertices in the last step, N (n, 3)."""
        return self._core.external_forces

    def element_fields(self) -> dict[str, NDArray[np.float64]]:
        """Fields of the elements: a dict of arrays.

        cauchy_stress (m, 6), Pa, and green_strain (m, 6) with the components XX YY ZZ XY YZ XZ; von_mises
        (m,), Pa; jacobian (m,); energy_density (m,), J/m³.
        """
        return self._core.element_fields()

    # Numbers

    @property
    def time(self) -> float:
        """Time of the state, s; of an equilibrium the load factor."""
        return self._core.time

    @property
    def step_number(self) -> int:
        """Number of steps made."""
        return self._core.step_number

    @property
    def time_step(self) -> float:
        """Size of the next step, s."""
        return self._core.time_step

    @property
    def stable_step(self) -> float:
        """The stability limit of explicit steps at the initial state, s."""
        return self._core.stable_step

    def current_stable_step(self) -> float:
        """The same at the present state, s; computed anew."""
        return self._core.current_stable_step()

    @property
    def energies(self) -> dict[str, float]:
        """Energies by name, J: kinetic, elastic, environment, those of further terms, total."""
        return self._core.energies

    @property
    def balance(self) -> dict[str, Any]:
        """The balance of energy and momenta so far: a dict; docs/outputs.md has the meanings."""
        return self._core.balance

    @property
    def history(self) -> dict[str, NDArray[np.float64]]:
        """Columns of the history by name, one value for the start and for each step.

        They are those of history.csv (docs/outputs.md).
        """
        return self._core.history

    @property
    def probes(self) -> dict[str, NDArray[np.float64]]:
        """The scene's probes by the column names of probes.csv, with step and time.

        One value for the start and for each step, NaN where a probe is not due.
        """
        return self._core.probes

    @property
    def status(self) -> str:
        """"running", "ok", "unstable", "failed" or "interrupted"."""
        return self._core.status

    @property
    def message(self) -> str:
        """What ended the run and what to do; empty if nothing went wrong."""
        return self._core.message

    @property
    def failure(self) -> dict[str, Any] | None:
        """The step that failed: a dict, or None."""
        return self._core.failure

    @property
    def warnings(self) -> list[str]:
        """Warnings for the user: a list of texts."""
        return self._core.warnings

    @property
    def load_path(self) -> dict[str, Any] | None:
        """What the load steps of an equilibrium found: a dict, or None for a motion."""
        return self._core.load_path

    # Meshes of other packages

    def to_vtk(self) -> Any:
        """The present shape as a vtkUnstructuredGrid with displacement and velocity."""
        from ._export import to_vtk

        return to_vtk(self)

    def to_meshio(self) -> Any:
        """The present shape as a meshio.Mesh with displacement and velocity."""
        from ._export import to_meshio

        return to_meshio(self)

    def to_pyvista(self) -> Any:
        """The present shape as a pyvista.UnstructuredGrid."""
        from ._export import to_pyvista

        return to_pyvista(self)

    def __repr__(self) -> str:
        return (f"<Session at {self.time:.6g} s, step {self.step_number}, "
                f"{len(self.masses)} vertices, {self.status}>")


def _without_none(value: Any) -> Any:
    if isinstance(value, dict):
        return {k: _without_none(v) for k, v in value.items() if v is not None}
    return value


