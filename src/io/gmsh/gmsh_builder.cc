#include "gmsh_builder.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>
#include <unordered_map>
#include <utility>

#include "core/quoting.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

using IndexOfTag = std::unordered_map<std::int64_t, Index>;

// The columns of an array in the order of all items. Rows of items that the file lacks are counted.
Matrix all_columns(const GmshData& data, const IndexOfTag& index_of, std::size_t count,
                   std::size_t& lost) {
  Matrix all = Matrix::Constant(data.values.rows(), static_cast<Index>(count),
                                std::numeric_limits<double>::quiet_NaN());
  for (std::size_t i = 0; i < data.tags.size(); ++i) {
    const auto found = index_of.find(data.tags[i]);
    if (found == index_of.end()) {
      ++lost;
    } else {
      all.col(found->second) = data.values.col(static_cast<Index>(i));
    }
  }
  return all;
}

void tell_lost(std::size_t lost, const std::string& name, const char* items,
               std::vector<std::string>& unused) {
  if (lost == 0) return;
  unused.push_back(fmt::format("{} values of the array {}, of {} that the file does not have", lost,
                               in_quotes(name), items));
}

bool same_vertices(const RawCell& a, const RawCell& b) {
  return std::is_permutation(a.vertices.begin(), a.vertices.end(), b.vertices.begin(),
                             b.vertices.end());
}

}  // namespace

const GmshType* find_gmsh_type(std::int64_t number) {
  static const std::map<std::int64_t, GmshType> types{
      {1, {CellType::kLine, 2, 1}},
      {2, {CellType::kTriangle, 3, 2}},
      {3, {CellType::kQuadrilateral, 4, 2}},
      {4, {CellType::kTetrahedron, 4, 3}},
      {5, {CellType::kHexahedron, 8, 3}},
      {6, {CellType::kWedge, 6, 3}},
      {7, {CellType::kPyramid, 5, 3}},
      {8, {CellType::kLine, 3, 1}},
      {9, {CellType::kTriangle, 6, 2}},
      {10, {CellType::kQuadrilateral, 9, 2}},
      {11, {CellType::kQuadraticTetrahedron, 10, 3}},
      {12, {CellType::kHexahedron, 27, 3}},
      {13, {CellType::kWedge, 18, 3}},
      {14, {CellType::kPyramid, 14, 3}},
      {15, {CellType::kVertex, 1, 0}},
      {16, {CellType::kQuadrilateral, 8, 2}},
      {17, {CellType::kHexahedron, 20, 3}},
      {18, {CellType::kWedge, 15, 3}},
      {19, {CellType::kPyramid, 13, 3}},
      {20, {CellType::kTriangle, 9, 2}},
      {21, {CellType::kTriangle, 10, 2}},
      {22, {CellType::kTriangle, 12, 2}},
      {23, {CellType::kTriangle, 15, 2}},
      {26, {CellType::kLine, 4, 1}},
      {27, {CellType::kLine, 5, 1}},
      {28, {CellType::kLine, 6, 1}},
      {29, {CellType::kQuadraticTetrahedron, 20, 3}},
      {30, {CellType::kQuadraticTetrahedron, 35, 3}},
      {31, {CellType::kQuadraticTetrahedron, 56, 3}}};
  const auto found = types.find(number);
  return found != types.end() ? &found->second : nullptr;
}

int GmshBuilder::group_index(int dimension, std::int64_t tag) {
  const auto [found, inserted] =
      group_of_.emplace(std::pair{dimension, tag}, static_cast<int>(mesh_.groups.size()));
  if (inserted) mesh_.groups.push_back({std::to_string(tag), dimension, static_cast<int>(tag)});
  return found->second;
}

void GmshBuilder::add_cell(const GmshType& type, std::int64_t tag, std::vector<std::int64_t> nodes,
                           const std::vector<std::int64_t>& physicals) {
  RawCell cell;
  cell.type = type.type;
  cell.id = tag;
  cell.vertices = std::move(nodes);
  // Gmsh lists the middles of the edges 23 and 13 in this order, RawCell the other way round.
  if (type.type == CellType::kQuadraticTetrahedron && cell.vertices.size() == 10) {
    std::swap(cell.vertices[8], cell.vertices[9]);
  }
  for (const std::int64_t physical : physicals) {
    cell.groups.push_back(group_index(type.dimension, physical));
    if (type.dimension == 3) cell.region = static_cast<int>(physical);
  }
  mesh_.cells.push_back(std::move(cell));
}

