#include "solver/newton/line_search.h"

#include <Eigen/Eigenvalues>
#include <memory>

#include "core/pseudo_random.h"
#include "support/step_problems.h"
#include "tetraction/solver/ceres_minimizer.h"
#include "tetraction/solver/newton_minimizer.h"

namespace tetraction {
namespace {

using namespace testing_support;

/// A column pressed together by a twentieth of its length, in a step so long that inertia has no say: the
/// straight column is a saddle.
class Column : public testing::Test {
 protected:
  Column() {
    const TetMesh& mesh = system_.mesh();
    std::vector<Index> ends = select_vertices(mesh, SelectPlane{0, 0.0, {}});
    const std::vector<Index> far = select_vertices(mesh, SelectPlane{0, 4.0, {}});
    ends.insert(ends.end(), far.begin(), far.end());
    PrescribedVertices held = prescribe_at_rest(mesh, ends, "ends");
    held.start.row(0) *= 0.95;
    system_.set_constraints(
        Constraints({{held}, {}, {}, {}}, mesh, Vector::Ones(mesh.vertex_count())));
    state_ = system_.rest_state();
    for (Index v = 0; v < mesh.vertex_count(); ++v) state_.position[3 * v] *= 0.95;
    // A load that sets the scale of the forces.
    Vector load = Vector::Zero(system_.dof_count());
    for (Index v = 0; v < mesh.vertex_count(); ++v) load[3 * v] = 1e-3;
    problem_.begin(state_, 100.0, 100.0, 1.0, load);
    measure_from_zero(problem_);
    // Newton's method on the gradient ends in a saddle as well as in a minimum, if it begins nearby:
    // at the column that has become shorter and thicker.
    saddle_ = state_.position;
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
      if (!system_.coordinates().is_free(v)) continue;
      saddle_[3 * v + 1] = 0.1 + 1.02 * (saddle_[3 * v + 1] - 0.1);
      saddle_[3 * v + 2] = 0.1 + 1.02 * (saddle_[3 * v + 2] - 0.1);
    }
    for (int iteration = 0; iteration < 20; ++iteration) {
      saddle_ += system_.coordinates().extend(
          dense_hessian(problem_, saddle_).partialPivLu().solve(-gradient(saddle_)));
    }
  }
  Vector gradient(const Vector& x) const {
    auto [phi, result] = value_and_gradient_of(problem_, x);
    return result;
  }
  double phi(const Vector& x) const {
    double result = 0.0;
    EXPECT_TRUE(problem_.value(x, result).ok());
    return result;
  }
  Eigen::SelfAdjointEigenSolver<Matrix> eigen(const Vector& x) const {
    return Eigen::SelfAdjointEigenSolver<Matrix>(dense_hessian(problem_, x));
  }
  void expect_minimum(Minimizer& minimizer, Vector x, const std::string& name) const {
    const MinimizerReport report = minimizer.minimize(problem_, x);
    ASSERT_TRUE(report.converged()) << name << ": " << report.message;
    EXPECT_LE(gradient(x).norm(), report.residual_limit) << name;
    EXPECT_GT(eigen(x).eigenvalues()[0], 0.0) << name;
    EXPECT_LT(phi(x), 0.9 * phi(saddle_)) << name;
    EXPECT_LE(report.iterations, 60) << name;
  }

  MechanicalSystem system_{generate_box({4, 0.2, 0.2}, {20, 1, 2}), all_materials()[1], 1000.0};
  State state_;
  StepProblem problem_{system_};
  Vector saddle_;
};

TEST_F(Column, TheStraightOneIsASaddle) {
  EXPECT_LT(gradient(saddle_).norm(), problem_.residual_limit(saddle_, 1e-8));
  EXPECT_LT(eigen(saddle_).eigenvalues()[0], 0.0);
}

TEST_F(Column, EveryMinimizerEndsInAMinimum) {
  for (const LinearSolver linear :
       {LinearSolver::kAuto, LinearSolver::kMatrixFree, LinearSolver::kCg, LinearSolver::kFactor}) {
    for (const bool keep : {true, false}) {
      NewtonOptions options;
      options.linear = linear;
      options.keep_factor = keep;
      // At the saddle itself there is no residual, and not a single iteration.
      expect_minimum(*make_newton_minimizer(system_, options), saddle_, to_string(linear));
      expect_minimum(*make_newton_minimizer(system_, options), state_.position, to_string(linear));
    }
  }
  expect_minimum(*make_ceres_minimizer(system_, {}), saddle_, "ceres");
  expect_minimum(*make_ceres_minimizer(system_, {}), state_.position, "ceres");
}

TEST_F(Column, FollowsNegativeCurvatureDownhill) {
  const auto modes = eigen(saddle_);
  NegativeCurvature way;
  way.direction = system_.coordinates().extend(modes.eigenvectors().col(0));
  way.curvature = modes.eigenvalues()[0];
  Iterate at;
  at.u = saddle_;
  ASSERT_TRUE(evaluate(problem_, at));
  const double start = at.phi;
  ASSERT_TRUE(follow(problem_, way, at));
  EXPECT_LT(at.phi, start);
  EXPECT_EQ(at.phi, phi(at.u));
  const Vector moved = at.u - saddle_;
  EXPECT_NEAR(std::abs(moved.dot(way.direction)), moved.norm() * way.direction.norm(),
              1e-9 * moved.norm());
  // With a slope it goes the way that the slope points down.
  const Vector before = saddle_ + 1e-3 * way.direction;
  at.u = before;
  ASSERT_TRUE(evaluate(problem_, at));
  ASSERT_TRUE(follow(problem_, way, at));
  EXPECT_GT((at.u - before).dot(way.direction), 0.0);
  // Directions of positive curvature are left alone.
  way.direction =
      system_.coordinates().extend(modes.eigenvectors().col(modes.eigenvalues().size() - 1));
  at.u = saddle_;
  ASSERT_TRUE(evaluate(problem_, at));
  EXPECT_FALSE(follow(problem_, way, at));
  way.curvature = 1.0;
  EXPECT_FALSE(follow(problem_, way, at));
  EXPECT_EQ(at.u, saddle_);
}

TEST(PseudoRandom, IsTheSameEveryTimeAndFillsItsRange) {
  const Vector numbers = pseudo_random(10000);
  EXPECT_EQ(numbers, pseudo_random(10000));
  EXPECT_EQ(Vector(numbers.head(100)), pseudo_random(100));
  EXPECT_LT(numbers.cwiseAbs().maxCoeff(), 1.0 + 1e-15);
  EXPECT_NEAR(numbers.mean(), 0.0, 0.02);
  EXPECT_NEAR(numbers.squaredNorm() / 10000.0, 1.0 / 3.0, 0.01);
}

}  // namespace
}  // namespace tetraction
