#include "vtk_cells.h"

#include <vtkCellType.h>

namespace tetraction {

CellType vtk_cell_type(int vtk, std::size_t vertices) {
  switch (vtk) {
    case VTK_VERTEX:
    case VTK_POLY_VERTEX:
      return CellType::kVertex;
    case VTK_LINE:
    case VTK_POLY_LINE:
    case VTK_QUADRATIC_EDGE:
      return CellType::kLine;
    case VTK_TRIANGLE:
    case VTK_TRIANGLE_STRIP:
    case VTK_QUADRATIC_TRIANGLE:
      return CellType::kTriangle;
    case VTK_QUAD:
    case VTK_PIXEL:
    case VTK_QUADRATIC_QUAD:
      return CellType::kQuadrilateral;
    case VTK_TETRA:
      return CellType::kTetrahedron;
    case VTK_QUADRATIC_TETRA:
      return CellType::kQuadraticTetrahedron;
    case VTK_HIGHER_ORDER_TETRAHEDRON:
    case VTK_LAGRANGE_TETRAHEDRON:
    case VTK_BEZIER_TETRAHEDRON:
      return vertices == 4 ? CellType::kTetrahedron : CellType::kQuadraticTetrahedron;
    case VTK_LAGRANGE_TRIANGLE:
    case VTK_BEZIER_TRIANGLE:
      return CellType::kTriangle;
    case VTK_HEXAHEDRON:
    case VTK_VOXEL:
    case VTK_QUADRATIC_HEXAHEDRON:
      return CellType::kHexahedron;
    case VTK_WEDGE:
    case VTK_QUADRATIC_WEDGE:
      return CellType::kWedge;
    case VTK_PYRAMID:
    case VTK_QUADRATIC_PYRAMID:
      return CellType::kPyramid;
    default:
      return CellType::kOther;
  }
}

std::size_t vtk_cell_size(int vtk) {
  switch (vtk) {
    case VTK_VERTEX:
      return 1;
    case VTK_LINE:
      return 2;
    case VTK_QUADRATIC_EDGE:
    case VTK_TRIANGLE:
      return 3;
    case VTK_QUAD:
    case VTK_PIXEL:
    case VTK_TETRA:
      return 4;
    case VTK_PYRAMID:
      return 5;
    case VTK_QUADRATIC_TRIANGLE:
    case VTK_WEDGE:
      return 6;
    case VTK_HEXAHEDRON:
    case VTK_VOXEL:
      return 8;
    case VTK_QUADRATIC_TETRA:
      return 10;
    default:
      return 0;
  }
}

}  // namespace tetraction
