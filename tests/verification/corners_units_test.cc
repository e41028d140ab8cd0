// The same problem in other units, bodies near incompressibility, and stiff springs, with every rule and
// solver.
#include <cmath>

#include "support/corner_scenes.h"

namespace tetraction {
namespace {

using namespace testing_support;

class AnyRule : public testing::TestWithParam<RuleWithSolver> {
 protected:
  bool implicit() const { return is_implicit(GetParam().integrator); }
};

INSTANTIATE_TEST_SUITE_P(All, AnyRule, testing::ValuesIn(rules_with_solvers()), name_with_solver);

// Galileo: a uniform velocity changes nothing in a vibration, and the tolerance must not grow with it. A bar is
// struck at a corner.
TEST_P(AnyRule, AFastBodyVibratesLikeOneAtRest) {
  const auto vibrate = [&](double speed) {
    Scene scene = scene_of({GeneratorKind::kBox, {4, 0.5, 0.5}, {8, 1, 1}}, elastic(1e5, 0.3));
    scene.initial.velocity = {speed, 0.0, 0.0};
    scene.solver = GetParam().solver;
    scene.time = {GetParam().integrator, 1e-3, false, 0.05};
    Session session(scene, mesh_of(scene));
    ShiftState blow;
    blow.change.vertices = {0};
    blow.change.impulse = {{0.0, 0.01, 0.0}};
    session.apply(blow);
    EXPECT_EQ(session.run(), RunStatus::kFinished) << session.message();
    return session.balance().energies().elastic();
  };
  const double at_rest = vibrate(0.0);
  EXPECT_GT(at_rest, 0.0);
  EXPECT_NEAR(vibrate(300.0), at_rest, 2e-4 * at_rest);
}

// Lengths times s at the same times and density: moduli and viscosity times s², forces times s⁴.
TEST_P(AnyRule, NanometresAndKilometresGiveTheSameMotion) {
  const auto run = [&](double s) {
    Scene scene = clamped_beam(s * Vector3(2, 0.5, 0.5), {8, 2, 2});
    scene.material.youngs_modulus = 1e6 * s * s;
    scene.damping.viscosity = 300.0 * s * s;
    scene.environment = gravity(9.81 * s);
    scene.initial.velocity = s * Vector3(0.1, 1.0, -0.3);
    ForceSettings load =
        testing_support::load(SelectPlane{0, 2.0 * s, {}}, s * s * s * s * Vector3(0, 20, 10));
    load.until = 0.0155;
    scene.force.push_back(load);
    scene.solver = GetParam().solver;
    scene.solver.tolerance = 1e-11;
    scene.time = {GetParam().integrator, implicit() ? 5e-3 : 5e-4, false, 0.03};
    Session session(scene, mesh_of(scene));
    EXPECT_EQ(session.run(), RunStatus::kFinished) << s << ": " << session.message();
    return Vector((session.state().position - session.system().rest_state().position) / s);
  };
  const Vector metres = run(1.0);
  ASSERT_GT(metres.norm(), 0.1);
  for (const double s : {1e-9, 1e-3, 1e3}) {
    EXPECT_LT((run(s) - metres).norm(), 1e-9 * metres.norm()) << s;
  }
}

// Up to ν = 0.49999 every rule runs, the session warns of locking, and the solvers of a rule agree.
TEST_P(AnyRule, NearlyIncompressibleBodies) {
  for (const double ratio : {0.49, 0.4999, 0.49999}) {
    Scene scene = clamped_beam({2, 0.5, 0.5}, {8, 2, 2});
    scene.material.poissons_ratio = ratio;
    scene.environment.kind = EnvironmentKind::kGravity;
    scene.solver = GetParam().solver;
    scene.time = {GetParam().integrator, implicit() ? 0.01 : 1.0, !implicit(), 0.05};
    Session session(scene, mesh_of(scene));
    ASSERT_EQ(session.run(), RunStatus::kFinished) << ratio << ": " << session.message();
    EXPECT_FALSE(session.warnings().empty()) << ratio;
    EXPECT_LT(session.balance().max_relative_energy_drift(),
              GetParam().integrator == Integrator::kBackwardEuler ? 1.0 : 0.05);
    if (!implicit()) continue;
    scene.solver = {"newton", LinearSolver::kFactor};
    Session other(scene, mesh_of(scene));
    ASSERT_EQ(other.run(), RunStatus::kFinished);
    const Vector moved = other.state().position - other.system().rest_state().position;
    EXPECT_LT((session.state().position - other.state().position).norm(), 1e-5 * moved.norm())
        << ratio;
  }
}

class ImplicitRule : public AnyRule {};

INSTANTIATE_TEST_SUITE_P(All, ImplicitRule, testing::ValuesIn(implicit_rules_with_solvers()),
                         name_with_solver);

// Penalty springs of any stiffness become the exact fix. They limit the step of explicit rules.
TEST_P(ImplicitRule, StiffSpringsBecomeAnExactFix) {
  const auto run = [&](double penalty) {
    Scene scene = clamped_beam({2, 0.5, 0.5}, {8, 2, 2});
    scene.fix[0].is_penalty = penalty > 0.0;
    scene.fix[0].penalty = penalty;
    scene.environment.kind = EnvironmentKind::kGravity;
    scene.solver = GetParam().solver;
    scene.time = {GetParam().integrator, 0.01, false, 0.1};
    Session session(scene, mesh_of(scene));
    EXPECT_EQ(session.run(), RunStatus::kFinished) << penalty << ": " << session.message();
    return Vector(session.state().position - session.system().rest_state().position);
  };
  const Vector exact = run(0.0);
  EXPECT_LT((run(1e9) - exact).norm(), 1e-4 * exact.norm());
  EXPECT_LT((run(1e13) - exact).norm(), 1e-4 * exact.norm());
}

}  // namespace
}  // namespace tetraction
