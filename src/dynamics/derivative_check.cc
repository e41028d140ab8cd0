#include "tetraction/dynamics/derivative_check.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace tetraction {
namespace {

using Shape = ElasticPotential::Shape;

double shortest_edge(const Shape::NodeMatrix& x) {
  double shortest = std::numeric_limits<double>::infinity();
  for (int a = 0; a < Shape::kNodes; ++a) {
    for (int b = a + 1; b < Shape::kNodes; ++b) {
      shortest = std::min(shortest, (x.col(a) - x.col(b)).norm());
    }
  }
  return shortest;
}

}  // namespace

DerivativeErrors check_derivatives(const ElasticPotential& potential, const Vector& q) {
  constexpr double kStep = 1e-5;
  const RestState& rest = potential.rest();
  Vector moved = q;
  double force_error = 0.0;
  double force_norm = 0.0;
  double stiffness_error = 0.0;
  double stiffness_norm = 0.0;
  for (Index e = 0; e < rest.element_count(); ++e) {
    ElasticPotential::ElementTerms exact;
    potential.element_terms(e, q, true, exact);
    const double step = kStep * shortest_edge(rest.gather(q, e));
    for (int j = 0; j < Shape::kDofs; ++j) {
      const Index dof = 3 * rest.nodes(e)[static_cast<std::size_t>(j / 3)] + j % 3;
      ElasticPotential::ElementTerms above;
      ElasticPotential::ElementTerms below;
      moved[dof] = q[dof] + step;
      potential.element_terms(e, moved, false, above);
      const double high = moved[dof];
      moved[dof] = q[dof] - step;
      potential.element_terms(e, moved, false, below);
      const double width = high - moved[dof];  // what the two points really are apart
      moved[dof] = q[dof];

      const double analytic = exact.gradient.data()[j];
      force_error += std::pow((above.energy - below.energy) / width - analytic, 2);
      force_norm += analytic * analytic;
      const Shape::NodeMatrix column = (above.gradient - below.gradient) / width;
      stiffness_error +=
          (Eigen::Map<const Shape::DofVector>(column.data()) - exact.hessian.col(j)).squaredNorm();
      stiffness_norm += exact.hessian.col(j).squaredNorm();
    }
  }
  return {std::sqrt(force_error / force_norm), std::sqrt(stiffness_error / stiffness_norm),
          std::sqrt(force_norm)};
}

Vector strained_state(const ElasticPotential& potential, const Vector& q, double strain) {
  const Index vertices = q.size() / 3;
  const auto points = q.reshaped(3, vertices);
  const Vector3 low = points.rowwise().minCoeff();
  const Vector3 size = (points.rowwise().maxCoeff() - low).cwiseMax(1e-300);

  double edge = std::numeric_limits<double>::infinity();
  const RestState& rest = potential.rest();
  for (Index e = 0; e < rest.element_count(); ++e) {
    edge = std::min(edge, shortest_edge(rest.gather(q, e)));
  }
  std::mt19937 random(20060901);
  std::uniform_real_distribution<double> jitter(-0.2 * edge, 0.2 * edge);

  Vector displacement(q.size());
  for (Index v = 0; v < vertices; ++v) {
    const Vector3 t = (vertex_block(q, v) - low).cwiseQuotient(size);  // in [0, 1]³
    vertex_block(displacement, v) =
        size.minCoeff() * Vector3(std::sin(2.0 * t.y()) * t.x(), std::cos(1.5 * t.z()) * t.x(),
                                  std::sin(1.0 + t.x()) * t.y()) +
        Vector3(jitter(random), jitter(random), jitter(random));
  }
  for (double scale = strain;; scale *= 0.5) {
    Vector result = q + scale * displacement;
    if (potential.admissible(result).ok()) return result;
    if (scale < 1e-12) return q;
  }
}

}  // namespace tetraction
