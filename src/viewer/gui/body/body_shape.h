// The data for drawing a body that do not depend on its state. They are made once for a mesh.
#pragma once

#include <vtkSmartPointer.h>

#include <array>
#include <memory>
#include <vector>

#include "tetraction/mesh/tet_mesh.h"

class vtkCellArray;
class vtkPoints;

namespace tetraction::viewer {

/// VTK cells with the vertex numbers of the mesh, so that all of them can use the same points.
struct BodyShape {
  vtkSmartPointer<vtkPoints> rest;  ///< rest positions, single precision
  Vector rest_position;             ///< the same, 3 per vertex, m
  vtkSmartPointer<vtkCellArray> tetrahedra, faces, edges, points;
  int cell_type = 10;  ///< VTK's type of the tetrahedra, VTK_TETRA or VTK_QUADRATIC_TETRA
  std::vector<std::array<Index, 3>>
      triangles;                        ///< vertices of the surface triangles, as in `faces`
  std::vector<Index> triangle_cell;     ///< the tetrahedron of each triangle
  std::vector<Index> surface_vertices;  ///< ascending
  double edge_length = 0.0;             ///< mean of the surface's edges at rest, m
  Vector3 low = Vector3::Zero(), high = Vector3::Ones();  ///< corners of the bounding box
};

/// Makes the data of a mesh. It takes a second for a million tetrahedra. Thread-safe.
std::shared_ptr<const BodyShape> make_body_shape(const TetMesh& mesh);

/// Whether a length between two vertices of a tetrahedron has changed by more than 1e-9 of it. Otherwise stresses and
/// energies are those of round-off, whatever the stiffness of the body. Fast for a body that is strained everywhere.
bool is_strained(const BodyShape& shape, const Vector& position);

/// One vertex cell for each of `vertices`.
vtkSmartPointer<vtkCellArray> point_cells(const std::vector<Index>& vertices);

}  // namespace tetraction::viewer
