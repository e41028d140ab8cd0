#include "tetraction/fem/rest_state.h"

#include <Eigen/LU>

#include "tetraction/core/parallel.h"

namespace tetraction {

RestState::RestState(const TetMesh& mesh)
    : elements_(mesh.tetrahedra.size()),
      nodes_(mesh.tetrahedra),
      incidence_begin_(mesh.vertices.size() + 1, 0) {
  for (std::size_t e = 0; e < nodes_.size(); ++e) {
    const Nodes& n = nodes_[e];
    const auto vertex = [&](std::size_t a) -> const Vector3& {
      return mesh.vertices[static_cast<std::size_t>(n[a])];
    };
    Matrix3 edges;
    for (int a = 0; a < 3; ++a) {
      edges.col(a) = vertex(static_cast<std::size_t>(a) + 1) - vertex(0);
    }
    // The rows of Dm⁻¹ are the gradients of N1..N3; those of all four add up to zero.
    const Matrix3 rest_edges_inverse = edges.inverse();
    Shape::NodeMatrix& g = elements_[e].gradients[0];
    g.rightCols<3>() = rest_edges_inverse.transpose();
    g.col(0) = -(g.col(1) + g.col(2) + g.col(3));
    elements_[e].weights[0] = edges.determinant() / 6.0;
    for (const Index v : n) ++incidence_begin_[static_cast<std::size_t>(v) + 1];
  }
  for (std::size_t v = 1; v < incidence_begin_.size(); ++v) {
    incidence_begin_[v] += incidence_begin_[v - 1];
  }
  incidence_.resize(incidence_begin_.back());
  std::vector<std::size_t> next(incidence_begin_.begin(), incidence_begin_.end() - 1);
  for (std::size_t e = 0; e < nodes_.size(); ++e) {
    for (int a = 0; a < Shape::kNodes; ++a) {
      const auto v = static_cast<std::size_t>(nodes_[e][static_cast<std::size_t>(a)]);
      incidence_[next[v]++] = {static_cast<Index>(e), a};
    }
  }
}

double RestState::volume(Index e) const {
  double volume = 0.0;
  for (const double w : element(e).weights) volume += w;
  return volume;
}

void RestState::add_gathered(const std::vector<Shape::NodeMatrix>& local, Vector& field) const {
  parallel_for(vertex_count(), 2048, [&](Index begin, Index end) {
    for (Index v = begin; v < end; ++v) {
      Vector3 sum = Vector3::Zero();
      for (const Incidence* i = incidence_begin(v); i != incidence_end(v); ++i) {
        sum += local[static_cast<std::size_t>(i->element)].col(i->node);
      }
      field.segment<3>(3 * v) += sum;
    }
  });
}

}  // namespace tetraction
