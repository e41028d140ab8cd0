#include "flat_tetrahedra.h"

#include <algorithm>
#include <cmath>

namespace tetraction {

double longest_edge(const TetMesh& mesh, Index e) {
  const auto t = mesh.tetrahedra[static_cast<std::size_t>(e)];
  double longest = 0.0;
  for (std::size_t a = 0; a < 4; ++a) {
    for (std::size_t b = a + 1; b < 4; ++b) {
      longest = std::max(longest, (mesh.vertices[static_cast<std::size_t>(t[a])] -
                                   mesh.vertices[static_cast<std::size_t>(t[b])])
                                      .norm());
    }
  }
  return longest;
}

bool is_flat(double volume, double longest) {
  constexpr double kFlat = 1e-14;
  return !(std::abs(6.0 * volume) > kFlat * longest * longest * longest);
}

}  // namespace tetraction
