"""Edits: changes of a run between two steps.

Each is one event of a scene file (docs/scene.md, [[event]]), which happens now.
"""

from . import _settings


class Edit:
    """A change between two steps. `entry` is what [[event]] would have for it, without `at`."""

    def __init__(self, entry):
        self.entry = entry

    def __repr__(self):
        return f"{type(self).__name__}({self.entry!r})"


class Set(Edit):
    """Changes keys of the scene: ``Set({"damping.viscosity": 20.0, "time.step": 1e-4})``."""

    def __init__(self, values=(), *, unset=()):
        entry = {}
        if values:
            entry["set"] = dict(values)
        if unset:
            entry["unset"] = list(unset)
        super().__init__(entry)


def _section_edit(name, section, number=None):
    """An edit that changes keys of a section, or of entry number `index` of a list."""

    class SectionEdit(Edit):
        def __init__(self, index=None, /, **values):
            if number is not None and index is None:
                super().__init__({section: _settings.plain(values)})
                return
            prefix = section if index is None else f"{section}.{int(index)}"
            super().__init__({"set": {f"{prefix}.{k}": v for k, v in values.items()}})

    SectionEdit.__name__ = SectionEdit.__qualname__ = name
    SectionEdit.__module__ = "tetraction"
    if number is None:
        SectionEdit.__doc__ = (
            f"Changes keys of [{section}]; the others stay. ``{name}(key=value, ...)``")
    else:
        SectionEdit.__doc__ = (
            f"Adds a [[{section}]] with these keys, or changes keys of the one with the number in "
            f"front: ``{name}(key=value, ...)``, ``{name}(0, key=value, ...)``.")
    return SectionEdit


SetTime = _section_edit("SetTime", "time")
SetSolver = _section_edit("SetSolver", "solver")
SetDamping = _section_edit("SetDamping", "damping")
SetEnvironment = _section_edit("SetEnvironment", "environment")
SetFix = _section_edit("SetFix", "fix", 0)
SetConstraint = _section_edit("SetConstraint", "constraint", 0)
SetForce = _section_edit("SetForce", "force", 0)
SetMoment = _section_edit("SetMoment", "moment", 0)
SetTraction = _section_edit("SetTraction", "traction", 0)
SetPressure = _section_edit("SetPressure", "pressure", 0)
SetBodyForce = _section_edit("SetBodyForce", "body_force", 0)


class SetMaterial(Edit):
    """Changes keys of the material; the others stay. A new law without its parameters needs all of them.

    ``SetMaterial(youngs_modulus=2e6)``; ``SetMaterial(region=1, mu=1e5)`` for the first [[material_region]];
    ``SetMaterial(custom=my_material)`` for one that is written in Python. The density cannot change.
    """

    def __init__(self, *, region=0, custom=None, **values):
        self.region = region
        self.custom = custom
        prefix = "material" if region == 0 else f"material_region.{region - 1}"
        entry = {"set": {f"{prefix}.{k}": v for k, v in values.items() if v is not None}}
        super().__init__(entry)


class Unfix(Edit):
    """Releases vertices from every [[fix]], or only from the one with the number `fix`."""

    def __init__(self, select=None, *, fix=None):
        select = {"all": True} if select is None else select
        super().__init__({"unfix": {"select": select, "fix": fix}})


class RemoveConstraint(Edit):
    """Removes the constraint with this number. The others keep their numbers."""

    def __init__(self, index):
        super().__init__({"remove_constraint": int(index)})


class SetMomentum(Edit):
    """Sets the momentum of every selected vertex, kg m/s."""

    def __init__(self, select, value):
        super().__init__({"momentum": {"select": select, "value": value}})


class Shift(Edit):
    """Moves single vertices by `displacement` (k, 3), m, and gives them impulses (k, 3), N s."""

    def __init__(self, vertices, *, displacement=None, impulse=None):
        super().__init__({"shift": {"vertices": vertices, "displacement": displacement,
                                    "impulse": impulse}})  # fmt: skip
