"""Sessions: runs that are stepped, looked at and changed."""

import operator
import os
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core, _scene, _settings
from ._edits import Edit, SetMaterial
from ._mesh import Mesh, mesh_of


class Session:
    """Moves one body through time: make steps, read the state, make edits.

    Parameters
    ----------
    scene : Scene or path-like
        What to run. Later changes of the object have no effect on the session.
    points : array (n, 3), float64, optional
        Rest positions, m, instead of the scene's mesh.
    tetrahedra : array (m, 4), int32 or int64, optional
        The vertices of each tetrahedron, from 0, with positive volumes.
    mesh : Mesh, optional
        Instead of both.
    copy : bool
        Whether the two arrays are copied. With False the session looks at your arrays if they have these types
        and lie contiguously in memory. You then promise that nothing changes their numbers while the session
        lives: results would be wrong, or the program would crash. The arrays are made read-only, but NumPy
        does not protect the array that yours is a view of.
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
                 tetrahedra: ArrayLike | None = None, *, mesh: Mesh | None = None, copy: bool = True,
                 history: bool = True, _static: bool = False, _increment: float = 1.0) -> None:  # fmt: skip
        if not isinstance(scene, _scene.Scene):
            scene = _scene.read_scene(scene)
        self._scene = scene.copy()
        self._tables = self._scene._tables()
        self._custom = {0: isinstance(self._scene.material, _scene.CustomMaterial)}
        for i, region in enumerate(self._scene.material_region):
            self._custom[i + 1] = region.material is not None
        self._own_events: list[dict[str, Any]] = []
        # Laws that edits have set. The library does not keep what is written in Python.
        self._laws: list[_scene.CustomMaterial] = []
        core_mesh, arrays = mesh_of(points, tetrahedra, mesh, copy)
        self._has_mesh = core_mesh is not None
        compiled = self._scene._compiled(self._tables, has_mesh=self._has_mesh)
        with self._scene._messages():
            self._core = _core.Session(compiled, core_mesh, _static, _increment, history, arrays)
        for field in self._scene.force_field:
            field._check(self.masses, self.positions)

    # Steps

    def step(self, count: int = 1) -> int:
        """Makes up to `count` steps and returns how many were made.

        Fewer are made at the end of the run and if a step fails; `status` and `message` say which. Other
        threads of Python run meanwhile, and Ctrl-C raises KeyboardInterrupt between two steps. Raises
        InputError if another thread uses the session.
        """
        return self._core.step(_whole(count, "step: the number of steps"))

    def run(self, *, observers: Sequence[Callable[["Session"], object]] = (),
            out: str | os.PathLike[str] | None = None) -> str:  # fmt: skip
        """Steps to the end of the run and returns the status.

        Parameters
        ----------
        observers : callables
            Each is called with the session after each step and may make edits. The run ends if one returns
            False. An exception, that of Ctrl-C too, ends the run and passes through. Without `out` the
            session can go on in both cases.
        out : path-like, optional
            A directory for the files that ``tetraction run`` writes. They are complete also if an observer
            ends the run.
        """
        if callable(observers):
            observers = [observers]
        out = "" if out is None else os.fspath(out)
        self._core.run(list(observers), out, self)
        return self.status

    def apply(self, edit: Edit | dict[str, Any]) -> None:
        """Makes an edit, which takes effect with the next step.

        Events of the scene that are due at the present time are made first, so that the edit has the last
        word. A session that has reached its end goes on after ``SetTime(end=...)`` with a later end. The
        balance records the jump of the energy as edit work. Raises InputError, and changes nothing, if the
        body does not allow the edit.
        """
        if isinstance(edit, dict):
            edit = Edit(edit)
        if not isinstance(edit, Edit):
            raise _core.InputError(
                f"apply takes an edit, such as tt.SetForce(...) or tt.Set({{...}}), not {type(edit).__name__}.")
        if isinstance(edit, SetMaterial) and edit.custom is not None:
            self._laws.append(edit.custom)
            self._core.set_material(edit.region, edit.custom._core)
            self._custom[edit.region] = True
            return
        plain_laws = self._check_laws(edit.entry.get("set", {}))
        # Events of the same time happen in the order of the list: those of the scene that are due now come
        # before the edit.
        planned = self._tables.get("event", [])
        now = self.time
        due = [e["at"] for e in planned if e["at"] <= now + 1e-6 * self.time_step]
        # The session keeps the entry, and the edit may change afterwards.
        entry = {"at": max([now, *due]), **_settings.owned(_without_none(edit.entry))}
        own = [*self._own_events, entry]
        events = [*planned, *own]
        order = sorted(range(len(events)), key=lambda i: events[i]["at"])
        compiled = self._scene._compiled({**self._tables, "event": events}, has_mesh=self._has_mesh)
        with self._scene._messages():
            self._core.apply(compiled, order.index(len(events) - 1))
        for region in plain_laws:
            self._custom[region] = False
        if not self._becomes_part_of_the_scene(entry):
            self._own_events = own

    def _check_laws(self, values: dict[str, Any]) -> list[int]:
        """The regions that get a law of the library. A key alone cannot change a law written in Python."""
        regions: dict[int, set[str]] = {}
        for key in values:
            parts = key.split(".")
            if parts[0] == "material" and len(parts) > 1:
                regions.setdefault(0, set()).add(parts[1])
            elif parts[0] == "material_region" and len(parts) > 2 and parts[1].isdigit():
                regions.setdefault(int(parts[1]) + 1, set()).add(parts[2])
        for region, keys in regions.items():
            if self._custom.get(region) and "model" not in keys:
                raise _core.InputError(
                    "The material is written in Python and has no such keys. Give the law of the library, "
                    'SetMaterial(model="neo-hookean", ...), or another one of your own, SetMaterial(custom=...).')
        return [region for region, keys in regions.items() if "model" in keys]

    def _becomes_part_of_the_scene(self, entry: dict[str, Any]) -> bool:
        """Whether an edit that was made is now in the tables, so that later edits need not repeat it.

        This holds for loads, steps and solvers, which a program may change after each step.
        """
        if self._tables.get("event") or self._own_events:
            return False
        changed = {key: value for key, value in entry.items() if key != "at"}
        if len(changed) != 1:
            return False
        (kind, value), = changed.items()
        tables: dict[str, Any] = {
            name: list(part) if isinstance(part, list) else dict(part)
            for name, part in self._tables.items()
        }
        if kind in _LOADS and isinstance(value, dict):
            tables.setdefault(kind, []).append(value)
        elif kind == "set" and all(key.split(".")[0] in (*_LOADS, "time", "solver") for key in value):
            for key, own in value.items():
                parts = key.split(".")
                if len(parts) != (3 if parts[0] in _LOADS else 2):
                    return False
                if parts[0] in _LOADS:
                    entries = tables[parts[0]] = [dict(e) for e in tables.get(parts[0], [])]
                    entries[int(parts[1])][parts[2]] = own
                else:
                    tables.setdefault(parts[0], {})[parts[1]] = own
        else:
            return False
        self._tables = tables
        return True

    def set(self, values: dict[str, Any] | None = None, /, **sections: Any) -> None:
        """Changes keys of the scene: ``session.set({"damping.viscosity": 20.0})``."""
        self.apply(Edit({"set": {**(values or {}), **sections}}))

    def checkpoint(self) -> object:
        """All that a session of the same scene and mesh needs to go on from here with the same bits."""
        return (self._core.checkpoint(), list(self._own_events), self._tables, dict(self._custom),
                list(self._laws))  # fmt: skip

    def restore(self, checkpoint: Any) -> None:
        """Goes on from a checkpoint of this session, or of one of the same scene and mesh."""
        if not (isinstance(checkpoint, tuple) and len(checkpoint) == 5):
            raise _core.InputError("restore takes what checkpoint() returned.")
        core, events, tables, custom, laws = checkpoint
        self._laws = [*self._laws, *(law for law in laws if law not in self._laws)]
        self._core.restore(core)
        self._own_events, self._tables, self._custom = list(events), tables, dict(custom)

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
    def vertex_ids(self) -> NDArray[np.int64]:
        """The number that the mesh file, and therefore selections and edits, have for each row (n,)."""
        return self._core.vertex_ids

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

    def fields(self, *names: str) -> dict[str, NDArray[np.float64]]:
        """Fields of the present state by name: a dict of arrays.

        The names are those of output.fields, for instance "von_mises_nodal", and "position". A field has one row
        for each vertex or tetrahedron, and one number in it for a scalar.
        """
        return self._core.fields(list(dict.fromkeys(names)))

    def element_fields(self) -> dict[str, NDArray[np.float64]]:
        """Fields of the elements: a dict of arrays.

        cauchy_stress (m, 6), Pa, and green_strain (m, 6) with the components XX YY ZZ XY YZ XZ; von_mises
        (m,), Pa; jacobian (m,); energy_density (m,), J/m³.
        """
        return self.fields(
            "cauchy_stress", "green_strain", "von_mises", "jacobian", "energy_density")

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


# The loads that an edit can add or change.
_LOADS = ("force", "moment", "traction", "pressure", "body_force")


def _whole(value: Any, what: str) -> int:
    try:
        number = operator.index(value)
    except TypeError:
        raise _core.InputError(f"{what} must be a whole number, not {value!r}.") from None
    if not 0 <= number < 2**62:
        raise _core.InputError(f"{what} must not be negative or huge, but it is {number}.")
    return number


def _without_none(value: Any) -> Any:
    if isinstance(value, dict):
        return {k: _without_none(v) for k, v in value.items() if v is not None}
    return value


