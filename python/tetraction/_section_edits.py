"""The edits of the sections of a scene, one class for each: SetTime, SetFix, ….

python/write_stub.py writes their types, _section_edits.pyi.
"""

from typing import Any, ClassVar

from . import _settings
from ._edits import Edit


class _SectionEdit(Edit):
    _section: ClassVar[str]

    def __init__(self, /, **values: Any) -> None:
        super().__init__({"set": {f"{self._section}.{k}": v for k, v in values.items()}})


class _EntryEdit(Edit):
    _section: ClassVar[str]

    def __init__(self, index: int | None = None, /, **values: Any) -> None:
        if index is None:
            super().__init__({self._section: _settings.plain(values)})
        else:
            prefix = f"{self._section}.{int(index)}"
            super().__init__({"set": {f"{prefix}.{k}": v for k, v in values.items()}})


def _edit_of(section: str) -> Any:
    """The edit of a section of a scene: SetTime of [time], SetForce of [[force]]."""
    kind = _settings.SINGLE.get(section) or _settings.LISTS[section]
    name = f"Set{kind.__name__}"
    base: type[Edit] = _SectionEdit
    text = f"Changes keys of [{section}]; the others stay: ``{name}(key=value)``."
    if section in _settings.LISTS:
        base = _EntryEdit
        text = (f"Adds a [[{section}]], ``{name}(key=value)``, or changes keys of entry i, "
                f"``{name}(i, key=value)``.")
    if section == "obstacle":
        text += (
            "\n\nSession.apply() raises InputError, and changes nothing, if the body would penetrate the obstacle, if "
            "another obstacle has its name, if there is no entry i, for values out of range, for friction with a solver "
            "that only minimises, and in a run whose scene has neither obstacles nor events that add some. A key that is "
            "set of an obstacle which was removed brings it back.")
    return type(name, (base,), {"_section": section, "__doc__": text, "__module__": "tetraction"})


for _section in _settings.CHANGEABLE:
    if not _section.startswith("material"):  # SetMaterial
        _kind = _edit_of(_section)
        globals()[_kind.__name__] = _kind
