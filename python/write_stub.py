"""Writes the types of the settings of scenes, _settings.pyi, from the library's tables of keys.

Usage: write_stub.py FOLDER_OF_THE_BUILT_PACKAGE
"""

import inspect
import keyword
import os
import sys

folder = sys.argv[1]
sys.path.insert(0, os.path.dirname(folder))
sys.dont_write_bytecode = True

from tetraction import _settings  # noqa: E402


def type_of(kind: str) -> str:
    """The type of a key that docs/scene.md describes with these words."""
    kind = kind.split(", ")[0] if '"auto"' not in kind else "number or name"
    if "text" == kind:
        return "str"
    if kind.startswith("`true`"):
        return "bool"
    if kind == "number":
        return "float"
    if kind in ("number or array", "number or name"):
        return "float | str"
    if kind == "whole number":
        return "int"
    if kind == "list of texts":
        return "Sequence[str]"
    if kind in ("three numbers", "two whole numbers", "list of whole numbers"):
        return "Sequence[float] | NDArray[Any]"
    return "Any"


lines = ["# Made by python/write_stub.py from the library's tables of keys.",
         "from collections.abc import Sequence", "from typing import Any, ClassVar", "",
         "from numpy.typing import NDArray", "", "from ._scene import CustomMaterial", "",
         f"__all__ = {_settings.__all__!r}", "",
         "class Settings:",
         "    _section: ClassVar[str]",
         "    _keys: ClassVar[dict[str, tuple[str, str, str, str]]]",
         "    def to_dict(self) -> dict[str, Any]: ...", "",
         "def owned(value: Any) -> Any: ...",
         "def plain(value: Any) -> Any: ...", ""]  # fmt: skip
for name, kind in vars(_settings).items():
    if not (inspect.isclass(kind) and kind is not _settings.Settings
            and issubclass(kind, _settings.Settings)):  # fmt: skip
        continue
    types = {}
    for key, (words, standard, _absent, _meaning) in kind._keys.items():
        type_name = "CustomMaterial" if words == "CustomMaterial" else type_of(words)
        if not standard and type_name != "Any":
            type_name += " | None"
        types[key] = type_name
    plain_names = {key: value for key, value in types.items() if not keyword.iskeyword(key)}
    lines.append(f"class {name}(Settings):")
    lines += [f"    {key}: {value}" for key, value in plain_names.items()]
    arguments = "".join(f", {key}: {value} = ..." for key, value in plain_names.items())
    # A key that is a word of Python is given as **{"lambda": ...}.
    more = ", **more: Any" if len(plain_names) < len(types) else ""
    lines.append(f"    def __init__(self, *{arguments}{more}) -> None: ...")
    lines.append(f"    def copy(self) -> {name}: ...")
    lines.append("")

lines += ["LOADS: dict[str, type[Settings]]", "", "class LoadLists:"]
for name, kind in inspect.get_annotations(_settings.LoadLists).items():
    lines.append(f"    {name}: list[{kind.__args__[0].__name__}]")
lines.append("")

path = os.path.join(folder, "_settings.pyi")
with open(path + ".part", "w", encoding="utf-8") as file:
    file.write("\n".join(lines))
os.replace(path + ".part", path)
