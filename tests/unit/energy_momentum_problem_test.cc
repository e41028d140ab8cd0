#include "dynamics/problems/energy_momentum_problem.h"

#include <Eigen/Geometry>
#include <Eigen/Sparse>
#include <Eigen/UmfPackSupport>
#include <vector>

#include "support/bodies.h"
#include "tetraction/solver/newton_minimizer.h"
#include "tetraction/solver/newton_root_finder.h"

namespace tetraction {
namespace {

using namespace testing_support;

// A free block of rubber that is stretched and spins, and one step of it.
class EnergyMomentumStep : public testing::TestWithParam<int> {
 protected:
  EnergyMomentumStep()
      : system_(generate_box({1.0, 0.5, 0.25}, {5, 3, 2}),
                all_materials()[static_cast<std::size_t>(GetParam())], 1000.0) {
    State state = system_.rest_state();
    Vector velocity(system_.dof_count());
    for (Index v = 0; v < system_.vertex_count(); ++v) {
      const Vector3 x = Vector3(1.1, 0.97, 0.97).cwiseProduct(vertex_block(state.position, v));
      vertex_block(state.position, v) = x;
      vertex_block(velocity, v) = Vector3(1.0, 2.5, 5.0).cross(x);
    }
    system_.set_velocity(state, velocity);
    step_.begin(state, kTime, kTime, 0.5, {});
    step_.set_origin(state.position);
  }

  // ∂r/∂u over the free coordinates, column by column.
  Eigen::SparseMatrix<double> derivative(const Vector& u) {
    const FreeCoordinates& free = step_.coordinates();
    equations_.linearize(u);
    std::vector<Eigen::Triplet<double>> entries;
    Vector product;
    for (Index j = 0; j < free.count(); ++j) {
      equations_.multiply(free.extend(Vector::Unit(free.count(), j)), product);
      const Vector column = free.restrict(product);
      for (Index i = 0; i < column.size(); ++i) {
        if (column[i] != 0.0) entries.emplace_back(i, j, column[i]);
      }
    }
    Eigen::SparseMatrix<double> matrix(free.count(), free.count());
    matrix.setFromTriplets(entries.begin(), entries.end());
    return matrix;
  }

  Vector free_residual(const Vector& u) {
    Vector residual;
    EXPECT_TRUE(equations_.residual(u, residual).ok());
    return step_.coordinates().restrict(residual);
  }

  static constexpr double kTime = 0.02;  // s, about three times the stability limit
  MechanicalSystem system_;
  DiscreteGradientStep step_{system_, StepForces::kDiscrete};
  EnergyMomentumProblem equations_{step_};
};

TEST_P(EnergyMomentumStep, HasTheDerivativeOfItsResidual) {
  const Vector u = 1e-3 * Vector::Random(system_.dof_count());
  const Vector d = Vector::Random(system_.dof_count());
  constexpr double kShort = 1e-6;
  const Vector difference =
      (free_residual(u + kShort * d) - free_residual(u - kShort * d)) / (2.0 * kShort);
  const Eigen::SparseMatrix<double> matrix = derivative(u);
  EXPECT_LT((matrix * step_.coordinates().restrict(d) - difference).norm(),
            1e-7 * difference.norm());
  // It is not symmetric, so that no minimisation has these equations.
  const Eigen::SparseMatrix<double> transposed = matrix.transpose();
  EXPECT_GT((matrix - transposed).norm(), 1e-4 * matrix.norm());
}

// The reference is Newton's method with an LU factorisation of the whole derivative by UMFPACK.
TEST_P(EnergyMomentumStep, HasTheSolutionOfADirectUnsymmetricSolver) {
  Vector expected = Vector::Zero(system_.dof_count());
  std::vector<double> residuals;
  for (int i = 0; i < 12; ++i) {
    const Vector residual = free_residual(expected);
    residuals.push_back(residual.norm());
    if (residuals.back() <= 1e-13 * residuals.front()) break;
    Eigen::UmfPackLU<Eigen::SparseMatrix<double>> factor;
    const Eigen::SparseMatrix<double> matrix = derivative(expected);
    factor.compute(matrix);
    ASSERT_EQ(factor.info(), Eigen::Success);
    expected -= step_.coordinates().extend(factor.solve(residual));
  }
  EXPECT_LT(residuals.back(), 1e-11 * residuals.front());
  EXPECT_LE(residuals.size(), 9U);  // Newton's method converges quadratically

  for (const LinearSolver linear :
       {LinearSolver::kMatrixFree, LinearSolver::kCg, LinearSolver::kFactor}) {
    Vector u = Vector::Zero(system_.dof_count());
    const auto finder = linear == LinearSolver::kFactor
                            ? make_newton_root_finder(system_, {1e-12, 60})
                            : make_newton_krylov_root_finder(system_, {{1e-12, 60}, linear, true});
    const MinimizerReport report = finder->find_root(equations_, u);
    ASSERT_TRUE(report.converged()) << report.message;
    EXPECT_LT((u - expected).norm(), 1e-9 * expected.norm());
  }
}

INSTANTIATE_TEST_SUITE_P(Materials, EnergyMomentumStep, testing::Values(0, 1, 2));

}  // namespace
}  // namespace tetraction
