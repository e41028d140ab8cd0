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

/// Rest data of all elements. The object refers to the positions and tetrahedra of the mesh, which
/// must live longer. It stores nothing else: gradients, volumes and centroids are computed in each
/// call.
class RestState {
 public:
  using Shape = LinearTetrahedron;
  using Nodes = std::array<Index, Shape::kNodes>;

  explicit RestState(const TetMesh& mesh)
      : positions_(mesh.vertices.view()), tetrahedra_(mesh.tetrahedra.view()) {}
  explicit RestState(TetMesh&&) = delete;

  Index element_count() const { return static_cast<Index>(tetrahedra_.size()); }
  Index vertex_count() const { return static_cast<Index>(positions_.size()); }
  Nodes nodes(Index e) const { return tetrahedra_[static_cast<std::size_t>(e)]; }
  Vector3 position(Index vertex) const { return positions_[static_cast<std::size_t>(vertex)]; }
  /// Gradients of the shape functions and volume of element e.
  RestElement<Shape> element(Index e) const;
  /// Rest volume of element e, m³.
  double volume(Index e) const;
  /// Centroid of element e, m.
  Vector3 center(Index e) const;

  /// The values of a DOF-ordered field at the element's nodes, one column per node.
  Shape::NodeMatrix gather(const Vector& field, Index e) const {
    Shape::NodeMatrix local;
    const Nodes n = nodes(e);
    for (int a = 0; a < Shape::kNodes; ++a) {
      local.col(a) = field.segment<3>(3 * n[static_cast<std::size_t>(a)]);
    }
    return local;
  }
  /// The positions of the element's nodes relative to its first node. They suffice for F and J, and
  /// they do not have the round-off of large coordinates.
  Shape::NodeMatrix gather_relative(const Positions& x, Index e) const {
    const auto relative = [&](const Vector& field) {
      const Shape::NodeMatrix local = gather(field, e);
      return Shape::NodeMatrix(local.colwise() - local.col(0));
    };
    Shape::NodeMatrix nodes = relative(x.origin());
    if (x.displacement() != nullptr) nodes += relative(*x.displacement());
    return nodes;
  }

 private:
  VertexView positions_;
  TetrahedronView tetrahedra_;
};

}  // namespace tetraction
