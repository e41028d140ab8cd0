// The parts of a drawn body that do not depend on its positions. They are made once for a mesh.
#pragma once

#include <vtkSmartPointer.h>

#include <array>
#include <memory>
#include <vector>

#include "tetraction/mesh/tet_mesh.h"

class vtkCellArray;
class vtkPoints;

namespace tetraction::viewer {

/// Cells for VTK, all with the vertices' own numbers, so that everything drawn can share the points.
struct BodyShape {
  vtkSmartPointer<vtkPoints> rest;  ///< of the mesh, single precision
  vtkSmartPointer<vtkCellArray> tetrahedra, faces, edges, points;
  std::vector<std::array<Index, 3>> triangles;            ///< of the surface, as in `faces`
  std::vector<Index> triangle_cell;                       ///< the tetrahedron of each
  std::vector<Index> surface_vertices;                    ///< ascending
  Vector3 low = Vector3::Zero(), high = Vector3::Ones();  ///< corners of the box around it
};

/// May be called in any thread; takes a second for a million tetrahedra.
std::shared_ptr<const BodyShape> make_body_shape(const TetMesh& mesh);

/// One vertex cell for each of `vertices`.
vtkSmartPointer<vtkCellArray> point_cells(const std::vector<Index>& vertices);

}  // namespace tetraction::viewer
