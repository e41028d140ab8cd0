// Friction between bodies: both momenta, the heat, and closed forms.
#include <cmath>
#include <utility>
#include <vector>

#include "support/body_contact.h"
#include "support/rules.h"
#include "support/same_run.h"
#include "tetraction/core/parallel.h"

namespace tetraction {
namespace {

using namespace testing_support;

class BodyFriction : public testing::TestWithParam<Integrator> {
 protected:
  ~BodyFriction() override { set_thread_count(0); }
  static Scene rough_cubes(double step_of_implicit, double end) {
    const double h = is_implicit(GetParam()) ? step_of_implicit : 1e-4;
    Scene scene = colliding_cubes(GetParam(), h, end);
    scene.contact.friction = 0.5;
    return scene;
  }
};

// Two cubes that spin and collide obliquely in empty space.
TEST_P(BodyFriction, KeepsMomentaAndBooksTheHeat) {
  const Scene scene = rough_cubes(5e-4, 0.12);
  Session session(scene, mesh_of_bodies(scene));
  run_apart(session);
  const Balance& balance = session.balance();
  const double start = balance.energies().total() + balance.friction_dissipation();
  const bool is_euler = GetParam() == Integrator::kBackwardEuler;
  EXPECT_GT(balance.friction_dissipation(), 1e-3 * start);
  EXPECT_LT(balance.friction_dissipation(), 0.3 * start);
  EXPECT_EQ(balance.constraint_work(), 0.0);
  EXPECT_LT(balance.linear_momentum_drift(), is_euler ? 1e-7 : 1e-12);
  if (GetParam() == Integrator::kEnergyMomentum) {
    EXPECT_LT(balance.max_relative_energy_drift(), 1e-11);
  }
  if (!is_euler) {
    EXPECT_LT(balance.angular_momentum_drift(), 1e-10);
    EXPECT_LT(balance.max_relative_energy_drift(), 0.05);
  }
}

TEST_P(BodyFriction, HasTheSameBitsOnThreadsAndAfterACheckpoint) {
  const Scene scene = rough_cubes(5e-4, 0.07);
  Session session(scene, mesh_of_bodies(scene));
  while (session.time() < 0.045) ASSERT_TRUE(session.step()) << session.message();
  ASSERT_GT(session.balance().friction_dissipation(), 0.0);
  const Checkpoint checkpoint = session.checkpoint();
  while (session.step()) {
  }
  ASSERT_EQ(session.status(), RunStatus::kFinished) << session.message();
  set_thread_count(2);
  Session restored(scene, mesh_of_bodies(scene));
  restored.restore(checkpoint);
  while (restored.step()) {
  }
  expect_same(session, restored);
}

INSTANTIATE_TEST_SUITE_P(Rules, BodyFriction, testing::ValuesIn(all_rules()), name_of_rule);

// A plate with the speed v₀ on a table that is held comes to rest after v₀²/(2 μ g), and all of its energy is heat.
// Flat faces transmit at most a tenth more than the layer's pressure, but the forces of all pairs carry the weight.
TEST_P(BodyFriction, StopsAPlateAfterItsDistance) {
  constexpr double kGravity = 10.0;
  constexpr double kFriction = 0.5;
  constexpr double kSpeed = 0.5;
  constexpr double kDistance = kSpeed * kSpeed / (2.0 * kFriction * kGravity);
  RawMesh raw;
  append_body(raw, generate_box({0.5, 0.1, 0.2}, {5, 1, 2}), Vector3::Zero());
  append_body(raw, generate_box({0.16, 0.05, 0.12}, {3, 1, 2}), Vector3(0.1, 0.102, 0.04));
  const TetMesh mesh = build_mesh(std::move(raw));
  Scene scene = scene_of(elastic(1e6, 0.3));
  const double h = is_implicit(GetParam()) ? 1e-3 : 1e-4;
  scene.time = {GetParam(), h, false, 0.5};
  scene.environment = gravity(kGravity);
  scene.fix = {fix(SelectBox{Vector3(-1.0, -1.0, -1.0), Vector3(1.0, 0.1005, 1.0)})};
  scene.contact.between = ContactBetween::kBodies;
  scene.contact.thickness = 0.004;
  scene.contact.friction = kFriction;
  scene.contact.slip_speed = 1e-4;
  // The layer carries the weight at rest without a bounce.
  const double pressure = 1000.0 * kGravity * 0.05;
  const double depth = 0.004 - 0.002;
  Barrier layer{0.004, 1.0};
  scene.contact.stiffness = pressure / -layer.slope(0.004 - depth);
  scene.initial.velocity = {kSpeed, 0.0, 0.0};
  const double mass = 1000.0 * 0.16 * 0.05 * 0.12;
  Session session(scene, mesh);
  const Vector& masses = session.system().mass();
  const auto place = [&] {
    double sum = 0.0;
    double whole = 0.0;
    for (Index v = 0; v < masses.size(); ++v) {
      if (!(mesh.rest_positions()[3 * v + 1] > 0.1015)) continue;
      sum += masses[v] * session.state().position[3 * v];
      whole += masses[v];
    }
    return sum / whole;
  };
  const double start = place();
  while (session.step()) {
  }
  ASSERT_EQ(session.status(), RunStatus::kFinished) << session.message();
  EXPECT_NEAR(place() - start, kDistance, 0.03 * kDistance);
  EXPECT_NEAR(session.balance().friction_dissipation(), 0.5 * mass * kSpeed * kSpeed,
              0.03 * 0.5 * mass * kSpeed * kSpeed);
}

}  // namespace
}  // namespace tetraction
