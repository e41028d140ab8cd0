// Element quality of a mesh, by the measures of VTK's Verdict library (vtkMeshQuality).
#pragma once

#include <string>
#include <vector>

#include "tetraction/mesh/tet_mesh.h"

namespace tetraction {

/// One measure over all tetrahedra.
struct QualityMeasure {
  std::string name;   ///< e.g. "scaled Jacobian", "radius ratio"
  std::string ideal;  ///< what a regular tetrahedron has, for the reader of a table
  double min = 0.0;
  double mean = 0.0;
  double max = 0.0;
  Index worst_element = 0;  ///< the file's id of the worst tetrahedron
  std::vector<double> values;
};

/// Scaled Jacobian (1 for a regular tetrahedron, 0 flat), radius ratio (1 ideal, larger is worse),
/// shape (1 ideal, 0 flat) and edge ratio (1 ideal), in this order.
std::vector<QualityMeasure> mesh_quality(const TetMesh& mesh);

}  // namespace tetraction
