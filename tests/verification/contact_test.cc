// Contact with obstacles against closed forms: the patch test, the impact of a bar, sliding and sticking, and a ball
// that is pressed into a block.
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "support/obstacles.h"
#include "support/rules.h"

namespace tetraction {
namespace {

using namespace testing_support;

Selection lower_faces() {
  return SelectFaces{{0.0, -1.0, 0.0}, {}};
}

class ContactPatch : public testing::TestWithParam<bool> {};

// A block under a traction stands on a plane, free to widen. The pressure on the plane is the traction. Linear
// tetrahedra have it exactly; the corners of quadratic faces, whose consistent weights are zero, have 2 % of the area
// here, which is the size of the error.
TEST_P(ContactPatch, HasAUniformPressure) {
  const bool is_quadratic = GetParam();
  for (const double nu : {0.0, 0.3}) {
    Scene scene = scene_of({GeneratorKind::kBox, {0.2, 0.2, 0.2}, {4, 2, 3}}, elastic(5e4, nu));
    scene.solver.tolerance = 1e-12;
    constexpr double kTraction = 5e3;
    scene.force.push_back(traction(SelectFaces{{0.0, 1.0, 0.0}, {}}, {0.0, -kTraction, 0.0}));
    scene.fix.push_back(fix(SelectVertices{{0}}, {true, false, true}));
    scene.fix.push_back(fix(SelectNearest{{0.2, 0.0, 0.0}}, {false, false, true}));
    ObstacleSettings plane = plane_obstacle("plane", {0.0, -0.004, 0.0});
    plane.thickness = 0.005;
    plane.select = lower_faces();
    scene.obstacle.push_back(plane);
    TetMesh mesh = mesh_of(scene);
    if (is_quadratic) mesh = with_edge_vertices(std::move(mesh));
    const FinishedEquilibrium session(scene, mesh);
    const MechanicalSystem& system = session.system();
    const ForcePoint at = system.force_point(session.state().position, 0.0);
    Vector pressure;
    Vector gap;
    system.contact()->fields(at, pressure, gap);
    const Vector rest = mesh.rest_positions();
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
      if (rest[3 * v + 1] > 0.0) {
        EXPECT_EQ(pressure[v], 0.0);
        continue;
      }
      if (!is_quadratic) {
        EXPECT_NEAR(pressure[v], kTraction, 1e-9 * kTraction) << v;
      }
      const Index corners = mesh_of(scene).vertex_count();
      if (is_quadratic && v >= corners) {
        EXPECT_NEAR(pressure[v], kTraction, 0.02 * kTraction) << v;
      }
    }
    const ObstacleForce force = system.contact()->forces(at)[0];
    EXPECT_LT((force.force - Vector3(0.0, kTraction * 0.04, 0.0)).norm(), 1e-9 * kTraction * 0.04);
  }
}

INSTANTIATE_TEST_SUITE_P(Elements, ContactPatch, testing::Bool(),
                         [](const auto& test) { return test.param ? "quadratic" : "linear"; });

// What stands on a plane presses it with its weight.
TEST(Contact, CarriesTheWeightOfABlock) {
  for (const bool is_quadratic : {false, true}) {
    Scene scene = scene_of({GeneratorKind::kBox, {0.2, 0.3, 0.2}, {3, 3, 3}}, elastic(1e5, 0.3));
    scene.environment = gravity(9.81);
    scene.fix.push_back(fix(SelectVertices{{0}}, {true, false, true}));
    scene.fix.push_back(fix(SelectNearest{{0.2, 0.0, 0.0}}, {false, false, true}));
    // From outside the layer: the first load step has to find the plane.
    scene.obstacle.push_back(plane_obstacle("plane", {0.0, -0.006, 0.0}));
    TetMesh mesh = mesh_of(scene);
    if (is_quadratic) mesh = with_edge_vertices(std::move(mesh));
    const FinishedEquilibrium session(scene, mesh);
    const MechanicalSystem& system = session.system();
    const ObstacleForce force =
        system.contact()->forces(system.force_point(session.state().position, 0.0))[0];
    const double weight = 9.81 * 1000.0 * 0.2 * 0.3 * 0.2;
    EXPECT_LT((force.force - Vector3(0.0, weight, 0.0)).norm(), 1e-8 * weight) << is_quadratic;
  }
}

class ContactOf : public testing::TestWithParam<Integrator> {
 protected:
  static bool is_euler() { return GetParam() == Integrator::kBackwardEuler; }
  // The energy of the integrator, and both momenta.
  static void expect_balance(const Session& session) {
    const Balance& balance = session.balance();
    EXPECT_LT(balance.linear_momentum_drift(), is_euler() ? 1e-7 : 1e-12);
    if (!is_euler()) {
      EXPECT_LT(balance.angular_momentum_drift(), 1e-9);
    }
    if (GetParam() == Integrator::kEnergyMomentum) {
      EXPECT_LT(balance.max_relative_energy_drift(), 1e-11);
    }
  }
};

// A block on a slope or a table, with the pressure of its weight from the start.
Scene sliding_block(Integrator rule, double tangent, double friction) {
  Scene scene = scene_of({GeneratorKind::kBox, {0.4, 0.1, 0.4}, {2, 1, 2}}, elastic(1e6, 0.0, 1e3));
  const double angle = std::atan(tangent);
  scene.environment = gravity(10.0, {std::sin(angle), -std::cos(angle), 0.0});
  const Barrier layer{0.01, 1e5};
  const double rest = distance_under(layer, 1e3 * 10.0 * std::cos(angle) * 0.1);
  ObstacleSettings slope = plane_obstacle("slope", {0.0, -rest, 0.0});
  slope.friction = friction;
  slope.thickness = layer.thickness;
  slope.stiffness = layer.stiffness;
  slope.select = lower_faces();
  scene.obstacle.push_back(slope);
  scene.time = {rule, is_implicit(rule) ? 2e-3 : 2e-4, false, 0.3};
  return scene;
}
constexpr double kBlockMass = 16.0;

// a = g (sin θ − μ cos θ). The block rocks a little at first, and slips at full speed after some milliseconds.
TEST_P(ContactOf, LetsABlockSlideDownASlopeAsCoulombSays) {
  const Scene scene = sliding_block(GetParam(), 1.0 / std::sqrt(3.0), 0.3);
  Session session(scene, mesh_of(scene));
  double early = 0.0;
  double early_time = 0.0;
  while (session.step()) {
    if (early_time == 0.0 && session.time() > 0.1) {
      early_time = session.time();
      early = session.balance().momenta().linear.x() / kBlockMass;
    }
  }
  ASSERT_EQ(session.status(), RunStatus::kFinished) << session.message();
  const double late = session.balance().momenta().linear.x() / kBlockMass;
  const double acceleration = (late - early) / (session.time() - early_time);
  EXPECT_NEAR(acceleration, 10.0 * (0.5 - 0.3 * std::sqrt(0.75)), 0.01 * 2.4);
  expect_balance(session);
}

// It stops after v₀²/(2 μ g), and the heat is all of its energy.
TEST_P(ContactOf, StopsABlockAfterItsDistance) {
  Scene scene = sliding_block(GetParam(), 0.0, 0.3);
  scene.time.end = 0.4;
  scene.initial.velocity = {1.0, 0.0, 0.0};
  const FinishedRun session(scene);
  const Vector& x = session.state().position;
  const Vector rest = session.system().mesh().rest_positions();
  double way = 0.0;
  for (Index v = 0; v < rest.size() / 3; ++v) {
    way += session.system().mass()[v] * (x[3 * v] - rest[3 * v]) / kBlockMass;
  }
  EXPECT_NEAR(way, 1.0 / (2.0 * 0.3 * 10.0), 0.01 / 6.0);
  EXPECT_NEAR(session.balance().friction_dissipation(), 0.5 * kBlockMass, 0.01 * 0.5 * kBlockMass);
  expect_balance(session);
}

// Below the angle of friction the block creeps with ε (1 − √(1 − tan θ/μ)), where f₁ balances its weight.
TEST(Contact, CreepsWhereItSticks) {
  Scene scene = sliding_block(Integrator::kBackwardEuler, 0.2, 0.3);
  scene.obstacle[0].slip_speed = 2e-3;
  const FinishedRun session(scene);
  const double creep = 2e-3 * (1.0 - std::sqrt(1.0 - 0.2 / 0.3));
  EXPECT_NEAR(session.balance().momenta().linear.x() / kBlockMass, creep, 2e-3 * creep);
}

INSTANTIATE_TEST_SUITE_P(Rules, ContactOf, testing::ValuesIn(all_rules()), name_of_rule);

}  // namespace
}  // namespace tetraction
