"""Scenes: what a run computes."""

import contextlib
import copy
import difflib
import os
import tomllib
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _core, _settings
from ._toml import document_text

_SINGLE = _settings.SINGLE
_LISTS = _settings.LISTS
_NAMES = [*_SINGLE, *_LISTS, "selection", "force_field"]


_Function = Callable[..., NDArray[Any]]
_FieldFunction = Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.float64]]


class _Functions:
    """Functions of the user that the library calls. The library does not keep this object: materials and
    fields do, which the collector of Python sees."""

    def __init__(self, **functions: Any) -> None:
        self.__dict__.update(functions)

    def __getattr__(self, name: str) -> Any:  # for type checkers
        raise AttributeError(name)


class CustomMaterial:
    """A hyperelastic material that is written in Python.

    The three functions get many deformation gradients F at once, an array of the shape (n, 3, 3), at which
    the energy density is defined. They must be derivatives of each other, which is tested at some F.

    With `with_places` the law may differ from element to element, as with fibres. All functions then get two more
    arrays: the number of the element that each F belongs to, a row of ``Session.tetrahedra``, (n,), and where
    it is evaluated at rest, m, (n, 3): the centroid of a linear tetrahedron, or one of four points of a
    quadratic one. The functions are tested at some elements when a body is made.

    The functions are called with the interpreter's lock held, so that other threads of Python wait. An
    exception that they raise ends the step, passes through, and leaves the state as it was.

    Parameters
    ----------
    energy : function
        Ψ(F), J/m³, of the shape (n,). Its value at F = 1 does not matter.
    stress : function
        P = ∂Ψ/∂F, the first Piola-Kirchhoff stress, Pa, of the shape (n, 3, 3).
    stiffness : function
        ∂P/∂F, Pa, of the shape (n, 3, 3, 3, 3): [:, i, J, k, L] = ∂P_iJ/∂F_kL.
    mu, lambda_ : float
        The Lamé parameters for small strains, Pa: scales of tolerances, and what damping.ratio refers to.
    density : float
        kg/m³.
    admissible : function, optional
        Where Ψ is defined, of the shape (n,). By default where det F > 0.
    with_places : bool
        Whether the functions are functions of F, element and position.
    name : str
        For messages.
    """

    def __init__(self, energy: _Function, stress: _Function, stiffness: _Function, *, mu: float,
                 lambda_: float, density: float = 1000.0, admissible: _Function | None = None,
                 with_places: bool = False, name: str = "custom") -> None:  # fmt: skip
        self.name = name
        self.mu, self.lambda_ = float(mu), float(lambda_)
        self.density = float(density)
        if not with_places:
            _check_batches(name, energy, stress, stiffness, float(mu), float(lambda_))
        self._functions = _Functions(energy=energy, stress=stress, stiffness=stiffness,
                                     admissible=admissible)  # fmt: skip
        self._core = _core.CustomMaterial(name, mu, lambda_, self._functions, bool(with_places))

    # A law of the user's own is not copied.
    def __deepcopy__(self, memo: Any) -> "CustomMaterial":
        return self


def _check_batches(name: str, energy: _Function, stress: _Function, stiffness: _Function, mu: float,
                   lambda_: float) -> None:  # fmt: skip
    """Each of many F must have its own values, which are finite and of the order of the parameters."""
    random = np.random.default_rng(1)
    F = np.eye(3) + 0.05 * random.uniform(-1, 1, (7, 3, 3))
    for function, what, shape in ((energy, "energy", ()), (stress, "stress", (3, 3)),
                                  (stiffness, "stiffness", (3, 3, 3, 3))):  # fmt: skip
        together = np.asarray(function(F.copy()), dtype=float)
        if together.shape != (len(F), *shape):
            raise _core.InputError(
                f"{name}: {what} must return an array of the shape {(len(F), *shape)} for {len(F)} F, not "
                f"{together.shape}.")  # fmt: skip
        if not np.isfinite(together).all():
            raise _core.InputError(f"{name}: {what} returns numbers that are not finite for F near 1.")
        alone = np.concatenate([np.asarray(function(f[None]), dtype=float) for f in F])
        if abs(alone - together).max() > 1e-9 * abs(together).max():
            raise _core.InputError(
                f"{name}: {what} has other values for many F at once than for each of them alone. The first "
                "index of the arrays counts the F; look for a sum or an index that mixes them.")
    modulus = abs(np.asarray(stiffness(np.eye(3)[None]), dtype=float)).max()
    given = lambda_ + 2 * mu
    if not 0.01 * given < modulus < 100 * given:
        raise _core.InputError(
            f"{name}: the largest stiffness at F = 1 is {modulus:.3g} Pa, and λ + 2μ of the given parameters is "
            f"{given:.3g} Pa. They must be of the same order: correct mu and lambda_.")


