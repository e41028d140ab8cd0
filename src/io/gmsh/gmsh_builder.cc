#include "gmsh_builder.h"

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
  for (const std::int64_t physical : physicals) {
    cell.groups.push_back(group_index(type.dimension, physical));
    if (type.dimension == 3) cell.region = static_cast<int>(physical);
  }
  mesh_.cells.push_back(std::move(cell));
}

}  // namespace tetraction
