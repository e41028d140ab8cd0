#include "tetraction/simulation/scene_objects.h"

#include <limits>
#include <string>

#include "support/bodies.h"
#include "support/messages.h"
#include "support/scene_parts.h"
#include "tetraction/dynamics/body_sums.h"

namespace tetraction {
namespace {

using namespace testing_support;

Scene clamped() {
  Scene scene = spinning_block(Integrator::kVerlet, 1e-3, 1.0);
  FixSettings fix = testing_support::fix(SelectPlane{0, 0.0, {}});
  fix.where = "scene.toml:10:1";
  scene.fix.push_back(fix);
  return scene;
}

std::string refusal(const Scene& scene) {
  return message_of([&] {
    const auto system = make_system(scene, generate_mesh(*scene.mesh.generate));
    make_initial_state(scene, *system);
  });
}

TEST(MakeSystem, MassIsDensityTimesVolumeAndSharedByVertices) {
  const Scene scene = clamped();
  const auto system = make_system(scene, generate_mesh(*scene.mesh.generate));
  EXPECT_NEAR(system->total_mass(), 2000.0, 1e-9);
  double shares = 0.0;
  for (Index e = 0; e < system->rest().element_count(); ++e) shares += system->element_mass(e);
  EXPECT_NEAR(shares, 2000.0, 1e-9);
}

TEST(MakeInitialState, StretchFirstThenVelocityAtTheStretchedPositions) {
  Scene scene = spinning_block(Integrator::kVerlet, 1e-3, 1.0);
  scene.initial.stretch = {2.0, 1.0, 0.5};
  const auto system = make_system(scene, generate_mesh(*scene.mesh.generate));
  const State state = make_initial_state(scene, *system);
  const Vector rest = system->mesh().rest_positions();
  const Vector3 center = center_of_mass(*system, rest);
  for (Index v = 0; v < system->vertex_count(); ++v) {
    const Vector3 arm = (rest.segment<3>(3 * v) - center).cwiseProduct(Vector3(2.0, 1.0, 0.5));
    EXPECT_LT((state.position.segment<3>(3 * v) - center - arm).norm(), 1e-14);
    const Vector3 w = scene.initial.angular_velocity;
    const Vector3 spin(w.y() * arm.z() - w.z() * arm.y(), w.z() * arm.x() - w.x() * arm.z(),
                       w.x() * arm.y() - w.y() * arm.x());
    EXPECT_LT((state.velocity.segment<3>(3 * v) - scene.initial.velocity - spin).norm(), 1e-13);
    EXPECT_LT(
        (state.momentum.segment<3>(3 * v) - system->mass()[v] * state.velocity.segment<3>(3 * v))
            .norm(),
        1e-12);
  }
}

TEST(MakeInitialState, FixedVerticesRestAtTheirTargets) {
  Scene scene = clamped();
  scene.fix[0].offset = Vector3(-0.05, 0.0, 0.01);
  scene.fix[0].components = {true, false, true};
  const auto system = make_system(scene, generate_mesh(*scene.mesh.generate));
  const State state = make_initial_state(scene, *system);
  Scene plain = clamped();
  plain.fix[0].components = {true, false, true};
  const State before = make_initial_state(plain, *system);
  for (const Index v : select_vertices(system->mesh(), SelectPlane{0, 0.0, {}})) {
    EXPECT_EQ(state.position[3 * v], before.position[3 * v] - 0.05);
    EXPECT_EQ(state.position[3 * v + 2], before.position[3 * v + 2] + 0.01);
    EXPECT_EQ(state.momentum[3 * v], 0.0);
    EXPECT_NE(state.momentum[3 * v + 1], 0.0) << "y is free";
  }
}

TEST(MakeInitialState, MomentumOfSingleVertices) {
  Scene scene = spinning_block(Integrator::kVerlet, 1e-3, 1.0);
  const MomentumSettings momentum{SelectVertices{{3}}, {1.0, -2.0, 3.0}, {}};
  scene.initial.momentum.push_back(momentum);
  const auto system = make_system(scene, generate_mesh(*scene.mesh.generate));
  const State state = make_initial_state(scene, *system);
  EXPECT_LT((state.momentum.segment<3>(9) - momentum.value).norm(), 1e-14);
}

TEST(MakeSystem, RefusesWithThePlaceInTheScene) {
  Scene nothing = clamped();
  nothing.fix[0].select = SelectPlane{1, 9.0, {}};
  EXPECT_EQ(refusal(nothing).rfind("scene.toml:10:1: ", 0), 0U);

  Scene twice = clamped();
  twice.fix.push_back(twice.fix[0]);
  EXPECT_EQ(refusal(twice), "accepted") << "the same target twice is no contradiction";
  twice.fix[1].offset = Vector3(0.1, 0, 0);
  EXPECT_NE(refusal(twice).find("fixed twice"), std::string::npos);

  Scene inverted = clamped();
  inverted.fix[0].offset = Vector3(1.9, 0, 0);
  EXPECT_NE(refusal(inverted).find("inverts element"), std::string::npos);

  Scene initial = clamped();
  TetMesh mesh = generate_mesh(*initial.mesh.generate);
  Matrix mirrored = Matrix::Zero(3, mesh.vertex_count());
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    mirrored(0, v) = -2.0 * mesh.vertices[static_cast<std::size_t>(v)].x();
  }
  mesh.point_arrays["mirrored"] = mirrored;
  initial.initial.displacement_array = "mirrored";
  initial.initial.places = {{"displacement_array", "scene.toml:7:1"}};
  const auto system = make_system(initial, std::move(mesh));
  const std::string message = message_of([&] { make_initial_state(initial, *system); });
  EXPECT_EQ(message.rfind("scene.toml:7:1: initial.displacement_array inverts element ", 0), 0U)
      << message;

