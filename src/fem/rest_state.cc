#include "tetraction/fem/rest_state.h"

#include <Eigen/LU>

#include "quadratic_rules.h"

namespace tetraction {
namespace {

using Shape = RestState::Shape;

// The nodes of the point of a quadratic element: zero and the three edges. node(v) is the value at a
// vertex. Values are taken relative to the first corner, which keeps their digits.
template <class Node>
Shape::NodeMatrix quadratic_point(const ElementNodes& nodes, int point, const Node& node) {
  std::array<Vector3, QuadraticPoints::kNodes> values;
  const Vector3 origin = node(nodes[0]);
  for (std::size_t a = 0; a < values.size(); ++a) values[a] = node(nodes[a]) - origin;
  std::array<Vector3, QuadraticPoints::kEdges> edges;
  QuadraticPoints::edges_of(values, edges);
  Shape::NodeMatrix local = Shape::NodeMatrix::Zero();
  const auto first = 3 * static_cast<std::size_t>(point);
  for (std::size_t k = 0; k < 3; ++k) local.col(static_cast<Index>(k + 1)) = edges[first + k];
  return local;
}

}  // namespace

Shape::NodeMatrix RestState::gather_quadratic(const Vector& field, Index i) const {
  return quadratic_point(nodes(element_of(i)), static_cast<int>(i % 4),
                         [&](Index v) -> Vector3 { return field.segment<3>(3 * v); });
}

Matrix3 RestState::point_edges(Index i) const {
  if (is_quadratic()) {
    return quadratic_point(nodes(element_of(i)), static_cast<int>(i % 4),
                           [&](Index v) { return position(v); })
        .rightCols<3>();
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
  PointEdges edges;
  for (std::size_t p = 0; p < edges.size(); ++p) {
    edges[p] = point_edges(4 * e + static_cast<Index>(p));
  }
  return curved_volume(edges);
}

Vector3 RestState::center(Index e) const {
  Vector3 sum = Vector3::Zero();
  for (const Index v : tetrahedra_[static_cast<std::size_t>(e)]) sum += position(v);
  return sum / 4.0;
}

}  // namespace tetraction
