"""Meshes."""

import os
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core


class Mesh:
    """A mesh of tetrahedra: `points` (n, 3), m, and `tetrahedra` (m, 4), or (m, 10) for quadratic ones.

    Made from arrays: float64 for points and int32 or int64 for tetrahedra, numbered from 0, with positive
    volumes, without unused points, and no two with the same vertices. The arrays are copied.

    With ``copy=False`` the mesh looks at your arrays if they have these types and lie contiguously in memory;
    others are converted all the same. You then promise that nothing changes their numbers as long as the mesh
    or a session of it lives: results would be wrong, or the program would crash. The arrays are made
    read-only, but NumPy does not protect the array that yours is a view of.
    """

    def __init__(self, points: ArrayLike, tetrahedra: ArrayLike, *, copy: bool = True) -> None:
        self._arrays: tuple[NDArray[Any], NDArray[Any]] | None
        self._core, self._arrays = _view(points, tetrahedra, copy)

    @classmethod
    def _of(cls, core: Any) -> "Mesh":
        mesh = cls.__new__(cls)
        mesh._core, mesh._arrays = core, None
        return mesh

    @property
    def points(self) -> NDArray[np.float64]:
        """Rest positions, m (n, 3)."""
        return self._core.points

    @property
    def tetrahedra(self) -> NDArray[np.integer[Any]]:
        """Vertices of the tetrahedra, (m, 4) or (m, 10) in the order of VTK."""
        return self._core.tetrahedra

    @property
    def volume(self) -> float:
        """Sum of the volumes, m³."""
        return self._core.volume

    @property
    def is_quadratic(self) -> bool:
        """Whether the tetrahedra have ten nodes."""
        return self._core.is_quadratic

    @property
    def vertex_ids(self) -> NDArray[np.int64]:
        """The number that the file, and therefore selections and edits, have for each row of `points`."""
        return self._core.vertex_ids

    @property
    def regions(self) -> NDArray[np.int64]:
        """Region of each tetrahedron (m,)."""
        return self._core.regions

    @property
    def groups(self) -> dict[str, NDArray[np.int64]]:
        """Vertices of the named groups of the file, by name."""
        return self._core.groups

    @property
    def point_arrays(self) -> dict[str, NDArray[np.float64]]:
        """Arrays of the file with a row for each vertex, by name."""
        return self._core.point_arrays

    @property
    def cell_arrays(self) -> dict[str, NDArray[np.float64]]:
        """Arrays of the file with a row for each tetrahedron, by name."""
        return self._core.cell_arrays

    def __repr__(self) -> str:
        kind = "quadratic" if self.is_quadratic else "linear"
        return f"<Mesh of {len(self.points)} points and {len(self.tetrahedra)} {kind} tetrahedra>"


def read_mesh(path: str | os.PathLike[str], *, scale: float = 1.0, quadratic: bool = False) -> Mesh:
    """Reads a mesh file: .vtu, .vtk, .msh, .node or .ele, .veg.

    Coordinates are multiplied by `scale`. With `quadratic` a linear mesh gets vertices in the middles of
    its edges. Raises FileError and InputError.
    """
    return Mesh._of(_core.Mesh.read(os.fspath(path), scale, quadratic))


def _view(points: Any, tetrahedra: Any, copy: bool) -> tuple[Any, tuple[NDArray[Any], NDArray[Any]]]:
    points = np.asarray(points)
    tetrahedra = np.asarray(tetrahedra)
    if points.ndim != 2 or points.shape[1] != 3:
        raise _core.InputError(f"points must have the shape (n, 3), not {points.shape}.")
    if tetrahedra.ndim != 2 or tetrahedra.shape[1] != 4:
        raise _core.InputError(
            f"tetrahedra must have the shape (m, 4), not {tetrahedra.shape}. For quadratic elements set "
            'mesh.element = "quadratic": vertices are added in the middles of the edges.')
    if not np.issubdtype(points.dtype, np.number) or np.iscomplexobj(points):
        raise _core.InputError(f"points must be real numbers, not {points.dtype}.")
    if not np.issubdtype(tetrahedra.dtype, np.integer):
        raise _core.InputError(f"tetrahedra must be whole numbers, not {tetrahedra.dtype}.")
    kind = tetrahedra.dtype if tetrahedra.dtype in (np.dtype(np.int32), np.dtype(np.int64)) else np.dtype(np.int64)
    # The library looks at these very numbers as long as the mesh is used.
    if copy:
        points = np.array(points, dtype=np.float64, order="C")
        tetrahedra = np.array(tetrahedra, dtype=kind, order="C")
    else:
        points = np.require(points, np.float64, ["C", "A", "E"])
        tetrahedra = np.require(tetrahedra, kind, ["C", "A", "E"])
    points.flags.writeable = False
    tetrahedra.flags.writeable = False
    return _core.Mesh.view(points, tetrahedra), (points, tetrahedra)


def mesh_of(points: Any, tetrahedra: Any, mesh: Mesh | None, copy: bool) -> tuple[Any, Any]:
    """The mesh of these arguments for the library, or None, and what it refers to."""
    if isinstance(points, Mesh) and mesh is None and tetrahedra is None:
        mesh, points = points, None
    if mesh is not None:
        if not isinstance(mesh, Mesh):
            raise _core.InputError("mesh must be a tetraction.Mesh; give arrays as points and tetrahedra.")
        if points is not None or tetrahedra is not None:
            raise _core.InputError("Give either a mesh or points and tetrahedra.")
        return mesh._core, mesh
    if points is None and tetrahedra is None:
        return None, None
    if points is None or tetrahedra is None:
        raise _core.InputError("points and tetrahedra belong together: give both.")
    return _view(points, tetrahedra, copy)
