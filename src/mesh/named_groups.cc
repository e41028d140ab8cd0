#include "named_groups.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "core/quoting.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

std::string with_dimension(const Group& group) {
  return fmt::format("{} (dimension {})", group.name, group.dimension);
}

std::string with_tag(const Group& group) {
  return fmt::format("{} (dimension {}, tag {})", group.name, group.dimension, group.tag);
}

}  // namespace

std::vector<const Group*> groups_named(const TetMesh& mesh, const std::string& name) {
  std::vector<const Group*> found;
  for (const Group& group : mesh.groups) {
    if (group.name == name) found.push_back(&group);
  }
  if (!found.empty()) return found;
  for (const Group& group : mesh.groups) {
    if (!name.starts_with(group.name)) continue;
    if (name == with_dimension(group) || name == with_tag(group)) found.push_back(&group);
  }
  return found;
}

void refuse_several(const std::vector<const Group*>& groups, const std::string& name) {
  if (groups.size() < 2) return;
  std::vector<std::string> names;
  for (const Group* group : groups) {
    const auto same = std::count_if(groups.begin(), groups.end(), [&](const Group* other) {
      return other->dimension == group->dimension;
    });
    names.push_back(same == 1 ? with_dimension(*group) : with_tag(*group));
  }
  throw InputError(
      fmt::format("the group {} is ambiguous, because the mesh has several of this name: {}. Name "
                  "one of these; any_of takes several.",
                  in_quotes(name), quoted_list({names.begin(), names.end()})));
}

}  // namespace tetraction
