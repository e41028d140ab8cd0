// Contact of bodies with each other and with themselves: nothing passes through anything, the energy and both momenta of
// a step of any size, and closed forms.
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "support/body_contact.h"
#include "support/rules.h"
#include "support/same_run.h"
#include "tetraction/core/parallel.h"

namespace tetraction {
namespace {

using namespace testing_support;

TEST(BodyContact, CubesThatCollideKeepEnergyAndMomenta) {
  Scene scene = colliding_cubes(Integrator::kEnergyMomentum, 1e-3, 1.0);
  const double limit = Session(scene, mesh_of_bodies(scene)).initial_limit().critical_step;
  for (const auto& [times, steps] : {std::pair{0.25, 150}, {1.0, 50}, {4.0, 15}}) {
    scene.time.step = times * limit;
    scene.time.retry = times > 1.0 ? 4 : 0;
    scene.time.end = steps * scene.time.step;
    Session session(scene, mesh_of_bodies(scene));
    const Momenta start = session.balance().momenta();
    const double gap = run_apart(session);
    EXPECT_LT(gap, session.system().contact()->least_thickness()) << "they never touched";
    const Balance& balance = session.balance();
    EXPECT_LT(balance.max_relative_energy_drift(), 1e-11) << times;
    EXPECT_LT(balance.linear_momentum_drift(), 1e-12) << times;
    EXPECT_LT(balance.angular_momentum_drift(), 1e-11) << times;
    // The collision turned the first cube back: its momentum along x was 8 kg m/s.
    Vector3 first = Vector3::Zero();
    for (Index v = 0; v < session.system().vertex_count() / 2; ++v) {
      first += vertex_block(session.state().momentum, v);
    }
    EXPECT_LT(first.x(), 0.25 * 8.0) << times;
    EXPECT_NEAR(start.linear.x(), 0.0, 1e-12);
  }
}

class BodyContactRules : public testing::TestWithParam<Integrator> {
 protected:
  ~BodyContactRules() override { set_thread_count(0); }
  static bool is_euler() { return GetParam() == Integrator::kBackwardEuler; }
  static double step() { return is_implicit(GetParam()) ? 2e-3 : 1e-4; }
};

TEST_P(BodyContactRules, KeepBodiesApart) {
  const Scene scene = colliding_cubes(GetParam(), step(), 0.12);
  Session session(scene, mesh_of_bodies(scene));
  const double gap = run_apart(session);
  EXPECT_LT(gap, session.system().contact()->least_thickness());
  const Balance& balance = session.balance();
  EXPECT_LT(balance.linear_momentum_drift(), is_euler() ? 1e-7 : 1e-12);
  if (!is_euler()) {
    EXPECT_LT(balance.angular_momentum_drift(), 1e-9);
    EXPECT_LT(balance.max_relative_energy_drift(), 0.05);
  }
}

// What touches changes the pattern of the matrix between iterations, while a factor of an older one is kept.
TEST_P(BodyContactRules, KeepARigidBodyApart) {
  Scene scene = colliding_cubes(GetParam(), step(), 0.12);
  scene.initial.angular_velocity.setZero();
  ConstraintSettings handle;
  handle.kind = ConstraintKind::kRigid;
  handle.select = SelectGroup{"body_0"};
  scene.constraint = {handle};
  Session session(scene, mesh_of_bodies(scene));
  const double gap = run_apart(session);
  EXPECT_LT(gap, session.system().contact()->least_thickness());
  EXPECT_LT(session.balance().linear_momentum_drift(), is_euler() ? 1e-7 : 1e-11);
}

TEST_P(BodyContactRules, GoOnFromACheckpointWithTheSameBits) {
  const Scene scene = colliding_cubes(GetParam(), step(), 0.08);
  Session continued(scene, mesh_of_bodies(scene));
  const double layer = continued.system().contact()->least_thickness();
  while (!(present_gap(continued) < layer)) ASSERT_TRUE(continued.step()) << continued.message();
  ASSERT_TRUE(continued.step()) << continued.message();
  ASSERT_LT(continued.time(), 0.07);
  const Checkpoint checkpoint = continued.checkpoint();
  Session restored(scene, mesh_of_bodies(scene));
  restored.restore(checkpoint);
  expect_same(continued, restored);
  while (continued.step()) ASSERT_TRUE(restored.step()) << restored.message();
  EXPECT_FALSE(restored.step());
  EXPECT_EQ(continued.status(), RunStatus::kFinished) << continued.message();
  expect_same(continued, restored);
}

TEST_P(BodyContactRules, HaveTheSameBitsOnAnyNumberOfThreads) {
  // With more vertices than a piece of the loops over them, and until the layers are in the middle of the impact.
  Scene scene = colliding_cubes(GetParam(), 2e-3, 0.022);
  scene.mesh.generate->cells = {6, 6, 6};
  if (!is_implicit(GetParam())) {
    scene.time.automatic = true;
    scene.time.end = 0.09;
    for (Vector3* v : {&scene.initial.velocity, &scene.initial.angular_velocity,
                       &scene.mesh.copies[0].velocity, &scene.mesh.copies[0].angular_velocity}) {
      *v *= 0.2;
    }
  }
  std::vector<Vector> positions;
  for (const int threads : {1, 2}) {
    set_thread_count(threads);
    Session session(scene, mesh_of_bodies(scene));
    while (session.step()) {
    }
    ASSERT_EQ(session.status(), RunStatus::kFinished) << session.message();
    EXPECT_TRUE(std::isfinite(present_gap(session)));
    positions.push_back(session.state().position);
  }
  EXPECT_EQ(positions[0], positions[1]);
}

INSTANTIATE_TEST_SUITE_P(Rules, BodyContactRules, testing::ValuesIn(all_rules()), name_of_rule);

// The limit of a step is that of the layer where most of the area is: pairs of edges, which have a small share, are not
// pressed by all of the motion. A bound for them alone takes a millionth of these steps.
TEST(BodyContact, AutomaticStepsPassAFastImpact) {
  Scene scene = colliding_cubes(Integrator::kVerlet, 1e-3, 0.1);
  scene.time.automatic = true;
  scene.initial.velocity *= 2.0;  // together half of the speed of waves
  scene.mesh.copies[0].velocity *= 2.0;
  Session session(scene, mesh_of_bodies(scene));
  double gap = present_gap(session);
  while (session.step() && session.step_number() < 2000) {
    gap = std::min(gap, present_gap(session));
  }
  EXPECT_EQ(session.status(), RunStatus::kFinished) << session.message();
  EXPECT_LT(gap, 0.5 * session.system().contact()->least_thickness());
  EXPECT_LT(session.balance().max_relative_energy_drift(), 0.01);
}

// All lengths and times are multiplied by the unit.
TEST(BodyContact, IsTheSameInAllUnits) {
  std::vector<double> energies;
  std::vector<Vector> places;
  for (const double unit : {1.0, 1e-6, 1e-3, 1e3}) {
    const Scene scene =
        colliding_cubes(Integrator::kEnergyMomentum, 2e-3 * unit, 0.06 * unit, unit);
    const FinishedRun run(scene, mesh_of_bodies(scene));
    EXPECT_LT(run.balance().max_relative_energy_drift(), 1e-11) << unit;
    energies.push_back(run.balance().energies().elastic() / (unit * unit * unit));
    places.push_back(run.state().position / unit);
    EXPECT_NEAR(energies.back(), energies.front(), 1e-6 * energies.front()) << unit;
    EXPECT_LT((places.back() - places.front()).norm(), 1e-7 * places.front().norm()) << unit;
  }
  EXPECT_GT(energies.front(), 0.0);
}

// Bars of the same section in a row, along x, the first of which flies towards the second.
struct Bars {
  static constexpr double kModulus = 1e6;
  static constexpr double kDensity = 1000.0;
  static constexpr double kSpeed = 0.03;  // about 1e-3 of the speed of waves
  static constexpr double kWidth = 0.1;

