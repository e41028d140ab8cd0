"""Edits: changes of a run between two steps.

Each is one event of a scene file (docs/scene.md, [[event]]), which happens now.
"""

from collections.abc import Sequence
from typing import Any

from . import _core, _settings
from ._scene import CustomMaterial


class Edit:
    """A change between two steps. `entry` is what [[event]] would have for it, without `at`.

    Lists, dicts and arrays in it are copied.
    """

    def __init__(self, entry: dict[str, Any]) -> None:
        self.entry = _settings.owned(entry)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.entry!r})"


class Set(Edit):
    """Changes keys of the scene: ``Set({"damping.viscosity": 20.0, "time.step": 1e-4})``.

    The keys in `unset` get their defaults.
    """

    def __init__(self, values: dict[str, Any] | None = None, *, unset: Sequence[str] = ()) -> None:
        entry: dict[str, Any] = {}
        if values:
            entry["set"] = dict(values)
        if unset:
            entry["unset"] = list(unset)
        super().__init__(entry)


class SetMaterial(Edit):
    """Changes keys of the material; the others stay. A new law without its parameters needs all of them.

    ``SetMaterial(youngs_modulus=2e6)``; ``SetMaterial(region=1, mu=1e5)`` for the first [[material_region]];
    ``SetMaterial(custom=my_material)`` for one that is written in Python. The density cannot change.
    """

    def __init__(self, *, region: int = 0, custom: CustomMaterial | None = None,
                 **values: Any) -> None:  # fmt: skip
        if custom is not None and values:
            raise _core.InputError(
                f"SetMaterial: give either custom or keys of a law; {', '.join(values)} cannot be combined with "
                "custom.")
        self.region = region
        self.custom = custom
        prefix = "material" if region == 0 else f"material_region.{region - 1}"
        entry = {"set": {f"{prefix}.{k}": v for k, v in values.items() if v is not None}}
        super().__init__(entry)


class Unfix(Edit):
    """Releases vertices from every [[fix]], or only from the one with the number `fix`."""

    def __init__(self, select: Any = None, *, fix: int | None = None) -> None:
        select = {"all": True} if select is None else select
        super().__init__({"unfix": {"select": select, "fix": fix}})


class RemoveConstraint(Edit):
    """Removes the constraint with this number. The others keep their numbers."""

    def __init__(self, index: int) -> None:
        super().__init__({"remove_constraint": int(index)})


class RemoveObstacle(Edit):
    """Removes the obstacle with this number. The others keep their numbers."""

    def __init__(self, index: int) -> None:
        super().__init__({"remove_obstacle": int(index)})


class SetMomentum(Edit):
    """Sets the momentum of every selected vertex, kg m/s."""

    def __init__(self, select: Any, value: Sequence[float]) -> None:
        super().__init__({"momentum": {"select": select, "value": value}})


class Shift(Edit):
    """Moves single vertices by `displacement` (k, 3), m, and gives them impulses (k, 3), N s.

    `vertices` are numbers of the mesh file, as in selections: Session.vertex_ids has that of each row.
    """

    def __init__(self, vertices: Any, *, displacement: Any = None, impulse: Any = None) -> None:
        super().__init__({"shift": {"vertices": vertices, "displacement": displacement,
                                    "impulse": impulse}})  # fmt: skip
