#include "solver/linear/matrix_free_cg.h"

#include <Eigen/Cholesky>

#include "support/step_problems.h"
#include "tetraction/core/parallel.h"

namespace tetraction {
namespace {

using namespace testing_support;

// A beam of stiff rubber, clamped at one end and bent by its own motion: with a step far beyond the
// stability limit the vertices' blocks alone need many iterations.
class StiffBeam : public testing::Test {
 protected:
  StiffBeam()
      : system_(generate_box({4.0, 1.0, 1.0}, {24, 6, 6}), NeoHookean(4e7, 6e7), 1000.0),
        problem_(system_) {
    system_.set_constraints(hold(system_.mesh(), SelectPlane{0, 0.0, {}}));
    system_.set_environment(Environment::uniform({0.0, -9.81, 0.0}));
    state_ = system_.rest_state();
    Vector velocity(system_.dof_count());
    for (Index v = 0; v < system_.vertex_count(); ++v) {
      const Vector3 x = system_.mesh().vertices[static_cast<std::size_t>(v)];
      velocity.segment<3>(3 * v) = x.x() * Vector3(0.1, -0.5, 0.3 * x.y());
    }
    system_.set_velocity(state_, velocity);
    begin(0.01);
    x_ = state_.position + 1e-3 * velocity;
  }

  void begin(double h) {
    problem_.begin(state_, h, h, 1.0, Vector::Zero(system_.dof_count()));
    measure_from_zero(problem_);
    double phi = 0.0;
    ASSERT_TRUE(problem_.value_and_full_gradient(state_.position, phi, gradient_).ok());
  }

  // −A⁻¹ gradient, from the assembled matrix.
  Vector direct() const {
    return system_.coordinates().extend(
        dense_hessian(problem_, x_).llt().solve(-system_.coordinates().restrict(gradient_)));
  }

  MechanicalSystem system_;
  State state_;
  StepProblem problem_;
  Vector x_;
  Vector gradient_;
};

TEST_F(StiffBeam, TheCoarseSpaceSparesIterationsAndChangesNoDirection) {
  const Vector expected = direct();
  MatrixFreeCg<double> cg(system_);
  cg.set(problem_, x_);
  Vector step;
  // A limit below the price of a coarse space: there is none.
  const CgReport cut = cg.solve(gradient_, 1e-9, 20, step);
  EXPECT_FALSE(cut.converged);
  EXPECT_EQ(cut.coarse_spaces, 0);
  // One is made on the way …
  const CgReport first = cg.solve(gradient_, 1e-9, 2000, step);
  ASSERT_TRUE(first.converged);
  EXPECT_EQ(first.coarse_spaces, 1);
  EXPECT_LE(first.reduction(), 1e-9);
  EXPECT_LT((step - expected).norm(), 1e-6 * expected.norm());
  // … and serves from the beginning.
  const CgReport second = cg.solve(gradient_, 1e-9, 2000, step);
  ASSERT_TRUE(second.converged);
  EXPECT_EQ(second.coarse_spaces, 0);
  EXPECT_LT((step - expected).norm(), 1e-6 * expected.norm());
  EXPECT_LT(second.iterations, first.iterations);
  EXPECT_LT(second.iterations, 120);
}

TEST_F(StiffBeam, SinglePrecisionGivesTheDigitsThatNewtonAsksFor) {
  const Vector expected = direct();
  MatrixFreeCg<float> cg(system_);
  cg.set(problem_, x_);
  Vector step;
  for (int i = 0; i < 2; ++i) {
    const CgReport report = cg.solve(gradient_, 1e-4, 2000, step);
    ASSERT_TRUE(report.converged);
    EXPECT_LT((step - expected).norm(), 1e-2 * expected.norm());
  }
}

TEST_F(StiffBeam, HeldVerticesStayWhereTheyAre) {
  MatrixFreeCg<float> cg(system_);
  cg.set(problem_, x_);
  Vector step;
  CgReport report;
  for (int i = 0; i < 3; ++i) report = cg.solve(gradient_, 1e-3, 2000, step);
  for (Index v = 0; v < system_.vertex_count(); ++v) {
    if (system_.coordinates().is_fully_prescribed(v)) {
      EXPECT_EQ(step.segment<3>(3 * v), Vector3::Zero());
    }
  }
}

// Where the mass has the say, a coarse space is tried once and left alone for long.
TEST_F(StiffBeam, ShortStepsDoWithoutACoarseSpace) {
  begin(1e-5);
  MatrixFreeCg<float> cg(system_);
  Vector step;
  int spaces = 0;
  int iterations = 0;
  for (int i = 0; i < 100; ++i) {
    cg.set(problem_, x_);
    const CgReport report = cg.solve(gradient_, 1e-3, 100, step);
    ASSERT_TRUE(report.converged);
    spaces += report.coarse_spaces;
    iterations += report.iterations;
  }
  EXPECT_GT(iterations, 100);
  EXPECT_LE(spaces, 2);
}

TEST_F(StiffBeam, IsBitwiseTheSameForAnyNumberOfThreads) {
  std::vector<Vector> steps;
  for (const int threads : {1, 2, 4}) {
    set_thread_count(threads);
    MatrixFreeCg<float> cg(system_);
    cg.set(problem_, x_);
    Vector step;
    EXPECT_EQ(cg.solve(gradient_, 1e-4, 2000, step).coarse_spaces, 1);
    cg.solve(gradient_, 1e-4, 2000, step);
    steps.push_back(step);
  }
  set_thread_count(0);
  EXPECT_EQ(steps[1], steps[0]);
  EXPECT_EQ(steps[2], steps[0]);
}

// A zero gradient, one of NaNs and an indefinite matrix do not go round for ever.
TEST_F(StiffBeam, Endings) {
  MatrixFreeCg<double> cg(system_);
  cg.set(problem_, x_);
  Vector step;
  const CgReport zero = cg.solve(Vector::Zero(system_.dof_count()), 1e-3, 100, step);
  EXPECT_TRUE(zero.converged);
  EXPECT_EQ(zero.iterations, 0);
  EXPECT_EQ(step.norm(), 0.0);
  const CgReport nan =
      cg.solve(Vector::Constant(system_.dof_count(), std::nan("")), 1e-3, 100, step);
  EXPECT_LE(nan.iterations, 100);
  Vector crushed = state_.position;
  for (Index v = 0; v < system_.vertex_count(); ++v) crushed[3 * v] *= 0.5;
  begin(1.0);
  cg.set(problem_, crushed);
  const CgReport indefinite = cg.solve(gradient_, 1e-9, 5000, step);
  EXPECT_TRUE(indefinite.negative_curvature);
  EXPECT_TRUE(step.allFinite());
}

}  // namespace
}  // namespace tetraction
