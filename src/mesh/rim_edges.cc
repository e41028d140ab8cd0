#include "rim_edges.h"

#include <algorithm>
#include <cstdlib>
#include <map>

namespace tetraction {

std::vector<std::array<Index, 2>> rim_edges(const std::vector<std::array<Index, 3>>& triangles) {
  // Directed edges from the smaller to the larger number, minus the others.
  std::map<std::array<Index, 2>, int> counts;
  for (const auto& triangle : triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const Index from = triangle[i];
      const Index to = triangle[(i + 1) % 3];
      counts[{std::min(from, to), std::max(from, to)}] += from < to ? 1 : -1;
    }
  }
  std::vector<std::array<Index, 2>> edges;
  for (const auto& [ends, count] : counts) {
    for (int i = 0; i < std::abs(count); ++i) {
      edges.push_back(count > 0 ? ends : std::array<Index, 2>{ends[1], ends[0]});
    }
  }
  return edges;
}

}  // namespace tetraction
