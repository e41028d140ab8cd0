// Distributed loads as forces on vertices: resultants, moments, and independence of the mesh.
#include "tetraction/dynamics/terms/consistent_loads.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "support/bodies.h"
#include "tetraction/core/error.h"
#include "tetraction/mesh/edge_vertices.h"

namespace tetraction {
namespace {

using namespace testing_support;

struct Resultant {
  Vector3 force = Vector3::Zero();
  Vector3 moment = Vector3::Zero();  // about the origin
};

Resultant resultant(const ExternalForce& force, const TetMesh& mesh) {
  Resultant sum;
  for (std::size_t i = 0; i < force.vertices.size(); ++i) {
    const Vector3 f = force.vectors.col(static_cast<Index>(i));
    const Vector3 x = mesh.vertices[static_cast<std::size_t>(force.vertices[i])];
    sum.force += f;
    sum.moment += x.cross(f);
  }
  return sum;
}

std::vector<std::array<Index, 3>> end_face(const TetMesh& mesh, double x) {
  return select_triangles(mesh, SelectPlane{0, x, {}});
}

TEST(ConsistentLoads, ATractionHasTheResultantOfItsSurfaceOnEveryMesh) {
  const Vector3 traction(2.0, -3.0, 0.5);
  for (const std::array<int, 3> cells : {std::array{1, 1, 1}, {2, 3, 5}, {4, 7, 2}}) {
    const TetMesh mesh = generate_box({2.0, 0.3, 0.7}, cells);
    const ExternalForce force =
        distributed_force(surface_distribution(mesh, end_face(mesh, 2.0)), traction);
    const Resultant sum = resultant(force, mesh);
    const Vector3 expected = 0.3 * 0.7 * traction;
    EXPECT_LT((sum.force - expected).norm(), 1e-14);
    // The centre of a uniform traction is the centroid of its surface.
    Vector3 centroid = Vector3::Zero();
    for (const auto& [a, b, c] : end_face(mesh, 2.0)) {
      const Vector3 x = mesh.vertices[static_cast<std::size_t>(a)];
      const Vector3 y = mesh.vertices[static_cast<std::size_t>(b)];
      const Vector3 z = mesh.vertices[static_cast<std::size_t>(c)];
      centroid += 0.5 * (y - x).cross(z - x).norm() * (x + y + z) / 3.0;
    }
    centroid /= 0.3 * 0.7;
    EXPECT_LT((sum.moment - centroid.cross(expected)).norm(), 1e-14);
  }
}

TEST(ConsistentLoads, BodyForcesAreThoseOfVolumeAndMass) {
  const TetMesh mesh = generate_box({2.0, 0.3, 0.7}, {3, 2, 2});
  const MechanicalSystem system(mesh, NeoHookean(1e5, 1e5), 800.0);
  std::vector<Index> all;
  for (Index e = 0; e < mesh.tetrahedron_count(); ++e) all.push_back(e);
  const Vector3 density(1.0, 2.0, 3.0);
  const double volume = 2.0 * 0.3 * 0.7;
  EXPECT_LT((resultant(distributed_force(volume_distribution(system, all), density), mesh).force -
             volume * density)
                .norm(),
            1e-13);
  const ExternalForce weight = distributed_force(mass_distribution(system, all), density);
  EXPECT_LT((resultant(weight, mesh).force - 800.0 * volume * density).norm(), 1e-10);
  // Every vertex has its mass times the acceleration.
  for (std::size_t i = 0; i < weight.vertices.size(); ++i) {
    const Vector3 expected = system.mass()[weight.vertices[i]] * density;
    EXPECT_LT((weight.vectors.col(static_cast<Index>(i)) - expected).norm(),
              1e-13 * expected.norm());
  }
}

TEST(ConsistentLoads, ATotalIsSharedOut) {
  const TetMesh mesh = generate_box({2.0, 0.3, 0.7}, {3, 2, 5});
  const Vector3 total(10.0, 20.0, -5.0);
  const LoadDistribution area = surface_distribution(mesh, end_face(mesh, 2.0));
  const ExternalForce force = shared_force(area, total);
  EXPECT_LT((resultant(force, mesh).force - total).norm(), 1e-13);
  EXPECT_LT((force.vectors - distributed_force(area, total / (0.3 * 0.7)).vectors).norm(), 1e-13);
  const ExternalForce equal = shared_force(equal_distribution({3, 5, 9, 11}), total);
  EXPECT_EQ(Vector3(equal.vectors.col(2)), Vector3(0.25 * total));
}

TEST(ConsistentLoads, AMomentHasNoResultantAndItsSize) {
  const TetMesh mesh = generate_box({2.0, 0.3, 0.7}, {3, 2, 5});
  for (const Vector3& moment :
       {Vector3(1.0, 0.0, 0.0), Vector3(0.0, 2.0, 0.0), Vector3(3.0, -1.0, 0.4)}) {
    const ExternalForce force =
        shared_moment(surface_distribution(mesh, end_face(mesh, 2.0)), mesh, moment);
    const Resultant sum = resultant(force, mesh);
    EXPECT_LT(sum.force.norm(), 1e-13);
    EXPECT_LT((sum.moment - moment).norm(), 1e-13);
  }
  // Two vertices carry a moment about every axis but the line through them.
  const Vector3 a = mesh.vertices[0];
  const Vector3 b = mesh.vertices[10];
  const LoadDistribution two = equal_distribution({0, 10});
  const Vector3 across = (b - a).cross(Vector3(0.3, 0.5, 0.2)).normalized();
  EXPECT_LT((resultant(shared_moment(two, mesh, across), mesh).moment - across).norm(), 1e-13);
  EXPECT_THROW(shared_moment(two, mesh, b - a), InputError);
  EXPECT_THROW(shared_moment(equal_distribution({4}), mesh, across), InputError);
}

// On a plane face with curved edges N dA has degree 4. x(1 + 0.3 y), y maps the face z = 0 of a box.
TEST(ConsistentLoads, TractionsOnPlaneFacesWithCurvedEdgesAreExact) {
  TetMesh mesh = with_edge_vertices(generate_box({2.0, 1.0, 1.0}, {1, 1, 1}));
  for (Vector3& x : mesh.vertices.own()) x[0] *= 1.0 + 0.3 * x[1];
  const ExternalForce force =
      distributed_force(surface_distribution(mesh, select_triangles(mesh, SelectPlane{2, 0.0, {}})),
                        Vector3::UnitZ());
  const Resultant sum = resultant(force, mesh);
  EXPECT_NEAR(sum.force.z(), 2.3, 1e-14);
  // ∫ y dA and −∫ x dA = −∫ x (1 + 0.3 y)² dx dy.
  EXPECT_NEAR(sum.moment.x(), 2.0 * (0.5 + 0.1), 1e-14);
  EXPECT_NEAR(sum.moment.y(), -2.0 * (1.0 + 0.3 + 0.03), 1e-14);
  // Straight edges have a third of the area at each middle and nothing at corners.
  const TetMesh straight = with_edge_vertices(generate_box({2.0, 1.0, 1.0}, {1, 1, 1}));
  const LoadDistribution flat =
      surface_distribution(straight, select_triangles(straight, SelectPlane{2, 0.0, {}}));
  EXPECT_EQ(flat.vertices.size(), 5U);
  EXPECT_NEAR(flat.weights.minCoeff(), 1.0 / 3.0, 1e-15);
}

// ∫ N_a dA over a curved face, by cutting it into many small triangles.
TEST(ConsistentLoads, TractionsOnCurvedFacesAreThoseOfManySmallTriangles) {
  TetMesh mesh = with_edge_vertices(generate_tetrahedron(1.0));
  const Vector moved = jiggled(mesh.rest_positions(), 0.15);
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    mesh.vertices.own()[static_cast<std::size_t>(v)] = vertex_block(moved, v);
  }
  const auto faces = boundary_faces(mesh);
  const EdgeVertices edges(mesh);
  for (const auto& face : faces) {
    const std::vector<Index> nodes = edges.of_face(face);
    const auto shapes = [](double r, double s) {
      const double l = 1.0 - r - s;
      return std::array<double, 6>{l * (2.0 * l - 1.0), r * (2.0 * r - 1.0), s * (2.0 * s - 1.0),
                                   4.0 * l * r,         4.0 * r * s,         4.0 * s * l};
    };
    const auto place = [&](double r, double s) {
      Vector3 x = Vector3::Zero();
      const auto n = shapes(r, s);
      for (std::size_t a = 0; a < 6; ++a) {
        x += n[a] * mesh.vertices[static_cast<std::size_t>(nodes[a])];
      }
      return x;
    };
    constexpr int kParts = 200;
    std::array<double, 6> expected{};
    const auto add = [&](double r, double s, double h) {  // a triangle of the parameters
      const Vector3 a = place(r, s);
      const double area = 0.5 * (place(r + h, s) - a).cross(place(r, s + h) - a).norm();
      const auto n = shapes(r + h / 3.0, s + h / 3.0);
      for (std::size_t k = 0; k < 6; ++k) expected[k] += area * n[k];
    };
    for (int i = 0; i < kParts; ++i) {
      for (int j = 0; i + j < kParts; ++j) {
        constexpr double kSize = 1.0 / kParts;
        add(i * kSize, j * kSize, kSize);
        if (i + j < kParts - 1) add((i + 1) * kSize, (j + 1) * kSize, -kSize);
      }
    }
    const LoadDistribution found = surface_distribution(mesh, {face});
    ASSERT_EQ(found.vertices.size(), 6U);
    double most = 0.0;
    for (std::size_t k = 0; k < 6; ++k) {
      const auto at = std::find(found.vertices.begin(), found.vertices.end(), nodes[k]);
      const double weight = found.weights[at - found.vertices.begin()];
      EXPECT_NEAR(weight, expected[k], 2e-5 * found.total());
      if (k < 3) most = std::max(most, std::abs(weight));
    }
    EXPECT_GT(most, 1e-3 * found.total());  // corners have forces, too
  }
}

}  // namespace
}  // namespace tetraction
