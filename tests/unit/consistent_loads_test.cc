// Distributed loads as forces on vertices: resultants, moments, and independence of the mesh.
#include "tetraction/dynamics/consistent_loads.h"

#include <Eigen/Geometry>

#include "support/bodies.h"
#include "tetraction/core/error.h"

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

}  // namespace
}  // namespace tetraction