class ForceField:
    """A potential of single vertices that is written in Python.

    Parameters
    ----------
    energy : function
        U(m, q), J, of the shape (n,), for the masses m (n,), kg, and positions q (n, 3), m, of all vertices.
    gradient : function
        ∂U/∂q, N, of the shape (n, 3): minus the force.
    hessian : function
        ∂²U/∂q², N/m, of the shape (n, 3, 3). Implicit steps need it.
    defined : function, optional
        Where U is defined: of positions (n, 3), a truth value for each vertex, (n,). By default everywhere. A step
        that would end elsewhere fails, and the other functions are called only where U is defined at all vertices.
    admissible_fraction : function, optional
        How far vertices may go: of positions q (n, 3) and displacements d (n, 3), the largest t of each vertex,
        (n,), for which U is defined from q to q + t d; infinite where there is no limit. Newton's method needs it
        to stay where U is defined.
    name : str
        Lower-case letters, digits and underscores. The history has the column <name>_energy.
    """

    def __init__(self, energy: _FieldFunction, gradient: _FieldFunction, hessian: _FieldFunction, *,
                 defined: Callable[[NDArray[np.float64]], NDArray[Any]] | None = None,
                 admissible_fraction: _FieldFunction | None = None,
                 name: str = "field") -> None:  # fmt: skip
        self.name = name
        self._functions = _Functions(energy=energy, gradient=gradient, hessian=hessian, defined=defined,
                                     admissible_fraction=admissible_fraction)  # fmt: skip
        self._core = _core.force_field(name, self._functions)

    def _check(self, masses: NDArray[np.float64], positions: NDArray[np.float64]) -> None:
        """Compares the derivatives with differences near these positions, where U is defined.

        The second derivative may jump, such as that of a floor from which vertices lift off. It then agrees with
        the difference to one side.
        """
        name, own = self.name, self._functions
        energy, gradient, hessian = own.energy, own.gradient, own.hessian
        q = np.array(positions)
        size = float(np.ptp(q, axis=0).max())
        for axis in range(3):
            h = next((h for h in (1e-5 * size, 1e-7 * size) if self._is_defined_around(q, axis, h)), None)
            if h is None:
                continue
            d = np.zeros_like(q)
            d[:, axis] = h
            with np.errstate(all="ignore"):
                slope = (energy(masses, q + d) - energy(masses, q - d)) / (2 * h)
                behind, here, ahead = (np.asarray(gradient(masses, at)) for at in (q - d, q, q + d))
                first, second = here[:, axis], np.asarray(hessian(masses, q))[:, :, axis]
            bends = [(ahead - behind) / (2 * h), (ahead - here) / h, (here - behind) / h]
            stiffness = max(abs(part).max() for part in (second, *bends))
            for what, given, differences, size_of in (
                    ("gradient", first, [slope], abs(here).max() + 100 * h * stiffness),
                    ("hessian", second, bends, stiffness)):  # fmt: skip
                error = np.min([abs(given - one) for one in differences], axis=0)
                if error.ndim > 1:
                    error = error.max(axis=1)  # of each vertex
                finite = error[np.isfinite(error)]
                if finite.size and np.median(finite) > 0.01 * size_of + 1e-300:
                    raise _core.InputError(
                        f"{name}: {what} is not the derivative of "
                        f"{'energy' if what == 'gradient' else 'gradient'}: along "
                        f"{'xyz'[axis]} they differ by {np.median(finite):.3g}. The gradient is minus the force.")

    def _is_defined_around(self, q: NDArray[np.float64], axis: int, h: float) -> bool:
        """Whether U is defined at q and h beside it in both directions of an axis."""
        defined = self._functions.defined
        d = h * np.eye(3)[axis]
        return defined is None or all(np.all(defined(at)) for at in (q - d, q, q + d))

    def __deepcopy__(self, memo: Any) -> "ForceField":
        return self


