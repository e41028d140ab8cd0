// Contact with obstacles against closed forms: the patch test, the impact of a bar, sliding and sticking, and a ball
// that is pressed into a block.
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
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
// tetrahedra have it exactly, and so have quadratic ones, whose corners feel the inner half of the layer only.
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
      EXPECT_NEAR(pressure[v], kTraction, 1e-9 * kTraction) << v;
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

// A bar with ν = 0 that hits a wall with v₀ = c/1000, of vertices that move along its axis only. The wave of the
// impact runs to the free end and back, for 2 L/c. All the while the wall presses with ρ c v₀ A, and then the bar
// leaves it with the velocity v₀. The layer gives way by 1.8 % of its thickness d̂, a tenth of an edge, and so makes
// the beginning and the end of the pulse last for 4 % of its length.
TEST_P(ContactOf, PressesABarThatHitsAWallWithItsImpedance) {
  constexpr double kLength = 1.0;
  constexpr double kWidth = 0.05;
  constexpr int kCells = 40;
  constexpr double kEdge = kLength / kCells;
  constexpr double kModulus = 1e6;
  constexpr double kDensity = 1e3;
  const double c = std::sqrt(kModulus / kDensity);
  const double v0 = 1e-3 * c;
  const double crossing = kEdge / c;
  Scene scene = scene_of({GeneratorKind::kBox, {kLength, kWidth, kWidth}, {kCells, 1, 1}},
                         elastic(kModulus, 0.0, kDensity));
  const double step = (is_implicit(GetParam()) ? 0.9 : 0.2) * crossing;
  scene.time = {GetParam(), step, false, 3.0 * kLength / c};
  scene.solver.tolerance = 1e-10;
  scene.initial.velocity = {-v0, 0.0, 0.0};
  scene.fix.push_back(fix(SelectAll{}, {false, true, true}));
  ObstacleSettings wall = plane_obstacle("wall", {-0.1001 * kEdge, 0.0, 0.0}, {1.0, 0.0, 0.0});
  wall.thickness = 0.1 * kEdge;
  wall.select = SelectFaces{{-1.0, 0.0, 0.0}, {}};
  scene.obstacle.push_back(wall);
  Session session(scene, mesh_of(scene));
  const double mass = kDensity * kLength * kWidth * kWidth;
  const double force = kDensity * c * v0 * kWidth * kWidth;
  double before = session.balance().momenta().linear.x();
  double begin = 0.0;
  double end = 0.0;
  double sum = 0.0;
  double square = 0.0;
  int count = 0;
  while (session.step()) {
    const double after = session.balance().momenta().linear.x();
    const double mean = (after - before) / session.time_step() / force;
    before = after;
    // From half of the force to half of the force. The vibrations that the bar keeps may touch the wall again later.
    if (mean > 0.5 && begin == 0.0) begin = session.time() - 0.5 * step;
    if (mean < 0.5 && begin > 0.0 && end == 0.0) end = session.time() - 0.5 * step;
    // Without the time in which the layer is pressed together and gives way again.
    if (session.time() > 0.2 * kLength / c && session.time() < 1.9 * kLength / c) {
      sum += mean;
      square += (mean - 1.0) * (mean - 1.0);
      ++count;
    }
  }
  ASSERT_EQ(session.status(), RunStatus::kFinished) << session.message();
  EXPECT_NEAR(sum / count, 1.0, is_euler() ? 0.05 : 5e-3);
  EXPECT_LT(std::sqrt(square / count), is_euler() ? 0.1 : 0.03);
  EXPECT_NEAR(end - begin, 2.0 * kLength / c, (is_euler() ? 0.08 : 0.04) * 2.0 * kLength / c);
  const double rebound = session.balance().momenta().linear.x() / (mass * v0);
  // Backward Euler loses 8 to 43 % of the energy in an impact.
  EXPECT_GT(rebound, is_euler() ? 0.8 : 0.98);
  EXPECT_LE(rebound, 1.0);
  const Vector3 impulse = session.balance().sums().obstacles[0].linear;
  EXPECT_NEAR(impulse.x(), (1.0 + rebound) * mass * v0, 1e-7 * mass * v0);
  expect_balance(session);
}

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

