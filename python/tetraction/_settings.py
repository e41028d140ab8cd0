"""The sections of a scene as Python objects.

Their keys, defaults and meanings are those of the scene file: the classes are made from the tables of the
library, from which docs/scene.md is made, too.
"""

import copy
import difflib
import tomllib
from typing import Any, ClassVar

import numpy as np

from . import _core

__all__ = [
    "Amplitude", "BodyForce", "Constraint", "Damping", "Environment", "Event", "Fix", "Force",
    "Generator", "Initial", "Material", "MaterialRegion", "MeshSettings", "Moment", "Momentum",
    "Output", "Pressure", "Probe", "Solver", "Time", "Traction",
]


class Settings:
    """A section of a scene: keys with values, as attributes or as keyword arguments.

    A key that has not been set has its default. Values are checked when the scene is used, because many
    checks concern several keys. Lists, dicts and arrays are copied when they are set.
    """

    _section: ClassVar[str] = ""
    _keys: ClassVar[dict[str, tuple[str, str, str, str]]] = {}  # name: (type and unit, default as TOML, what its absence means, meaning)

    def __init__(self, **values: Any) -> None:
        object.__setattr__(self, "_values", {})
        for name, value in values.items():
            setattr(self, name, value)

    @classmethod
    def _check_key(cls, name: str) -> None:
        if name in cls._keys:
            return
        near = difflib.get_close_matches(name, cls._keys, 1)
        hint = f"did you mean {near[0]!r}?" if near else f"there are {', '.join(cls._keys)}."
        raise _core.InputError(f"{cls.__name__} has no key {name!r}: {hint}")

    def __setattr__(self, name: str, value: Any) -> None:
        self._check_key(name)
        if value is None:
            self._values.pop(name, None)
        else:
            self._values[name] = owned(value)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        if name not in self._keys:
            raise AttributeError(f"{type(self).__name__} has no key {name!r}")
        if name in self._values:
            return self._values[name]
        default = self._keys[name][1]
        return _constant(tomllib.loads(f"x = {default}")["x"]) if default else None

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self._keys]

    def __eq__(self, other: object) -> bool:
        return type(self) is type(other) and self._values == other._values

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        inside = ", ".join(f"{name}={value!r}" for name, value in self._values.items())
        return f"{type(self).__name__}({inside})"

    def to_dict(self) -> dict[str, Any]:
        """The keys that have been set, as plain Python values."""
        return {name: plain(value) for name, value in self._values.items()}

    def copy(self) -> "Settings":
        """A copy whose values can be changed by themselves."""
        return copy.deepcopy(self)


def _constant(value: Any) -> Any:
    """Lists as tuples: a change within a default would be lost."""
    return tuple(_constant(entry) for entry in value) if isinstance(value, list) else value


def owned(value: Any) -> Any:
    """The value with copies of the lists, dicts and arrays in it, which their owner may change later."""
    if isinstance(value, np.ndarray):
        return value.copy()
    if isinstance(value, dict):
        return {key: owned(entry) for key, entry in value.items()}
    if isinstance(value, list):
        return [owned(entry) for entry in value]
    if type(value) is tuple:
        return tuple(owned(entry) for entry in value)
    return value


def plain(value: Any) -> Any:
    """The value with settings as mappings."""
    if isinstance(value, Settings):
        return value.to_dict()
    if isinstance(value, dict):
        return {key: plain(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(entry) for entry in value]
    return value


def _class_of(name: str, section: str, more: tuple[str, ...] = ()) -> Any:
    """The class of settings of a section, with the keys of further sections."""
    keys = {}
    for part in (*more, section):
        for key, kind, standard, absent, meaning in _core.section_keys(part):
            keys[key] = (kind, standard, absent, meaning)
    lines = [f"The keys of the section [{section}] of a scene.", "", "Attributes", "----------"]
    for key, (kind, standard, absent, meaning) in keys.items():
        default = f"default {standard}" if standard else absent
        lines += [f"{key} : {kind.replace('`', '')}", f"    {meaning} ({default})"]
    return type(name, (Settings,), {
        "_section": section, "_keys": keys, "__doc__": "\n".join(lines), "__module__": "tetraction",
    })  # fmt: skip


MeshSettings = _class_of("MeshSettings", "mesh")
Generator = _class_of("Generator", "mesh.generate")
Material = _class_of("Material", "material")
MaterialRegion = _class_of("MaterialRegion", "material_region", ("material",))
MaterialRegion._keys["material"] = (
    "CustomMaterial", "", "–", "a material that is written in Python, instead of the keys of a law")
Time = _class_of("Time", "time")
Solver = _class_of("Solver", "solver")
Environment = _class_of("Environment", "environment")
Damping = _class_of("Damping", "damping")
Fix = _class_of("Fix", "fix")
Constraint = _class_of("Constraint", "constraint")
Force = _class_of("Force", "force")
Moment = _class_of("Moment", "moment")
Traction = _class_of("Traction", "traction")
Pressure = _class_of("Pressure", "pressure")
BodyForce = _class_of("BodyForce", "body_force")
Amplitude = _class_of("Amplitude", "amplitude")
Initial = _class_of("Initial", "initial")
Momentum = _class_of("Momentum", "initial.momentum")
Event = _class_of("Event", "event")
ShiftSettings = _class_of("Shift", "shift")
Output = _class_of("Output", "output")
Probe = _class_of("Probe", "probe")


class LoadLists:
    """The loads of a scene: a list for each kind."""

    force: list[Force]
    moment: list[Moment]
    traction: list[Traction]
    pressure: list[Pressure]
    body_force: list[BodyForce]


LOADS = {kind._section: kind for kind in (Force, Moment, Traction, Pressure, BodyForce)}
