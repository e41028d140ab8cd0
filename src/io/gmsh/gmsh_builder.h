// Collects the data that the readers of all versions of the Gmsh format find.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "gmsh_types.h"
#include "tetraction/mesh/tet_mesh.h"

namespace tetraction {

class GmshBuilder {
 public:
  explicit GmshBuilder(const std::string& source) { mesh_.source = source; }

  /// Dimension of a physical name in files that state none. The name then holds for every
  /// dimension.
  static constexpr std::int64_t kAnyDimension = -1;
  /// Names a physical group. Names come before the elements.
  void name_group(std::int64_t dimension, std::int64_t tag, std::string name) {
    names_[{dimension, tag}] = std::move(name);
  }

  // How many more there will be: lists that grow step by step need up to three times the memory on the way.
  void expect_vertices(std::int64_t count) {
    mesh_.vertex_ids.reserve(mesh_.vertex_ids.size() + static_cast<std::size_t>(count));
    mesh_.vertices.reserve(mesh_.vertices.size() + static_cast<std::size_t>(count));
  }
  void expect_cells(std::int64_t count) {
    mesh_.cells.reserve(mesh_.cells.size() + static_cast<std::size_t>(count));
  }

  void add_vertex(std::int64_t tag, const Vector3& x) {
    mesh_.vertex_ids.push_back(tag);
    mesh_.vertices.push_back(x);
  }

  /// Adds an element that belongs to the physical groups of these tags. The last one is its region.
  void add_cell(const GmshType& type, std::int64_t tag, std::vector<std::int64_t> nodes,
                const std::vector<std::int64_t>& physicals);

  /// Adds a cell array: one column of values for each of the elements of these tags. It
  /// replaces an array of the same name. Elements without a column get NaN.
  void add_cell_array(const std::string& name, const std::vector<std::int64_t>& tags,
                      Matrix values);

  std::size_t vertex_count() const { return mesh_.vertices.size(); }
  std::size_t cell_count() const { return mesh_.cells.size(); }
  RawMesh take();

 private:
  int group_index(int dimension, std::int64_t tag);

  struct CellArray {
    std::vector<std::int64_t> tags;
    Matrix values;  // components × tags
  };

  RawMesh mesh_;
  std::map<std::string, CellArray> cell_arrays_;
  std::map<std::pair<std::int64_t, std::int64_t>, std::string> names_;
  std::map<std::pair<int, std::int64_t>, int> group_of_;
};

}  // namespace tetraction
