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
from ._analyses import Modes, Study, modes, run, static, study
from ._core import Error, FileError, InputError, NumericalError, OutputError
from ._edits import (
    Edit,
    RemoveConstraint,
    Set,
    SetBodyForce,
    SetConstraint,
    SetDamping,
    SetEnvironment,
    SetFix,
    SetForce,
    SetMaterial,
    SetMoment,
    SetMomentum,
    SetPressure,
    SetSolver,
    SetTime,
    SetTraction,
    Shift,
    Unfix,
)
from ._mesh import Mesh, read_mesh
from ._scene import CustomMaterial, ForceField, Scene, read_scene
from ._session import Session
from ._settings import (
    Amplitude,
    BodyForce,
    Constraint,
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
    Output,
    Pressure,
    Probe,
    Solver,
    Time,
    Traction,
)

__version__ = _core.version


def set_thread_count(count):
    """Sets how many threads the loops over elements use, in all sessions."""
    _core.set_thread_count(count)


def thread_count():
    """How many threads the loops over elements use."""
    return _core.thread_count()