class Scene(_settings.Sections):
    """The description of a run: the sections of a scene file as attributes.

    ``mesh``, ``material``, ``time``, ``solver``, ``damping``, ``environment``, ``initial`` and ``output`` are
    settings. ``material_region``, ``fix``, ``constraint``, ``force``, ``moment``, ``traction``, ``pressure``,
    ``body_force``, ``amplitude``, ``event`` and ``probe`` are lists of them. ``selection`` is a dict of named
    selections. ``force_field`` is a list of :class:`ForceField`. A dict may stand for any settings::

        scene = tt.Scene(material=tt.Material(youngs_modulus=1e6, poissons_ratio=0.3, density=1000),
                         time={"integrator": "midpoint", "step": 1e-3, "end": 1.0})
        scene.fix.append(tt.Fix(select={"plane": {"axis": "x", "at": 0}}))

    A material may be a :class:`CustomMaterial`, that of a region as its key `material`. Paths of files are
    relative to `folder`.
    """

    selection: dict[str, Any]
    force_field: list[ForceField]

    def __init__(self, *, folder: str | os.PathLike[str] = ".", **sections: Any) -> None:
        self._folder = os.fspath(folder)
        self._name = "scene"
        self.selection = {}
        self.force_field = []
        for name, kind in _SINGLE.items():
            setattr(self, name, kind())
        for name in _LISTS:
            setattr(self, name, [])
        for name, value in sections.items():
            setattr(self, name, value)

    def __setattr__(self, name: str, value: Any) -> None:
        if name not in _NAMES and not name.startswith("_"):
            near = difflib.get_close_matches(name, _NAMES, 1)
            raise _core.InputError(
                f"A scene has no section {name!r}: "
                + (f"did you mean {near[0]!r}?" if near else f"there are {', '.join(_NAMES)}."))
        if name in _SINGLE and isinstance(value, dict):
            value = _SINGLE[name](**value)
        if name in _SINGLE and not isinstance(value, (_SINGLE[name], CustomMaterial)):
            raise _core.InputError(f"{name} must be a tetraction.{_SINGLE[name].__name__} or a dict, not {value!r}.")
        if name == "force_field" and not isinstance(value, list):
            value = list(value) if isinstance(value, tuple) else [value]
        if name in _LISTS:
            entries = value if isinstance(value, (list, tuple)) else [value]
            value = [_LISTS[name](**e) if isinstance(e, dict) else e for e in entries]
            for entry in value:
                if not isinstance(entry, _LISTS[name]):
                    raise _core.InputError(
                        f"Entries of {name} must be tetraction.{_LISTS[name].__name__} or dicts, not {entry!r}.")
        object.__setattr__(self, name, value)

    def __repr__(self) -> str:
        return f"Scene({', '.join(f'{k}={v!r}' for k, v in self.to_dict().items())})"

    def copy(self) -> "Scene":
        """A copy that can be changed by itself."""
        return copy.deepcopy(self)

    def to_dict(self) -> dict[str, Any]:
        """The sections that have been set, as plain values with the names of the scene file.

        Of a material that is written in Python there are the name, as `model`, and the density.
        """
        return self._to_tables(lambda material: {"model": material.name, "density": material.density})

    def _tables(self) -> dict[str, Any]:
        """The same with materials that the reader accepts."""
        return self._to_tables(_stand_in)

    def _to_tables(self, custom: Callable[[CustomMaterial], dict[str, Any]]) -> dict[str, Any]:
        result: dict[str, Any] = {}
        for name in _SINGLE:
            value = getattr(self, name)
            if isinstance(value, CustomMaterial):
                value = custom(value)
            if value := _settings.plain(value):
                result[name] = value
        for name in _LISTS:
            entries = [self._entry(entry, custom) for entry in getattr(self, name)]
            if entries:
                result[name] = entries
        if self.selection:
            result["selection"] = _settings.plain(self.selection)
        return result

    @staticmethod
    def _entry(entry: Any, custom: Callable[[CustomMaterial], dict[str, Any]]) -> dict[str, Any]:
        values = _settings.plain(entry)
        if isinstance(values.get("material"), CustomMaterial):
            values.update(custom(values.pop("material")))
        return values

    def to_toml(self) -> str:
        """The scene as the text of a scene file, with defaults filled in."""
        return self._compiled().text(self._folder)

    def _path(self) -> str:
        return os.path.join(self._folder, self._name)

    @contextlib.contextmanager
    def _messages(self) -> Iterator[None]:
        """Names the page of the documentation, and no lines of a text that the user has not seen."""
        try:
            yield
        except _core.InputError as error:
            place, _, rest = str(error).partition(": ")
            text = rest if place.startswith(self._path() + ":") else str(error)
            page = _core.documentation_of(text)
            raise _core.InputError(f"{text} See {page}." if page else text) from None

    def _compiled(self, tables: dict[str, Any] | None = None, *, has_mesh: bool = False,
                  overrides: Sequence[str] = ()) -> Any:  # fmt: skip
        """The scene as the library takes it, from these tables or its own with these overrides, checked."""
        tables = dict(self._tables() if tables is None else tables)
        mesh = dict(tables.get("mesh", {}))
        if has_mesh and not mesh.get("file") and not mesh.get("generate"):
            mesh["generate"] = {"kind": "tetrahedron"}  # the arrays take its place
            tables["mesh"] = mesh
        with self._messages():
            scene = _core.Scene.from_text(document_text(tables), self._path(), list(overrides))
        if isinstance(self.material, CustomMaterial):
            scene.set_material(0, self.material._core)
        for i, region in enumerate(self.material_region):
            if region.material is not None:
                scene.set_material(i + 1, region.material._core)
        for field in self.force_field:
            scene.add_force_term(field._core)
        return scene


