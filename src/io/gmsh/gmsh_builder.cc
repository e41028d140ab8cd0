#include "gmsh_builder.h"

#include <limits>
#include <unordered_map>
#include <utility>

namespace tetraction {

int GmshBuilder::group_index(int dimension, std::int64_t tag) {
  const auto [found, inserted] =
      group_of_.emplace(std::pair{dimension, tag}, static_cast<int>(mesh_.groups.size()));
  if (inserted) {
    auto name = names_.find({dimension, tag});
    if (name == names_.end()) name = names_.find({kAnyDimension, tag});
    mesh_.groups.push_back({name != names_.end() ? name->second : std::to_string(tag), dimension,
                            static_cast<int>(tag)});
  }
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

void GmshBuilder::add_cell_array(const std::string& name, const std::vector<std::int64_t>& tags,
                                 Matrix values) {
  cell_arrays_[name] = {tags, std::move(values)};
}

RawMesh GmshBuilder::take() {
  if (cell_arrays_.empty()) return std::move(mesh_);
  std::unordered_map<std::int64_t, Index> cell_of_tag;
  for (std::size_t c = 0; c < mesh_.cells.size(); ++c) {
    cell_of_tag.emplace(mesh_.cells[c].id, static_cast<Index>(c));
  }
  for (const auto& [name, given] : cell_arrays_) {
    Matrix& all = mesh_.cell_arrays[name];
    all.setConstant(given.values.rows(), static_cast<Index>(mesh_.cells.size()),
                    std::numeric_limits<double>::quiet_NaN());
    for (std::size_t i = 0; i < given.tags.size(); ++i) {
      const auto found = cell_of_tag.find(given.tags[i]);
      if (found == cell_of_tag.end()) continue;
      all.col(found->second) = given.values.col(static_cast<Index>(i));
    }
  }
  return std::move(mesh_);
}

}  // namespace tetraction
