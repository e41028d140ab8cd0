// The books of the explicit rules, and what steppers do with the states that they are given.

#include <cmath>

#include "support/corner_scenes.h"
#include "support/force_terms.h"
#include "support/step_problems.h"
#include "tetraction/dynamics/balance.h"
#include "tetraction/dynamics/body_sums.h"
#include "tetraction/dynamics/constraints/multipliers.h"
#include "tetraction/dynamics/steppers/stability.h"

namespace tetraction {
namespace {

using namespace testing_support;

std::unique_ptr<MechanicalSystem> busy_body() {
  auto body = std::make_unique<MechanicalSystem>(small_block(), all_materials()[1], 1000.0);
  body->set_environment(Environment::uniform({0.0, -9.81, 0.0}));
  body->add_force({{5, 6}, {1.0, 0.0, 0.0}});
  return body;
}

class Steppers : public testing::TestWithParam<RuleWithSolver> {};

INSTANTIATE_TEST_SUITE_P(All, Steppers, testing::ValuesIn(rules_with_solvers()), name_with_solver);

TEST_P(Steppers, WriteTheirResultToAnotherStateAndLeaveTheFirstAlone) {
  const auto body = busy_body();
  PrescribedVertices moving = prescribe_at_rest(
      body->mesh(), select_vertices(body->mesh(), SelectPlane{0, 0.0, {}}), "moving");
  moving.motion.velocity = Vector3(0.0, 0.1, 0.0);
  const FixedDistance rod{20, 33, 0.0, "rod"};
  FixedDistance distance = rod;
  distance.length = (body->mesh().vertices[20] - body->mesh().vertices[33]).norm();
  body->set_constraints(Constraints({{moving}, {}, {distance}, {}}, body->mesh(), body->mass()));
  const double h = is_implicit(GetParam().integrator) ? 4e-3 : 2e-4;
  const auto make = [&] { return make_stepper(GetParam().integrator, GetParam().solver, *body); };

  State a = bending_state(*body);
  State b = a;
  State alone = a;
  const auto stepper = make();
  const auto other = make();
  State* from = &a;
  State* to = &b;
  const double* places[] = {a.position.data(),     a.momentum.data(),     a.velocity.data(),
                            b.position.data(),     b.momentum.data(),     b.velocity.data(),
                            alone.position.data(), alone.momentum.data(), alone.velocity.data()};
  for (int k = 0; k < 6; ++k) {
    const State before = *from;
    const StepOutcome outcome = stepper->advance(*from, *to, h, from->time + h);
    ASSERT_TRUE(outcome.ok()) << outcome.message;
    EXPECT_EQ(from->position, before.position);
    EXPECT_EQ(from->momentum, before.momentum);
    EXPECT_EQ(from->velocity, before.velocity);
    EXPECT_EQ(from->step, before.step);
    EXPECT_EQ(from->time, before.time);
    EXPECT_EQ(to->step, before.step + 1);
    EXPECT_EQ(to->time, before.time + h);
    ASSERT_TRUE(other->step(alone, h).ok());
    EXPECT_EQ(alone.position, to->position);
    EXPECT_EQ(alone.momentum, to->momentum);
    EXPECT_EQ(alone.velocity, to->velocity);
    std::swap(from, to);
  }
  const double* now[] = {a.position.data(),     a.momentum.data(),     a.velocity.data(),
                         b.position.data(),     b.momentum.data(),     b.velocity.data(),
                         alone.position.data(), alone.momentum.data(), alone.velocity.data()};
  EXPECT_TRUE(std::equal(std::begin(places), std::end(places), std::begin(now)));

  // The same from a state without vectors, and again after a step that failed.
  State empty;
  stepper->reset();
  ASSERT_TRUE(stepper->advance(*from, empty, h, from->time + h).ok());
  const State before = alone;
  EXPECT_FALSE(other->step(alone, 1e300).ok());
  EXPECT_EQ(alone.position, before.position);
  EXPECT_EQ(alone.momentum, before.momentum);
  EXPECT_EQ(alone.time, before.time);
  other->reset();
  ASSERT_TRUE(other->step(alone, h).ok());
  EXPECT_LT((alone.position - empty.position).norm(), 1e-9 * empty.position.norm());
}

// A step with damping is an impulse of damping, a step without damping, and another impulse. What the
// impulses take is dissipated, and nothing else is: the error of the energy is that of the step
// without damping.
TEST(DissipatedEnergy, OfVerletIsWhatTheImpulsesOfDampingTake) {
  for (const int constraints : {0, 1, 2, 3}) {
    SCOPED_TRACE(constraints);
    const auto body = busy_body();
    ConstraintList list;
    if (constraints >= 1) {
      list.held.push_back(prescribe_at_rest(
          body->mesh(), select_vertices(body->mesh(), SelectPlane{0, 0.0, {}}), "moving"));
      if (constraints >= 2) list.held[0].motion.velocity = Vector3(0.3, 0.1, 0.0);
    }
    if (constraints == 3) {
      FixedDistance rod;
      rod.a = 20;
      rod.b = 33;
      rod.length = (body->mesh().vertices[20] - body->mesh().vertices[33]).norm();
      list.distances.push_back(rod);
    }
    body->set_constraints(Constraints(list, body->mesh(), body->mass()));
    const Damping damping{2.0, 30.0, 500.0};
    body->set_damping(damping);
    constexpr double kStep = 4e-4;
    State state = bending_state(*body);
    {
      const auto warm_up = make_verlet_stepper(*body);
      for (int k = 0; k < 20; ++k) ASSERT_TRUE(warm_up->step(state, kStep).ok());
    }
    // The state with the first impulse.
    Vector impulse = Vector::Zero(body->dof_count());
    const Vector velocity = body->velocity_of(state.momentum);
    body->add_damping_force(state.position, state.time, velocity, impulse);
    body->add_viscous_force(state.position, velocity, impulse);
    impulse *= 0.5 * kStep;
    State kicked = state;
    project_impulse(body->constraints(), body->mass(), state.position, impulse);
    kicked.momentum += impulse;

    const auto error_of_a_step = [&](State start, double& dissipated) {
      Balance balance(*body, start);
      const StepOutcome outcome = make_verlet_stepper(*body)->step(start, kStep);
      EXPECT_TRUE(outcome.ok());
      dissipated = outcome.dissipated_energy;
      balance.enter(start, outcome);
      return balance.energy_error();
    };
    double dissipated = 0.0;
    const double with = error_of_a_step(state, dissipated);
    EXPECT_GT(dissipated, 0.1);
    body->set_damping({});
    double none = 0.0;
    const double without = error_of_a_step(kicked, none);
    EXPECT_EQ(none, 0.0);
    EXPECT_NEAR(with, without, 1e-11 * kinetic_energy(*body, state.momentum));
  }
}

// Nothing but drag, just below the limit.
TEST(DissipatedEnergy, OfPureDragIsTheKineticEnergyThatIsMissing) {
  for (const Integrator rule : {Integrator::kVerlet, Integrator::kExplicit}) {
    Scene scene = scene_of(elastic(1e3, 0.3));
    scene.initial.velocity = {1e-3, 0.0, 0.0};
    scene.damping.drag = 5e4;
    scene.time = {rule, 1e-4, false, 1.0};
    const StabilityLimit limit = Session(scene, generate_tetrahedron()).initial_limit();
    scene.time.step = 0.99 * limit.critical_step;
    scene.time.end = 200.0 * scene.time.step;
    Session session(scene, generate_tetrahedron());
    const double start = session.balance().energies().kinetic();
    ASSERT_TRUE(session.step()) << session.message();
    EXPECT_NEAR(session.balance().dissipated_energy(),
                start - session.balance().energies().kinetic(), 1e-12 * start);
    EXPECT_EQ(session.run(), RunStatus::kFinished) << session.message();
    EXPECT_LT(session.balance().max_relative_energy_drift(), 1e-10);
    EXPECT_LT(session.balance().energies().kinetic(), 0.1 * start);
  }
}

// Below the limit no step is refused: neither from rest, where the impulse of damping at the end can
// act against the first velocities, nor later.
TEST(DissipatedEnergy, RefusesNoStepBelowTheLimit) {
  for (const double damping : {0.0, 3.0, 10.0, 30.0, 100.0, 1000.0}) {
    Scene scene = scene_of(elastic(1e5, 0.3));
    scene.initial.stretch = {1.001, 0.9995, 1.002};
    scene.damping.mass_damping = damping;
    scene.time = {Integrator::kVerlet, 1e-4, false, 1.0};
    const StabilityLimit limit = Session(scene, generate_tetrahedron()).initial_limit();
    scene.time.step = 0.98 * limit.critical_step;
    scene.time.end = 500.0 * scene.time.step;
    Session session(scene, generate_tetrahedron());
    double before = 0.0;
    while (session.step()) {
      EXPECT_GE(session.balance().dissipated_energy(), before);
      before = session.balance().dissipated_energy();
    }
    EXPECT_EQ(session.status(), RunStatus::kFinished) << damping << ": " << session.message();
  }
}

}  // namespace
}  // namespace tetraction
