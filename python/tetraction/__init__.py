"""Hyperelastic tetrahedral solids in time, by the Hamilton-Pontryagin variational integrator.

::

    import tetraction as tt

    scene = tt.read_scene("spring.toml")
    session = tt.Session(scene)
    session.step(100)
    print(session.time, session.energies, session.positions)

Scenes have the keys of the scene file. Units are those of SI. docs/python.md is the guide.
"""

from . import _core, material
from ._analyses import Modes, modes, run, static
from ._core import Error, FileError, InputError, NumericalError, OutputError
from ._edits import (
    Edit,
    RemoveConstraint,
    RemoveObstacle,
    Set,
    SetMaterial,
    SetMomentum,
    Shift,
    Unfix,
)
from ._mesh import Mesh, read_mesh
from ._scene import CustomMaterial, ForceField, Scene, read_scene
from ._section_edits import (
    SetBodyForce,
    SetConstraint,
    SetDamping,
    SetEnvironment,
    SetFix,
    SetForce,
    SetMoment,
    SetObstacle,
    SetPressure,
    SetPull,
    SetSolver,
    SetTime,
    SetTraction,
)
from ._session import Session
from ._settings import (
    Amplitude,
    BodyForce,
    Constraint,
    Contact,
    Damping,
    Environment,
    Event,
    Fix,
    Force,
    Generator,
    Initial,
    Material,
    MaterialRegion,
    MeshSettings,
    Moment,
    Momentum,
    Obstacle,
    Output,
    Pressure,
    Probe,
    Pull,
    Solver,
    Time,
    Traction,
)
from ._study import Motion, ProbeSeries, Study, read_study, study

__all__ = [
    "Amplitude",
    "BodyForce",
    "Constraint",
    "Contact",
    "CustomMaterial",
    "Damping",
    "Edit",
    "Environment",
    "Error",
    "Event",
    "FileError",
    "Fix",
    "Force",
    "ForceField",
    "Generator",
    "Initial",
    "InputError",
    "Material",
    "MaterialRegion",
    "Mesh",
    "MeshSettings",
    "Modes",
    "Moment",
    "Momentum",
    "Motion",
    "NumericalError",
    "Obstacle",
    "Output",
    "OutputError",
    "Pressure",
    "Probe",
    "ProbeSeries",
    "Pull",
    "RemoveConstraint",
    "RemoveObstacle",
    "Scene",
    "Session",
    "Set",
    "SetBodyForce",
    "SetConstraint",
    "SetDamping",
    "SetEnvironment",
    "SetFix",
    "SetForce",
    "SetMaterial",
    "SetMoment",
    "SetObstacle",
    "SetMomentum",
    "SetPressure",
    "SetPull",
    "SetSolver",
    "SetTime",
    "SetTraction",
    "Shift",
    "Solver",
    "Study",
    "Time",
    "Traction",
    "Unfix",
    "material",
    "modes",
    "read_mesh",
    "read_scene",
    "read_study",
    "run",
    "set_thread_count",
    "static",
    "study",
    "thread_count",
]

__version__ = _core.version


def set_thread_count(count: int) -> None:
    """Sets how many threads the loops over elements use, in all sessions; 0 for one per core."""
    if not isinstance(count, int) or not 0 <= count <= 1024:
        raise InputError(f"The number of threads must be between 0 and 1024, not {count!r}.")
    _core.set_thread_count(count)


def thread_count() -> int:
    """How many threads the loops over elements use."""
    return _core.thread_count()
