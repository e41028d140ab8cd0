// The consistent mass: matrices of elements, momentum and weights.
#include "tetraction/dynamics/consistent_mass.h"

#include <Eigen/Geometry>
#include <cmath>

#include "support/bodies.h"

namespace tetraction {
namespace {

using namespace testing_support;

// Zienkiewicz, Taylor & Zhu: the integrals of products of the shape functions with straight edges are
// V/420 times these numbers.
TEST(ConsistentMass, MatrixOfAnElementWithStraightEdges) {
  const TetMesh mesh = with_edge_vertices(small_block());
  const RestState rest(mesh);
  const Matrix mass = element_mass_matrix(rest, 3);
  const double unit = rest.volume(3) / 420.0;
  const auto on = [](std::size_t edge, std::size_t corner) {
    return kTetrahedronEdges[edge][0] == corner || kTetrahedronEdges[edge][1] == corner;
  };
  const double tolerance = 1e-13 * 420.0 * unit;
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) EXPECT_NEAR(mass(i, j), (i == j ? 6.0 : 1.0) * unit, tolerance);
    for (std::size_t k = 0; k < 6; ++k) {
      EXPECT_NEAR(mass(i, 4 + static_cast<Index>(k)),
                  (on(k, static_cast<std::size_t>(i)) ? -4.0 : -6.0) * unit, tolerance);
    }
  }
  for (std::size_t k = 0; k < 6; ++k) {
    for (std::size_t m = 0; m < 6; ++m) {
      const bool touch = on(m, kTetrahedronEdges[k][0]) || on(m, kTetrahedronEdges[k][1]);
      const double expected = k == m ? 32.0 : touch ? 16.0 : 8.0;
      EXPECT_NEAR(mass(4 + static_cast<Index>(k), 4 + static_cast<Index>(m)), expected * unit,
                  tolerance);
    }
  }
}

TEST(ConsistentMass, MatrixOfALinearElement) {
  const TetMesh mesh = small_block();
  const RestState rest(mesh);
  const Matrix mass = element_mass_matrix(rest, 0);
  EXPECT_NEAR(mass(1, 1), rest.volume(0) / 10.0, 1e-15);
  EXPECT_NEAR(mass(0, 2), rest.volume(0) / 20.0, 1e-15);
}

TEST(ConsistentMass, WeightsAreTheMomentumOfAUnitVelocity) {
  for (const bool quadratic : {false, true}) {
    const TetMesh mesh = quadratic ? with_edge_vertices(small_block()) : small_block();
    const MechanicalSystem system(mesh, all_materials()[1], 1000.0);
    const Vector weights = consistent_weights(system);
    EXPECT_NEAR(weights.sum(), system.total_mass(), 1e-12 * system.total_mass());
    const Vector momentum = consistent_momentum(system, Vector::Ones(system.dof_count()));
    for (Index v = 0; v < system.vertex_count(); ++v) {
      EXPECT_NEAR(momentum[3 * v + 1], weights[v], 1e-12 * system.total_mass());
      if (quadratic) continue;
      EXPECT_NEAR(weights[v], system.mass()[v], 1e-12 * system.total_mass());
    }
  }
}

// A rigid rotation has the moment of inertia of the body, which lumped masses give with an error.
TEST(ConsistentMass, RotationHasTheExactMomentOfInertia) {
  const TetMesh mesh = with_edge_vertices(small_block());  // 2 × 1 × 1 m
  const MechanicalSystem system(mesh, all_materials()[1], 1000.0);
  Vector velocity(system.dof_count());
  for (Index v = 0; v < system.vertex_count(); ++v) {
    const Vector3 arm = mesh.vertices[static_cast<std::size_t>(v)] - Vector3(1.0, 0.5, 0.5);
    vertex_block(velocity, v) = Vector3::UnitZ().cross(arm);
  }
  const double exact = 2000.0 * (4.0 + 1.0) / 12.0;
  EXPECT_NEAR(velocity.dot(consistent_momentum(system, velocity)), exact, 1e-12 * exact);
}

// The map x(1 + 0.3 y), y(1 + 0.2 z), z(1 + 0.25 x) of a box, which isoparametric elements follow exactly:
// ∫ x² dV with x = Σ N_a x_a has a closed form, and N_a N_b det(∂X/∂ξ) has degree 7.
TEST(ConsistentMass, OfCurvedElementsIsExact) {
  TetMesh mesh = with_edge_vertices(small_block({1, 1, 1}));
  for (Vector3& x : mesh.vertices.own()) {
    x = Vector3(x[0] * (1.0 + 0.3 * x[1]), x[1] * (1.0 + 0.2 * x[2]), x[2] * (1.0 + 0.25 * x[0]));
  }
  const MechanicalSystem system(mesh, all_materials()[1], 1.0);
  Vector velocity = Vector::Zero(system.dof_count());
  for (Index v = 0; v < system.vertex_count(); ++v) {
    velocity[3 * v] = mesh.vertices[static_cast<std::size_t>(v)].x();
  }
  // ∫ x²(1 + 0.25 x) ∫ (1 + 0.3 y)³ ∫ (1 + 0.2 z) + 0.015 ∫ x³ ∫ y (1 + 0.3 y)² ∫ z.
  const double exact = (8.0 / 3.0 + 1.0) * (std::pow(1.3, 4) - 1.0) / 1.2 * 1.1 +
                       0.015 * 4.0 * (0.5 + 0.2 + 0.0225) * 0.5;
  EXPECT_NEAR(velocity.dot(consistent_momentum(system, velocity)), exact, 1e-13 * exact);
  EXPECT_NEAR(consistent_weights(system).sum(), system.total_mass(), 1e-14);
}

}  // namespace
}  // namespace tetraction
