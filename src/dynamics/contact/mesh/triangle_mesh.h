// A surface of triangles that does not deform.
#pragma once

#include <array>
#include <vector>

#include "dynamics/contact/pairs/box_tree.h"
#include "tetraction/core/types.h"

namespace tetraction {

/// A rigid surface of triangles, watertight or open. Both of its sides act.
///
/// Its features are its triangles, edges and vertices, numbered one after the other. A sum over the distances of
/// a point takes each feature with its coefficient: 1 for triangles, 1 − (number of triangles) for edges, and for
/// vertices what makes the sum of all features at the vertex 1: inner edges −1, inner vertices +1, those of a
/// border 0 (the convergent sum of M. Li et al., Convergent incremental potential contact, 2023). A point has
/// then one closest place on a flat part of the surface, whatever its triangles.
class TriangleMesh {
 public:
  /// Points with equal coordinates are one, points of no triangle are left out, and so are repeated triangles.
  /// Throws InputError if there is no triangle, a number is not finite, a corner is out of range, or a triangle
  /// has no area: its height is below 1e-10 of its longest edge.
  TriangleMesh(const std::vector<Vector3>& points,
               const std::vector<std::array<Index, 3>>& triangles);

  const std::vector<Vector3>& points() const { return points_; }
  const std::vector<std::array<Index, 3>>& triangles() const { return triangles_; }
  /// Each once, lower number first.
  const std::vector<std::array<Index, 2>>& edges() const { return edges_; }
  /// Edge k of a triangle joins its corners k and k + 1.
  const std::vector<std::array<Index, 3>>& triangle_edges() const { return triangle_edges_; }
  /// Whether each edge has two triangles or another even number.
  bool watertight() const { return watertight_; }

  /// Edges and vertices at which the surface is not flat, or ends. A flat body face that comes down on a flat
  /// part touches it nowhere else.
  const std::vector<Index>& sharp_edges() const { return sharp_edges_; }
  const std::vector<Index>& sharp_vertices() const { return sharp_vertices_; }

  Index feature_count() const { return first_vertex() + static_cast<Index>(points_.size()); }
  Index first_edge() const { return static_cast<Index>(triangles_.size()); }
  Index first_vertex() const { return first_edge() + static_cast<Index>(edges_.size()); }
  double coefficient(Index feature) const {
    return coefficients_[static_cast<std::size_t>(feature)];
  }
  /// The feature of a triangle that is closest to a point: its inside, one of its edges, or a vertex.
  Index closest_feature_of_triangle(Index triangle, const Vector3& x) const;
  /// The same of an edge, by its number among edges.
  Index closest_feature_of_edge(Index edge, const Vector3& x) const;
  /// From the closest point of the plane, line or point of a feature to x.
  Vector3 offset(Index feature, const Vector3& x) const;
  /// ∂ offset/∂x: the projector normal to the feature.
  Matrix3 projector(Index feature) const;
  /// Appends the parts of the way from x to x + move at which the closest feature of a triangle may change:
  /// for each the part t in (0, 1), and its derivative by x + move.
  struct Crossing {
    double t;
    Vector3 rate;
  };
  void add_crossings(Index triangle, const Vector3& x, const Vector3& move,
                     std::vector<Crossing>& crossings) const;
  /// The same of an edge.
  void add_edge_crossings(Index edge, const Vector3& x, const Vector3& move,
                          std::vector<Crossing>& crossings) const;

  /// The trees of all triangles, edges and vertices.
  const BoxTree& triangle_tree() const { return triangle_tree_; }
  const BoxTree& edge_tree() const { return edge_tree_; }
  const BoxTree& vertex_tree() const { return vertex_tree_; }
  /// Their items are places in sharp_edges() and sharp_vertices().
  const BoxTree& sharp_edge_tree() const { return sharp_edge_tree_; }
  const BoxTree& sharp_vertex_tree() const { return sharp_vertex_tree_; }

 private:
  void weld(const std::vector<Vector3>& points, const std::vector<std::array<Index, 3>>& triangles);
  void find_edges();
  void find_sharp_features(const std::vector<std::vector<Index>>& triangles_of_edge);
  void build_trees();

  std::vector<Vector3> points_;
  std::vector<std::array<Index, 3>> triangles_;
  std::vector<Vector3> normals_;  // of length 1
  std::vector<std::array<Index, 2>> edges_;
  std::vector<std::array<Index, 3>> triangle_edges_;
  std::vector<double> coefficients_;
  std::vector<Index> sharp_edges_;
  std::vector<Index> sharp_vertices_;
  bool watertight_ = false;
  BoxTree triangle_tree_;
  BoxTree edge_tree_;
  BoxTree vertex_tree_;
  BoxTree sharp_edge_tree_;
  BoxTree sharp_vertex_tree_;
};

}  // namespace tetraction