  Bars(double first, double second, int cells_of_unit) {
    constexpr double kGap = 0.002;
    const auto box = [&](double length) {
      return generate_box({length, kWidth, kWidth},
                          {static_cast<int>(std::lround(length * cells_of_unit)), 1, 1});
    };
    RawMesh raw;
    Matrix velocity(3, 0);
    for (const auto& [bar, shift] : {std::pair{box(first), 0.0}, {box(second), first + kGap}}) {
      const auto start = static_cast<std::int64_t>(raw.vertices.size());
      velocity.conservativeResize(3, velocity.cols() + bar.vertex_count());
      for (Index v = 0; v < bar.vertex_count(); ++v) {
        const Vector3 place = bar.rest_positions().segment<3>(3 * v);
        velocity.col(start + v) = shift == 0.0 ? Vector3(kSpeed, 0.0, 0.0) : Vector3(0, 0, 0);
        raw.vertices.push_back(place + Vector3(shift, 0.0, 0.0));
        raw.vertex_ids.push_back(start + v);
      }
      for (const auto& corners : bar.tetrahedra) {
        RawCell cell;
        cell.type = CellType::kTetrahedron;
        cell.id = static_cast<std::int64_t>(raw.cells.size());
        for (const Index v : corners) cell.vertices.push_back(start + v);
        raw.cells.push_back(cell);
      }
      if (shift == 0.0) vertices_of_first = bar.vertex_count();
    }
    raw.point_arrays["v"] = velocity;
    mesh = build_mesh(std::move(raw));
    scene = scene_of(elastic(kModulus, 0.0, kDensity));
    scene.initial.velocity_array = "v";
    scene.contact.between = ContactBetween::kBodies;
    scene.contact.thickness = 0.001;
    speed_of_waves = std::sqrt(kModulus / kDensity);
  }

