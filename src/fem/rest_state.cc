#include "tetraction/fem/rest_state.h"

#include <Eigen/LU>

#include "mesh/quadratic_rules.h"

namespace tetraction {
namespace {

using Shape = RestState::Shape;

// The edges at a point of a quadratic element. node(v) is the value at a vertex.
template <class Node>
Matrix3 edges_at(const ElementNodes& nodes, Index point, const Node& node) {
  return edges_at_points([&](int a) -> Vector3 {
    return node(nodes[static_cast<std::size_t>(a)]);
  })[static_cast<std::size_t>(point)];
}

}  // namespace

Shape::NodeMatrix RestState::gather_quadratic(const Vector& field, Index i) const {
  Shape::NodeMatrix local = Shape::NodeMatrix::Zero();
  local.rightCols<3>() = edges_at(nodes(element_of(i)), i % 4,
                                  [&](Index v) -> Vector3 { return field.segment<3>(3 * v); });
  return local;
}

Matrix3 RestState::point_edges(Index i) const {
  if (is_quadratic()) {
    return edges_at(nodes(element_of(i)), i % 4, [&](Index v) { return position(v); });
  }
  const auto n = tetrahedra_[static_cast<std::size_t>(i)];
  Matrix3 edges;
  for (int a = 0; a < 3; ++a) {
    edges.col(a) = position(n[static_cast<std::size_t>(a) + 1]) - position(n[0]);
  }
  return edges;
}

RestElement<Shape> RestState::point(Index i) const {
  const Matrix3 edges = point_edges(i);
  RestElement<Shape> element;
  // The rows of D_m⁻¹ are the gradients of N1, N2 and N3. The gradients of all four shape functions
  // add up to zero.
  Shape::NodeMatrix& g = element.gradients[0];
  g.rightCols<3>() = edges.inverse().transpose();
  g.col(0) = -(g.col(1) + g.col(2) + g.col(3));
  element.weights[0] = edges.determinant() / 6.0;
  return element;
}

double RestState::point_volume(Index i) const {
  return point_edges(i).determinant() / 6.0;
}

double RestState::volume(Index e) const {
  if (!is_quadratic()) return point_volume(e);
  const ElementNodes n = nodes(e);
  return curved_volume(
      edges_at_points([&](int a) { return position(n[static_cast<std::size_t>(a)]); }));
}

Vector3 RestState::center(Index e) const {
  Vector3 sum = Vector3::Zero();
  for (const Index v : tetrahedra_[static_cast<std::size_t>(e)]) sum += position(v);
  return sum / 4.0;
}

}  // namespace tetraction
