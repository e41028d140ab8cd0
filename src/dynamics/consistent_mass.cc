#include "tetraction/dynamics/consistent_mass.h"

#include "mesh/quadratic_rules.h"

namespace tetraction {

Matrix element_mass_matrix(const RestState& rest, Index e) {
  if (!rest.is_quadratic()) {
    return rest.volume(e) / 20.0 * (Eigen::Matrix4d::Ones() + Eigen::Matrix4d::Identity());
  }
  static constexpr auto kPoints = rule_of_degree_seven();
  const ElementNodes nodes = rest.nodes(e);
  const Vector3 origin = rest.position(nodes[0]);
  const auto node = [&](int a) -> Vector3 {
    return rest.position(nodes[static_cast<std::size_t>(a)]) - origin;
  };
  Matrix matrix = Matrix::Zero(QuadraticPoints::kNodes, QuadraticPoints::kNodes);
  for (const VolumePoint& point : kPoints) {
    const auto shapes = quadratic_shapes(point.l);
    const Eigen::Map<const Eigen::Matrix<double, QuadraticPoints::kNodes, 1>> n(shapes.data());
    const double jacobian = quadratic_edges(point.l, node).determinant();
    matrix += point.weight / 6.0 * jacobian * n * n.transpose();
  }
  return matrix;
}

Vector consistent_momentum(const MechanicalSystem& system, const Vector& velocity) {
  const RestState& rest = system.rest();
  Vector momentum = Vector::Zero(system.dof_count());
  for (Index e = 0; e < rest.element_count(); ++e) {
    const Matrix mass = system.density(e) * element_mass_matrix(rest, e);
    const ElementNodes nodes = rest.nodes(e);
    for (std::size_t a = 0; a < nodes.size(); ++a) {
      for (std::size_t b = 0; b < nodes.size(); ++b) {
        vertex_block(momentum, nodes[a]) +=
            mass(static_cast<Index>(a), static_cast<Index>(b)) * vertex_block(velocity, nodes[b]);
      }
    }
  }
  return momentum;
}

Vector consistent_weights(const MechanicalSystem& system) {
  const RestState& rest = system.rest();
  Vector weights = Vector::Zero(system.vertex_count());
  for (Index e = 0; e < rest.element_count(); ++e) {
    const Vector sums = system.density(e) * element_mass_matrix(rest, e).rowwise().sum();
    const ElementNodes nodes = rest.nodes(e);
    for (std::size_t a = 0; a < nodes.size(); ++a) weights[nodes[a]] += sums[static_cast<Index>(a)];
  }
  return weights;
}

}  // namespace tetraction
