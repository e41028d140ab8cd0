#include "tetraction/fem/rest_state.h"

#include <Eigen/LU>

#include "tetraction/core/parallel.h"

namespace tetraction {
namespace {

using Shape = RestState::Shape;

// D = [X1 − X0, X2 − X0, X3 − X0].
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
  // The rows of D⁻¹ are the gradients of N1..N3; those of all four add up to zero.
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

VertexIncidence::VertexIncidence(const RestState& rest)
    : begin_(static_cast<std::size_t>(rest.vertex_count()) + 1, 0) {
  for (Index e = 0; e < rest.element_count(); ++e) {
    for (const Index v : rest.nodes(e)) ++begin_[static_cast<std::size_t>(v) + 1];
  }
  for (std::size_t v = 1; v < begin_.size(); ++v) begin_[v] += begin_[v - 1];
  uses_.resize(begin_.back());
  std::vector<std::size_t> next(begin_.begin(), begin_.end() - 1);
  for (Index e = 0; e < rest.element_count(); ++e) {
    for (int a = 0; a < Shape::kNodes; ++a) {
      const auto v = static_cast<std::size_t>(rest.nodes(e)[static_cast<std::size_t>(a)]);
      uses_[next[v]++] = {e, a};
    }
  }
}

void VertexIncidence::add_gathered(const std::vector<Shape::NodeMatrix>& local,
                                   Vector& field) const {
  parallel_for(static_cast<Index>(begin_.size()) - 1, 2048, [&](Index begin, Index end) {
    for (Index v = begin; v < end; ++v) {
      Vector3 sum = Vector3::Zero();
      for (const Use& use : uses(v)) {
        sum += local[static_cast<std::size_t>(use.element)].col(use.node);
      }
      field.segment<3>(3 * v) += sum;
    }
  });
}

}  // namespace tetraction
