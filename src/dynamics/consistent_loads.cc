#include "tetraction/dynamics/consistent_loads.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <utility>

#include "core/decompositions.h"
#include "tetraction/core/error.h"
#include "tetraction/fem/rest_state.h"
#include "tetraction/mesh/edge_vertices.h"

namespace tetraction {
namespace {

// In a part, a vertex has the weights that it has in other parts, too.
LoadDistribution make_distribution(const TetMesh& mesh, std::map<Index, double> weight_of) {
  LoadDistribution distribution;
  distribution.part = mesh.part;
  if (mesh.part) {
    Vector weights = Vector::Zero(mesh.vertex_count());
    for (const auto& [vertex, weight] : weight_of) weights[vertex] = weight;
    mesh.part->add_shared(weights.data(), 1);
    for (Index v = 0; v < weights.size(); ++v) {
      if (weights[v] != 0.0) weight_of[v] = weights[v];
    }
  }
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

// ∫ N_a dA of the six nodes of a quadratic face, by the rule with three points at the middles of the
// edges, exact for degree 2: there N_a is 1 at its own node and 0 at all others, so that corners get
// nothing. A third of the area of a flat face belongs to each middle.
void add_quadratic_face(const TetMesh& mesh, const std::vector<Index>& v,
                        std::map<Index, double>& weight_of) {
  std::array<Vector3, 6> x;
  for (std::size_t a = 0; a < 6; ++a) x[a] = position(mesh, v[a]);
  // ∂x/∂ξ and ∂x/∂η of x = Σ N_a x_a at the points (½, 0), (½, ½) and (0, ½).
  const auto area = [](const Vector3& along, const Vector3& across) {
    return 0.5 * along.cross(across).norm();
  };
  const Vector3 chord_01 = x[1] - x[0];
  const Vector3 chord_12 = x[2] - x[1];
  const Vector3 chord_20 = x[0] - x[2];
  weight_of[v[3]] += area(chord_01, -x[0] - x[2] - 2.0 * x[3] + 2.0 * x[4] + 2.0 * x[5]) / 3.0;
  weight_of[v[4]] += area(chord_12, -x[1] - x[0] - 2.0 * x[4] + 2.0 * x[5] + 2.0 * x[3]) / 3.0;
  weight_of[v[5]] += area(chord_20, -x[2] - x[1] - 2.0 * x[5] + 2.0 * x[3] + 2.0 * x[4]) / 3.0;
}

// The weights of the elements' nodes, times a density.
template <class Density>
LoadDistribution element_distribution(const MechanicalSystem& system,
                                      const std::vector<Index>& tetrahedra,
                                      const Density& density_of) {
  std::map<Index, double> weight_of;
  for (const Index e : tetrahedra) {
    const Vector weights = system.element_weights(e);
    const double density = density_of(e);
    Index a = 0;
    for (const Index v : system.rest().nodes(e)) weight_of[v] += density * weights[a++];
  }
  return make_distribution(system.mesh(), std::move(weight_of));
}

// The number of the distribution's vertices that count in a sum over the body.
Index own_count(const LoadDistribution& distribution) {
  const std::vector<Index>& vertices = distribution.vertices;
  if (!distribution.part) return static_cast<Index>(vertices.size());
  return std::lower_bound(vertices.begin(), vertices.end(), distribution.part->owned_vertices) -
         vertices.begin();
}

}  // namespace

double LoadDistribution::total() const {
  return part ? sum_over_parts(part.get(), weights.head(own_count(*this)).sum()) : weights.sum();
}

LoadDistribution surface_distribution(const TetMesh& mesh,
                                      const std::vector<std::array<Index, 3>>& triangles) {
  std::map<Index, double> weight_of;
  const EdgeVertices edges(mesh);
  for (const auto& face : triangles) {
    const std::vector<Index> v = edges.of_face(face);
    if (v.size() == 6) {
      add_quadratic_face(mesh, v, weight_of);
      continue;
    }
    const Vector3 x = position(mesh, v[0]);
    const double area = 0.5 * (position(mesh, v[1]) - x).cross(position(mesh, v[2]) - x).norm();
    for (const Index own : face) weight_of[own] += area / 3.0;
  }
  return make_distribution(mesh, std::move(weight_of));
}

LoadDistribution volume_distribution(const MechanicalSystem& system,
                                     const std::vector<Index>& tetrahedra) {
  return element_distribution(system, tetrahedra, [](Index) { return 1.0; });
}

LoadDistribution mass_distribution(const MechanicalSystem& system,
                                   const std::vector<Index>& tetrahedra) {
  return element_distribution(system, tetrahedra, [&](Index e) { return system.density(e); });
}

LoadDistribution equal_distribution(std::vector<Index> vertices, SharedMeshPart part) {
  const auto count = static_cast<Index>(vertices.size());
  return {std::move(vertices), Vector::Ones(count), std::move(part)};
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
  const Index own = own_count(distribution);
  const MeshPart* mesh_part = distribution.part.get();
  Vector3 moment_of_weights = mesh_part == nullptr
                                  ? Vector3(arms * distribution.weights)
                                  : Vector3(arms.leftCols(own) * distribution.weights.head(own));
  sum_over_parts(mesh_part, moment_of_weights.data(), 3);
  arms.colwise() -= Vector3(moment_of_weights / distribution.total());
  Matrix3 inertia = Matrix3::Zero();
  for (Index i = 0; i < own; ++i) {
    const Vector3 r = arms.col(i);
    inertia +=
        distribution.weights[i] * (r.squaredNorm() * Matrix3::Identity() - r * r.transpose());
  }
  sum_over_parts(mesh_part, inertia.data(), 9);
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
