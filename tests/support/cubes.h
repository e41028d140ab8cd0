// Bodies of unit cubes, which may touch in faces, edges and corners.
#pragma once

#include <algorithm>
#include <array>
#include <map>
#include <utility>
#include <vector>

#include "tetraction/mesh/tet_mesh.h"

namespace tetraction::testing_support {

/// A unit cube at each of these places, divided into six tetrahedra around the diagonal from its lowest
/// corner. Cubes share the vertices in which they touch.
inline TetMesh cubes(const std::vector<std::array<int, 3>>& places) {
  RawMesh raw;
  std::map<std::array<int, 3>, std::int64_t> ids;
  const auto id_of = [&](const std::array<int, 3>& place) {
    const auto [entry, is_new] = ids.emplace(place, static_cast<std::int64_t>(ids.size()));
    if (is_new) {
      raw.vertices.emplace_back(place[0], place[1], place[2]);
      raw.vertex_ids.push_back(entry->second);
    }
    return entry->second;
  };
  for (const auto& place : places) {
    std::array<std::size_t, 3> axes{0, 1, 2};
    do {
      RawCell cell;
      cell.type = CellType::kTetrahedron;
      cell.id = static_cast<std::int64_t>(raw.cells.size());
      std::array<int, 3> corner = place;
      cell.vertices.push_back(id_of(corner));
      for (const std::size_t axis : axes) {
        ++corner[axis];
        cell.vertices.push_back(id_of(corner));
      }
      raw.cells.push_back(std::move(cell));
    } while (std::next_permutation(axes.begin(), axes.end()));
  }
  return build_mesh(std::move(raw));
}

}  // namespace tetraction::testing_support
