// The spring of [pull] with every rule and solver, against closed solutions, and what other analyses make of it.
#include <cmath>
#include <numbers>
#include <numeric>

#include "support/corner_scenes.h"
#include "support/cubes.h"
#include "support/soft_cube.h"
#include "tetraction/simulation/equilibrium.h"
#include "tetraction/solver/normal_modes.h"

namespace tetraction {
namespace {

using namespace testing_support;

constexpr double kStiffness = 800.0;
constexpr double kDamping = 16.0;
constexpr double kEnd = 0.3;

std::vector<std::int64_t> all_vertices(const TetMesh& mesh) {
  std::vector<std::int64_t> numbers(static_cast<std::size_t>(mesh.vertex_count()));
  std::iota(numbers.begin(), numbers.end(), 0);
  return numbers;
}

Vector3 center(const Session& session) {
  const Vector& mass = session.system().mass();
  Vector3 sum = Vector3::Zero();
  for (Index v = 0; v < mass.size(); ++v) {
    sum += mass[v] * vertex_block(session.state().position, v);
  }
  return sum / mass.sum();
}

class Pull : public SoftCube {
 protected:
  Scene pulled_cube(double step, double end) const {
    Scene scene = cube(step, end);
    scene.pull = {all_vertices(cube_mesh()), {0.1, 0.0, 0.05}, kStiffness, kDamping};
    return scene;
  }
};

INSTANTIATE_TEST_SUITE_P(All, Pull, testing::ValuesIn(rules_with_solvers()), name_with_solver);

// A pull of all vertices leaves a body rigid, which is a damped oscillator: with ω₀² = k/M, γ = d/2M and ω² = ω₀² − γ²
// its way from the target falls as e^(−γt) (cos ωt + γ/ω sin ωt).
TEST_P(Pull, MovesABodyAsADampedOscillator) {
  const auto run = [&](double step) {
    const Scene scene = pulled_cube(step, kEnd);
    if (GetParam().solver.kind == "ceres") {
      expect_error([&] { Session session(scene, cube_mesh()); }, {"\"pull\"", "Ceres"});
      return 0.0;
    }
    Session session(scene, cube_mesh());
    const double mass = session.system().total_mass();
    const Vector3 way = center(session) - scene.pull.target;
    EXPECT_EQ(session.run(), RunStatus::kFinished) << session.message();
    const double gamma = 0.5 * kDamping / mass;
    const double omega = std::sqrt(kStiffness / mass - gamma * gamma);
    const double t = session.state().time;
    const double decay = std::exp(-gamma * t);
    const double place = decay * (std::cos(omega * t) + gamma / omega * std::sin(omega * t));
    const double speed = -decay * (omega + gamma * gamma / omega) * std::sin(omega * t);
    const Vector3 exact = scene.pull.target + place * way;
    const double given = 0.5 * kStiffness * (1.0 - place * place) * way.squaredNorm();
    const double kinetic = 0.5 * mass * speed * speed * way.squaredNorm();
    const Balance& balance = session.balance();
    // Errors of a rule of the first order fall with the step.
    const double allowed = has_second_order() ? 1e-3 : 35.0 * step;
    EXPECT_NEAR(balance.external_work(), given, allowed * given);
    EXPECT_NEAR(balance.dissipated_energy(), given - kinetic, allowed * given);
    EXPECT_NEAR(balance.energies().total(), balance.energies().kinetic(), 1e-9 * given)
        << "the spring's energy is no part of the total";
    if (GetParam().integrator == Integrator::kEnergyMomentum) {
      EXPECT_LT(std::abs(balance.energy_error()), 1e-9 * given);
    }
    return (center(session) - exact).norm() / way.norm();
  };
  const double coarse = run(2e-3);
  const double fine = run(1e-3);
  EXPECT_LT(fine, has_second_order() ? 1e-4 : 0.02);
  if (coarse > 0.0) {
    EXPECT_GT(coarse / fine, has_second_order() ? 3.7 : 1.85);
  }
}

// A change of the unit of length, with that of time, changes nothing but the numbers.
TEST(PullInUnits, FromMicrometresToKilometres) {
  const auto run = [](double unit) {
    Scene scene = scene_of(elastic(5e4, 0.3));
    scene.time = {Integrator::kMidpoint, 2e-3 * unit, false, 0.04 * unit};
    scene.pull = {
        {3, 7, 9}, {0.15 * unit, 0.1 * unit, 0.0}, kStiffness * unit, kDamping * unit * unit};
    Session session(scene, generate_box({0.2 * unit, 0.2 * unit, 0.2 * unit}, {2, 2, 2}));
    EXPECT_EQ(session.run(), RunStatus::kFinished) << session.message();
    return Vector(session.state().position / unit);
  };
  const Vector metres = run(1.0);
  for (const double unit : {1e-6, 1e-3, 1e3}) {
    EXPECT_LT((run(unit) - metres).lpNorm<Eigen::Infinity>(), 1e-9) << unit;
  }
}

// Statics: the same forces, given as loads, have the same equilibrium.
TEST(PullInStatics, IsAForceAtItsEquilibrium) {
  Scene scene = clamped_beam({0.4, 0.1, 0.1}, {8, 2, 2});
  const TetMesh mesh = mesh_of(scene);
  const std::vector<Index> tip = select_vertices(mesh, SelectPlane{0, 0.4, {}});
  scene.pull = {{tip.begin(), tip.end()}, {0.38, 0.15, 0.05}, 3000.0, 0.0};
  Session session(scene, mesh);
  const MechanicalSystem& system = session.system();
  const Equilibrium pulled = find_equilibrium(system);
  ASSERT_TRUE(pulled.found) << pulled.message;
  Vector3 mean = Vector3::Zero();
  Vector3 sum = Vector3::Zero();
  double mass = 0.0;
  for (const Index v : tip) {
    mean += system.mass()[v] * vertex_block(pulled.position, v);
    mass += system.mass()[v];
    sum += vertex_block(pulled.load, v);
  }
  mean /= mass;
  EXPECT_GT(mean.y(), 0.06) << "it bends the beam";
  const Vector3 force = scene.pull.stiffness * (scene.pull.target - mean);
  EXPECT_LT((sum - force).norm(), 1e-9 * force.norm());

  Scene loaded = scene;
  loaded.pull = {};
  for (const Index v : tip) {
    loaded.force.push_back(load(SelectVertices{{v}}, vertex_block(pulled.load, v)));
  }
  Session other(loaded, mesh);
  const Equilibrium by_forces = find_equilibrium(other.system());
  ASSERT_TRUE(by_forces.found) << by_forces.message;
  EXPECT_LT((by_forces.position - pulled.position).lpNorm<Eigen::Infinity>(), 1e-8);
}

// A rigid body on the spring swings with ω² = k/M. Without loads the same motions are rigid ones.
TEST(PullInModes, IsASpringWithLoadsOnly) {
  Scene scene = scene_of(elastic(5e4, 0.3));
  scene.pull = {all_vertices(cube_mesh()), {0.0, 0.0, 0.0}, kStiffness, 0.0};
  Session session(scene, cube_mesh());
  const MechanicalSystem& system = session.system();
  NormalModeOptions options;
  options.count = 6;
  options.with_loads = true;
  const NormalModes loaded = normal_modes(system, session.state().position, options);
  const double expected = std::sqrt(kStiffness / system.total_mass()) / (2.0 * std::numbers::pi);
  Index springs = 0;
  for (const NormalMode& mode : loaded.modes) {
    if (std::abs(mode.frequency() - expected) < 1e-6 * expected) ++springs;
  }
  EXPECT_EQ(springs, 3);
  options.with_loads = false;
  for (const NormalMode& mode : normal_modes(system, session.state().position, options).modes) {
    EXPECT_EQ(mode.kind, ModeKind::kRigid);
  }
}

// A mean that rests moves with velocities of round-off, whose damping forces do work of any sign.
TEST(PullWithExplicitRules, MayDampAMeanThatRests) {
  for (const Integrator rule : {Integrator::kVerlet, Integrator::kExplicit}) {
    Scene scene = scene_of(elastic(1e5, 0.3));
    scene.time = {rule, 2e-3, false, 0.4};
    scene.initial.angular_velocity = {0.0, 0.0, 3.0};
    const TetMesh mesh = generate_box({1.0, 1.0, 1.0}, {1, 1, 1});
    scene.pull = {all_vertices(mesh), {0.5, 0.5, 0.5}, 4e3, 100.0};
    Session session(scene, mesh);
    EXPECT_EQ(session.run(), RunStatus::kFinished) << session.message();
  }
}

// The damper of one vertex and of two slow down the pulled vertices alone, and that of a fixed one nothing.
TEST(PullWithExplicitRules, LimitsAutomaticStepsByStabilityAlone) {
  const auto first_step = [](const std::vector<std::int64_t>& vertices) {
    Scene scene = clamped_beam({0.4, 0.1, 0.1}, {4, 1, 1});
    scene.time.integrator = Integrator::kVerlet;
    scene.time.automatic = true;
    scene.time.end = 0.01;
    scene.pull = {vertices, {0.4, 0.1, 0.1}, 0.0, 100.0};
    if (vertices.empty()) scene.pull = {};
    Session session(scene, mesh_of(scene));
    EXPECT_TRUE(session.step()) << session.message();
    return session.state().time;
  };
  const double free = first_step({});
  EXPECT_NEAR(first_step({0}), free, 1e-3 * free) << "a fixed vertex";
  EXPECT_NEAR(first_step({19}), free, 1e-3 * free);
  EXPECT_NEAR(first_step({18, 19}), free, 1e-3 * free);
}

// The spring is at rest, or all but at rest, so that its force is nothing beside its stiffness.
TEST(PullInStatics, HoldsWhereItsForceIsRoundOff) {
  for (const double offset : {0.0, 1e-10, 1e-8, 1e-7, 1e-3}) {
    const TetMesh mesh = generate_box({1.0, 1.0, 1.0}, {1, 1, 1});
    Scene scene = scene_of(elastic(1e5, 0.3));
    scene.pull = {all_vertices(mesh), {0.5 + offset, 0.5, 0.5}, 1e3, 0.0};
    Scene guided = scene;
    scene.fix.push_back(fix(SelectPlane{0, 0.0, {}}));
    guided.constraint.push_back(on_line(SelectAll{}, {1.0, 0.0, 0.0}));
    for (const Scene& each : {scene, guided}) {
      Session session(each, mesh);
      const Equilibrium found = find_equilibrium(session.system());
      EXPECT_TRUE(found.found) << offset << ' ' << found.message;
    }
  }
}

// The mean of two parts is held, but they can move against each other.
TEST(PullInStatics, OfSeparatePartsLeavesThemFreeAgainstEachOther) {
  TetMesh mesh = cubes({{0, 0, 0}, {3, 0, 0}});
  Scene scene = scene_of(elastic(1e5, 0.3));
  scene.pull = {all_vertices(mesh), {2.5, 0.5, 0.5}, 1e3, 0.0};
  scene.constraint.push_back(on_line(SelectAll{}, {1.0, 0.0, 0.0}));
  Session session(scene, mesh);
  expect_error([&] { find_equilibrium(session.system()); }, {"can still", "against each other"});
  scene.fix.push_back(fix(SelectPlane{0, 4.0, {}}));
  Session held(scene, mesh);
  EXPECT_TRUE(find_equilibrium(held.system()).found) << "one of them is fixed";
}

TEST(PullInScenes, IsCheckedInEventsToo) {
  const TetMesh mesh = generate_box({1.0, 1.0, 1.0}, {1, 1, 1});
  Scene scene = scene_of(elastic(1e5, 0.3));
  scene.time = {Integrator::kMidpoint, 1e-3, false, 0.01};
  const auto refused = [&](const std::vector<std::int64_t>& vertices,
                           const std::vector<std::string>& says) {
    Scene other = scene;
    other.event.push_back(
        {0.005, {SetPull{{vertices, Vector3::Zero(), 1.0, 0.0}}}, "", "at the event"});
    expect_error([&] { Session session(other, mesh); }, says);
  };
  refused({70}, {"at the event", "pull.vertices", "70"});
  refused({7, 7}, {"at the event", "pull.vertices", "twice"});
  scene.solver.kind = "ceres";
  refused({6, 7}, {"at the event", "Ceres", "\"pull\""});
}

// Without loads neither the spring nor its damper counts.
TEST(PullInModes, HasADamperWithLoadsOnly) {
  Scene scene = clamped_beam({0.4, 0.1, 0.1}, {4, 1, 1});
  scene.pull = {{18, 19}, {0.4, 0.1, 0.1}, 1e3, 5.0};
  Session session(scene, mesh_of(scene));
  NormalModeOptions options;
  options.count = 1;
  const auto ratio = [&] {
    return normal_modes(session.system(), session.state().position, options).modes[0].damping_ratio;
  };
  EXPECT_EQ(ratio(), 0.0);
  options.with_loads = true;
  EXPECT_GT(ratio(), 0.01);
}

}  // namespace
}  // namespace tetraction
