#include "bounding_box.h"

namespace tetraction {

BoundingBox bounding_box(const TetMesh& mesh) {
  if (mesh.part) return {mesh.part->whole.low, mesh.part->whole.high};
  BoundingBox box{mesh.vertices.front(), mesh.vertices.front()};
  for (const Vector3 x : mesh.vertices) {
    box.low = box.low.cwiseMin(x);
    box.high = box.high.cwiseMax(x);
  }
  return box;
}

}  // namespace tetraction