void GmshBuilder::name_groups() {
  for (const auto& [key, group] : group_of_) {
    const auto [dimension, tag] = key;
    auto name = names_.find({dimension, tag});
    if (name == names_.end()) name = names_.find({kAnyDimension, tag});
    if (name != names_.end()) mesh_.groups[static_cast<std::size_t>(group)].name = name->second;
  }
}

// The named groups that no element belongs to.
std::string GmshBuilder::unused_names() const {
  std::vector<std::string_view> names;
  for (const auto& [key, name] : names_) {
    const auto& [dimension, tag] = key;
    bool used = false;
    for (int d = 0; d < 4; ++d) {
      const bool meant = dimension == kAnyDimension || dimension == d;
      used = used || (meant && group_of_.contains({d, tag}));
    }
    if (!used) names.push_back(name);
  }
  return names.empty() ? ""
                       : fmt::format("the groups {}, which have no elements", quoted_list(names));
}

void GmshBuilder::place_cell_arrays(std::vector<std::string>& unused) {
  if (cell_arrays_.empty()) return;
  IndexOfTag index_of;
  std::set<std::int64_t> several;
  for (std::size_t c = 0; c < mesh_.cells.size(); ++c) {
    const RawCell& cell = mesh_.cells[c];
    const auto [found, is_new] = index_of.emplace(cell.id, static_cast<Index>(c));
    // Version 2 repeats an element for each of its groups.
    if (!is_new && !same_vertices(cell, mesh_.cells[static_cast<std::size_t>(found->second)])) {
      several.insert(cell.id);
    }
  }
  for (const auto& [name, data] : cell_arrays_) {
    for (const std::int64_t tag : data.tags) {
      if (several.empty() || !several.contains(tag)) continue;
      throw FileError(
          fmt::format("{}: the array {} has a value of element {}, but several elements have this "
                      "number. Number the elements anew.",
                      mesh_.source, in_quotes(name), tag));
    }
    std::size_t lost = 0;
    mesh_.cell_arrays[name] = all_columns(data, index_of, mesh_.cells.size(), lost);
    tell_lost(lost, name, "elements", unused);
  }
}

void GmshBuilder::place_point_arrays(std::vector<std::string>& unused) {
  if (point_arrays_.empty()) return;
  IndexOfTag index_of;
  for (std::size_t v = 0; v < mesh_.vertex_ids.size(); ++v) {
    index_of.emplace(mesh_.vertex_ids[v], static_cast<Index>(v));
  }
  for (const auto& [name, data] : point_arrays_) {
    std::size_t lost = 0;
    mesh_.point_arrays[name] = all_columns(data, index_of, mesh_.vertices.size(), lost);
    tell_lost(lost, name, "nodes", unused);
  }
}

std::optional<std::int64_t> GmshBuilder::repeated_tetrahedron() const {
  std::vector<std::int64_t> tags;
  for (const RawCell& cell : mesh_.cells) {
    if (cell.type == CellType::kTetrahedron || cell.type == CellType::kQuadraticTetrahedron) {
      tags.push_back(cell.id);
    }
  }
  std::sort(tags.begin(), tags.end());
  const auto found = std::adjacent_find(tags.begin(), tags.end());
  if (found == tags.end()) return {};
  return *found;
}

RawMesh GmshBuilder::take(std::vector<std::string>& unused) {
  name_groups();
  if (std::string names = unused_names(); !names.empty()) unused.push_back(std::move(names));
  if (!skipped_.empty()) {
    const std::vector<std::string_view> sections(skipped_.begin(), skipped_.end());
    unused.push_back("the sections " + quoted_list(sections));
  }
  place_cell_arrays(unused);
  place_point_arrays(unused);
  return std::move(mesh_);
}

}  // namespace tetraction
