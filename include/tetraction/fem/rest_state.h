// What the element loop needs of the rest configuration, computed once per mesh.
#pragma once

#include <array>
#include <vector>

#include "tetraction/fem/element_shape.h"
#include "tetraction/mesh/tet_mesh.h"

namespace tetraction {

/// Rest data of all elements, and which elements meet at each vertex.
class RestState {
 public:
  using Shape = LinearTetrahedron;
  using Nodes = std::array<Index, Shape::kNodes>;

  /// One use of a vertex by an element.
  struct Incidence {
    Index element;
    int node;
  };

  explicit RestState(const TetMesh& mesh);

  Index element_count() const { return static_cast<Index>(elements_.size()); }
  Index vertex_count() const { return static_cast<Index>(incidence_begin_.size()) - 1; }
  const RestElement<Shape>& element(Index e) const {
    return elements_[static_cast<std::size_t>(e)];
  }
  const Nodes& nodes(Index e) const { return nodes_[static_cast<std::size_t>(e)]; }
  /// Rest volume of element e, m³.
  double volume(Index e) const;

  /// The element's columns of a DOF-ordered field.
  Shape::NodeMatrix gather(const Vector& field, Index e) const {
    Shape::NodeMatrix local;
    const Nodes& n = nodes(e);
    for (int a = 0; a < Shape::kNodes; ++a) {
      local.col(a) = field.segment<3>(3 * n[static_cast<std::size_t>(a)]);
    }
    return local;
  }

  /// The elements that meet at a vertex, in ascending order: the order in which their forces are
  /// added, whatever the number of threads.
  const Incidence* incidence_begin(Index vertex) const {
    return incidence_.data() + incidence_begin_[static_cast<std::size_t>(vertex)];
  }
  const Incidence* incidence_end(Index vertex) const {
    return incidence_.data() + incidence_begin_[static_cast<std::size_t>(vertex) + 1];
  }

  /// Sums columns of per-element results into a DOF-ordered field: field(v) += Σ local(e, node).
  void add_gathered(const std::vector<Shape::NodeMatrix>& local, Vector& field) const;

 private:
  std::vector<RestElement<Shape>> elements_;
  std::vector<Nodes> nodes_;
  std::vector<Incidence> incidence_;
  std::vector<std::size_t> incidence_begin_;
};

}  // namespace tetraction
