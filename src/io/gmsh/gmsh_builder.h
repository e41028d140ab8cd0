// Collects the data that the readers of all versions of the Gmsh format find.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "gmsh_data.h"
#include "tetraction/mesh/tet_mesh.h"

namespace tetraction {

/// An element type of the Gmsh format.
struct GmshType {
  CellType type;
  int nodes;
  int dimension;
};

/// The type with a number of the format, or nullptr if the readers do not know it.
const GmshType* find_gmsh_type(std::int64_t number);

class GmshBuilder {
 public:
  explicit GmshBuilder(const std::string& source) { mesh_.source = source; }

  /// Dimension of a physical name in files that state none. The name then holds for every
  /// dimension.
  static constexpr std::int64_t kAnyDimension = -1;
  /// Names a physical group. False if it has another name already.
  bool name_group(std::int64_t dimension, std::int64_t tag, const std::string& name) {
    return names_.emplace(std::pair{dimension, tag}, name).first->second == name;
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

  /// Adds an array of elements or of vertices. What has no row gets NaN. False if there is an array of
  /// that name already.
  bool add_cell_array(GmshData data) { return add(std::move(data), cell_arrays_); }
  bool add_point_array(GmshData data) { return add(std::move(data), point_arrays_); }
  /// Notes a section that is not read.
  void skip(const std::string& section) { skipped_.insert(section); }

  std::size_t vertex_count() const { return mesh_.vertices.size(); }
  std::size_t cell_count() const { return mesh_.cells.size(); }
  /// A number that several tetrahedra have.
  std::optional<std::int64_t> repeated_tetrahedron() const;
  /// The mesh. Appends what of the file is not used to `unused`. Throws FileError if an array has a value
  /// of an element whose number several elements have.
  RawMesh take(std::vector<std::string>& unused);

 private:
  using Arrays = std::map<std::string, GmshData>;

  static bool add(GmshData data, Arrays& arrays) {
    const std::string name = data.name;
    return arrays.emplace(name, std::move(data)).second;
  }
  int group_index(int dimension, std::int64_t tag);
  void name_groups();
  std::string unused_names() const;
  void place_cell_arrays(std::vector<std::string>& unused);
  void place_point_arrays(std::vector<std::string>& unused);

  RawMesh mesh_;
  Arrays cell_arrays_;
  Arrays point_arrays_;
  std::map<std::pair<std::int64_t, std::int64_t>, std::string> names_;
  std::map<std::pair<int, std::int64_t>, int> group_of_;
  std::set<std::string> skipped_;
};

}  // namespace tetraction
