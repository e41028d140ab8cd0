"""Shapes of a session as meshes of other packages, which are imported when they are needed."""

from typing import Any

import numpy as np


def _fields(session: Any) -> dict[str, Any]:
    return {
        "displacement": session.displacements,
        "velocity": np.array(session.velocities),
        "momentum": np.array(session.momenta),
    }


def to_vtk(session: Any) -> Any:
    """The present shape as a vtkUnstructuredGrid."""
    from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import (
        VTK_QUADRATIC_TETRA, VTK_TETRA, vtkCellArray, vtkUnstructuredGrid)  # fmt: skip

    tetrahedra = session.tetrahedra
    count, width = tetrahedra.shape
    points = vtkPoints()
    points.SetData(numpy_to_vtk(np.array(session.positions), deep=True))
    cells = vtkCellArray()
    cells.SetData(
        numpy_to_vtkIdTypeArray(np.arange(0, width * count + 1, width, dtype=np.int64), deep=True),
        numpy_to_vtkIdTypeArray(tetrahedra.ravel(), deep=True))
    grid = vtkUnstructuredGrid()
    grid.SetPoints(points)
    grid.SetCells(VTK_TETRA if width == 4 else VTK_QUADRATIC_TETRA, cells)
    for name, values in _fields(session).items():
        array = numpy_to_vtk(values, deep=True)
        array.SetName(name)
        grid.GetPointData().AddArray(array)
    return grid


def to_meshio(session: Any) -> Any:
    """The present shape as a meshio.Mesh."""
    import meshio

    tetrahedra = session.tetrahedra
    kind = "tetra" if tetrahedra.shape[1] == 4 else "tetra10"
    return meshio.Mesh(np.array(session.positions), [(kind, tetrahedra)],
                       point_data=_fields(session))  # fmt: skip


def to_pyvista(session: Any) -> Any:
    """The present shape as a pyvista.UnstructuredGrid."""
    import pyvista

    return pyvista.wrap(to_vtk(session))
