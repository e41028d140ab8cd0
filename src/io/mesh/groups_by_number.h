// Groups of cells that a file tells apart by numbers without names.
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "tetraction/mesh/tet_mesh.h"

namespace tetraction {

/// Makes a group of each number but 0, with the number as its name.
class GroupsByNumber {
 public:
  /// Adds groups of cells of this dimension to the mesh, which must live longer.
  GroupsByNumber(RawMesh& mesh, int dimension) : mesh_(mesh), dimension_(dimension) {}

  /// Puts a cell into the group of a number.
  void add(RawCell& cell, std::int64_t number) {
    if (number == 0) return;
    const auto [found, inserted] = group_of_.emplace(number, static_cast<int>(mesh_.groups.size()));
    if (inserted) {
      mesh_.groups.push_back({std::to_string(number), dimension_, static_cast<int>(number)});
    }
    cell.groups.push_back(found->second);
  }

 private:
  RawMesh& mesh_;
  int dimension_;
  std::map<std::int64_t, int> group_of_;
};

}  // namespace tetraction
