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


def _class_name(section: str) -> str:
    return "".join(word.capitalize() for word in section.split("_"))


_NAMES = {"mesh": "MeshSettings"}  # a Mesh is a mesh

#: The sections of a scene by their names: those that it has once, and the lists.
SINGLE: dict[str, Any] = {}
LISTS: dict[str, Any] = {}
#: Those that edits can change.
CHANGEABLE: list[str] = []
for _section, _is_list, _may_change in _core.scene_sections():
    _name = _NAMES.get(_section, _class_name(_section))
    _more = ("material",) if _section == "material_region" else ()
    globals()[_name] = (LISTS if _is_list else SINGLE)[_section] = _class_of(_name, _section, _more)
    if _may_change:
        CHANGEABLE.append(_section)
LISTS["material_region"]._keys["material"] = (
    "CustomMaterial", "", "–", "a material that is written in Python, instead of the keys of a law")
LISTS["event"] = Event = _class_of("Event", "event")
Generator = _class_of("Generator", "mesh.generate")
Momentum = _class_of("Momentum", "initial.momentum")
ShiftSettings = _class_of("Shift", "shift")


class Sections:
    """The sections of a scene as attributes. Its types are in _settings.pyi."""
