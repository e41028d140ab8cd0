// Where a deformed surface penetrates itself, and how far it can move until then.
#include <algorithm>

#include "dynamics/contact/pairs/edge_crossing.h"
#include "dynamics/contact/pairs/surface_loops.h"
#include "dynamics/contact/pairs/way_clearing.h"
#include "self_contact.h"

namespace tetraction {
namespace {

// How far a vertex moves at most, without the motion that all have in common.
double farthest_move(const Vector& d) {
  const Vector3 mean = mean_of_vertices(d);
  double farthest = 0.0;
  for (Index i = 0; i < d.size() / 3; ++i) {
    farthest = std::max(farthest, (vertex_block(d, i) - mean).norm());
  }
  return farthest;
}

}  // namespace

Index SelfContact::find_penetrating_vertex(const Vector& x) const {
  const Index count = x.size() / 3;
  Index first = count;
  for (const MovingPair& moving : pairs_of(near_.on_way(x, x, 0.0))) {
    if (!(moving.distance(x) > 0.0)) first = std::min(first, moving.vertices[0]);
  }
  for (const auto& [e, t] : near_.edge_faces(x)) {
    const auto& [i, j] = surface_.edges[static_cast<std::size_t>(e)];
    const auto& [a, b, c] = surface_.triangles[static_cast<std::size_t>(t)];
    if (std::min(i, j) < first &&
        edge_crosses_triangle(vertex_block(x, i), vertex_block(x, j), vertex_block(x, a),
                              vertex_block(x, b), vertex_block(x, c))) {
      first = std::min(i, j);
    }
  }
  return first == count ? -1 : first;
}

// A margin of the boxes, so that what touches by round-off is found.
std::vector<MovingPair> SelfContact::pairs_on_way(const Vector& from, const Vector& to) const {
  return pairs_of(near_.on_way(from, to, 0.1 * barrier_.thickness));
}

// Long ways are made in parts, of which each is twice as long as the last one: the boxes of whole ways would overlap too
// many others.
double SelfContact::longest_step(const Vector& x, const Vector& d) const {
  if (!x.allFinite() || !d.allFinite()) return 0.0;
  const double farthest = farthest_move(d);
  double done = 0.0;
  double part = farthest > longest_part_ ? longest_part_ / farthest : 1.0;
  if (!(part > 0.0)) return 0.0;  // the way is too long for numbers
  while (done < 1.0) {
    const Vector start = done == 0.0 ? x : Vector(x + done * d);
    const Vector way = part == 1.0 ? d : Vector(part * d);
    double free = 1.0;
    for (const double each :
         free_parts_of(pairs_on_way(start, start + way), start, way, barrier_.thickness)) {
      free = std::min(free, each);
    }
    if (free < 1.0) return done + free * part;
    done = part < 1.0 - done ? done + part : 1.0;
    part = std::min(2.0 * part, 1.0 - done);
  }
  return 1.0;
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
