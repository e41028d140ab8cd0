#include "tetraction/dynamics/stability.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <cstdlib>

#include "support/bodies.h"
#include "support/step_problems.h"
#include "tetraction/dynamics/derivative_check.h"

namespace tetraction {
namespace {

using namespace testing_support;

// Largest eigenvalue of M⁻¹K over the free DOFs by the dense generalised eigenproblem.
double dense_omega_max(const MechanicalSystem& system, const Vector& q) {
  const SparsityPattern pattern(system.rest(), system.coordinates());
  std::vector<double> values(static_cast<std::size_t>(pattern.nonzeros()), 0.0);
  EXPECT_TRUE(system.elastic().add_hessian(q, pattern, values.data()).ok());
  const Matrix k = dense_matrix(pattern, values);
  const Matrix m = system.coordinates().reduced_mass(system.mass()).asDiagonal();
  const Eigen::GeneralizedSelfAdjointEigenSolver<Matrix> solver(k, m, Eigen::EigenvaluesOnly);
  return std::sqrt(solver.eigenvalues().maxCoeff());
}

TEST(StabilityLimit, AgreesWithTheDenseEigenproblem) {
  for (const MaterialModel& material : all_materials()) {
    for (const auto& cells : {std::array{1, 1, 1}, std::array{6, 4, 3}}) {
      MechanicalSystem system(small_block(cells), material, 1000.0);
      system.set_constraints(hold(system.mesh(), SelectPlane{0, 0.0, {}}));
      for (const Vector& q :
           {system.rest_state().position,
            strained_state(system.elastic(), system.rest_state().position, 0.2)}) {
        const StabilityLimit limit = stability_limit(system, q);
        const double exact = dense_omega_max(system, q);
        EXPECT_NEAR(limit.omega_max, exact, 1e-3 * exact) << material_name(material);
        EXPECT_NEAR(limit.critical_step, 2.0 / exact, 2e-3 / exact);
        EXPECT_GE(limit.element, 0);
      }
    }
  }
}

TEST(StabilityLimit, IsSetByTheSmallestElement) {
  TetMesh mesh = small_block();
  // Squeeze the last vertex into its neighbours.
  mesh.vertices.own().back() -= Vector3(0.45, 0.0, 0.0);
  const MechanicalSystem regular(small_block(), all_materials()[1], 1000.0);
  const MechanicalSystem squeezed(mesh, all_materials()[1], 1000.0);
  const StabilityLimit limit = stability_limit(squeezed, squeezed.rest_state().position);
  EXPECT_LT(limit.critical_step,
            0.7 * stability_limit(regular, regular.rest_state().position).critical_step);
  const auto& nodes = squeezed.rest().nodes(limit.element);
  EXPECT_NE(std::find(nodes.begin(), nodes.end(), squeezed.vertex_count() - 1), nodes.end());
}

TEST(StabilityLimit, NeitherUsesNorDependsOnTheProgramsRandomNumbers) {
  const MechanicalSystem system(small_block({6, 4, 3}), all_materials()[1], 1000.0);
  const Vector q = jiggled(system.rest_state().position, 0.01);
  std::srand(1);
  const int expected = std::rand();
  std::srand(1);
  const StabilityLimit first = stability_limit(system, q);
  EXPECT_EQ(std::rand(), expected);
  EXPECT_EQ(stability_limit(system, q).omega_max, first.omega_max);
}

TEST(StabilityLimit, IsNoneWhereEveryVertexIsHeld) {
  MechanicalSystem system(small_block(), all_materials()[1], 1000.0);
  system.set_constraints(hold(system.mesh(), SelectAll{}));
  system.set_damping({1.0, 1.0, 1.0});
  const StabilityLimit limit = stability_limit(system, system.rest_state().position);
  EXPECT_TRUE(std::isinf(limit.critical_step));
  EXPECT_EQ(limit.omega_max, 0.0);
  EXPECT_EQ(limit.element, -1);
}

}  // namespace
}  // namespace tetraction
