#include "tetraction/solver/newton_root_finder.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "core/gmres.h"
#include "support/step_problems.h"
#include "tetraction/core/error.h"
#include "tetraction/solver/newton_minimizer.h"

namespace tetraction {
namespace {

using namespace testing_support;

TEST(Gmres, SolvesAnUnsymmetricSystem) {
  constexpr int kSize = 30;
  const Matrix a = Matrix::Random(kSize, kSize) + 8.0 * Matrix::Identity(kSize, kSize);
  const Vector b = Vector::Random(kSize);
  const Vector diagonal = a.diagonal().cwiseInverse();
  const auto multiply = [&](const Vector& v, Vector& w) { w = a * v; };
  const auto precondition = [&](const Vector& v, Vector& w) { w = diagonal.cwiseProduct(v); };
  Vector x;
  const GmresReport rough = gmres(b, multiply, precondition, 1e-3, kSize, x);
  EXPECT_TRUE(rough.converged);
  EXPECT_LE((b - a * x).norm(), 1.0001e-3 * b.norm());
  EXPECT_NEAR((b - a * x).norm() / b.norm(), rough.reduction, 1e-12);
  const GmresReport exact = gmres(b, multiply, precondition, 1e-13, kSize, x);
  EXPECT_TRUE(exact.converged);
  EXPECT_GT(exact.iterations, rough.iterations);
  EXPECT_LT((x - a.partialPivLu().solve(b)).norm(), 1e-11 * x.norm());
  const GmresReport cut = gmres(b, multiply, precondition, 1e-13, 3, x);
  EXPECT_FALSE(cut.converged);
  EXPECT_EQ(cut.iterations, 3);
  EXPECT_NEAR((b - a * x).norm() / b.norm(), cut.reduction, 1e-12);
}

TEST(Gmres, KnowsTheSolutionsOfZeroAndOfTheIdentity) {
  const auto copy = [](const Vector& v, Vector& w) { w = v; };
  Vector x;
  EXPECT_TRUE(gmres(Vector::Zero(5), copy, copy, 1e-10, 5, x).converged);
  EXPECT_EQ(x, Vector::Zero(5));
  const Vector b = Vector::Random(5);
  const GmresReport report = gmres(b, copy, copy, 1e-10, 5, x);
  EXPECT_EQ(report.iterations, 1);
  EXPECT_LT((x - b).norm(), 1e-15 * b.norm());
}

// The step of a StepProblem with a circulatory force in addition: κ e × u at every vertex, whose
// derivative is skew-symmetric. It has no potential.
class CirculatoryStep : public RootProblem {
 public:
  CirculatoryStep(const StepProblem& step, double strength) : step_(step), strength_(strength) {}

  const FreeCoordinates& coordinates() const override { return step_.coordinates(); }
  double length_scale() const override { return step_.length_scale(); }
  bool is_defined(const Vector& u) const override { return step_.is_defined(u); }
  EvaluationStatus residual(const Vector& u, Vector& residual) const override {
    const EvaluationStatus status = step_.residual(u, residual);
    if (status.ok()) add_circulation(u, residual);
    return status;
  }
  double longest_step(const Vector& u, const Vector& d, bool elements_are_safe) const override {
    return step_.longest_step(u, d, elements_are_safe);
  }
  double force_scale() const override { return step_.force_scale(); }
  double round_off(const Vector& u) const override { return step_.round_off(u); }
  EvaluationStatus linearize(const Vector& u) override {
    hessian_ = dense_hessian(step_, u);
    return {};
  }
  void multiply(const Vector& d, Vector& product) const override {
    product = coordinates().extend(hessian_ * coordinates().restrict(d));
    add_circulation(d, product);
  }
  const MinimizationProblem& approximation() const override { return step_; }

 private:
  void add_circulation(const Vector& u, Vector& force) const {
    for (Index v = 0; v < u.size() / 3; ++v) {
      vertex_block(force, v) += strength_ * Vector3(1.0, 2.0, -1.0).cross(vertex_block(u, v));
    }
  }

