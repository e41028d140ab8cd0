// What the element loop needs of the rest configuration.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "tetraction/fem/element_shape.h"
#include "tetraction/fem/positions.h"
#include "tetraction/mesh/tet_mesh.h"

namespace tetraction {

/// Rest data of all elements. Refers to the positions and tetrahedra of the mesh it was made of, which
/// must live longer, and works out the rest from them when asked.
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

  /// The element's columns of a DOF-ordered field.
  Shape::NodeMatrix gather(const Vector& field, Index e) const {
    Shape::NodeMatrix local;
    const Nodes n = nodes(e);
    for (int a = 0; a < Shape::kNodes; ++a) {
      local.col(a) = field.segment<3>(3 * n[static_cast<std::size_t>(a)]);
    }
    return local;
  }
  /// The element's nodes as seen from its first one: what F and J need, without the round-off of where
  /// the element is.
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
