// The period that a scene excites, against its normal modes.
#include "tetraction/simulation/excited_period.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/bodies.h"
#include "tetraction/simulation/scene_objects.h"
#include "tetraction/solver/normal_modes.h"

namespace tetraction {
namespace {

// A beam along x that is held at its left end; its cross-section is wider along z than along y.
Scene cantilever() {
  Scene scene;
  scene.mesh.generate = GeneratorSettings{GeneratorKind::kBox, {2.0, 0.2, 0.4}, {10, 2, 4}};
  scene.material.youngs_modulus = 1e6;
  scene.material.poissons_ratio = 0.3;
  scene.time.end = 1.0;
  FixSettings fix;
  fix.select = SelectPlane{0, 0.0, {}};
  scene.fix.push_back(fix);
  return scene;
}

ExcitedPeriod find(const Scene& scene) {
  const auto system = make_system(scene, generate_mesh(*scene.mesh.generate));
  return excited_period(scene, *system);
}

// The period of the lowest mode of the scene that moves mostly along a direction.
double period_along(const Scene& scene, int direction) {
  const auto system = make_system(scene, generate_mesh(*scene.mesh.generate));
  make_initial_state(scene, *system);
  NormalModeOptions options;
  options.count = 20;
  for (const NormalMode& mode :
       normal_modes(*system, system->mesh().rest_positions(), options).modes) {
    if (mode.effective_mass[direction] > 0.5 * mode.effective_mass.sum() &&
        mode.effective_mass[direction] > 0.1 * system->total_mass()) {
      return 1.0 / mode.frequency();
    }
  }
  return 0.0;
}

TEST(ExcitedPeriod, FollowsTheDirectionOfTheLoad) {
  Scene scene = cantilever();
  scene.environment = {EnvironmentKind::kGravity, 0.1, {0.0, -1.0, 0.0}};
  const ExcitedPeriod soft = find(scene);
  EXPECT_NEAR(soft.period, period_along(scene, 1), 1e-9 * soft.period);
  EXPECT_EQ(soft.source.find("mode 1 ("), 0U) << soft.source;
  scene.environment.direction = Vector3(1.0, 0.0, 0.0);
  const ExcitedPeriod axial = find(scene);
  EXPECT_LT(axial.period, 0.7 * soft.period);
}

TEST(ExcitedPeriod, FollowsTheStart) {
  Scene scene = cantilever();
  scene.initial.velocity = {0.0, 0.0, 1.0};
  const double period = period_along(scene, 2);
  EXPECT_NEAR(find(scene).period, period, 1e-9 * period);
}

TEST(ExcitedPeriod, FollowsLoadsThatBeginLater) {
  Scene scene = cantilever();
  ForceSettings force;
  force.select = SelectPlane{0, 2.0, {}};
  force.vector = {0.0, 0.1, 0.0};
  force.from = 0.5;
  force.until = 0.51;
  scene.force.push_back(force);
  const double period = period_along(scene, 1);
  EXPECT_NEAR(find(scene).period, period, 1e-9 * period);
}

TEST(ExcitedPeriod, IsThatOfAFasterAmplitude) {
  Scene scene = cantilever();
  AmplitudeSettings shake;
  shake.name = "shake";
  shake.kind = AmplitudeKind::kSine;
  shake.frequency = 1000.0;
  scene.amplitude.push_back(shake);
  scene.environment = {EnvironmentKind::kGravity, 0.1, {0.0, -1.0, 0.0}};
  EXPECT_NEAR(find(scene).period, period_along(scene, 1), 1e-9);  // it does not act
  scene.environment.amplitude = "shake";
  const ExcitedPeriod forced = find(scene);
  EXPECT_DOUBLE_EQ(forced.period, 1e-3);
  EXPECT_EQ(forced.source, "the amplitude shake");
}

TEST(ExcitedPeriod, IsThatOfAHeldEndThatMoves) {
  Scene scene = cantilever();
  scene.fix[0].velocity = {0.0, 0.01, 0.0};
  const double period = period_along(scene, 1);
  EXPECT_NEAR(find(scene).period, period, 1e-9 * period);
}

TEST(ExcitedPeriod, IsThatOfAStretchedFreeBody) {
  Scene scene = testing_support::spinning_block(Integrator::kMidpoint, 1e-3, 1.0);
  const ExcitedPeriod found = find(scene);
  EXPECT_GT(found.period, 0.0) << found.source;
}

TEST(ExcitedPeriod, IsMissingWithoutExcitation) {
  Scene scene = cantilever();
  EXPECT_EQ(find(scene).period, 0.0);
  EXPECT_NE(find(scene).source.find("neither the loads nor the start"), std::string::npos);
  scene = testing_support::spinning_block(Integrator::kMidpoint, 1e-3, 1.0);
  scene.initial = {};
  scene.initial.velocity = {1.0, 0.0, 0.0};
  EXPECT_EQ(find(scene).period, 0.0) << find(scene).source;
}

}  // namespace
}  // namespace tetraction
