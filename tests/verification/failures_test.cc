// Steps that fail: the state stays as it was, and the message names the place, the cause and a remedy
// that fits it.

#include <cmath>
#include <limits>
#include <memory>
#include <string>

#include "support/corner_scenes.h"
#include "tetraction/dynamics/terms/vertex_potential.h"
#include "tetraction/simulation/step_failure.h"

namespace tetraction {
namespace {

using namespace testing_support;

constexpr Integrator kAllRules[] = {Integrator::kExplicit, Integrator::kVerlet,
                                    Integrator::kMidpoint, Integrator::kBackwardEuler,
                                    Integrator::kEnergyMomentum};

Scene beam(Integrator rule, double step) {
  Scene scene = clamped_beam({2, 1, 1}, {4, 2, 2});
  scene.time = {rule, step, false, 1000.0 * step};
  return scene;
}

// Runs until a step fails. Everything but the failure must be as before that step.
const StepFailure& failure_of(Session& session) {
  State before = session.state();
  double energy = session.balance().energies().total();
  while (session.step()) {
    before = session.state();
    energy = session.balance().energies().total();
  }
  EXPECT_NE(session.status(), RunStatus::kFinished);
  EXPECT_EQ(exit_code(session.status()), 1);
  EXPECT_EQ(session.state().position, before.position);
  EXPECT_EQ(session.state().momentum, before.momentum);
  EXPECT_EQ(session.state().step, before.step);
  EXPECT_EQ(session.balance().energies().total(), energy);
  EXPECT_TRUE(session.state().position.allFinite());
  EXPECT_TRUE(session.state().momentum.allFinite());
  EXPECT_TRUE(std::isfinite(energy));
  const StepFailure* failure = session.failure();
  if (failure == nullptr) {
    ADD_FAILURE() << session.message();
    static const StepFailure none;
    return none;
  }
  EXPECT_FALSE(failure->elements.empty());
  EXPECT_FALSE(failure->what.empty());
  EXPECT_FALSE(failure->remedy.empty());
  EXPECT_NE(session.message().find(failure->remedy), std::string::npos);
  return *failure;
}

bool says(const Session& session, const std::string& part) {
  return session.message().find(part) != std::string::npos;
}

TEST(Failures, AbsurdLoadsAreNotAnsweredWithSmallerSteps) {
  for (const Integrator rule : kAllRules) {
    Scene scene = beam(rule, is_implicit(rule) ? 1e-2 : 1e-4);
    scene.force = {load(SelectPlane{0, 2.0, {}}, {0.0, 1e30, 0.0})};
    Session session(scene, mesh_of(scene));
    const StepFailure& failure = failure_of(session);
    EXPECT_EQ(failure.cause, FailureCause::kLoads) << to_string(rule) << session.message();
    EXPECT_NE(failure.remedy.find("units"), std::string::npos);
    EXPECT_EQ(failure.remedy.find("maller"), std::string::npos) << failure.remedy;
    EXPECT_TRUE(says(session, "element ")) << session.message();
    EXPECT_TRUE(says(session, "centroid (")) << session.message();
    EXPECT_TRUE(says(session, "J = ")) << session.message();
  }
}

TEST(Failures, AnExplicitStepAboveItsLimitNamesTheLimit) {
  for (const Integrator rule : {Integrator::kExplicit, Integrator::kVerlet}) {
    Scene scene = beam(rule, 2e-2);
    scene.environment.kind = EnvironmentKind::kGravity;
    scene.time.end = 10.0;
    Session session(scene, mesh_of(scene));
    EXPECT_EQ(session.run(), RunStatus::kUnstable);
    const StepFailure* failure = session.failure();
    ASSERT_NE(failure, nullptr);
    EXPECT_EQ(failure->cause, FailureCause::kStepAboveLimit) << session.message();
    EXPECT_GT(failure->time_step, failure->stable_step);
    EXPECT_GT(failure->stable_step, 0.0);
    EXPECT_TRUE(says(session, "stability limit")) << session.message();
    EXPECT_TRUE(says(session, "auto")) << session.message();
    EXPECT_TRUE(session.state().position.allFinite());
  }
}

TEST(Failures, AVertexThatIsFasterThanWavesIsNamed) {
  Scene scene = beam(Integrator::kVerlet, 1e-4);
  scene.initial.momentum = {{SelectNearest{{2.0, 1.0, 1.0}}, {-1e6, 0.0, 0.0}, {}}};
  Session session(scene, mesh_of(scene));
  const StepFailure& failure = failure_of(session);
  EXPECT_EQ(failure.cause, FailureCause::kSpeed) << session.message();
  EXPECT_EQ(failure.remedy.find("maller"), std::string::npos) << failure.remedy;
}

TEST(Failures, APrescribedMotionThatCrushesElementsIsNamed) {
  for (const Integrator rule : {Integrator::kVerlet, Integrator::kMidpoint}) {
    Scene scene = beam(rule, 1e-4);
    scene.material.model = "neo-hookean";
    scene.fix.push_back(moving(SelectPlane{0, 2.0, {}}, {-60.0, 0.0, 0.0}));
    Session session(scene, mesh_of(scene));
    const StepFailure& failure = failure_of(session);
    EXPECT_EQ(failure.cause, FailureCause::kPrescribedMotion)
        << to_string(rule) << " " << session.message();
    EXPECT_TRUE(says(session, "slower")) << session.message();
  }
}

TEST(Failures, IterationsThatAreUsedUpAreNamed) {
  for (const Integrator rule : {Integrator::kMidpoint, Integrator::kBackwardEuler}) {
    Scene scene = beam(rule, 0.1);
    scene.environment.kind = EnvironmentKind::kGravity;
    scene.solver.max_iterations = 1;
    scene.solver.tolerance = 1e-12;
    Session session(scene, mesh_of(scene));
    const StepFailure& failure = failure_of(session);
    EXPECT_EQ(failure.cause, FailureCause::kIterations) << session.message();
    EXPECT_TRUE(says(session, "solver.max_iterations")) << session.message();
  }
}

TEST(Failures, StiffnessContrastIsNamed) {
  Scene scene = beam(Integrator::kMidpoint, 0.1);
  scene.environment.kind = EnvironmentKind::kGravity;
  MaterialRegionSettings stiff{SelectBox{{-1.0, -1.0, -1.0}, {1.0, 2.0, 2.0}}, scene.material, {}};
  stiff.material.youngs_modulus = 1e18;
  scene.material_region = {stiff};
  scene.solver.max_iterations = 1;
  Session session(scene, mesh_of(scene));
  const StepFailure& failure = failure_of(session);
  EXPECT_EQ(failure.cause, FailureCause::kStiffnessContrast) << session.message();
  EXPECT_TRUE(says(session, "rigid")) << session.message();
}

// A term whose force or energy is not finite from some time on.
class BadTerm : public VertexPotential {
 public:
  enum class Kind { kForce, kEnergy, kInfinite };
  explicit BadTerm(Kind kind) : kind_(kind) {}
  std::string name() const override { return "bad"; }
  double value(double /*mass*/, const Vector3& x) const override {
    return kind_ == Kind::kEnergy && reached(x) ? kNaN : 0.0;
  }
  Vector3 gradient(double /*mass*/, const Vector3& x) const override {
    if (!reached(x) || kind_ == Kind::kEnergy) return Vector3::Zero();
    return {0.0, kind_ == Kind::kInfinite ? std::numeric_limits<double>::infinity() : kNaN, 0.0};
  }
  Matrix3 hessian(double /*mass*/, const Vector3& /*x*/) const override { return Matrix3::Zero(); }

