#include "tetraction/fem/rest_state.h"

#include <Eigen/LU>

#include "tetraction/core/parallel.h"

namespace tetraction {
namespace {

using Shape = RestState::Shape;

// D_m = [X1 − X0, X2 − X0, X3 − X0].
Matrix3 rest_edges(const RestState& rest, Index e) {
  const RestState::Nodes n = rest.nodes(e);
  Matrix3 edges;
  for (int a = 0; a < 3; ++a) {
    edges.col(a) = rest.position(n[static_cast<std::size_t>(a) + 1]) - rest.position(n[0]);
  }
  return edges;
}

}  // namespace

RestElement<Shape> RestState::element(Index e) const {
  const Matrix3 edges = rest_edges(*this, e);
  RestElement<Shape> element;
  // The rows of D_m⁻¹ are the gradients of N1, N2 and N3. The gradients of all four shape functions
  // add up to zero.
  Shape::NodeMatrix& g = element.gradients[0];
  g.rightCols<3>() = edges.inverse().transpose();
  g.col(0) = -(g.col(1) + g.col(2) + g.col(3));
  element.weights[0] = edges.determinant() / 6.0;
  return element;
}

double RestState::volume(Index e) const {
  return rest_edges(*this, e).determinant() / 6.0;
}

Vector3 RestState::center(Index e) const {
  Vector3 sum = Vector3::Zero();
  for (const Index v : nodes(e)) sum += position(v);
  return sum / Shape::kNodes;
}

}  // namespace tetraction