  Scene scene;
  TetMesh mesh;
  Index vertices_of_first = 0;
  double speed_of_waves = 0.0;
};

// A bar of the length L₁ that meets a longer one of the same section stops, and the other one has v₀ L₁/L₂; equal bars
// exchange their velocities. They touch for the time 2 L₁/c with the force ½ ρ c v₀ A. The gap takes part of a
// millimetre, which the bar passes with v₀. 20 cells of a bar leave ripples of the wave.
TEST(BodyContact, BarsExchangeTheirMomentum) {
  for (const double second : {1.0, 2.0}) {
    Bars bars(1.0, second, 20);
    const double contact_time = 2.0 * 1.0 / bars.speed_of_waves;
    bars.scene.time.integrator = Integrator::kEnergyMomentum;
    bars.scene.time.step = contact_time / 60.0;
    // To the layer, the contact, and until the end of the second bar has its last wave.
    bars.scene.time.end = 0.0015 / Bars::kSpeed + 1.2 * contact_time;
    Session session(bars.scene, bars.mesh);
    const Vector& mass = session.system().mass();
    const auto momentum = [&](Index begin, Index end) {
      double sum = 0.0;
      for (Index v = begin; v < end; ++v) sum += session.state().momentum[3 * v];
      return sum;
    };
    const Index all = session.system().vertex_count();
    const double whole = momentum(0, all);
    const double mass_of_second = mass.tail(all - bars.vertices_of_first).sum();
    double first_touch = -1.0;
    double middle_force = 0.0;
    int middle_steps = 0;
    double before = momentum(bars.vertices_of_first, all);
    while (session.step()) {
      const double after = momentum(bars.vertices_of_first, all);
      const double force = (after - before) / bars.scene.time.step;
      before = after;
      if (std::isfinite(present_gap(session)) && first_touch < 0.0) first_touch = session.time();
      const double since = first_touch < 0.0 ? -1.0 : (session.time() - first_touch) / contact_time;
      if (since > 0.2 && since < 0.8) {
        middle_force += force;
        ++middle_steps;
      }
    }
    ASSERT_EQ(session.status(), RunStatus::kFinished) << session.message();
    EXPECT_LT(session.balance().max_relative_energy_drift(), 1e-11);
    const double impedance = Bars::kDensity * bars.speed_of_waves * Bars::kWidth * Bars::kWidth;
    EXPECT_NEAR(middle_force / middle_steps, 0.5 * impedance * Bars::kSpeed,
                0.02 * 0.5 * impedance * Bars::kSpeed)
        << second;
    EXPECT_NEAR(momentum(0, bars.vertices_of_first), 0.0, 0.03 * whole) << second;
    EXPECT_NEAR(momentum(bars.vertices_of_first, all) / mass_of_second, Bars::kSpeed / second,
                0.03 * Bars::kSpeed)
        << second;
    EXPECT_TRUE(std::isinf(present_gap(session))) << "they are still together";
  }
}

// Ten blocks upon each other, which can move vertically only: each interface carries the weight above it.
TEST(BodyContact, StackedBlocksCarryTheWeightAbove) {
  constexpr int kBlocks = 10;
  constexpr double kEdge = 0.1;
  Scene scene =
      scene_of({GeneratorKind::kBox, {kEdge, kEdge, kEdge}, {2, 2, 2}}, elastic(1e6, 0.3));
  scene.environment = gravity(9.81);
  for (int k = 1; k < kBlocks; ++k) {
    MeshCopySettings copy;
    copy.at = {0.0, k * (kEdge + 0.002), 0.0};
    scene.mesh.copies.push_back(copy);
  }
  scene.fix = {fix(SelectAll{}, {true, false, true})};
  scene.contact.between = ContactBetween::kBodies;
  scene.contact.thickness = 0.003;
  scene.obstacle = {plane_obstacle("floor", {0.0, -0.001, 0.0})};
  scene.obstacle[0].thickness = 0.003;
  const TetMesh mesh = mesh_of_bodies(scene);
  const FinishedEquilibrium run(scene, mesh);
  Vector gradient = Vector::Zero(run.system().dof_count());
  const MechanicalSystem& system = run.system();
  ForcePoint at = system.force_point(run.state().position, 0.0);
  system.contact()->add_gradient(at, gradient);
  const Index vertices = system.vertex_count() / kBlocks;
  const double weight = system.total_mass() / kBlocks * 9.81;
  for (int k = 0; k < kBlocks; ++k) {
    // What the block below, or the floor, carries: all contact forces on the blocks from k on.
    double force = 0.0;
    for (Index v = k * vertices; v < system.vertex_count(); ++v) force -= gradient[3 * v + 1];
    EXPECT_NEAR(force, (kBlocks - k) * weight, 1e-6 * weight) << k;
  }
  EXPECT_EQ(count_intersections(mesh, run.state().position), 0);
}

// A block with a slit, whose two halves swing against each other.
TetMesh slit_block(int cells) {
  const TetMesh whole = generate_box({0.5, 0.3, 0.1}, {5 * cells, 3 * cells, cells});
  RawMesh raw;
  const Vector rest = whole.rest_positions();
  for (Index v = 0; v < whole.vertex_count(); ++v) {
    raw.vertices.emplace_back(vertex_block(rest, v));
    raw.vertex_ids.push_back(v);
  }
  for (const auto& corners : whole.tetrahedra) {
    Vector3 center = Vector3::Zero();
    for (const Index v : corners) center += 0.25 * vertex_block(rest, v);
    if (center.x() > 0.1 && center.y() > 0.1 && center.y() < 0.2) continue;
    RawCell cell;
    cell.type = CellType::kTetrahedron;
    cell.id = static_cast<std::int64_t>(raw.cells.size());
    for (const Index v : corners) cell.vertices.push_back(v);
    raw.cells.push_back(cell);
  }
  return build_mesh(std::move(raw));
}

TEST(BodyContact, ABodyTouchesItself) {
  for (const Integrator rule :
       {Integrator::kEnergyMomentum, Integrator::kBackwardEuler, Integrator::kVerlet}) {
    Scene scene = scene_of(elastic(1e5, 0.3));
    const double h = rule == Integrator::kVerlet ? 2e-4 : 2e-3;
    scene.time = {rule, h, false, 0.1};
    for (const double side : {1.0, -1.0}) {
      MomentumSettings pull;
      const double y = side > 0.0 ? 0.0 : 0.2;
      pull.select = SelectBox{Vector3(0.29, y - 0.01, -1.0), Vector3(0.6, y + 0.11, 1.0)};
      pull.value = {0.0, side * 0.25, 0.0};
      scene.initial.momentum.push_back(pull);
    }
    scene.contact.between = ContactBetween::kAll;
    const TetMesh mesh = slit_block(1);
    Session session(scene, mesh);
    const double gap = run_apart(session);
    EXPECT_LT(gap, session.system().contact()->least_thickness()) << to_string(rule);
    if (rule == Integrator::kEnergyMomentum) {
      EXPECT_LT(session.balance().max_relative_energy_drift(), 1e-11);
      EXPECT_LT(session.balance().angular_momentum_drift(), 1e-10);
    }
    // Without contact the halves pass through each other.
    scene.contact.between = ContactBetween::kNone;
    Session free(scene, mesh);
    int most = 0;
    while (free.step()) {
      most = std::max(most, count_intersections(mesh, free.state().position));
    }
    EXPECT_GT(most, 0) << to_string(rule);
  }
}

// Ten lengths of an element in a step.
TEST(BodyContact, FastBodiesDoNotPassThrough) {
  Scene scene = colliding_cubes(Integrator::kBackwardEuler, 1e-2, 0.1);
  scene.material.youngs_modulus = 2e9;
  scene.time.retry = 8;
  scene.initial.velocity = {100.0, 0.0, 0.0};
  scene.mesh.copies[0].at = {3.0, 0.05, 0.0};
  scene.mesh.copies[0].velocity = {0.0, 0.0, 0.0};
  Session session(scene, mesh_of_bodies(scene));
  run_apart(session);
  // The second one was hit: it has a part of the 800 kg m/s. The first one slides past it within a step.
  double momentum = 0.0;
  for (Index v = session.system().vertex_count() / 2; v < session.system().vertex_count(); ++v) {
    momentum += session.state().momentum[3 * v];
  }
  EXPECT_GT(momentum, 8.0);
}

}  // namespace
}  // namespace tetraction
