#include "tetraction/dynamics/consistent_loads.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <map>
#include <utility>

#include "core/decompositions.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

LoadDistribution make_distribution(const std::map<Index, double>& weight_of) {
  LoadDistribution distribution;
  distribution.weights.resize(static_cast<Index>(weight_of.size()));
  for (const auto& [vertex, weight] : weight_of) {
    distribution.weights[static_cast<Index>(distribution.vertices.size())] = weight;
    distribution.vertices.push_back(vertex);
  }
  return distribution;
}

Vector3 position(const TetMesh& mesh, Index v) {
  return mesh.vertices[static_cast<std::size_t>(v)];
}

}  // namespace

LoadDistribution surface_distribution(const TetMesh& mesh,
                                      const std::vector<std::array<Index, 3>>& triangles) {
  std::map<Index, double> weight_of;
  for (const auto& [a, b, c] : triangles) {
    const Vector3 x = position(mesh, a);
    const double area = 0.5 * (position(mesh, b) - x).cross(position(mesh, c) - x).norm();
    for (const Index v : {a, b, c}) weight_of[v] += area / 3.0;
  }
  return make_distribution(weight_of);
}

LoadDistribution volume_distribution(const TetMesh& mesh, const std::vector<Index>& tetrahedra) {
  std::map<Index, double> weight_of;
  for (const Index e : tetrahedra) {
    for (const Index v : mesh.tetrahedra[static_cast<std::size_t>(e)]) {
      weight_of[v] += mesh.volume(e) / 4.0;
    }
  }
  return make_distribution(weight_of);
}

LoadDistribution mass_distribution(const MechanicalSystem& system,
                                   const std::vector<Index>& tetrahedra) {
  std::map<Index, double> weight_of;
  for (const Index e : tetrahedra) {
    for (const Index v : system.rest().nodes(e)) weight_of[v] += system.mass_share(e);
  }
  return make_distribution(weight_of);
}

LoadDistribution equal_distribution(std::vector<Index> vertices) {
  const auto count = static_cast<Index>(vertices.size());
  return {std::move(vertices), Vector::Ones(count)};
}

ExternalForce distributed_force(const LoadDistribution& distribution, const Vector3& density) {
  ExternalForce force;
  force.vertices = distribution.vertices;
  force.vectors = density * distribution.weights.transpose();
  return force;
}

ExternalForce shared_force(const LoadDistribution& distribution, const Vector3& total) {
  ExternalForce force;
  force.vertices = distribution.vertices;
  force.vectors = total * (distribution.weights / distribution.total()).transpose();
  return force;
}

ExternalForce shared_moment(const LoadDistribution& distribution, const TetMesh& mesh,
                            const Vector3& moment) {
  const auto count = static_cast<Index>(distribution.vertices.size());
  Matrix arms(3, count);
  for (Index i = 0; i < count; ++i) {
    arms.col(i) = position(mesh, distribution.vertices[static_cast<std::size_t>(i)]);
  }
  arms.colwise() -= Vector3(arms * distribution.weights / distribution.total());
  Matrix3 inertia = Matrix3::Zero();
  for (Index i = 0; i < count; ++i) {
    const Vector3 r = arms.col(i);
    inertia +=
        distribution.weights[i] * (r.squaredNorm() * Matrix3::Identity() - r * r.transpose());
  }
  const SymmetricEigen3 eigen = symmetric_eigen(inertia);
  constexpr double kSingular = 1e-12;
  Vector3 theta = Vector3::Zero();
  for (int i = 0; i < 3; ++i) {
    const double part = eigen.vectors.col(i).dot(moment);
    if (eigen.values[i] > kSingular * eigen.values[2]) {
      theta += part / eigen.values[i] * eigen.vectors.col(i);
    } else if (std::abs(part) > 1e-9 * moment.norm()) {
      throw InputError(fmt::format(
          "the selected {} cannot carry this moment: select more vertices, which are not all on "
          "the axis of the moment.",
          count == 1 ? "vertex" : "vertices"));
    }
  }
  ExternalForce force;
  force.vertices = distribution.vertices;
  force.vectors.resize(3, count);
  for (Index i = 0; i < count; ++i) {
    force.vectors.col(i) = distribution.weights[i] * theta.cross(Vector3(arms.col(i)));
  }
  return force;
}

}  // namespace tetraction
