#include "tetraction/fem/step_length.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>

#include "support/bodies.h"
#include "tetraction/core/parallel.h"
#include "tetraction/dynamics/problems/derivative_check.h"

namespace tetraction {
namespace {

using namespace testing_support;

constexpr double kLeast = 0.1;  // of the volume that is to be left
constexpr double kPi = 3.14159265358979323846;
constexpr double kSlack = 0.09;  // a tenth of the loss

double volume(const RestState& rest, const Vector& q, Index e) {
  const auto nodes = rest.gather(q, e);
  const Matrix3 edges = nodes.rightCols<3>().colwise() - nodes.col(0);
  return edges.determinant();
}

// Least J(t)/J(0) of the elements that are not inverted at q.
double least_ratio(const RestState& rest, const Vector& q, const Vector& d, double t) {
  double least = 1.0;
  const Vector at = q + t * d;
  for (Index e = 0; e < rest.element_count(); ++e) {
    const double start = volume(rest, q, e);
    if (start > 0.0) least = std::min(least, volume(rest, at, e) / start);
  }
  return least;
}

// Nothing is lost on the way, and it does not stop early.
void expect_exact(const RestState& rest, const Vector& q, const Vector& d, double step) {
  ASSERT_GE(step, 0.0);
  ASSERT_LE(step, 1.0);
  for (int i = 0; i <= 1000; ++i) {
    ASSERT_GE(least_ratio(rest, q, d, step * i / 1000.0), kLeast * (1.0 - 1e-12)) << i;
  }
  if (step < 1.0) {
    EXPECT_LE(least_ratio(rest, q, d, step), kLeast + kSlack + 1e-12);
  }
}

// The displacement to F x of all vertices.
Vector to(const Matrix3& f, const Vector& q) {
  Vector d(q.size());
  for (Index v = 0; v < q.size() / 3; ++v) {
    d.segment<3>(3 * v) = f * q.segment<3>(3 * v) - q.segment<3>(3 * v);
  }
  return d;
}

class StepLength : public testing::Test {
 protected:
  const TetMesh mesh_ = small_block();
  const RestState rest_{mesh_};
  const Vector q_ = jiggled(mesh_.rest_positions(), 0.02);
};

TEST_F(StepLength, HarmlessStepsAreNotCut) {
  EXPECT_EQ(admissible_step(rest_, q_, Vector::Zero(q_.size())), 1.0);
  EXPECT_EQ(admissible_step(rest_, q_, jiggled(Vector::Zero(q_.size()), 0.01)), 1.0);
  EXPECT_EQ(admissible_step(rest_, q_, 1e6 * Vector::Ones(q_.size())), 1.0);
  EXPECT_EQ(admissible_step(rest_, q_, 50.0 * q_), 1.0);
  // A rotation by a right angle: J = 1 − 2t + 2t² ≥ ½ on the way.
  const Matrix3 quarter = Eigen::AngleAxisd(0.5 * kPi, Vector3::UnitZ()).matrix();
  EXPECT_EQ(admissible_step(rest_, q_, to(quarter, q_)), 1.0);
  // Compression to just above a tenth of the volume and a tenth of the loss.
  EXPECT_EQ(admissible_step(rest_, q_, to(Vector3(0.2, 1, 1).asDiagonal(), q_)), 1.0);
}

TEST_F(StepLength, LinearLossOfVolume) {
  for (const double rate : {1.0, 2.0, 30.0, 1e6}) {  // J = 1 − rate t
    const double step = admissible_step(rest_, q_, to(Vector3(1.0 - rate, 1, 1).asDiagonal(), q_));
    EXPECT_LE(step, 0.9 / rate);
    EXPECT_GE(step, 0.81 / rate * (1.0 - 1e-12));
  }
}

TEST_F(StepLength, CubicLossOfVolume) {
  for (const double rate : {1.0, 3.0, 100.0}) {  // J = (1 − rate t)³
    const Vector d = -rate * q_;
    const double step = admissible_step(rest_, q_, d);
    EXPECT_LE(step, (1.0 - std::cbrt(kLeast)) / rate * (1.0 + 1e-12));
    EXPECT_GE(step, (1.0 - std::cbrt(kLeast + kSlack)) / rate * (1.0 - 1e-12));
    expect_exact(rest_, q_, d, step);
  }
}

TEST_F(StepLength, ThroughZeroAndBackIsCutBeforeTheFirstZero) {
  // J = (1 − 2t)(1 − 1.5t): 0.5 at the end, below zero between ½ and ⅔.
  const Vector d = to(Vector3(-1.0, -0.5, 1.0).asDiagonal(), q_);
  ASSERT_NEAR(least_ratio(rest_, q_, d, 1.0), 0.5, 1e-9);
  ASSERT_LT(least_ratio(rest_, q_, d, 0.58), 0.0);
  const double step = admissible_step(rest_, q_, d);
  EXPECT_LT(step, 0.5);
  expect_exact(rest_, q_, d, step);

  // Half a turn: J = (1 − 2t)² touches zero half way.
  const Matrix3 turn = Eigen::AngleAxisd(kPi, Vector3(1, 2, -1).normalized()).matrix();
  const Vector half_turn = to(turn, q_);
  ASSERT_GT(least_ratio(rest_, q_, half_turn, 1.0), 0.99);
  const double turned = admissible_step(rest_, q_, half_turn);
  EXPECT_LT(turned, 0.5);
  expect_exact(rest_, q_, half_turn, turned);
}

TEST_F(StepLength, VolumeThatGrowsFirst) {
  // J = (1 + 10t)(1 − 2t): rises to 1.8 at t = 0.2, zero at ½.
  const Vector d = to(Vector3(11.0, -1.0, 1.0).asDiagonal(), q_);
  const double step = admissible_step(rest_, q_, d);
  EXPECT_GT(step, 0.4);
  EXPECT_LT(step, 0.5);
  expect_exact(rest_, q_, d, step);
}

TEST_F(StepLength, RandomSteps) {
  int cut = 0;
  int whole = 0;
  for (unsigned seed = 1; seed <= 30; ++seed) {
    for (const double size : {0.05, 0.15, 0.5, 3.0}) {
      const Vector d = jiggled(Vector::Zero(q_.size()), size, seed);
      const double step = admissible_step(rest_, q_, d);
      EXPECT_GT(step, 0.0);
      (step < 1.0 ? cut : whole) += 1;
      expect_exact(rest_, q_, d, step);
    }
  }
  EXPECT_GT(cut, 20);
  EXPECT_GT(whole, 20);
}

TEST_F(StepLength, ElementsThatAreInvertedAlreadyDoNotCount) {
  Vector mirrored = q_;
  for (Index v = 0; v < mesh_.vertex_count(); ++v) mirrored[3 * v] *= -1.0;
  EXPECT_EQ(admissible_step(rest_, mirrored, -5.0 * mirrored), 1.0);

  Vector one = mesh_.rest_positions();
  one.tail<3>() = mesh_.vertices.front();
  const Vector d = jiggled(Vector::Zero(one.size()), 0.3);
  const double step = admissible_step(rest_, one, d);
  EXPECT_LT(step, 1.0);
  expect_exact(rest_, one, d, step);
}

// A search that goes by the steepest slope would not come to an end here.
TEST_F(StepLength, EnormousDisplacementsAreCutAtOnce) {
  for (const double size : {1e4, 1e8, 1e12}) {
    for (unsigned seed = 1; seed <= 5; ++seed) {
      const Vector d = size * jiggled(Vector::Zero(q_.size()), 1.0, seed);
      const double step = admissible_step(rest_, q_, d);
      EXPECT_GT(step, 0.0);
      EXPECT_LT(step, 1e-1);
      expect_exact(rest_, q_, d, step);
    }
  }
}

TEST(StepLengthOfManyElements, IsTheSameForAnyNumberOfThreads) {
  const TetMesh mesh = small_block({14, 9, 9});
  const RestState rest(mesh);
  const Vector q = mesh.rest_positions();
  const Vector d = jiggled(Vector::Zero(q.size()), 0.2);
  set_thread_count(1);
  const double step = admissible_step(rest, q, d);
  EXPECT_LT(step, 1.0);
  for (const int threads : {2, 4}) {
    set_thread_count(threads);
    for (int i = 0; i < 20; ++i) EXPECT_EQ(admissible_step(rest, q, d), step);
  }
  set_thread_count(0);
}

}  // namespace
}  // namespace tetraction
