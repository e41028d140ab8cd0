#include "tetraction/mesh/mesh_checks.h"

#include <algorithm>
#include <array>
#include <vector>

namespace tetraction {

Index coincident_vertices(const TetMesh& mesh) {
  std::vector<std::array<double, 3>> places;
  places.reserve(mesh.vertices.size());
  for (const Vector3 x : mesh.vertices) places.push_back({x[0], x[1], x[2]});
  std::sort(places.begin(), places.end());
  Index count = 0;
  for (std::size_t i = 1; i < places.size(); ++i) {
    if (places[i] == places[i - 1]) ++count;
  }
  return count;
}

}  // namespace tetraction