  const StepProblem& step_;
  double strength_;
  Matrix hessian_;
};

class RootOfAStep : public ::testing::Test {
 protected:
  RootOfAStep() {
    problem_.begin(block_.state, kStep, kStep, 1.0, {});
    mass_term_ = problem_.coefficient().maxCoeff();
  }
  BendingBlock block_;
  StepProblem& problem_ = block_.problem;
  double mass_term_ = 0.0;  // N/m
};

TEST_F(RootOfAStep, HasNoResidualAlthoughTheDerivativeIsUnsymmetric) {
  const auto finder = make_newton_root_finder(block_.system, {1e-11, 60});
  Vector without;
  for (const double share : {0.0, 0.3, 2.0}) {
    CirculatoryStep problem(problem_, share * mass_term_);
    Vector u = Vector::Zero(block_.system.dof_count());
    const MinimizerReport report = finder->find_root(problem, u);
    ASSERT_TRUE(report.converged()) << share << ": " << report.message;
    EXPECT_LE(report.iterations, 12) << share;
    Vector residual;
    ASSERT_TRUE(problem.residual(u, residual).ok());
    EXPECT_LE(block_.system.coordinates().restricted_norm(residual), report.residual_limit);
    EXPECT_LE(report.residual, 1.01 * problem_.residual_limit(u, 1e-11));
    if (share == 0.0) {
      without = u;
      Vector minimum = Vector::Zero(u.size());
      ASSERT_TRUE(make_newton_minimizer(block_.system, {{1e-11, 60}, LinearSolver::kAuto, true})
                      ->minimize(problem_, minimum)
                      .converged());
      EXPECT_LT((u - minimum).norm(), 1e-9 * u.norm());
    } else {
      EXPECT_GT((u - without).norm(), 0.05 * without.norm());
    }
  }
}

TEST_F(RootOfAStep, IsTheSameAsThatOfAnExactNewtonMethod) {
  CirculatoryStep problem(problem_, 0.5 * mass_term_);
  const FreeCoordinates& coordinates = block_.system.coordinates();
  Vector expected = Vector::Zero(block_.system.dof_count());
  for (int i = 0; i < 12; ++i) {
    Vector residual;
    ASSERT_TRUE(problem.residual(expected, residual).ok());
    ASSERT_TRUE(problem.linearize(expected).ok());
    Matrix derivative(coordinates.count(), coordinates.count());
    for (Index j = 0; j < coordinates.count(); ++j) {
      Vector product;
      problem.multiply(coordinates.extend(Vector::Unit(coordinates.count(), j)), product);
      derivative.col(j) = coordinates.restrict(product);
    }
    expected -= coordinates.extend(derivative.partialPivLu().solve(coordinates.restrict(residual)));
  }
  Vector u = Vector::Zero(block_.system.dof_count());
  ASSERT_TRUE(
      make_newton_root_finder(block_.system, {1e-12, 60})->find_root(problem, u).converged());
  EXPECT_LT((u - expected).norm(), 1e-9 * expected.norm());
}

TEST_F(RootOfAStep, KeepsItsFactorFromStepToStep) {
  const auto finder = make_newton_root_finder(block_.system, {1e-8, 60});
  CirculatoryStep problem(problem_, 0.1 * mass_term_);
  Vector u = Vector::Zero(block_.system.dof_count());
  EXPECT_EQ(finder->find_root(problem, u).factorizations, 1);
  problem_.begin(block_.state, 1.1 * kStep, 1.1 * kStep, 1.0, {});
  u.setZero();
  const MinimizerReport again = finder->find_root(problem, u);
  EXPECT_TRUE(again.converged()) << again.message;
  EXPECT_EQ(again.factorizations, 0);
}

TEST_F(RootOfAStep, ReportsWhyThereIsNone) {
  CirculatoryStep problem(problem_, 0.5 * mass_term_);
  Vector u = Vector::Zero(block_.system.dof_count());
  const MinimizerReport cut =
      make_newton_root_finder(block_.system, {1e-11, 1})->find_root(problem, u);
  EXPECT_EQ(cut.termination, Termination::kIterationLimit);
  EXPECT_EQ(cut.iterations, 1);
  // The origin is a point where the body is turned inside out.
  problem_.set_origin(-problem_.base());
  u.setZero();
  const MinimizerReport undefined =
      make_newton_root_finder(block_.system, {})->find_root(problem, u);
  EXPECT_EQ(undefined.termination, Termination::kInadmissible);
  EXPECT_THROW(make_newton_root_finder(block_.system, {0.0, 10}), InputError);
  EXPECT_THROW(make_newton_root_finder(block_.system, {1e-8, 0}), InputError);
}

}  // namespace
}  // namespace tetraction
