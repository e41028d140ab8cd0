"""Hyperelastic tetrahedral solids in time, by the Hamilton-Pontryagin variational integrator.

::

    import tetraction as tt

    scene = tt.read_scene("spring.toml")
    session = tt.Session(scene)
    session.step(100)
    print(session.time, session.energies, session.positions)

Scenes have the keys of the scene file. Units are those of SI. docs/python.md is the guide.
"""

from . import _core, _edits, _settings, material
from ._analyses import Modes, Study, modes, run, static, study
from ._core import Error, FileError, InputError, NumericalError, OutputError
from ._edits import *
from ._mesh import Mesh, read_mesh
from ._scene import CustomMaterial, ForceField, Scene, read_scene
from ._session import Session
from ._settings import *

__all__ = [
    "CustomMaterial", "Error", "FileError", "ForceField", "InputError", "Mesh", "Modes",
    "NumericalError", "OutputError", "Scene", "Session", "Study", "material", "modes", "read_mesh",
    "read_scene", "run", "set_thread_count", "static", "study", "thread_count",
]
__all__ += _edits.__all__
__all__ += _settings.__all__

__version__ = _core.version


def set_thread_count(count: int) -> None:
    """Sets how many threads the loops over elements use, in all sessions; 0 for one per core."""
    if not isinstance(count, int) or not 0 <= count <= 1024:
        raise InputError(f"The number of threads must be between 0 and 1024, not {count!r}.")
    _core.set_thread_count(count)


def thread_count() -> int:
    """How many threads the loops over elements use."""
    return _core.thread_count()
