#include "tetraction/dynamics/terms/consistent_loads.h"

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

// A quadratic face: its corners, and the vertices in the middles of the edges 01, 12 and 20.
using FaceNodes = std::array<Vector3, 6>;

// |∂x/∂L_1 × ∂x/∂L_2| at L_1 = r, L_2 = s: the area at x in an area of the parameters.
double area_density(const FaceNodes& x, double r, double s) {
  const double l = 1.0 - r - s;
  const Vector3 along =
      (1.0 - 4.0 * l) * x[0] + (4.0 * r - 1.0) * x[1] + 4.0 * ((l - r) * x[3] + s * (x[4] - x[5]));
  const Vector3 across =
      (1.0 - 4.0 * l) * x[0] + (4.0 * s - 1.0) * x[2] + 4.0 * ((l - s) * x[5] + r * (x[4] - x[3]));
  return along.cross(across).norm();
}

// Whether the edges are straight up to round-off, with their vertices in the middle.
bool is_straight(const FaceNodes& x) {
  constexpr double kRoundOff = 1e-12;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vector3& a = x[k];
    const Vector3& b = x[(k + 1) % 3];
    if ((x[k + 3] - 0.5 * (a + b)).norm() > kRoundOff * (b - a).norm()) return false;
  }
  return true;
}

// A third of the area belongs to each middle, and nothing to the corners.
std::array<double, 6> straight_face_weights(const FaceNodes& x) {
  const auto area = [](const Vector3& along, const Vector3& across) {
    return 0.5 * along.cross(across).norm();
  };
  return {0.0,
          0.0,
          0.0,
          area(x[1] - x[0], -x[0] - x[2] - 2.0 * x[3] + 2.0 * x[4] + 2.0 * x[5]) / 3.0,
          area(x[2] - x[1], -x[1] - x[0] - 2.0 * x[4] + 2.0 * x[5] + 2.0 * x[3]) / 3.0,
          area(x[0] - x[2], -x[2] - x[1] - 2.0 * x[5] + 2.0 * x[3] + 2.0 * x[4]) / 3.0};
}

// ∫ N_a dA of the six nodes of a quadratic face. With curved edges in a plane N_a dA has degree 4; on
// a curved surface it is no polynomial, but smooth. The rule is the product of two of Gauss with 8
// points, along a line from a corner and along the opposite edge, and has degree 14.
std::array<double, 6> quadratic_face_weights(const FaceNodes& x) {
  if (is_straight(x)) return straight_face_weights(x);
  // Places and weights between −1 and 1, and those with the other sign.
  constexpr std::array<std::array<double, 2>, 4> kGauss{
      {{0.18343464249564980494, 0.36268378337836198297},
       {0.52553240991632898582, 0.31370664587788728734},
       {0.79666647741362673959, 0.22238103445337447054},
       {0.96028985649753623168, 0.10122853629037625915}}};
  const auto at = [&](std::size_t i) {
    const auto& [place, weight] = kGauss[i / 2];
    return std::array{0.5 + (i % 2 == 0 ? 0.5 : -0.5) * place, 0.5 * weight};
  };
  std::array<double, 6> weights{};
  for (std::size_t i = 0; i < 8; ++i) {
    for (std::size_t j = 0; j < 8; ++j) {
      const auto [u, weight_u] = at(i);
      const auto [v, weight_v] = at(j);
      const double r = u * (1.0 - v);
      const double s = u * v;
      const double l = 1.0 - u;
      const double area = u * weight_u * weight_v * area_density(x, r, s);
      const std::array<double, 6> shapes{l * (2.0 * l - 1.0), r * (2.0 * r - 1.0),
                                         s * (2.0 * s - 1.0), 4.0 * l * r,
                                         4.0 * r * s,         4.0 * s * l};
      for (std::size_t a = 0; a < 6; ++a) weights[a] += area * shapes[a];
    }
  }
  return weights;
}

void add_quadratic_face(const TetMesh& mesh, const std::vector<Index>& v,
                        std::map<Index, double>& weight_of) {
  FaceNodes x;
  for (std::size_t a = 0; a < 6; ++a) x[a] = position(mesh, v[a]);
  const std::array<double, 6> weights = quadratic_face_weights(x);
  for (std::size_t a = 0; a < 6; ++a) {
    if (weights[a] != 0.0) weight_of[v[a]] += weights[a];
  }
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
