// The vertices of a body in groups of neighbours.
#pragma once

#include <vector>

#include "tetraction/fem/rest_state.h"

namespace tetraction {

/// Compact groups of about equal size, by recursive coordinate bisection of the rest positions: the
/// aggregates of the two-level preconditioner (coarse_space.h). Vertices of a group stand together
/// in the order in which conjugate gradients go over them: a vertex' *place*.
class VertexGroups {
 public:
  /// With n vertices about 0.08 n^¾ groups: so that a factor of the coarse matrix, which has six
  /// unknowns a group, costs a small and constant part of what a product with the stiffness does.
  explicit VertexGroups(const RestState& rest);

  Index count() const { return static_cast<Index>(begin_.size()) - 1; }
  /// Places [begin(g), end(g)) are those of the vertices of group g.
  Index begin(Index group) const { return begin_[static_cast<std::size_t>(group)]; }
  Index end(Index group) const { return begin(group + 1); }
  /// The group of a place.
  Index group(Index place) const;
  /// The vertices in the order of their places.
  const std::vector<std::int32_t>& order() const { return order_; }
  Index vertex(Index place) const { return order_[static_cast<std::size_t>(place)]; }

 private:
  std::vector<std::int32_t> order_;
  std::vector<Index> begin_;
};

}  // namespace tetraction
