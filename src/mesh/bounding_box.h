// The box around a body at rest.
#pragma once

#include "tetraction/mesh/tet_mesh.h"

namespace tetraction {

struct BoundingBox {
  Vector3 low;   ///< m
  Vector3 high;  ///< m
  Vector3 size() const { return high - low; }
  double diagonal() const { return size().norm(); }
};

/// The box around the rest positions of all vertices, along the axes; of a part, that of the whole mesh.
BoundingBox bounding_box(const TetMesh& mesh);

}  // namespace tetraction