  Scene array = clamped();
  array.initial.displacement_array = "mode";
  EXPECT_NE(refusal(array).find("no point-data array"), std::string::npos);
}

TEST(MakeEnvironment, ACustomOneNeedsItsField) {
  EnvironmentSettings settings;
  settings.kind = EnvironmentKind::kCustom;
  EXPECT_THROW(make_environment(settings), InputError);
}

// Settings of a program pass the same checks as those of a scene file, with the same words.
TEST(MakeStepper, RefusesSolverSettingsByTheirKey) {
  const Scene scene = clamped();
  const auto system = make_system(scene, generate_mesh(*scene.mesh.generate));
  const auto refusal_of = [&](const SolverSettings& solver) {
    return message_of([&] { make_stepper(Integrator::kMidpoint, solver, *system); });
  };
  EXPECT_EQ(refusal_of({}), "accepted");
  EXPECT_EQ(refusal_of({.tolerance = 2.0}),
            "solver.tolerance = 2; it must lie between 0 and 1, both excluded; 1e-8 is usual.");
  EXPECT_EQ(refusal_of({.max_iterations = 0}), "solver.max_iterations = 0; it must be 1 or more.");
  EXPECT_EQ(refusal_of({.kind = "gauss"}),
            "solver.kind = \"gauss\" is not a solver; there are newton and ceres.");
}

TEST(CheckEvents, FindsSolversThatCannotComputeTheSteps) {
  const auto refusal_of = [](const Scene& scene, std::vector<Edit> edits) -> std::string {
    Scene changed = scene;
    changed.event.push_back({0.1, {}, "", "scene.toml:12:1: event at 0.1 s"});
    changed.event.push_back({0.2, std::move(edits), "", "scene.toml:20:1: event at 0.2 s"});
    return message_of([&] {
      check_events(changed, *make_system(changed, generate_mesh(*changed.mesh.generate)));
    });
  };
  Scene scene = clamped();
  TimeSettings midpoint = scene.time;
  midpoint.integrator = Integrator::kMidpoint;
  TimeSettings energy_momentum = scene.time;
  energy_momentum.integrator = Integrator::kEnergyMomentum;
  SolverSettings ceres = scene.solver;
  ceres.kind = "ceres";
  EXPECT_EQ(refusal_of(scene, {SetTime{midpoint}, SetSolver{ceres}}), "accepted");
  std::string text = refusal_of(scene, {SetTime{energy_momentum}, SetSolver{ceres}});
  EXPECT_EQ(text.rfind("scene.toml:20:1: event at 0.2 s: solver.kind", 0), 0U) << text;
  scene.mesh.volume = VolumeRule::kNodal;
  EXPECT_EQ(refusal_of(scene, {SetSolver{ceres}}), "accepted");  // verlet needs no solver
  text = refusal_of(scene, {SetTime{midpoint}, SetSolver{ceres}});
  EXPECT_EQ(text.rfind("scene.toml:20:1: event at 0.2 s: Ceres", 0), 0U) << text;
}

TEST(SetDamping, RefusesACoefficientByItsKey) {
  const Scene scene = clamped();
  const auto system = make_system(scene, generate_mesh(*scene.mesh.generate));
  const auto refusal_of = [&](const Damping& damping) {
    return message_of([&] { system->set_damping(damping); });
  };
  EXPECT_EQ(refusal_of({1.0, 0.0, 2.0}), "accepted");
  EXPECT_EQ(refusal_of({.mass_damping = -1.0}),
            "damping.mass_damping = -1; it must be 0 or more: negative damping makes energy.");
  EXPECT_EQ(refusal_of({.viscosity = std::numeric_limits<double>::infinity()}),
            "damping.viscosity = inf; it must be finite.");
}

}  // namespace
}  // namespace tetraction
