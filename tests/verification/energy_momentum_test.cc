// The conservation laws of the energy-momentum rule: energy and both momenta with any step, and a balance that
// closes with everything that acts on the body.
#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "support/corner_scenes.h"
#include "support/force_terms.h"

namespace tetraction {
namespace {

using namespace testing_support;

double stable_step(Scene scene) {
  scene.time = {Integrator::kVerlet, 1e-9, false, 1e-9};
  return Session(scene, mesh_of(scene)).initial_limit().critical_step;
}

struct NamedMaterial {
  std::string name;
  std::function<void(MaterialSettings&)> set;
};

std::vector<NamedMaterial> materials() {
  std::vector<NamedMaterial> all{
      {"stvk", [](MaterialSettings& m) { m.model = "stvk"; }},
      {"neo_hookean", [](MaterialSettings& m) { m.model = "neo-hookean"; }},
      {"quadratic", [](MaterialSettings& m) { m.volumetric = VolumetricPart::kQuadratic; }},
      {"mooney_rivlin",
       [](MaterialSettings& m) {
         m.model = "mooney-rivlin";
         m.numbers["ratio"] = 0.5;
       }},
      {"yeoh",
       [](MaterialSettings& m) {
         m.model = "yeoh";
         m.numbers["c20"] = 1e3;
         m.numbers["c30"] = 1e3;
       }},
      {"custom", [](MaterialSettings& m) {
         const LameParameters lame = lame_from_young(1e5, 0.3);
         m.custom = CustomMaterial(NeoHookean(lame.mu, lame.lambda));
       }}};
  for (const MaterialChoice& choice : material_choices()) {
    std::string name = std::string("like_") + choice.name;
    std::replace(name.begin(), name.end(), '-', '_');
    all.push_back({name, [&choice](MaterialSettings& m) {
                     m.model = choice.name;
                     choice.set_like(m, lame_from_young(1e5, 0.3));
                   }});
  }
  return all;
}

class EnergyMomentumOf : public testing::TestWithParam<NamedMaterial> {};

TEST_P(EnergyMomentumOf, KeepsEnergyAndMomentaAtAnyStep) {
  Scene scene = spinning_block(Integrator::kEnergyMomentum, 1e-3, 1.0);
  GetParam().set(scene.material);
  const double limit = stable_step(scene);
  // Ten times the limit is 0.5 s here, in which the body turns by more than a radian.
  for (const auto& [times, steps] : {std::pair{1.0, 300}, {3.0, 200}, {10.0, 60}}) {
    scene.time.step = times * limit;
    scene.time.end = steps * scene.time.step;
    Session session(scene, mesh_of(scene));
    ASSERT_EQ(session.run(), RunStatus::kFinished) << times << ": " << session.message();
    EXPECT_LT(session.balance().max_relative_energy_drift(), 1e-11) << times;
    EXPECT_LT(session.balance().linear_momentum_drift(), 1e-12) << times;
    EXPECT_LT(session.balance().angular_momentum_drift(), 1e-11) << times;
  }
}

INSTANTIATE_TEST_SUITE_P(Materials, EnergyMomentumOf, testing::ValuesIn(materials()),
                         [](const auto& test) { return test.param.name; });

TEST(EnergyMomentum, KeepsTheEnergyWhereMidpointGainsIt) {
  Scene scene = spinning_block(Integrator::kMidpoint, 0.2, 20.0);
  scene.material.youngs_modulus = 1e6;
  scene.initial.stretch = {1.3, 0.9, 0.9};
  scene.initial.angular_velocity = {3.0, 2.0, 5.0};
  Session midpoint(scene, mesh_of(scene));
  midpoint.run();
  scene.time.integrator = Integrator::kEnergyMomentum;
  FinishedRun session(scene);
  EXPECT_GT(midpoint.balance().max_relative_energy_drift(), 0.1);
  EXPECT_LT(session.balance().max_relative_energy_drift(), 1e-11);
  EXPECT_LT(session.balance().angular_momentum_drift(), 1e-11);
}

TEST(EnergyMomentum, IsTheMidpointRuleForSmallSteps) {
  // Both are of the second order and differ by terms of that order.
  std::vector<double> difference;
  for (const double step : {2e-3, 1e-3}) {
    Scene scene = spinning_block(Integrator::kMidpoint, step, 0.1);
    scene.solver.tolerance = 1e-11;
    Session midpoint(scene, mesh_of(scene));
    ASSERT_EQ(midpoint.run(), RunStatus::kFinished);
    scene.time.integrator = Integrator::kEnergyMomentum;
    FinishedRun session(scene);
    difference.push_back((session.state().position - midpoint.state().position).norm());
  }
  EXPECT_LT(difference[0], 1e-3);
  EXPECT_GT(difference[1], 0.0);
  EXPECT_NEAR(difference[0] / difference[1], 4.0, 0.2);
}

// A scene with one thing that acts on the body.
struct Acting {
  std::string name;
  std::function<void(Scene&)> add;
};

AmplitudeSettings swinging() {
  return sine("swing", 0.7, 0.4);
}

ForceSettings load_of(LoadKind kind, const Selection& select) {
  ForceSettings settings;
  settings.kind = kind;
  settings.select = select;
  settings.vector = {300.0, 500.0, -200.0};
  settings.value = 4e3;
  return settings;
}

std::vector<Acting> acting() {
  const auto fixed = [](double x) { return fix(SelectPlane{0, x, {}}); };
  return {
      {"nothing", [](Scene&) {}},
      {"gravity", [](Scene& s) { s.environment.kind = EnvironmentKind::kGravity; }},
      {"changing_gravity",
       [](Scene& s) {
         s.amplitude = {swinging()};
         s.environment.kind = EnvironmentKind::kGravity;
         s.environment.amplitude = "swing";
       }},
      {"attraction",
       [](Scene& s) {
         s.environment.kind = EnvironmentKind::kAttraction;
         s.environment.strength = 2e4;
         s.environment.softening = 0.5;
       }},
      {"drag", [](Scene& s) { s.damping.drag = 50.0; }},
      {"mass_damping", [](Scene& s) { s.damping.mass_damping = 0.5; }},
      {"viscosity", [](Scene& s) { s.damping.viscosity = 500.0; }},
      {"fixed", [=](Scene& s) { s.fix = {fixed(0.0)}; }},
      {"moving",
       [=](Scene& s) {
         FixSettings fix = fixed(0.0);
         fix.velocity = {0.5, 0.2, 0.0};
         s.fix = {fix};
       }},
      {"swinging_fix",
       [=](Scene& s) {
         s.amplitude = {swinging()};
         FixSettings fix = fixed(0.0);
         fix.offset = Vector3(0.1, 0.2, 0.0);
         fix.amplitude = "swing";
         s.fix = {fix};
       }},
      {"penalty",
       [=](Scene& s) {
         FixSettings fix = fixed(0.0);
         fix.is_penalty = true;
         fix.penalty = 1e5;
         fix.velocity = {0.5, 0.2, 0.0};
         s.fix = {fix};
       }},
      {"plane",
       [](Scene& s) {
         ConstraintSettings plane = constraint_of(ConstraintKind::kPlane, SelectPlane{0, 0.0, {}});
         plane.direction = {1.0, 1.0, 0.3};
         s.constraint = {plane};
       }},
      {"line",
       [](Scene& s) {
         ConstraintSettings line = constraint_of(ConstraintKind::kLine, SelectPlane{0, 2.0, {}});
         line.direction = {0.2, 1.0, 0.5};
         s.constraint = {line};
       }},
      {"distance", [](Scene& s) { s.constraint = {rod(0, 11)}; }},
      {"free_handle",
       [](Scene& s) {
         s.constraint = {constraint_of(ConstraintKind::kRigid, SelectPlane{0, 2.0, {}})};
       }},
      {"driven_handle",
       [](Scene& s) {
         ConstraintSettings handle = constraint_of(ConstraintKind::kRigid, SelectPlane{0, 2.0, {}});
         handle.velocity = Vector3(0.2, 0.0, 0.1);
         handle.angular_velocity = Vector3(1.0, 2.0, 0.0);
         s.constraint = {handle};
       }},
      {"distance_to_a_moving_vertex",
       [=](Scene& s) {
         s.constraint = {rod(0, 11)};
         s.fix = {moving(SelectVertices{{0}}, {0.5, 0.2, 0.0})};
       }},
      {"force",
       [](Scene& s) {
         s.amplitude = {swinging()};
         ForceSettings force = load_of(LoadKind::kForce, SelectPlane{0, 2.0, {}});
         force.amplitude = "swing";
         s.force = {force};
       }},
      {"closed_pressure",
       [](Scene& s) { s.pressure = {load_of(LoadKind::kPressure, SelectSurface{})}; }},
      {"open_pressure",
       [](Scene& s) {
         s.amplitude = {swinging()};
         ForceSettings pressure = load_of(LoadKind::kPressure, SelectPlane{0, 2.0, {}});
         pressure.amplitude = "swing";
         s.pressure = {pressure};
       }},
      {"pressure_at_a_clamp", [=](Scene& s) {
         s.fix = {fixed(0.0)};
         s.pressure = {load_of(LoadKind::kPressure, SelectPlane{1, 1.0, {}})};
       }}};
}

class EnergyMomentumWith : public testing::TestWithParam<Acting> {};

TEST_P(EnergyMomentumWith, ItsBalanceCloses) {
  for (const double step : {0.01, 0.1}) {
    Scene scene = spinning_block(Integrator::kEnergyMomentum, step, 40 * step);
    GetParam().add(scene);
    Session session(scene, mesh_of(scene));
    ASSERT_EQ(session.run(), RunStatus::kFinished) << step << ": " << session.message();
    const Balance& balance = session.balance();
    EXPECT_LT(balance.max_relative_energy_drift(), 1e-11) << step;
    EXPECT_LT(balance.linear_momentum_drift(), 1e-11) << step;
    EXPECT_LT(balance.angular_momentum_drift(), 1e-11) << step;
    EXPECT_LT(session.constraint_error(), 1e-11);
    if (scene.damping.drag + scene.damping.mass_damping + scene.damping.viscosity > 0.0) {
      EXPECT_GT(balance.dissipated_energy(), 0.01 * balance.energies().total());
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, EnergyMomentumWith, testing::ValuesIn(acting()),
                         [](const auto& test) { return test.param.name; });

// A block that was stretched and let go while it turns by a sixth of a radian in a step.
TEST_P(EnergyMomentumOf, SolvesStepsOfAHundredTimesTheLimit) {
  Scene scene = scene_of({GeneratorKind::kBox, {1.0, 0.5, 0.25}, {5, 3, 2}}, elastic(1e6, 0.3));
  GetParam().set(scene.material);
  scene.initial.stretch = {1.05, 0.98, 0.98};
  const double step = 100.0 * stable_step(scene);
  scene.initial.angular_velocity = {0.02 / step, 0.05 / step, 0.15 / step};
  scene.time = {Integrator::kEnergyMomentum, step, false, 6.0 * step};
  FinishedRun session(scene);
  EXPECT_LT(session.balance().max_relative_energy_drift(), 1e-11);
  EXPECT_LT(session.balance().angular_momentum_drift(), 1e-11);
}

// Near rest the energies are so small that round-off is a share of them.
TEST(EnergyMomentum, GoesOnNearRest) {
  Scene beam =
      scene_of({GeneratorKind::kBeam, {2, 0.5, 0.5}, {6, 2, 2}}, elastic(2.1e11, 0.3, 7800.0));
  Scene loaded = beam;
  loaded.fix = {fix(SelectPlane{0, 0.0, {}})};
  AmplitudeSettings slow;
  slow.name = "slow";
  slow.kind = AmplitudeKind::kSmoothStep;
  slow.from = 0.0;
  slow.until = 0.01;
  loaded.amplitude = {slow};
  ForceSettings force = load_of(LoadKind::kForce, SelectPlane{0, 2.0, {}});
  force.total = Vector3(0, 1e5, 0);
  force.amplitude = "slow";
  loaded.force = {force};
  for (const double step : {1e-5, 1e-4, 1e-3}) {
    loaded.time = {Integrator::kEnergyMomentum, step, false, 0.01};
    Session session(loaded, mesh_of(loaded));
    ASSERT_EQ(session.run(), RunStatus::kFinished) << step << ": " << session.message();
    EXPECT_LT(session.balance().max_relative_energy_drift(), 1e-9) << step;
  }
  Scene damped = beam;
  damped.material.youngs_modulus = 1e6;
  damped.material.density = 1000.0;
  damped.damping.viscosity = 3e4;
  damped.initial.stretch = {1.05, 0.97, 1.0};
  damped.time = {Integrator::kEnergyMomentum, 0.01, false, 3.0};
  FinishedRun session(damped);
  EXPECT_LT(session.balance().max_relative_energy_drift(), 1e-12);
  for (const double strain : {1e-10, 1e-13}) {
    Scene tiny = beam;
    tiny.initial.stretch = {1.0 + strain, 1.0, 1.0};
    tiny.time = {Integrator::kEnergyMomentum, 1e-3, false, 0.02};
    Session still(tiny, mesh_of(tiny));
    EXPECT_EQ(still.run(), RunStatus::kFinished) << strain << ": " << still.message();
  }
}

TEST(EnergyMomentum, KeepsTheAngularMomentumAboutACentre) {
  for (const double softening : {0.0, 0.5}) {
    Scene scene = spinning_block(Integrator::kEnergyMomentum, 0.05, 10.0);
    scene.initial.displacement = {5.0, 0.0, 0.0};
    scene.initial.velocity = {0.0, 3.0, 1.0};
    scene.environment.kind = EnvironmentKind::kAttraction;
    scene.environment.strength = 1e4;
    scene.environment.softening = softening;
    Session session(scene, mesh_of(scene));
    const Vector3 before = session.balance().momenta().angular;
    const double scale = session.balance().momenta().angular_scale;
    ASSERT_EQ(session.run(), RunStatus::kFinished) << session.message();
    EXPECT_LT((session.balance().momenta().angular - before).norm(), 1e-11 * scale);
    EXPECT_LT(session.balance().max_relative_energy_drift(), 1e-11);
  }
}

TEST(EnergyMomentum, AClosedPressureOnAFreeBodyKeepsBothMomenta) {
  Scene scene = spinning_block(Integrator::kEnergyMomentum, 0.05, 5.0);
  scene.pressure = {load_of(LoadKind::kPressure, SelectSurface{})};
  Session session(scene, mesh_of(scene));
  const Momenta before = session.balance().momenta();
  ASSERT_EQ(session.run(), RunStatus::kFinished) << session.message();
  const Momenta& after = session.balance().momenta();
  EXPECT_LT((after.linear - before.linear).norm(), 1e-12 * before.linear_scale);
  EXPECT_LT((after.angular - before.angular).norm(), 1e-11 * before.angular_scale);
}

// Flat quadratic elements have more round-off than is estimated. The solver must see that the last
// residuals are round-off, instead of going on as long as they change.
TEST(EnergyMomentum, EndsAtRoundOffWithFlatElements) {
  Scene scene;
  scene.mesh.generate = GeneratorSettings{GeneratorKind::kBox, {1, 0.1, 0.1}, {40, 1, 1}};
  scene.mesh.quadratic = true;
  scene.material.youngs_modulus = 1e6;
  scene.material.poissons_ratio = 0.3;
  scene.environment.kind = EnvironmentKind::kGravity;
  scene.fix = {fix(SelectPlane{0, 0.0, {}})};
  scene.time = {Integrator::kEnergyMomentum, 0.01, false, 1.0};
  const TetMesh mesh = with_edge_vertices(mesh_of(scene));
  for (const double step : {0.0047, 0.0127, 0.02}) {
    scene.time.step = step;
    scene.time.end = 4.0 * step;
    Session session(scene, mesh);
    while (session.step()) EXPECT_LE(session.last_iterations(), 12) << step;
    ASSERT_EQ(session.status(), RunStatus::kFinished) << session.message();
    EXPECT_LT(session.balance().max_relative_energy_drift(), 1e-11) << step;
  }
}

}  // namespace
}  // namespace tetraction
