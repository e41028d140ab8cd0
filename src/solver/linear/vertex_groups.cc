#include "vertex_groups.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace tetraction {
namespace {

// Sorts the vertices [begin, end) into `groups` parts, cut across their longest extent.
void bisect(const RestState& rest, std::vector<std::int32_t>& order, Index begin, Index end,
            Index groups, std::vector<Index>& ends) {
  const auto first = order.begin() + begin;
  const auto last = order.begin() + end;
  if (groups == 1) {
    std::sort(first, last);
    ends.push_back(end);
    return;
  }
  Vector3 low = rest.position(*first);
  Vector3 high = low;
  std::for_each(first, last, [&](std::int32_t v) {
    low = low.cwiseMin(rest.position(v));
    high = high.cwiseMax(rest.position(v));
  });
  Index axis = 0;
  (high - low).maxCoeff(&axis);
  const Index middle = begin + (end - begin) * (groups / 2) / groups;
  std::nth_element(first, order.begin() + middle, last, [&](std::int32_t a, std::int32_t b) {
    return std::pair(rest.position(a)[axis], a) < std::pair(rest.position(b)[axis], b);
  });
  bisect(rest, order, begin, middle, groups / 2, ends);
  bisect(rest, order, middle, end, groups - groups / 2, ends);
}

}  // namespace

VertexGroups::VertexGroups(const RestState& rest, const MeshPart* part)
    : order_(static_cast<std::size_t>(rest.vertex_count())), begin_{0} {
  const Index all = rest.vertex_count();
  const Index n = part != nullptr ? part->owned_vertices : all;
  std::iota(order_.begin(), order_.end(), 0);
  if (n > 0) {
    const Index groups =
        std::clamp<Index>(std::llround(0.04 * std::pow(static_cast<double>(n), 0.85)), 1, n);
    bisect(rest, order_, 0, n, groups, begin_);
  }
  count_ = count_with_copies();
  constexpr Index kCopies = 64;  // in a group
  for (Index end = n; end < all;) begin_.push_back(end = std::min(end + kCopies, all));
}

Index VertexGroups::group(Index place) const {
  return std::upper_bound(begin_.begin(), begin_.end(), place) - begin_.begin() - 1;
}

}  // namespace tetraction
