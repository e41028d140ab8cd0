// The data of the rest configuration that the element loops need.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "tetraction/fem/element_shape.h"
#include "tetraction/fem/positions.h"
#include "tetraction/mesh/tet_mesh.h"

namespace tetraction {

/// The vertices of one element: four corners, and the middles of the six edges if it is quadratic.
class ElementNodes {
 public:
  explicit ElementNodes(const std::array<Index, 4>& corners) : count_(4) {
    for (std::size_t a = 0; a < 4; ++a) nodes_[a] = corners[a];
  }
  ElementNodes(const std::array<Index, 4>& corners, const std::array<Index, 6>& middles)
      : ElementNodes(corners) {
    count_ = 10;
    for (std::size_t a = 0; a < 6; ++a) nodes_[4 + a] = middles[a];
  }
  std::size_t size() const { return count_; }
  const Index* begin() const { return nodes_.data(); }
  const Index* end() const { return nodes_.data() + count_; }
  Index operator[](std::size_t a) const { return nodes_[a]; }

 private:
  std::array<Index, 10> nodes_{};
  std::size_t count_;
};

/// Rest data of all elements. The object refers to the positions and tetrahedra of the mesh, which
/// must live longer. It stores nothing else: gradients, volumes and centroids are computed in each
/// call.
///
/// An element has one quadrature point if it is linear, and four if it is quadratic; the points of
/// element e are those from e × points_per_element() on. Every point is presented as a linear
/// tetrahedron with the volume that the point stands for, whose nodes follow linearly from those of
/// the element (src/mesh/quadratic_points.h). For a linear mesh point e is element e itself.
class RestState {
 public:
  using Shape = LinearTetrahedron;

  explicit RestState(const TetMesh& mesh)
      : positions_(mesh.vertices.view()),
        tetrahedra_(mesh.tetrahedra.view()),
        edge_vertices_(mesh.edge_vertices) {}
  explicit RestState(TetMesh&&) = delete;

  Index element_count() const { return static_cast<Index>(tetrahedra_.size()); }
  Index vertex_count() const { return static_cast<Index>(positions_.size()); }
  bool is_quadratic() const { return !edge_vertices_.empty(); }
  int nodes_per_element() const { return is_quadratic() ? 10 : 4; }
  int points_per_element() const { return is_quadratic() ? 4 : 1; }
  Index point_count() const { return points_per_element() * element_count(); }
  Index element_of(Index point) const { return is_quadratic() ? point / 4 : point; }
  ElementNodes nodes(Index e) const {
    const auto i = static_cast<std::size_t>(e);
    return is_quadratic() ? ElementNodes(tetrahedra_[i], edge_vertices_[i])
                          : ElementNodes(tetrahedra_[i]);
  }
  Vector3 position(Index vertex) const { return positions_[static_cast<std::size_t>(vertex)]; }
  /// Gradients of the shape functions and volume of a point.
  RestElement<Shape> point(Index i) const;
  /// The rest edges [X1−X0, X2−X0, X3−X0] of a point, m.
  Matrix3 point_edges(Index i) const;
  /// The volume that a point stands for, m³.
  double point_volume(Index i) const;
  /// Rest volume of element e, exact also with curved edges, m³.
  double volume(Index e) const;
  /// Centroid of the corners of element e, m.
  Vector3 center(Index e) const;
  /// The share of an element's mass that belongs to its node a. Linear elements have equal shares.
  /// Quadratic ones have 1/36 at a corner and 4/27 in the middle of an edge: the diagonal of the
  /// consistent mass matrix of an element with straight edges, scaled to the right sum (Hinton, Rock &
  /// Zienkiewicz 1976). It is positive, and it has the right centre of mass.
  double mass_fraction(int a) const {
    if (!is_quadratic()) return 0.25;
    return a < 4 ? 1.0 / 36.0 : 4.0 / 27.0;
  }

  /// The values of a DOF-ordered field at the nodes of a point, one column per node. For the point of
  /// a quadratic element, of whose nodes only the differences have a meaning, the first is zero.
  Shape::NodeMatrix gather(const Vector& field, Index i) const {
    if (is_quadratic()) return gather_quadratic(field, i);
    Shape::NodeMatrix local;
    const auto n = tetrahedra_[static_cast<std::size_t>(i)];
    for (int a = 0; a < Shape::kNodes; ++a) {
      local.col(a) = field.segment<3>(3 * n[static_cast<std::size_t>(a)]);
    }
    return local;
  }
  /// The positions of the nodes of a point relative to its first node. They suffice for F and J, and
  /// they do not have the round-off of large coordinates.
  Shape::NodeMatrix gather_relative(const Positions& x, Index i) const {
    const auto relative = [&](const Vector& field) {
      const Shape::NodeMatrix local = gather(field, i);
      return Shape::NodeMatrix(local.colwise() - local.col(0));
    };
    Shape::NodeMatrix nodes = relative(x.origin());
    if (x.displacement() != nullptr) nodes += relative(*x.displacement());
    return nodes;
  }

 private:
  Shape::NodeMatrix gather_quadratic(const Vector& field, Index i) const;

  VertexView positions_;
  TetrahedronView tetrahedra_;
  std::span<const std::array<Index, 6>> edge_vertices_;
};

}  // namespace tetraction
