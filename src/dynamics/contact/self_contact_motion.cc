// Where a deformed surface penetrates itself, and how far it can move until then.
#include <algorithm>

#include "dynamics/contact/pairs/edge_crossing.h"
#include "dynamics/contact/pairs/surface_loops.h"
#include "dynamics/contact/pairs/way_clearing.h"
#include "self_contact.h"

namespace tetraction {

Index SelfContact::find_penetrating_vertex(const Vector& x) const {
  const Index count = x.size() / 3;
  Index first = count;
  const Near near = find_near(x, x, 0.0);
  for (const MovingPair& moving : pairs_of(near)) {
    if (!(moving.distance(x) > 0.0)) first = std::min(first, moving.vertices[0]);
  }
  // Edges that cross triangles. find_near() has fitted the tree.
  const auto lowest_vertex_at_crossing = [&](Index e, std::vector<Index>& found) {
    const auto& edge = surface_.edges[static_cast<std::size_t>(e)];
    const auto& [i, j] = edge;
    triangles_.query(box_of_ways(edge, x, x).widened(0.0), found);
    for (const Index t : found) {
      const auto& [a, b, c] = surface_.triangles[static_cast<std::size_t>(t)];
      if (!may_touch(i, a) || i == a || i == b || i == c || j == a || j == b || j == c) continue;
      if (edge_crosses_triangle(vertex_block(x, i), vertex_block(x, j), vertex_block(x, a),
                                vertex_block(x, b), vertex_block(x, c))) {
        return std::min(i, j);
      }
    }
    return count;
  };
  first = std::min(first, smallest_over_items(static_cast<Index>(surface_.edges.size()), count,
                                              lowest_vertex_at_crossing));
  return first == count ? -1 : first;
}

// A margin of the boxes, so that what touches by round-off is found.
std::vector<MovingPair> SelfContact::pairs_on_way(const Vector& from, const Vector& to) const {
  return pairs_of(find_near(from, to, 0.1 * barrier_.thickness));
}

double SelfContact::longest_step(const Vector& x, const Vector& d) const {
  if (!x.allFinite() || !d.allFinite()) return 0.0;
  double longest = 1.0;
  for (const double part : free_parts_of(pairs_on_way(x, x + d), x, d, barrier_.thickness)) {
    longest = std::min(longest, part);
  }
  return longest;
}

void SelfContact::clear_way(const Vector& from, Vector& x) const {
  WayClearing clearing(from, x);
  for (int round = 0; round < WayClearing::kRounds; ++round) {
    const std::vector<MovingPair> pairs = pairs_on_way(from, x);
    const std::vector<double> free = free_parts_of(pairs, from, x - from, barrier_.thickness);
    clearing.begin_round();
    for (std::size_t k = 0; k < pairs.size(); ++k) clearing.limit(pairs[k].own(), free[k]);
    if (clearing.is_clear()) return;
    clearing.shorten();
  }
  // `from` is clear, so that a common part of what is left is.
  const Vector d = x - from;
  x = from + (WayClearing::kKept * longest_step(from, d)) * d;
}

}  // namespace tetraction
