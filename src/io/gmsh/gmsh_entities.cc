#include "gmsh_entities.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>

namespace tetraction {
namespace {

// No real mesh has more groups for one entity. Each element of an entity joins all of its groups,
// so without this limit a small file could require any amount of memory.
constexpr std::int64_t kMostPhysicals = 100;

}  // namespace

void refuse_gmsh_ghosts(const TextScanner& in, const std::string& what) {
  in.fail(what +
          ": a ghost element is a copy for another partition, so that the body could be meant with "
          "it or without it. Save the mesh without ghost cells (Gmsh: "
          "Mesh.PartitionCreateGhostCells = 0) or without partitions.");
}

std::int64_t GmshEntities::count(const char* wanted, std::int64_t least_bytes) {
  return in_.checked_count(numbers_.size(wanted), wanted, least_bytes);
}

void GmshEntities::read() {
  numbers_.begin_section();
  read_lists(false);
}

void GmshEntities::read_partitioned() {
  numbers_.begin_section();
  numbers_.size("the number of partitions");
  if (const std::int64_t ghosts = count("the number of ghost entities", 4); ghosts > 0) {
    refuse_gmsh_ghosts(in_, fmt::format("the file has {} entities of ghost elements", ghosts));
  }
  read_lists(true);
}

void GmshEntities::read_lists(bool partitioned) {
  std::array<std::int64_t, 4> counts{};
  for (auto& n : counts) n = count("a number of entities", 4);
  for (int dimension = 0; dimension < 4; ++dimension) {
    for (std::int64_t i = 0; i < counts[static_cast<std::size_t>(dimension)]; ++i) {
      read_entity(dimension, partitioned);
    }
  }
}

void GmshEntities::read_entity(int dimension, bool partitioned) {
  const std::int64_t tag = numbers_.int32("an entity tag");
  bool has_groups = true;
  if (partitioned) {
    // The border between two partitions has the groups of what it cuts, although it belongs to none.
    has_groups = numbers_.int32("the dimension of a parent") == dimension;
    numbers_.int32("the tag of a parent");
    const std::int64_t partitions = count("a number of partitions", 2);
    for (std::int64_t p = 0; p < partitions; ++p) numbers_.int32("a partition");
  }
  const int coordinates = dimension == 0 ? 3 : 6;
  for (int c = 0; c < coordinates; ++c) numbers_.real("an entity's bounds");
  const std::int64_t physicals = count("a number of physical tags", 2);
  const auto [entity, is_new] =
      physicals_.emplace(std::pair{dimension, tag}, std::vector<std::int64_t>{});
  if (!is_new) {
    in_.fail(
        fmt::format("entity {} of dimension {} is given a second time, and twice is ambiguous.",
                    tag, dimension));
  }
  if (physicals > kMostPhysicals) {
    in_.fail(fmt::format("an entity has {} physical tags; at most {} are read.", physicals,
                         kMostPhysicals));
  }
  std::vector<std::int64_t>& known = entity->second;
  for (std::int64_t p = 0; p < physicals; ++p) {
    // A tag is negative if a group contains an entity with reversed orientation.
    const std::int64_t physical = std::abs(numbers_.int32("a physical tag"));
    if (has_groups && std::find(known.begin(), known.end(), physical) == known.end()) {
      known.push_back(physical);
    }
  }
  if (dimension == 0) return;
  const std::int64_t bounding = count("a number of bounding entities", 2);
  for (std::int64_t b = 0; b < bounding; ++b) numbers_.int32("a bounding entity");
}

bool GmshEntities::lacks(std::int64_t dimension, std::int64_t tag) const {
  return !physicals_.empty() && !physicals_.contains({dimension, tag});
}

const std::vector<std::int64_t>& GmshEntities::physicals_of(std::int64_t dimension,
                                                            std::int64_t tag) const {
  static const std::vector<std::int64_t> kNone;
  const auto found = physicals_.find({dimension, tag});
  return found != physicals_.end() ? found->second : kNone;
}

}  // namespace tetraction
