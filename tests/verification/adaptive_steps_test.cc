// Steps whose size adapts to an error or to the discrete energy, and steps that are repeated.

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "support/corner_scenes.h"
#include "tetraction/dynamics/body_sums.h"
#include "tetraction/simulation/study.h"

namespace tetraction {
namespace {

using namespace testing_support;

Scene adaptive_block(Integrator rule, double tolerance, double end) {
  Scene scene = spinning_block(rule, 1e-3, end);
  scene.solver.tolerance = 1e-11;
  scene.time.adapt = StepAdaptation::kError;
  scene.time.tolerance = tolerance;
  return scene;
}

// Every step of a rule of order p has the error C h^(p+1) = tolerance, so that the error at the end is
// proportional to h^p, which is tolerance^(p/(p+1)).
TEST(AdaptiveSteps, TheErrorFollowsTheToleranceAsTheOrderOfTheRuleSays) {
  constexpr double kEnd = 0.3;
  Scene fine = spinning_block(Integrator::kVerlet, kEnd / 60000, kEnd);
  Session reference(fine, mesh_of(fine));
  ASSERT_EQ(reference.run(), RunStatus::kFinished);
  for (const Integrator rule : all_integrators()) {
    const int p = order(rule);
    const double first = p == 2 ? 2e-6 : 2e-5;
    std::vector<double> errors;
    std::vector<double> steps;
    for (const double tolerance : {first, first / 8, first / 64}) {
      const Scene scene = adaptive_block(rule, tolerance, kEnd);
      FinishedRun session(scene);
      EXPECT_EQ(session.time(), kEnd);
      EXPECT_EQ(session.step_control().above_tolerance, 0);
      if (is_variational(rule)) {
        EXPECT_LT(session.balance().linear_momentum_drift(), 1e-11) << to_string(rule);
      }
      errors.push_back((session.state().position - reference.state().position).norm());
      steps.push_back(static_cast<double>(session.step_number()));
    }
    const double expected = static_cast<double>(p) / (p + 1);
    for (std::size_t i = 1; i < errors.size(); ++i) {
      const double slope = std::log(errors[i - 1] / errors[i]) / std::log(8.0);
      EXPECT_NEAR(slope, expected, 0.2) << to_string(rule) << " " << i << ": " << errors[i - 1]
                                        << " " << errors[i] << " steps " << steps[i];
      EXPECT_NEAR(std::log(steps[i] / steps[i - 1]) / std::log(8.0), 1.0 / (p + 1), 0.1)
          << to_string(rule) << " " << steps[i - 1] << " " << steps[i];
    }
  }
}

// A body of a millimetre around a centre at a distance of a metre: its centre of mass moves like a
// planet. The motion begins at the pericentre with a = 1/(1 − e), so that a period is 2π a^(3/2).
struct Orbit {
  Scene scene;
  double period = 0.0;
  Vector3 start = Vector3::Zero();
};
Orbit orbit(double eccentricity, double step, double young = 1e4) {
  Orbit orbit;
  Scene& scene = orbit.scene;
  constexpr double kEdge = 1e-3;
  scene.mesh.generate =
      GeneratorSettings{GeneratorKind::kTetrahedron, {kEdge, kEdge, kEdge}, {1, 1, 1}};
  scene.material.youngs_modulus = young;
  scene.material.poissons_ratio = 0.3;
  scene.material.density = 1000.0;
  scene.environment.kind = EnvironmentKind::kAttraction;
  const TetMesh mesh = generate_mesh(*scene.mesh.generate);
  // Every vertex has the same mass and is attracted by the same strength.
  scene.environment.strength = 1000.0 * mesh.total_volume() / 4.0;
  const Vector3 center = mesh.rest_positions().reshaped(3, mesh.vertex_count()).rowwise().mean();
  scene.initial.displacement = Vector3(1.0, 0.0, 0.0) - center;
  scene.initial.velocity = {0.0, std::sqrt(1.0 + eccentricity), 0.0};
  orbit.period = 2.0 * std::numbers::pi * std::pow(1.0 - eccentricity, -1.5);
  orbit.start = {1.0, 0.0, 0.0};
  scene.solver.tolerance = 1e-11;
  scene.time = {Integrator::kMidpoint, step, false, orbit.period};
  return orbit;
}

double distance_from_start(const Session& session, const Orbit& orbit) {
  return (center_of_mass(session.system(), session.state().position) - orbit.start).norm();
}

// Its vibrations have periods of about a quarter of a second, which the steps resolve: the change of
// the step would excite faster ones, and then the steps would have to resolve those.
constexpr double kSoft = 0.5;  // Pa

TEST(AdaptiveSteps, AnEccentricOrbitTakesFewerStepsThanWithASteadyOne) {
  Orbit planet = orbit(0.7, 1e-3, kSoft);
  planet.scene.time.adapt = StepAdaptation::kError;
  planet.scene.time.tolerance = 1e-3;  // of 1.4 mm
  FinishedRun session(planet.scene, mesh_of(planet.scene));
  EXPECT_EQ(session.time(), planet.period);
  EXPECT_GT(session.steps().largest, 5.0 * session.steps().smallest);
  const double error = distance_from_start(session, planet);
  const auto steps = static_cast<double>(2 * session.step_number());

  Orbit steady = orbit(0.7, planet.period / steps, kSoft);
  FinishedRun fixed(steady.scene, mesh_of(steady.scene));
  EXPECT_LT(error, 0.2 * distance_from_start(fixed, steady));
  EXPECT_LT(error, 0.03) << steps;
  EXPECT_LT(steps, 1000.0);
  EXPECT_LT(session.balance().angular_momentum_drift(), 1e-8);
}

TEST(AdaptiveSteps, LandOnEventsAndBecomeSmallerWhereTheBodyStiffens) {
  for (const Integrator rule : all_integrators()) {
    Scene scene = adaptive_block(rule, 1e-4, 0.4);
    MaterialSettings stiff = scene.material;
    stiff.youngs_modulus = 100.0 * *stiff.youngs_modulus;
    scene.event.push_back({0.1234, {SetMaterial{0, stiff}}, "{}", "event.0"});
    Session session(scene, mesh_of(scene));
    double before = 0.0;
    double after = 1.0;
    while (session.step()) {
      if (session.time() < 0.1234) before = session.steps().last;
      if (session.time() > 0.1234) after = std::min(after, session.steps().last);
    }
    ASSERT_EQ(session.status(), RunStatus::kFinished) << session.message();
    ASSERT_EQ(session.edits().size(), 1U);
    EXPECT_EQ(session.edits()[0].time, 0.1234) << to_string(rule);
    EXPECT_EQ(session.time(), 0.4);
    EXPECT_LT(after, 0.7 * before) << to_string(rule);
    if (is_variational(rule)) {
      EXPECT_LT(session.balance().angular_momentum_drift(), 1e-8) << to_string(rule);
    }
  }
}

// A pulse of force between two events whose distance is a small part of the step.
TEST(AdaptiveSteps, LandOnEventsThatAreCloseTogether) {
  for (const double length : {1e-10, 1e-8, 1e-6}) {
    Scene scene = adaptive_block(Integrator::kMidpoint, 1e-4, 0.1);
    ForceSettings load;
    scene.force.push_back(load);
    const double begin = 0.0333;
    const double end = begin + length;
    load.vector = {1e3, 0.0, 0.0};
    scene.event.push_back({begin, {SetForce{0, load}}, "{}", "event.0"});
    load.vector.setZero();
    scene.event.push_back({end, {SetForce{0, load}}, "{}", "event.1"});
    FinishedRun session(scene);
    ASSERT_EQ(session.edits().size(), 2U);
    EXPECT_EQ(session.edits()[0].time, begin);
    EXPECT_EQ(session.edits()[1].time, end);
    const double impulse =
        1e3 * static_cast<double>(session.system().vertex_count()) * (end - begin);
    EXPECT_NEAR(session.balance().sums().linear_impulse.x(), impulse, 1e-9 * impulse);
  }
}

TEST(AdaptiveSteps, ExplicitRulesStayBelowTheirStabilityLimit) {
  for (const Integrator rule : {Integrator::kExplicit, Integrator::kVerlet}) {
    Scene scene = adaptive_block(rule, 0.5, 2.0);  // the error alone would allow any step
    scene.time.step = 1.0;
    Session session(scene, mesh_of(scene));
    const double limit = session.current_limit().critical_step;
    EXPECT_LE(session.time_step(), limit);
    ASSERT_EQ(session.run(), RunStatus::kFinished) << session.message();
    EXPECT_LT(session.steps().largest, 1.2 * limit);
    EXPECT_GT(session.steps().largest, 0.5 * limit);
    scene.time.automatic = true;
    Session automatic(scene, mesh_of(scene));
    EXPECT_NEAR(automatic.time_step(), 0.5 * limit, 1e-9);
    EXPECT_EQ(automatic.run(), RunStatus::kFinished);
  }
}

// Stability is the stronger bound.
TEST(AdaptiveSteps, AMinimumAboveTheStabilityLimitIsExceededWithAWarning) {
  Scene scene = adaptive_block(Integrator::kVerlet, 1e-3, 0.1);
  double limit = 0.0;
  {
    Session session(scene, mesh_of(scene));
    limit = session.current_limit().critical_step;
  }
  scene.time.min_step = 2.0 * limit;
  Session session(scene, mesh_of(scene));
  EXPECT_TRUE(any_warning(session, "time.min_step")) << "at the start";
  ASSERT_EQ(session.run(), RunStatus::kFinished) << session.message();
  EXPECT_LT(session.steps().largest, limit);
  EXPECT_EQ(std::count_if(session.warnings().begin(), session.warnings().end(),
                          [](const std::string& w) { return w.find("min_step =") < w.size(); }),
            1);
  scene.time.min_step = 0.5 * limit;
  Session quiet(scene, mesh_of(scene));
  EXPECT_FALSE(any_warning(quiet, "time.min_step ="));
}

TEST(AdaptiveSteps, ABodyAtRestTakesTheLargestStep) {
  Scene scene = adaptive_block(Integrator::kMidpoint, 1e-4, 10.0);
  scene.initial = {};
  scene.time.max_step = 0.5;
  Session session(scene, mesh_of(scene));
  ASSERT_EQ(session.run(), RunStatus::kFinished);
  EXPECT_EQ(session.steps().largest, 0.5);
  EXPECT_LT(session.step_number(), 30);
}

// A tolerance that the smallest step cannot meet: it is taken all the same, and the run says so.
TEST(AdaptiveSteps, CountStepsThatDoNotMeetTheTolerance) {
  Scene scene = adaptive_block(Integrator::kMidpoint, 1e-12, 0.05);
  scene.time.min_step = 1e-3;
  FinishedRun session(scene);
  EXPECT_EQ(session.step_number(), 50);
  EXPECT_EQ(session.step_control().above_tolerance, 50);
  EXPECT_TRUE(any_warning(session, "time.min_step"));
}

// The two halves must give the result of two steps of the rule.
TEST(AdaptiveSteps, AStepConsistsOfTwoStepsOfTheRule) {
  for (const Integrator rule : all_integrators()) {
    Scene scene = adaptive_block(rule, 0.5, 0.05);
    scene.environment.kind = EnvironmentKind::kGravity;
    scene.damping.viscosity = 5.0;
    scene.time.step = scene.time.max_step.emplace(1e-3);
    scene.time.end = 3e-3;
    FinishedRun session(scene);
    EXPECT_EQ(session.step_number(), 3);
    scene.time.adapt = StepAdaptation::kNone;
    scene.time.step = 0.5e-3;
    Session steady(scene, mesh_of(scene));
    ASSERT_EQ(steady.run(), RunStatus::kFinished);
    const double scale = (steady.state().position - steady.system().mesh().rest_positions()).norm();
    EXPECT_LT((session.state().position - steady.state().position).norm(), 1e-9 * scale)
        << to_string(rule);
    EXPECT_NEAR(session.balance().energy_error(), steady.balance().energy_error(),
                1e-8 * steady.balance().energy_scale());
    EXPECT_NEAR(session.balance().dissipated_energy(), steady.balance().dissipated_energy(),
                1e-8 * steady.balance().energy_scale());
    EXPECT_LT(
        (session.balance().sums().linear_impulse - steady.balance().sums().linear_impulse).norm(),
        1e-9);
  }
}

TEST(EnergyAdaptation, KeepsTheDiscreteEnergyOfALargeVibration) {
  Scene scene = spinning_block(Integrator::kMidpoint, 4e-3, 2.0);
  scene.initial.stretch = {1.4, 0.8, 1.0};
  scene.solver.tolerance = 1e-10;
  Session steady(scene, mesh_of(scene));
  ASSERT_EQ(steady.run(), RunStatus::kFinished);
  scene.time.adapt = StepAdaptation::kEnergy;
  Session session(scene, mesh_of(scene));
  double least = 1e300;
  double most = -1e300;
  while (session.step()) {
    if (session.time() == 2.0) break;  // the last step is cut at the end
    least = std::min(least, session.step_control().discrete_energy);
    most = std::max(most, session.step_control().discrete_energy);
  }
  ASSERT_EQ(session.status(), RunStatus::kFinished) << session.message();
  EXPECT_EQ(session.time(), 2.0);
  EXPECT_EQ(session.step_control().without_solution, 0);
  EXPECT_LT(most - least, 3e-10 * session.balance().energy_scale());
  EXPECT_GT(session.steps().largest, 1.05 * session.steps().smallest);
  EXPECT_LT(session.balance().angular_momentum_drift(), 1e-7);
}

// With the midpoint rule the discrete energy is H − h²c/8 + O(h⁴), c = vᵀKv + fᵀM⁻¹f, while steps of
// one size conserve H − h²c/24 + O(h⁴). A step that keeps the first is therefore proportional to
// c^(−1/3) in a slow variation. On an orbit c is proportional to (1 + e)⁴ (2 + e) at the pericentre
// and to (1 − e)⁴ (2 − e) at the apocentre.
TEST(EnergyAdaptation, TheStepFollowsFromTheCurvatureOfAnOrbit) {
  constexpr double e = 0.5;
  Orbit planet = orbit(e, 2e-3);
  planet.scene.time.adapt = StepAdaptation::kEnergy;
  Session session(planet.scene, mesh_of(planet.scene));
  double least = 1e300;
  double most = -1e300;
  while (session.step()) {
    if (session.time() == planet.period) break;
    least = std::min(least, session.step_control().discrete_energy);
    most = std::max(most, session.step_control().discrete_energy);
  }
  ASSERT_EQ(session.status(), RunStatus::kFinished) << session.message();
  EXPECT_EQ(session.step_control().without_solution, 0);
  EXPECT_LT(most - least, 1e-9 * session.balance().energy_scale());
  const double ratio = std::cbrt(std::pow((1.0 + e) / (1.0 - e), 4) * (2.0 + e) / (2.0 - e));
  EXPECT_NEAR(session.steps().largest / session.steps().smallest, ratio, 0.05 * ratio);
  EXPECT_LT(distance_from_start(session, planet), 2e-3);
}

// c is negative on a part of an orbit with e > 0.79, and no step keeps the discrete energy there.
TEST(EnergyAdaptation, CountsStepsWithoutASolution) {
  Orbit planet = orbit(0.9, 5e-3, kSoft);
  planet.scene.time.adapt = StepAdaptation::kEnergy;
  FinishedRun session(planet.scene, mesh_of(planet.scene));
  EXPECT_EQ(session.time(), planet.period);
  const StepControl& control = session.step_control();
  EXPECT_GT(control.without_solution, 0);
  EXPECT_LT(control.without_solution, session.step_number());
  EXPECT_TRUE(any_warning(session, "no size between the bounds keeps the discrete energy"));
  EXPECT_GE(session.steps().smallest, 5e-4 * (1.0 - 1e-12));
  EXPECT_LE(session.steps().largest, 5e-2 * (1.0 + 1e-12));
}

// Work and dissipation change the energy to keep, in halves at both ends of a step.
TEST(EnergyAdaptation, FollowsTheWorkOfLoadsAndOfDamping) {
  Scene scene = spinning_block(Integrator::kMidpoint, 4e-3, 1.0);
  scene.environment.kind = EnvironmentKind::kGravity;
  scene.damping = {0.0, 0.3, 20.0};
  scene.force.push_back(load(SelectVertices{{0}}, {0.0, 300.0, 0.0}));
  scene.time.adapt = StepAdaptation::kEnergy;
  scene.time.max_step = 8e-3;
  Session session(scene, mesh_of(scene));
  double residual = 0.0;
  Index solved = 0;
  while (session.step()) {
    if (session.time() == 1.0) break;
    residual = std::max(residual, std::abs(session.step_control().energy_residual));
    ++solved;
  }
  ASSERT_EQ(session.status(), RunStatus::kFinished) << session.message();
  EXPECT_GT(session.balance().dissipated_energy(), 0.01 * session.balance().energy_scale());
  EXPECT_LT(session.step_control().without_solution, solved);
  EXPECT_LT(session.balance().max_relative_energy_drift(), 0.02);
}

// A pull that the solver cannot follow in whole steps within its few iterations.
Scene hard_pull(double end) {
  Scene scene = scene_of({GeneratorKind::kBeam, {4, 1, 1}, {8, 2, 2}}, elastic(1e5, 0.4));
  scene.time = {Integrator::kMidpoint, 0.05, false, end};
  scene.solver.max_iterations = 4;
  scene.fix.resize(1);
  scene.fix[0].select = SelectPlane{0, 0.0, {}};
  scene.force.push_back(total_load(SelectPlane{0, 4.0, {}}, {0.0, 6e4, 0.0}));
  return scene;
}

TEST(Retry, MakesAStepThatFailsInSmallerOnesAndReturnsToTheWholeStep) {
  Scene scene = hard_pull(1.0);
  scene.event.push_back({0.5, {SetDamping{{0.0, 1.0, 0.0}}}, "{}", "event.0"});
  Session plain(scene, mesh_of(scene));
  ASSERT_EQ(plain.run(), RunStatus::kNotConverged) << "the scene is too easy";
  scene.time.retry = 6;
  Session session(scene, mesh_of(scene));
  Index whole = 0;
  while (session.step()) {
    const auto number = static_cast<double>(session.step_number());
    EXPECT_EQ(session.time(), number == 20 ? 1.0 : number * 0.05) << "steps stay at their times";
    whole += session.step_control().last_substeps == 1 ? 1 : 0;
    EXPECT_EQ(session.steps().last, 0.05);
  }
  ASSERT_EQ(session.status(), RunStatus::kFinished) << session.message();
  EXPECT_EQ(session.step_number(), 20);
  EXPECT_EQ(session.edits()[0].time, 0.5);
  const StepControl& control = session.step_control();
  EXPECT_GT(control.retried, 0);
  EXPECT_EQ(whole + control.retried, 20);
  EXPECT_GT(whole, 0);
  EXPECT_GE(control.failed, control.retried);
  EXPECT_EQ(control.failed, control.rejected);
  EXPECT_LT(session.steps().smallest, 0.05);
  EXPECT_TRUE(any_warning(session, "time.retry"));
  EXPECT_LT(session.balance().max_relative_energy_drift(), 0.2);
}

TEST(Retry, LeavesTheStateAsItWasIfNoStepSucceeds) {
  Scene scene = hard_pull(1.0);
  scene.solver.max_iterations = 1;
  scene.time.retry = 2;
  Session session(scene, mesh_of(scene));
  const State start = session.state();
  const double energy = session.balance().energies().total();
  ASSERT_EQ(session.run(), RunStatus::kNotConverged);
  EXPECT_EQ(session.state().position, start.position);
  EXPECT_EQ(session.time(), 0.0);
  EXPECT_EQ(session.balance().energies().total(), energy);
  EXPECT_EQ(session.step_control().retried, 0);
  EXPECT_EQ(session.step_control().failed, 3);
  EXPECT_NE(session.message().find("halved 2 times"), std::string::npos) << session.message();
}

// An explicit step above the limit inverts elements or blows up; in halves it does neither.
TEST(Retry, RecoversExplicitStepsAboveTheLimit) {
  Scene scene = spinning_block(Integrator::kVerlet, 1e-3, 1.0);
  {
    Session session(scene, mesh_of(scene));
    scene.time.step = 1.5 * session.current_limit().critical_step;
    scene.time.end = 40.0 * scene.time.step;
  }
  Session plain(scene, mesh_of(scene));
  ASSERT_EQ(plain.run(), RunStatus::kUnstable);
  scene.time.retry = 3;
  Session session(scene, mesh_of(scene));
  EXPECT_EQ(session.run(), RunStatus::kFinished) << session.message();
  EXPECT_GT(session.step_control().retried, 0);
  EXPECT_EQ(session.step_number(), 40);
}

// A little above the limit the energy grows slowly. It must not grow up to what ends any run.
TEST(Retry, RefusesStepsThatGoOnAddingEnergy) {
  Scene scene = spinning_block(Integrator::kVerlet, 1e-3, 1.0);
  {
    Session session(scene, mesh_of(scene));
    scene.time.step = 1.1 * session.current_limit().critical_step;
    scene.time.end = 200.0 * scene.time.step;
  }
  scene.time.retry = 3;
  FinishedRun session(scene);
  EXPECT_GT(session.step_control().retried, 0);
  EXPECT_GT(session.balance().max_relative_energy_drift(), 0.1);
  EXPECT_LT(session.balance().max_relative_energy_drift(), 1.2);
  EXPECT_TRUE(any_warning(session, "the energy error reached"));
}

TEST(AdaptiveSteps, AStudyRefusesThem) {
  const Scene scene = adaptive_block(Integrator::kMidpoint, 1e-4, 0.1);
  StudySettings settings;
  settings.steps = {1e-3};
  EXPECT_THROW(run_study(scene, mesh_of(scene), settings), InputError);
}

}  // namespace
}  // namespace tetraction