 private:
  static constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  static bool reached(const Vector3& x) { return x.y() < -1e-3; }
  Kind kind_;
};

TEST(Failures, TermsThatAreNoNumbersPassNoStep) {
  for (const Integrator rule : kAllRules) {
    for (const BadTerm::Kind kind :
         {BadTerm::Kind::kForce, BadTerm::Kind::kEnergy, BadTerm::Kind::kInfinite}) {
      Scene scene = beam(rule, is_implicit(rule) ? 1e-2 : 1e-3);
      scene.environment.kind = EnvironmentKind::kGravity;
      scene.time.end = 1.0;
      scene.force_term = {std::make_shared<BadTerm>(kind)};
      Session session(scene, mesh_of(scene));
      const StepFailure& failure = failure_of(session);
      EXPECT_GT(session.step_number(), 0);
      if (!is_implicit(rule)) {
        EXPECT_EQ(failure.cause, FailureCause::kForceTerm) << session.message();
        EXPECT_TRUE(says(session, "\"bad\"")) << session.message();
      }
    }
  }
}

// A load that is not finite from a time on.
class BadLoad : public ForceTerm {
 public:
  std::string name() const override { return "bad_load"; }
  bool has_load() const override { return true; }
  void add_load(const ForcePoint& at, Vector& force) const override {
    if (at.time > 0.01) force[4] = std::numeric_limits<double>::quiet_NaN();
  }
};

TEST(Failures, LoadsThatAreNoNumbersPassNoStep) {
  for (const Integrator rule : kAllRules) {
    Scene scene = beam(rule, is_implicit(rule) ? 1e-2 : 1e-3);
    scene.force_term = {std::make_shared<BadLoad>()};
    Session session(scene, mesh_of(scene));
    const StepFailure& failure = failure_of(session);
    EXPECT_GT(session.step_number(), 0);
    EXPECT_EQ(failure.cause, FailureCause::kForceTerm) << to_string(rule) << session.message();
    EXPECT_TRUE(says(session, "\"bad_load\"")) << session.message();
    EXPECT_TRUE(says(session, "vertex 1")) << session.message();
  }
}

// Values that are finite each, but not together.
TEST(Failures, NumbersThatOverflowPassNoStep) {
  for (const Integrator rule : kAllRules) {
    Scene scene = beam(rule, 1e-3);
    Session session(scene, mesh_of(scene));
    ASSERT_TRUE(session.step());
    session.apply(SetMomentum{{SelectNearest{{2.0, 1.0, 1.0}}, {1e140, -1e150, 0.0}, {}}});
    const StepFailure& failure = failure_of(session);
    EXPECT_EQ(failure.cause, FailureCause::kSpeed) << to_string(rule) << session.message();
  }
}

// Its velocities jump as the amplitude says, and no step resolves a jump.
TEST(Failures, ABodyThatIsHeldEverywhereHasNoStepToBlame) {
  Scene scene = beam(Integrator::kMidpoint, 1e-3);
  scene.time.end = 0.1;
  scene.amplitude = {corners("a", {{0.0, 0.0}, {0.03, 1.0}, {0.06, 0.0}, {0.1, 1.0}})};
  scene.fix[0].select = SelectAll{};
  scene.fix[0].offset = Vector3(0.0, 0.01, 0.0);
  scene.fix[0].amplitude = "a";
  Session session(scene, mesh_of(scene));
  ASSERT_EQ(session.run(), RunStatus::kFinished);
  EXPECT_GT(session.balance().max_relative_energy_drift(), 0.5);
  EXPECT_FALSE(testing_support::any_warning(session, "energy error"));
}

TEST(Failures, AFailureIsForgottenWhenTheRunGoesBack) {
  Scene scene = beam(Integrator::kVerlet, 2e-2);
  scene.environment.kind = EnvironmentKind::kGravity;
  scene.time.end = 10.0;
  Session session(scene, mesh_of(scene));
  session.keep_good_states();
  while (session.step()) {
  }
  ASSERT_NE(session.failure(), nullptr);
  session.go_back();
  EXPECT_EQ(session.failure(), nullptr);
}

}  // namespace
}  // namespace tetraction
