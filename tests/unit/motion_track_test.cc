#include "tetraction/simulation/motion_track.h"

#include <cmath>

#include "support/bodies.h"

namespace tetraction {
namespace {

using namespace testing_support;

TEST(MotionTrack, HasFewerTimesForALargeMesh) {
  EXPECT_EQ(track_times(300), 100U);
  // So that not more than 64 MB are kept, but at least ten times.
  EXPECT_EQ(track_times(400'000), 20U);
  EXPECT_EQ(track_times(3'000'000), 10U);
}

MotionTrack recorded(const Scene& scene) {
  const TetMesh mesh = generate_mesh(*scene.mesh.generate);
  MotionRecorder recorder;
  Session session(scene, mesh);
  session.run({&recorder});
  return recorder.take();
}

// The motion of a body in free fall is a parabola, which a cubic reproduces.
TEST(MotionTrack, InterpolatesBetweenSteps) {
  for (const double step : {0.1, 0.03, 0.004, 0.01}) {
    Scene scene = spinning_block(Integrator::kVerlet, step, 1.0);
    scene.initial = {};
    scene.initial.velocity = {1.0, 2.0, 0.0};
    scene.environment.kind = EnvironmentKind::kGravity;
    scene.environment.strength = 10.0;
    scene.material.youngs_modulus = 1.0;  // stable at this step
    const MotionTrack track = recorded(scene);
    ASSERT_TRUE(track.is_whole()) << step;
    ASSERT_EQ(track.count, 100U);
    double squares = 0.0;
    for (std::size_t k = 0; k < track.count; ++k) {
      const double t = 0.01 * static_cast<double>(k + 1);
      const Vector3 expected = t * scene.initial.velocity + 0.5 * t * t * Vector3(0, -10, 0);
      for (Index v = 0; v < track.rest.size() / 3; ++v) {
        const Vector3 moved = vertex_block(track.positions[k], v) - vertex_block(track.rest, v);
        EXPECT_LT((moved - expected).norm(), 1e-12) << step << " " << t;
      }
      squares += expected.squaredNorm();
    }
    const double count = static_cast<double>(track.rest.size() / 3);
    const TrackScales scales = scales_of(track);
    EXPECT_NEAR(scales.over_time, std::sqrt(0.01 * squares * count), 1e-10);
    EXPECT_NEAR(scales.at_end, std::sqrt(count) * Vector3(1, -3, 0).norm(), 1e-10);
  }
}

TEST(MotionTrack, EndsWithTheLastStateOfTheRun) {
  Scene scene = spinning_block(Integrator::kMidpoint, 3e-3, 0.02);
  const TetMesh mesh = generate_mesh(*scene.mesh.generate);
  MotionRecorder recorder;
  Session session(scene, mesh);
  session.run({&recorder});
  ASSERT_TRUE(recorder.track().is_whole());
  EXPECT_EQ(recorder.track().last(), session.state().position);
}

TEST(MotionTrack, OfARunThatDidNotReachTheEndIsNotWhole) {
  const MotionTrack track = recorded(spinning_block(Integrator::kExplicit, 0.25, 5.0));
  EXPECT_FALSE(track.is_whole());
}

TEST(MotionTrack, ABodyThatDoesNotMoveHasAScaleOfItsSize) {
  Scene scene = spinning_block(Integrator::kVerlet, 1e-3, 0.01);
  scene.initial = {};
  const TrackScales scales = scales_of(recorded(scene));
  EXPECT_GE(scales.at_end, 1e-12);
  EXPECT_LT(scales.at_end, 1e-10);
  EXPECT_EQ(scales.at_end, scales.over_time);
}

TEST(MotionTrack, ExtrapolatesPositionsAndProbes) {
  MotionTrack fine;
  fine.count = 1;
  fine.positions = {Vector::Constant(3, 1.25)};
  MotionTrack coarse = fine;
  coarse.positions = {Vector::Constant(3, 2.0)};
  fine.extrapolate(1.0 / 3.0, coarse);
  EXPECT_NEAR(fine.last()[1], 1.0, 1e-15);

  ProbeRecord one{"tip", 1, {0.0, 0.5, 1.0}, {0.0, 2.0, 4.0}};
  const ProbeRecord two{"tip", 1, {0.0, 1.0}, {1.0, 7.0}};
  EXPECT_EQ(one.at(0.25)[0], 1.0);
  EXPECT_EQ(one.at(3.0)[0], 4.0);
  EXPECT_EQ(one.largest(), 4.0);
  EXPECT_EQ(one.largest_difference(two), 3.0);
  one.extrapolate(1.0, two);  // less the differences 1, 2 and 3
  EXPECT_EQ(one.values, (std::vector<double>{-1.0, 0.0, 1.0}));
}

}  // namespace
}  // namespace tetraction
