// The vertices, edges and triangles of one surface that are near each other.
#pragma once

#include <array>
#include <vector>

#include "dynamics/contact/obstacle_contact.h"
#include "dynamics/contact/pairs/box_tree.h"

namespace tetraction {

/// Finds pairs of features of a deforming surface whose boxes overlap. Features that share a vertex are no pairs.
///
/// Steps and iterations ask for much the same places again and again. A search therefore takes larger boxes than it has to,
/// and what it finds is kept until a vertex leaves its box. The answers do not depend on that: of what is kept, exactly the
/// pairs whose own boxes overlap are returned.
///
/// Positions count from the mean of all vertices, so that a common motion, however fast, is none.
class NearFeatures {
 public:
  /// `body_of` has the number of the body of each vertex. Only features of different bodies are pairs, unless
  /// `within_bodies`. `margin`: how far a vertex may move before there is a new search, m.
  NearFeatures(ContactSurface surface, std::vector<Index> body_of, bool within_bodies,
               double margin);

  /// The numbers of two features.
  using Pairs = std::vector<std::array<Index, 2>>;
  struct Found {
    Pairs vertex_faces;  ///< vertices and triangles, in the order of the vertices
    Pairs edge_edges;    ///< each once, the lower number first
  };
  /// All pairs that are nearer than `reach` somewhere on the straight ways of the vertices from one set of positions to
  /// another, and some others. Positions have 3 numbers per vertex, m.
  Found on_way(const Vector& from, const Vector& to, double reach) const;
  /// All edges and triangles that cross each other, and some others, in the order of the edges.
  Pairs edge_faces(const Vector& x) const;

 private:
  // What a search has found, and the boxes that the vertices must not leave.
  struct Kept {
    std::vector<Box> boxes;  // of the vertices
    double reach = 0.0;      // m
    Found near;
    Pairs edge_faces;
  };

  bool may_touch(Index a, Index b) const;
  // The boxes of the ways of the vertices; none if a position is not finite.
  std::vector<Box> boxes_of_ways(const Vector& from, const Vector& to) const;
  const Kept& kept_for(const std::vector<Box>& boxes, double reach) const;
  Kept search(const std::vector<Box>& boxes, double reach) const;

  ContactSurface surface_;
  std::vector<Index> body_of_;
  bool within_bodies_;
  double margin_;
  mutable Kept kept_;                      // for a reach up to the margin
  mutable Kept far_;                       // for a larger one
  mutable std::vector<double> last_ways_;  // how far the vertices went on the last way, m
};

}  // namespace tetraction
