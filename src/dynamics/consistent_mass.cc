#include "tetraction/dynamics/consistent_mass.h"

#include <Eigen/LU>
#include <array>

#include "fem/quadratic_shapes.h"

namespace tetraction {
namespace {

struct MassPoint {
  VolumeCoordinates l;
  double weight;  // of the volume of the element
};

constexpr std::array<MassPoint, 14> mass_points() {
  constexpr std::array<std::array<double, 2>, 2> kInner{
      {{0.31088591926330060980, 0.11268792571801585080},
       {0.092735250310891226402, 0.073493043116361949544}}};
  constexpr double kEdge = 0.045503704125649649492;
  constexpr double kEdgeWeight = 0.042546020777081466438;
  std::array<MassPoint, 14> points{};
  std::size_t count = 0;
  for (const auto& [a, weight] : kInner) {
    for (std::size_t i = 0; i < 4; ++i) {
      VolumeCoordinates l{a, a, a, a};
      l[i] = 1.0 - 3.0 * a;
      points[count++] = {l, weight};
    }
  }
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      VolumeCoordinates l{kEdge, kEdge, kEdge, kEdge};
      l[i] = l[j] = 0.5 - kEdge;
      points[count++] = {l, kEdgeWeight};
    }
  }
  return points;
}

}  // namespace

Matrix element_mass_matrix(const RestState& rest, Index e) {
  if (!rest.is_quadratic()) {
    return rest.volume(e) / 20.0 * (Eigen::Matrix4d::Ones() + Eigen::Matrix4d::Identity());
  }
  static const auto kPoints = mass_points();
  const ElementNodes nodes = rest.nodes(e);
  const Vector3 origin = rest.position(nodes[0]);
  const auto node = [&](int a) -> Vector3 {
    return rest.position(nodes[static_cast<std::size_t>(a)]) - origin;
  };
  Matrix matrix = Matrix::Zero(QuadraticPoints::kNodes, QuadraticPoints::kNodes);
  for (const MassPoint& point : kPoints) {
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
