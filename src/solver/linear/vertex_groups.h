// Divides the vertices of a body into groups of neighbours.
#pragma once

#include <vector>

#include "tetraction/fem/rest_state.h"
#include "tetraction/mesh/mesh_part.h"

namespace tetraction {

/// Compact groups of about equal size, made by recursive coordinate bisection of the rest
/// positions. They are the aggregates of the two-level preconditioner (coarse_space.h). Conjugate
/// gradients process the vertices in an order in which those of a group follow one another. The
/// position of a vertex in this order is its *place*.
class VertexGroups {
 public:
  /// Makes about 0.04 n^0.85 groups of n vertices. If groups had a fixed size, the number of iterations would not
  /// grow with n, but a solve with the factor of the coarse matrix, which has six unknowns per group, would cost
  /// about n^(4/3). So the size of groups grows slowly. Up to 200,000 vertices the solve takes less than a tenth of
  /// an iteration, and from 4,000 to 200,000 vertices the iterations grow by a factor of 1.4 (docs/scaling.md).
  ///
  /// For a part of a body, these are groups of its own vertices. The copies of vertices of other parts come
  /// in further groups, which serve for loops only.
  explicit VertexGroups(const RestState& rest, const MeshPart* part = nullptr);

  /// The number of groups without those of copies.
  Index count() const { return count_; }
  /// The number of all groups.
  Index count_with_copies() const { return static_cast<Index>(begin_.size()) - 1; }
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
  Index count_ = 0;
};

}  // namespace tetraction
