#include "simulation/study/position_errors.h"

#include <cmath>

#include "support/bodies.h"

namespace tetraction {
namespace {

using namespace testing_support;

TEST(ComparisonTimes, AreMultiplesOfEachStepAndTheEnd) {
  const std::vector<double> times = comparison_times({0.1, 0.25}, 1.0, 300);
  const std::vector<double> expected{0.1, 0.2, 0.25, 0.3, 0.4, 0.5, 0.6, 0.7, 0.75, 0.8, 0.9, 1.0};
  ASSERT_EQ(times.size(), expected.size());
  for (std::size_t i = 0; i < times.size(); ++i) EXPECT_NEAR(times[i], expected[i], 1e-15);
  // A last step that is shorter.
  EXPECT_EQ(comparison_times({0.4}, 1.0, 300).size(), 3U);
}

TEST(ComparisonTimes, AreBoundedInNumber) {
  EXPECT_LE(comparison_times({1e-5}, 1.0, 300).size(), 101U);
  EXPECT_GE(comparison_times({1e-5}, 1.0, 300).size(), 100U);
  // So that a hundred million numbers are not kept for a large mesh.
  EXPECT_LE(comparison_times({1e-5}, 1.0, 3'000'000).size(), 12U);
  EXPECT_GE(comparison_times({1e-5}, 1.0, 3'000'000).size(), 4U);
}

// The motion of a body in free fall is a parabola, which a cubic reproduces.
TEST(ReferenceTrack, InterpolatesBetweenSteps) {
  Scene scene = spinning_block(Integrator::kVerlet, 0.1, 1.0);
  scene.initial = {};
  scene.initial.velocity = {1.0, 2.0, 0.0};
  scene.environment.kind = EnvironmentKind::kGravity;
  scene.environment.strength = 10.0;
  scene.material.youngs_modulus = 1.0;  // stable at this step
  const TetMesh mesh = generate_mesh(*scene.mesh.generate);
  ReferenceTrack track({0.05, 0.1, 0.33, 1.0, 1.5});
  DistanceFromReference none(track);
  Session session(scene, mesh);
  session.run({&track, &none});
  const Vector rest = session.system().mesh().rest_positions();
  double squares = 0.0;
  for (const double t : {0.05, 0.1, 0.33, 1.0}) {
    const Vector* at = track.at(t);
    ASSERT_NE(at, nullptr) << t;
    const Vector3 expected = t * scene.initial.velocity + 0.5 * t * t * Vector3(0, -10, 0);
    for (Index v = 0; v < session.system().vertex_count(); ++v) {
      EXPECT_LT((vertex_block(*at, v) - vertex_block(rest, v) - expected).norm(), 1e-12) << t;
    }
    squares += expected.squaredNorm();
  }
  EXPECT_EQ(track.at(0.2), nullptr) << "was not asked for";
  EXPECT_EQ(track.at(1.5), nullptr) << "was not reached";
  const double count = static_cast<double>(session.system().vertex_count());
  EXPECT_NEAR(track.scale_over_time(), std::sqrt(0.25 * squares * count), 1e-10);
  EXPECT_NEAR(track.scale_at_end(), std::sqrt(count) * Vector3(1, -3, 0).norm(), 1e-10);
  EXPECT_LT(none.root_mean_square(), 1e-12) << "a run from itself";
}

TEST(ReferenceTrack, ABodyThatDoesNotMoveHasAScaleOfItsSize) {
  Scene scene = spinning_block(Integrator::kVerlet, 1e-3, 0.01);
  scene.initial = {};
  const TetMesh mesh = generate_mesh(*scene.mesh.generate);
  ReferenceTrack track({0.005, 0.01});
  Session session(scene, mesh);
  session.run({&track});
  EXPECT_GE(track.scale_at_end(), 1e-12);
  EXPECT_LT(track.scale_at_end(), 1e-10);
  EXPECT_EQ(track.scale_at_end(), track.scale_over_time());
}

}  // namespace
}  // namespace tetraction