def _stand_in(material: CustomMaterial) -> dict[str, Any]:
    """A material that the reader accepts in place of one that is written in Python."""
    return {"model": "neo-hookean", "mu": material.mu, "lambda": material.lambda_,
            "density": material.density}  # fmt: skip


def read_scene(path: str | os.PathLike[str],
               overrides: Sequence[str] | dict[str, Any] = ()) -> Scene:  # fmt: skip
    """Reads a scene file.

    Parameters
    ----------
    path : path-like
        A TOML file. docs/scene.md describes it.
    overrides : sequence of str, or dict
        As after --set on the command line: ["time.step=1e-4"] or {"time.step": 1e-4}.

    Returns
    -------
    Scene
        With the values of the file. Raises FileError and InputError, whose messages name the line.
    """
    path = os.fspath(path)
    if isinstance(overrides, dict):
        from ._toml import value_text

        overrides = [f"{key}={value_text(value)}" for key, value in overrides.items()]
    _core.Scene.read(path, list(overrides))  # all checks, with the lines of the file
    with open(path, "rb") as file:
        tables = tomllib.load(file)
    for override in overrides:
        key, _, text = override.partition("=")
        _put(tables, key.strip().split("."), _override_value(text.strip()))
    scene = Scene(folder=os.path.dirname(path) or ".", **tables)
    scene._name = os.path.basename(path)
    return scene


def _override_value(text: str) -> Any:
    try:
        return tomllib.loads(f"x = {text}")["x"]
    except tomllib.TOMLDecodeError:
        return text


def _put(tables: Any, keys: Sequence[str], value: Any) -> None:
    """Puts a value into nested mappings and lists. Entries of lists have numbers."""
    for key, following in zip(keys[:-1], keys[1:]):
        new: Any = [] if following.isdigit() else {}
        if isinstance(tables, list):
            index = int(key)
            while len(tables) <= index:
                tables.append({})
            if not tables[index] and new == []:
                tables[index] = new
            tables = tables[index]
        else:
            tables = tables.setdefault(key, new)
    if isinstance(tables, list):
        index = int(keys[-1])
        tables[index : index + 1] = [value]
    else:
        tables[keys[-1]] = value
