#include "nodal_patches.h"

#include <algorithm>
#include <limits>

#include "fem/kernels/volume_kernels.h"

namespace tetraction {

NodalPatches::NodalPatches(const ElasticPotential& elastic)
    : rest_(elastic.rest()), blocks_(BlockAccess::blocks(elastic)) {
  list_lanes();
  list_patches(elastic);
  Vector positions(3 * rest_.vertex_count());
  for (Index v = 0; v < rest_.vertex_count(); ++v) vertex_block(positions, v) = rest_.position(v);
  find_volumes(positions, rest_volumes_);
  patch_volumes_.resize(count());
  for_each([&](Index p) {
    double sum = 0.0;
    for (const std::int32_t lane : lanes(p)) sum += rest_volumes_[static_cast<std::size_t>(lane)];
    patch_volumes_[p] = sum;
  });
}

void NodalPatches::list_lanes() {
  element_of_lane_.assign(static_cast<std::size_t>(blocks_.batch_count() * kBatchLanes), -1);
  position_of_lane_.resize(element_of_lane_.size());
  lane_of_element_.resize(static_cast<std::size_t>(rest_.element_count()));
  for (Index b = 0; b < blocks_.block_count(); ++b) {
    const ElementBlocks::Block& block = blocks_.block(b);
    blocks_.for_each_point(block, [&](Index e, Index batch, int lane) {
      const Index number = batch * kBatchLanes + lane;
      position_of_lane_[static_cast<std::size_t>(number)] = static_cast<std::int32_t>(
          block.first_batch * kBatchLanes + lane * block.batch_count + (batch - block.first_batch));
      element_of_lane_[static_cast<std::size_t>(number)] = e;
      lane_of_element_[static_cast<std::size_t>(e)] = static_cast<std::int32_t>(number);
    });
  }
}

// For each vertex its first tetrahedron in the order of the blocks.
std::vector<std::int32_t> NodalPatches::order_of_vertices() const {
  std::vector<std::int32_t> order(static_cast<std::size_t>(rest_.vertex_count()),
                                  std::numeric_limits<std::int32_t>::max());
  for (Index e = 0; e < rest_.element_count(); ++e) {
    for (const Index v : rest_.nodes(e)) {
      std::int32_t& first = order[static_cast<std::size_t>(v)];
      first = std::min(first, position_of_lane_[lane(e)]);
    }
  }
  return order;
}

void NodalPatches::list_patches(const ElasticPotential& elastic) {
  // (vertex, material, element) of all nodes in ascending order.
  struct Node {
    std::int32_t order;
    Index vertex;
    int material;
    Index element;
    std::size_t node;
    auto operator<=>(const Node&) const = default;  // NOLINT(modernize-use-nullptr)
  };
  const std::vector<std::int32_t> order = order_of_vertices();
  std::vector<Node> nodes;
  nodes.reserve(4 * lane_of_element_.size());
  for (Index e = 0; e < rest_.element_count(); ++e) {
    const ElementNodes own = rest_.nodes(e);
    for (std::size_t a = 0; a < own.size(); ++a) {
      nodes.push_back(
          {order[static_cast<std::size_t>(own[a])], own[a], elastic.material_index(e), e, a});
    }
  }
  std::sort(nodes.begin(), nodes.end());
  patches_of_lane_.assign(element_of_lane_.size(), {-1, -1, -1, -1});
  for (const Node& node : nodes) {
    if (vertex_.empty() || vertex_.back() != node.vertex || material_.back() != node.material) {
      vertex_.push_back(node.vertex);
      material_.push_back(node.material);
      begin_.push_back(lanes_.size());
    }
    lanes_.push_back(static_cast<std::int32_t>(lane(node.element)));
    patches_of_lane_[lane(node.element)][node.node] = static_cast<std::int32_t>(count() - 1);
  }
  begin_.push_back(lanes_.size());
}

void NodalPatches::find_volumes(const Positions& x, AlignedVector<double>& volumes) const {
  volumes.resize(lane_count());
  for_blocks(x, [&](const ElementBlocks::Block& block, const double* positions,
                    const double* displacements) {
    element_volumes(blocks_.batches(block), positions, displacements,
                    volumes.data() + block.first_batch * kBatchLanes);
  });
}

const NodalPatches::Rows& NodalPatches::rows() const {
  if (rows_.begin.empty()) {
    list_vertices();
    list_sums();
  }
  return rows_;
}

// The corners of the tetrahedra of a patch, in ascending order.
std::vector<NodalPatches::Corner> NodalPatches::corners_of(Index patch) const {
  std::vector<Corner> corners;
  for (const std::int32_t number : lanes(patch)) {
    const auto lane = static_cast<std::size_t>(number);
    std::int32_t node = 0;
    for (const Index v : rest_.nodes(element(lane))) corners.push_back({v, number, node++});
  }
  std::sort(corners.begin(), corners.end());
  return corners;
}

void NodalPatches::list_vertices() const {
  for (Index p = 0; p < count(); ++p) {
    rows_.begin.push_back(rows_.vertices.size());
    for (const Corner& corner : corners_of(p)) {
      if (rows_.begin.back() == rows_.vertices.size() || rows_.vertices.back() != corner.vertex) {
        rows_.vertices.push_back(corner.vertex);
      }
    }
  }
  rows_.begin.push_back(rows_.vertices.size());
}

// Whether the tetrahedra with these corners, which are at one vertex, surround the edge to another:
// whether each of their other vertices belongs to two of them.
bool NodalPatches::surround_edge(std::span<const Corner> corners, Index vertex) const {
  std::vector<Index> ring;
  for (const Corner& corner : corners) {
    for (const Index v : rest_.nodes(element(static_cast<std::size_t>(corner.lane)))) {
      if (v != corner.vertex && v != vertex) ring.push_back(v);
    }
  }
  std::sort(ring.begin(), ring.end());
  for (std::size_t k = 0; k < ring.size(); k += 2) {
    if (k + 1 == ring.size() || ring[k] != ring[k + 1]) return false;
    if (k + 2 < ring.size() && ring[k] == ring[k + 2]) return false;
  }
  return true;
}

void NodalPatches::list_sums() const {
  std::vector<std::span<const Corner>> lists;  // of the sums of a patch
  for (Index p = 0; p < count(); ++p) {
    const std::vector<Corner> corners = corners_of(p);
    std::span<const Corner> own;
    bool inside = true;
    lists.clear();
    for (std::size_t begin = 0, end = 0; begin < corners.size(); begin = end) {
      const Index v = corners[begin].vertex;
      while (end < corners.size() && corners[end].vertex == v) ++end;
      const auto list = std::span(corners).subspan(begin, end - begin);
      if (v == vertex(p)) {
        own = list;
        continue;
      }
      const bool closed = surround_edge(list, vertex(p));
      inside = inside && closed;
      if (!closed || v > vertex(p)) lists.push_back(list);
    }
    // The volume at an inner vertex does not depend on its place.
    lists.push_back(inside ? own.first(0) : own);
    // Sums of the same length follow one another, so that the loop over them is predictable.
    std::stable_sort(lists.begin(), lists.end(),
                     [](const auto& a, const auto& b) { return a.size() < b.size(); });
    const auto entry = [&](Index patch, Index v) {
      const auto first = rows_.vertices.begin() +
                         static_cast<std::ptrdiff_t>(rows_.begin[static_cast<std::size_t>(patch)]);
      const auto last =
          rows_.vertices.begin() +
          static_cast<std::ptrdiff_t>(rows_.begin[static_cast<std::size_t>(patch) + 1]);
      return static_cast<std::int32_t>(std::lower_bound(first, last, v) - rows_.vertices.begin());
    };
    for (const std::span<const Corner>& list : lists) {
      GradientSum sum;
      const Index v = list.empty() ? vertex(p) : list.front().vertex;
      sum.patch = static_cast<std::int32_t>(p);
      sum.entry = entry(p, v);
      sum.corner_begin = static_cast<std::uint32_t>(rows_.corners.size());
      if (v != vertex(p) && surround_edge(list, vertex(p))) {
        sum.other_patch = patches_of_lane_[static_cast<std::size_t>(list.front().lane)]
                                          [static_cast<std::size_t>(list.front().node)];
        sum.other_entry = entry(sum.other_patch, vertex(p));
      }
      for (const Corner& corner : list) {
        const Index place = position(static_cast<std::size_t>(corner.lane));
        rows_.corners.push_back(static_cast<std::int32_t>(4 * place) + corner.node);
      }
      rows_.sums.push_back(sum);
    }
  }
  rows_.sums.emplace_back();
  rows_.sums.back().corner_begin = static_cast<std::uint32_t>(rows_.corners.size());
}

}  // namespace tetraction
