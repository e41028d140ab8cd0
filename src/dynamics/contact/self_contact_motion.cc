// Where a deformed surface penetrates itself, and how far it can move until then.
#include <algorithm>
#include <cmath>
#include <limits>

#include "additive_ccd.h"
#include "core/disjoint_sets.h"
#include "edge_crossing.h"
#include "self_contact.h"
#include "tetraction/core/parallel.h"

namespace tetraction {
namespace {

constexpr Index kWayGrain = 64;
// Rounds of clear_way() before the whole surface goes a common part of the way.
constexpr int kRoundsOfClearing = 40;
// The part of the way to the first touch that is kept.
constexpr double kKeptPart = 0.9;

std::size_t at(Index i) {
  return static_cast<std::size_t>(i);
}

}  // namespace

Index SelfContact::find_penetrating_vertex(const Vector& x) const {
  const Index count = x.size() / 3;
  Index first = count;
  const Near near = find_near(x, x, 0.0);
  const auto touches = [&](const Pair& pair) {
    if (pair_distance(pair.pair.kind, pair.points(x)).squared > 0.0) return;
    first = std::min(first, pair.vertices[0]);
  };
  for (const auto& [i, t] : near.vertex_faces) touches(vertex_face(i, t));
  for (const auto& [e, f] : near.edge_edges) touches(edge_edge(e, f));
  // Edges that cross triangles. find_near() has fitted the tree.
  constexpr Index kPiece = 256;
  const auto edges = static_cast<Index>(surface_.edges.size());
  const Index pieces = (edges + kPiece - 1) / kPiece;
  std::vector<Index> least(at(pieces), count);
  parallel_for(pieces, 1, [&](Index begin, Index end) {
    std::vector<Index> found;
    for (Index piece = begin; piece < end; ++piece) {
      const Index last = std::min(edges, (piece + 1) * kPiece);
      for (Index e = piece * kPiece; e < last; ++e) {
        const auto& [i, j] = surface_.edges[at(e)];
        Box box;
        box.add(vertex_block(x, i));
        box.add(vertex_block(x, j));
        found.clear();
        triangles_.query(box.widened(0.0), found);
        for (const Index t : found) {
          const auto& [a, b, c] = surface_.triangles[at(t)];
          if (!may_touch(i, a) || i == a || i == b || i == c || j == a || j == b || j == c)
            continue;
          if (edge_crosses_triangle(vertex_block(x, i), vertex_block(x, j), vertex_block(x, a),
                                    vertex_block(x, b), vertex_block(x, c))) {
            least[at(piece)] = std::min({least[at(piece)], i, j});
          }
        }
      }
    }
  });
  for (const Index i : least) first = std::min(first, i);
  return first == count ? -1 : first;
}

std::vector<double> SelfContact::free_parts(const std::vector<Pair>& pairs, const Vector& x,
                                            const Vector& d) const {
  std::vector<double> parts(pairs.size());
  parallel_for(static_cast<Index>(parts.size()), kWayGrain, [&](Index begin, Index end) {
    for (std::size_t k = at(begin); k < at(end); ++k) {
      parts[k] = first_touch(pairs[k].pair.kind, pairs[k].points(x), pairs[k].points(d),
                             barrier_.thickness);
    }
  });
  return parts;
}

std::vector<SelfContact::Pair> SelfContact::pairs_on_way(const Vector& from,
                                                         const Vector& to) const {
  const Near near = find_near(from, to, 0.1 * barrier_.thickness);
  std::vector<Pair> pairs;
  pairs.reserve(near.vertex_faces.size() + near.edge_edges.size());
  for (const auto& [i, t] : near.vertex_faces) pairs.push_back(vertex_face(i, t));
  for (const auto& [e, f] : near.edge_edges) pairs.push_back(edge_edge(e, f));
  return pairs;
}

double SelfContact::longest_step(const Vector& x, const Vector& d) const {
  if (!x.allFinite() || !d.allFinite()) return 0.0;
  double longest = 1.0;
  for (const double part : free_parts(pairs_on_way(x, x + d), x, d)) {
    longest = std::min(longest, part);
  }
  return longest;
}

// Vertices of pairs that would touch go a common part of their ways.
void SelfContact::clear_way(const Vector& from, Vector& x) const {
  const Index count = x.size() / 3;
  for (Index i = 0; i < count; ++i) {
    if (!vertex_block(x, i).allFinite()) vertex_block(x, i) = vertex_block(from, i);
  }
  const Vector whole = x - from;
  Vector part = Vector::Ones(count);
  DisjointSets sets(count);
  for (int round = 0; round < kRoundsOfClearing; ++round) {
    const Vector d = x - from;
    const std::vector<Pair> pairs = pairs_on_way(from, x);
    const std::vector<double> free = free_parts(pairs, from, d);
    Vector allowed = Vector::Ones(count);
    bool is_clear = true;
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      if (free[k] >= 1.0) continue;
      is_clear = false;
      for (int a = 0; a < pairs[k].size(); ++a) {
        const Index i = pairs[k].vertices[static_cast<std::size_t>(a)];
        allowed[i] = std::min(allowed[i], kKeptPart * free[k]);
        sets.join(pairs[k].vertices[0], i);
      }
    }
    if (is_clear) return;
    Index set_count = 0;
    const std::vector<Index> set = sets.numbers(set_count);
    Vector of_set = Vector::Ones(set_count);
    for (Index i = 0; i < count; ++i) {
      double& least = of_set[set[at(i)]];
      least = std::min(least, part[i] * allowed[i]);
    }
    for (Index i = 0; i < count; ++i) {
      part[i] = of_set[set[at(i)]];
      if (part[i] < 1.0) {
        vertex_block(x, i) = vertex_block(from, i) + part[i] * vertex_block(whole, i);
      }
    }
  }
  // `from` is clear, so that a common part of what is left is.
  const Vector d = x - from;
  x = from + (kKeptPart * longest_step(from, d)) * d;
}

}  // namespace tetraction
