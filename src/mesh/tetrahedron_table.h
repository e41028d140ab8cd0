// Recognises tetrahedra that a file gives twice.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "tetraction/core/types.h"

namespace tetraction {

struct TetrahedronHash {
  std::size_t operator()(const std::array<Index, 4>& vertices) const {
    std::size_t hash = 0;
    for (const Index v : vertices) {
      hash = (hash ^ static_cast<std::size_t>(v)) * 0x9E3779B97F4A7C15U;
      hash ^= hash >> 32U;
    }
    return hash;
  }
};

// The first tetrahedron with the same vertices. It keeps numbers of tetrahedra only: a map with the vertices
// as keys would need more memory than the mesh.
class TetrahedronTable {
 public:
  explicit TetrahedronTable(std::size_t most) : slots_(most + most / 2 + 1, kFree) {}

  // `tetrahedra`: those that were added before. Returns the number of the first one with these vertices, which is that
  // of the next one if it is new.
  Index find_or_add(std::array<Index, 4> vertices,
                    const std::vector<std::array<Index, 4>>& tetrahedra) {
    std::sort(vertices.begin(), vertices.end());
    std::size_t slot = TetrahedronHash()(vertices) % slots_.size();
    while (slots_[slot] != kFree) {
      std::array<Index, 4> other = tetrahedra[static_cast<std::size_t>(slots_[slot])];
      std::sort(other.begin(), other.end());
      if (other == vertices) return slots_[slot];
      slot = slot + 1 < slots_.size() ? slot + 1 : 0;
    }
    return slots_[slot] = static_cast<Index>(tetrahedra.size());
  }

 private:
  static constexpr Index kFree = -1;
  std::vector<Index> slots_;
};

}  // namespace tetraction
