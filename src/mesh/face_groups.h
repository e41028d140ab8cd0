// The faces of the tetrahedra of a mesh, those with the same vertices together.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "tetraction/mesh/tet_mesh.h"

namespace tetraction {

/// The corners of the faces of a tetrahedron with positive volume, whose normals point outward.
inline constexpr std::array<std::array<std::size_t, 3>, 4> kFaceCorners{
    {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};

/// Calls visit(span of numbers) for all groups of faces with the same three vertices, in ascending order of these.
/// Face f of tetrahedron e has the number 4 e + f; the numbers of a group are in no order. Only the faces whose
/// smallest vertex is in [low, high) are taken, which limits the memory.
///
/// The faces are placed by their smallest vertex, of which few have the same, so that only short lists are sorted.
template <class Visit>
void for_each_face_group(const TetMesh& mesh, Index low, Index high, const Visit& visit) {
  struct Face {
    Index middle;  // of the sorted vertices
    Index last;
    Index number;
  };
  const auto for_each_face = [&](const auto& body) {
    for (std::size_t e = 0; e < mesh.tetrahedra.size(); ++e) {
      const auto t = mesh.tetrahedra[e];
      for (std::size_t f = 0; f < 4; ++f) {
        std::array<Index, 3> key{t[kFaceCorners[f][0]], t[kFaceCorners[f][1]],
                                 t[kFaceCorners[f][2]]};
        if (key[1] < key[0]) std::swap(key[0], key[1]);
        if (key[2] < key[1]) std::swap(key[1], key[2]);
        if (key[1] < key[0]) std::swap(key[0], key[1]);
        if (key[0] < low || key[0] >= high) continue;
        body(static_cast<std::size_t>(key[0] - low),
             Face{key[1], key[2], static_cast<Index>(4 * e + f)});
      }
    }
  };
  // The faces with the smallest vertex low + k will be those from begin[k] to begin[k + 1].
  std::vector<std::size_t> begin(static_cast<std::size_t>(high - low) + 2, 0);
  for_each_face([&](std::size_t k, const Face&) { ++begin[k + 2]; });
  for (std::size_t k = 2; k < begin.size(); ++k) begin[k] += begin[k - 1];
  std::vector<Face> faces(begin.back());
  for_each_face([&](std::size_t k, const Face& face) { faces[begin[k + 1]++] = face; });
  std::vector<Index> numbers;
  for (std::size_t k = 0; k + 2 < begin.size(); ++k) {
    const std::span<Face> of_vertex(faces.data() + begin[k], begin[k + 1] - begin[k]);
    std::sort(of_vertex.begin(), of_vertex.end(), [](const Face& a, const Face& b) {
      return a.middle != b.middle ? a.middle < b.middle : a.last < b.last;
    });
    for (std::size_t i = 0; i < of_vertex.size();) {
      numbers.clear();
      const Face& first = of_vertex[i];
      for (; i < of_vertex.size() && of_vertex[i].middle == first.middle &&
             of_vertex[i].last == first.last;
           ++i) {
        numbers.push_back(of_vertex[i].number);
      }
      visit(std::span<const Index>(numbers));
    }
  }
}

}  // namespace tetraction
