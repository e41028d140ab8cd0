#include "tetraction/solver/ceres_minimizer.h"

#include <Eigen/Cholesky>

#include "support/bodies.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

using namespace testing_support;

constexpr double kStep = 0.02;

// A clamped block under gravity and a spin: bends, stretches and turns within a step.
class ImplicitStep : public testing::Test {
 protected:
  ImplicitStep() : system_(small_block(), all_materials()[1], 1000.0), problem_(system_) {
    system_.set_constraints(hold(system_.mesh(), SelectPlane{0, 0.0, {}}));
    system_.set_environment(Environment::uniform({0.0, -9.81, 0.0}));
    state_ = system_.rest_state();
    Vector velocity(system_.dof_count());
    for (Index v = 0; v < system_.vertex_count(); ++v) {
      const Vector3 x = system_.mesh().vertices[static_cast<std::size_t>(v)];
      velocity.segment<3>(3 * v) = x.x() * Vector3(0.5, -4.0, 2.0 * x.y());
    }
    system_.set_velocity(state_, velocity);
    problem_.begin(state_, kStep, kStep, 1.0, Vector::Zero(system_.dof_count()));
  }

  double residual(const Vector& x) const {
    double phi = 0.0;
    Vector gradient;
    EXPECT_TRUE(problem_.value_and_gradient(x, phi, gradient).ok());
    return gradient.norm();
  }

  // Newton's method with a dense Cholesky factor of the assembled Hessian and step halving.
  Vector dense_newton() const {
    const SparsityPattern pattern(system_.rest(), system_.coordinates());
    std::vector<double> values(static_cast<std::size_t>(pattern.nonzeros()));
    Vector x = state_.position;
    for (int iteration = 0; iteration < 50; ++iteration) {
      double phi = 0.0;
      Vector gradient;
      EXPECT_TRUE(problem_.value_and_gradient(x, phi, gradient).ok());
      if (gradient.norm() < 1e-12 * problem_.residual_limit(x, 0.5)) break;
      EXPECT_TRUE(problem_.hessian(x, pattern, values.data()).ok());
      Matrix k = Matrix::Zero(pattern.size(), pattern.size());
      for (Index j = 0; j < pattern.size(); ++j) {
        for (int i = pattern.column_begin()[static_cast<std::size_t>(j)];
             i < pattern.column_begin()[static_cast<std::size_t>(j) + 1]; ++i) {
          k(pattern.rows()[static_cast<std::size_t>(i)], j) = values[static_cast<std::size_t>(i)];
        }
      }
      const Vector step =
          system_.coordinates().extend(k.selfadjointView<Eigen::Lower>().ldlt().solve(-gradient));
      double length = 1.0;
      double trial = 0.0;
      while (!problem_.value(x + length * step, trial).ok() ||
             trial > phi + 1e-12 * std::abs(phi)) {
        length *= 0.5;
        if (length < 1e-6) break;
      }
      x += length * step;
    }
    return x;
  }

  MechanicalSystem system_;
  State state_;
  StepProblem problem_;
};

TEST_F(ImplicitStep, SharesOfTheElementsAddUpToTheWhole) {
  const Vector x = jiggled(problem_.inertial_guess(), 0.01);
  double phi = 0.0;
  Vector gradient;
  ASSERT_TRUE(problem_.value_and_gradient(x, phi, gradient).ok());
  double sum = 0.0;
  Vector sum_gradient = Vector::Zero(x.size());
  for (Index e = 0; e < system_.rest().element_count(); ++e) {
    ElasticPotential::ElementTerms terms;
    ASSERT_TRUE(problem_.element_terms(e, x, false, terms));
    sum += terms.energy;
    for (int a = 0; a < 4; ++a) {
      sum_gradient.segment<3>(3 * system_.rest().nodes(e)[static_cast<std::size_t>(a)]) +=
          terms.gradient.col(a);
    }
  }
  EXPECT_NEAR(sum, phi, 1e-12 * phi);
  EXPECT_LT((system_.coordinates().restrict(sum_gradient) - gradient).norm(),
            1e-12 * gradient.norm());
}

TEST_F(ImplicitStep, AgreesWithADenseNewtonSolve) {
  const auto minimizer = make_ceres_minimizer(system_, {1e-11, 100});
  Vector x = state_.position;
  const MinimizerReport report = minimizer->minimize(problem_, x);
  ASSERT_TRUE(report.converged()) << report.message;
  const Vector reference = dense_newton();
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
  // Quadratic: once |g| has fallen below 1e-2 of the force scale, each iteration squares it, up to
  // a constant, until round-off.
  const double scale = problem_.residual_limit(state_.position, 0.5) / 0.5;
  const double floor = 1e-11 * scale;
  int squared = 0;
  for (std::size_t i = 0; i + 1 < residuals.size(); ++i) {
    const double relative = residuals[i] / scale;
    if (relative > 1e-2 || residuals[i] < floor) continue;
    EXPECT_LT(residuals[i + 1], std::max(20.0 * relative * relative * scale, floor));
    ++squared;
  }
  EXPECT_GE(squared, 1);
  EXPECT_LT(residuals.back(), floor);
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
  const MinimizerReport report = minimizer->minimize(problem_, x);
  ASSERT_TRUE(report.converged()) << report.message;
  EXPECT_LT((x - good).norm(), 1e-8 * (good - state_.position).norm());
}

TEST_F(ImplicitStep, LeavesFixedVerticesBitwiseAlone) {
  const auto minimizer = make_ceres_minimizer(system_, {});
  Vector x = state_.position;
  ASSERT_TRUE(minimizer->minimize(problem_, x).converged());
  for (Index v = 0; v < system_.vertex_count(); ++v) {
    if (!system_.coordinates().is_held(v)) continue;
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
  // Strains of 1e-9: nothing is left of the elastic energy beside a constant of 0.1 μ.
  MechanicalSystem stiff(small_block(), NeoHookean(8e10, 1.2e11), 7800.0);
  stiff.set_constraints(hold(stiff.mesh(), SelectPlane{0, 0.0, {}}));
  stiff.set_environment(Environment::uniform({0.0, -1e-3, 0.0}));
  StepProblem problem(stiff);
  problem.begin(stiff.rest_state(), 0.1, 0.1, 1.0, Vector::Zero(stiff.dof_count()));
  const auto minimizer = make_ceres_minimizer(stiff, {});
  Vector x = stiff.rest_state().position;
  const MinimizerReport report = minimizer->minimize(problem, x);
  EXPECT_TRUE(report.converged()) << report.message << " " << report.residual << " > "
                                  << report.residual_limit;
}

TEST_F(ImplicitStep, ForcesThatOverflowAreNotTakenForConverged) {
  system_.set_environment(Environment::uniform({0.0, -1e300, 0.0}));
  problem_.begin(state_, kStep, kStep, 1.0, Vector::Zero(system_.dof_count()));
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