// The explicit rules let nothing slip that sticks: friction stops a vertex as far as it can. Released at once, the
// block shears by twice its strain at rest, which takes twice its weight's part along the slope.
TEST(Contact, SticksInExplicitSteps) {
  for (const Integrator rule : {Integrator::kVerlet, Integrator::kExplicit}) {
    const Scene scene = sliding_block(rule, 0.1, 0.3);
    const FinishedRun session(scene);
    const Vector& x = session.state().position;
    const Vector rest = session.system().mesh().rest_positions();
    for (Index v = 0; v < rest.size() / 3; ++v) {
      if (rest[3 * v + 1] > 0.0) continue;
      // Corners lose their normal force for some moments after the release, and move by a micrometre in them.
      EXPECT_NEAR(x[3 * v], rest[3 * v], 5e-6) << v;
    }
    const Vector3 impulse = session.balance().sums().obstacles[0].linear;
    EXPECT_NEAR(impulse.x() / impulse.y(), -0.1, 1e-3);
  }
}

INSTANTIATE_TEST_SUITE_P(Rules, ContactOf, testing::ValuesIn(all_rules()), name_of_rule);

// Hertz: a rigid ball pressed into a half-space. A quarter of a block with cells that grow away from the contact.
//
//     F = 4/3 E* √R δ^{3/2},   a = √(R δ),   p₀ = 3 F/(2 π a²),   E* = E/(1 − ν²)
//
// so that p₀ = (6 F E*²/(π³ R²))^{1/3}. The block is held at its bottom, at the depth L of fifteen times a, where a
// half-space would go down by F (1 + ν)(3 − 2 ν)/(2 π E L) (Boussinesq), which counts as a part of δ. Linear tetrahedra
// of a seventh of a are a little too stiff.
TEST(Contact, HasThePressureOfHertz) {
  constexpr double kSize = 1.0;
  constexpr double kRadius = 1.0;
  constexpr double kDepth = 4.5e-3;
  constexpr double kModulus = 1e6;
  constexpr double kNu = 0.3;
  constexpr int kCells = 13;
  const auto graded = [](double s) { return kSize * (0.12 * s + 0.88 * s * s * s); };
  const TetMesh even = generate_box({1.0, 1.0, 1.0}, {kCells, kCells, kCells});
  RawMesh raw;
  append_body(raw, even, Vector3::Zero());
  for (Vector3& x : raw.vertices) x = {graded(x.x()), -graded(1.0 - x.y()), graded(x.z())};
  const TetMesh mesh = build_mesh(std::move(raw));
  const double edge = graded(1.0 / kCells);
  Scene scene = scene_of(elastic(kModulus, kNu));
  scene.solver.tolerance = 1e-9;
  scene.fix.push_back(fix(SelectPlane{0, 0.0, {}}, {true, false, false}));
  scene.fix.push_back(fix(SelectPlane{2, 0.0, {}}, {false, false, true}));
  scene.fix.push_back(fix(SelectPlane{1, -kSize, {}}));
  const Barrier layer{0.05 * edge, kModulus};
  ObstacleSettings ball = sphere_obstacle("ball", {0.0, kRadius + layer.thickness, 0.0}, kRadius);
  ball.offset = {0.0, -kDepth, 0.0};
  ball.thickness = layer.thickness;
  ball.stiffness = layer.stiffness;
  ball.select = SelectFaces{{0.0, 1.0, 0.0}, {}};
  scene.obstacle.push_back(ball);
  const FinishedEquilibrium session(scene, mesh);
  const MechanicalSystem& system = session.system();
  const ForcePoint at = system.force_point(session.state().position, 0.0);
  const double force = -4.0 * system.contact()->forces(at)[0].force.y();
  Vector pressure;
  Vector gap;
  system.contact()->fields(at, pressure, gap);
  const double peak = pressure.maxCoeff();
  const double e_star = kModulus / (1.0 - kNu * kNu);
  const double p0 = std::cbrt(6.0 * force * e_star * e_star /
                              (std::pow(std::numbers::pi, 3) * kRadius * kRadius));
  EXPECT_NEAR(peak, p0, 0.05 * p0);
  // The layer's own compression is no part of the depth.
  const double depth =
      kDepth - (layer.thickness - distance_under(layer, peak)) +
      force * (1.0 + kNu) * (3.0 - 2.0 * kNu) / (2.0 * std::numbers::pi * kModulus * kSize);
  const double hertz = 4.0 / 3.0 * e_star * std::sqrt(kRadius) * std::pow(depth, 1.5);
  EXPECT_NEAR(force, hertz, 0.08 * hertz);
}

}  // namespace
}  // namespace tetraction
