#include "tetraction/solver/ceres_minimizer.h"

#include "support/step_problems.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

using namespace testing_support;

class ImplicitStep : public testing::Test {
 protected:
  double residual(const Vector& x) const {
    const auto [phi, gradient] = value_and_gradient_of(problem_, x);
    return gradient.norm();
  }

  BendingBlock block_;
  MechanicalSystem& system_ = block_.system;
  const State& state_ = block_.state;
  StepProblem& problem_ = block_.problem;
};

TEST_F(ImplicitStep, SharesOfTheElementsAddUpToTheWhole) {
  Vector guess;
  problem_.inertial_guess(guess);
  const Vector x = jiggled(guess, 0.01);
  const auto [phi, gradient] = value_and_gradient_of(problem_, x);
  double sum = 0.0;
  Vector sum_gradient = Vector::Zero(x.size());
  for (Index e = 0; e < system_.rest().element_count(); ++e) {
    ElasticPotential::ElementTerms terms;
    ASSERT_TRUE(problem_.element_terms(e, x, nullptr, false, terms));
    sum += terms.energy;
    for (int a = 0; a < 4; ++a) {
      sum_gradient.segment<3>(3 * system_.rest().nodes(e)[static_cast<std::size_t>(a)]) +=
          terms.gradient.col(a);
    }
  }
  EXPECT_NEAR(sum, phi + problem_.square_value(), 1e-12 * sum);
  EXPECT_LT((system_.coordinates().restrict(sum_gradient) - gradient).norm(),
            1e-12 * gradient.norm());
}

TEST_F(ImplicitStep, AgreesWithADenseNewtonSolve) {
  const auto minimizer = make_ceres_minimizer(system_, {1e-11, 100});
  Vector x = state_.position;
  const MinimizerReport report = minimizer->minimize(problem_, x);
  ASSERT_TRUE(report.converged()) << report.message;
  const Vector reference = dense_newton(problem_, state_.position);
  const double moved = (reference - state_.position).norm();
  ASSERT_GT(moved, 0.01);
  EXPECT_LT((x - reference).norm(), 1e-8 * moved);
}

TEST_F(ImplicitStep, IterationsAreNewtonIterations) {
  // The gradient after each iteration, from solves that are cut off one iteration later each time.
  std::vector<double> residuals;
  for (int iterations = 1; iterations <= 8; ++iterations) {
    const auto minimizer = make_ceres_minimizer(system_, {1e-14, iterations});
    Vector x = state_.position;
    minimizer->minimize(problem_, x);
    residuals.push_back(residual(x));
  }
  expect_quadratic_convergence(residuals, problem_.residual_limit(state_.position, 0.5) / 0.5);
}

TEST_F(ImplicitStep, RecoversFromAnInvertedFirstGuess) {
  const auto minimizer = make_ceres_minimizer(system_, {1e-10, 100});
  Vector good = state_.position;
  ASSERT_TRUE(minimizer->minimize(problem_, good).converged());

  Vector x = state_.position;
  for (Index v = 0; v < system_.vertex_count(); ++v) {
    if (system_.coordinates().is_free(v)) x[3 * v] *= -1.0;  // mirrored: J < 0
  }
  double phi = 0.0;
  ASSERT_FALSE(problem_.value(x, phi).ok());
  problem_.set_origin(problem_.base());
  Vector u = x - problem_.base();
  const MinimizerReport report = minimizer->minimize(problem_, u);
  ASSERT_TRUE(report.converged()) << report.message;
  EXPECT_LT((problem_.base() + u - good).norm(), 1e-8 * (good - state_.position).norm());
}

TEST_F(ImplicitStep, LeavesFixedVerticesBitwiseAlone) {
  const auto minimizer = make_ceres_minimizer(system_, {});
  Vector x = state_.position;
  ASSERT_TRUE(minimizer->minimize(problem_, x).converged());
  for (Index v = 0; v < system_.vertex_count(); ++v) {
    if (!system_.coordinates().is_fully_prescribed(v)) continue;
    EXPECT_EQ(x.segment<3>(3 * v), state_.position.segment<3>(3 * v));
  }
}

TEST_F(ImplicitStep, SaysWhenTheIterationLimitIsReached) {
  const auto minimizer = make_ceres_minimizer(system_, {1e-12, 1});
  Vector x = state_.position;
  const MinimizerReport report = minimizer->minimize(problem_, x);
  EXPECT_EQ(report.termination, Termination::kIterationLimit);
  EXPECT_FALSE(report.converged());
  EXPECT_GT(report.residual, report.residual_limit);
  EXPECT_EQ(report.iterations, 1);
}

TEST_F(ImplicitStep, ConvergesForTinyMotionsOfAStiffBody) {
  const StiffBlock stiff;
  const auto minimizer = make_ceres_minimizer(stiff.system, {});
  Vector x = stiff.system.rest_state().position;
  const MinimizerReport report = minimizer->minimize(stiff.problem, x);
  EXPECT_TRUE(report.converged()) << report.message << " " << report.residual << " > "
                                  << report.residual_limit;
}

TEST_F(ImplicitStep, ForcesThatOverflowAreNotTakenForConverged) {
  system_.set_environment(Environment::uniform({0.0, -1e300, 0.0}));
  begin(problem_, state_);
  const auto minimizer = make_ceres_minimizer(system_, {});
  Vector x = state_.position;
  EXPECT_EQ(minimizer->minimize(problem_, x).termination, Termination::kInadmissible);
}

TEST(CeresMinimizer, RefusesMeaninglessOptions) {
  const MechanicalSystem system(small_block(), all_materials()[1], 1000.0);
  EXPECT_THROW(make_ceres_minimizer(system, {0.0, 100}), InputError);
  EXPECT_THROW(make_ceres_minimizer(system, {1e-8, 0}), InputError);
}

}  // namespace
}  // namespace tetraction
