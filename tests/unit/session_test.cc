#include "tetraction/simulation/session.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "support/runs.h"
#include "tetraction/dynamics/body_sums.h"

namespace tetraction {
namespace {

using namespace testing_support;

class EditedSession : public testing::TestWithParam<Integrator> {};

INSTANTIATE_TEST_SUITE_P(Rules, EditedSession, testing::ValuesIn(all_rules()), name_of_rule);

// Everything that acts on a body, and every kind of edit, in one run.
TEST_P(EditedSession, TheBooksCloseWithEveryTermAtOnce) {
  Scene scene = spinning_block(GetParam(), 1e-3, 0.12);
  scene.environment = {EnvironmentKind::kGravity, 0.2, -Vector3::UnitY(), 0.0};
  scene.damping = {20.0, 2.0, 400.0};
  FixSettings spring = springs(SelectNearest{{2, 1, 1}}, 500.0);
  spring.velocity = {0.0, 0.3, 0.0};
  scene.fix = {moving(SelectBox{{0, 0, 0}, {0, 1, 0}}, {0.1, 0.0, -0.2}), spring};
  scene.constraint = {rod(2, 11)};
  ForceSettings push = load(SelectPlane{0, 2.0, {}}, {50.0, -20.0, 10.0});
  scene.force = {push};
  const TetMesh mesh = mesh_of(scene);
  Session session(scene, mesh);

  MaterialSettings softer = scene.material;
  softer.youngs_modulus = 5e4;
  softer.model = "stvk";
  TimeSettings finer = scene.time;
  finer.step = 5e-4;
  FixSettings more = fix(SelectNearest{{1, 1, 0}});
  const std::vector<Edit> edits{
      SetMaterial{0, softer},
      SetMomentum{{SelectPlane{0, 2.0, {}}, {0.0, 60.0, 0.0}, {}}},
      SetDamping{{0.0, 0.0, 10.0}},
      SetEnvironment{{EnvironmentKind::kAttraction, 20.0, Vector3::UnitY(), 0.5}},
      SetTime{finer},
      SetFix{std::nullopt, more},
      Unfix{SelectBox{{0, 0, 0}, {0, 1, 0}}, {}},
      SetForce{0, {push.select, {0.0, 5.0, 0.0}, 0.0, 1.0, {}}},
      SetConstraint{std::nullopt,
                    {ConstraintKind::kPlane,
                     {0, 1},
                     {},
                     SelectNearest{{2, 0, 0}},
                     {},
                     Vector3(1, 1, 1),
                     {},
                     {},
                     {}}}};

  const double start = session.balance().energies().total();
  double largest = std::abs(start);
  std::size_t next = 0;
  double jumps = 0.0;
  while (session.step()) {
    const Balance& balance = session.balance();
    const double total = balance.energies().total();
    for (const double term : {total, balance.external_work(), balance.dissipated_energy(),
                              balance.constraint_work(), balance.edit_work()}) {
      largest = std::max(largest, std::abs(term));
    }
    const double sum = total - start - balance.external_work() + balance.dissipated_energy() -
                       balance.constraint_work() - balance.edit_work();
    EXPECT_NEAR(balance.energy_error(), sum, 1e-13 * largest);
    if (session.state().step % 10 == 0 && next < edits.size()) {
      const double before = balance.energies().total();
      session.apply(edits[next++], "{}");
      EXPECT_NEAR(session.edits().back().energy_jump, balance.energies().total() - before,
                  1e-12 * largest);
      jumps += session.edits().back().energy_jump;
    }
  }
  ASSERT_EQ(session.status(), RunStatus::kFinished) << session.message();
  EXPECT_EQ(next, edits.size());
  const Balance& balance = session.balance();
  // Every term has taken part, and what is left is the rule's own error, much smaller than any of
  // them: none was forgotten.
  double smallest = largest;
  for (const double term : {balance.external_work(), balance.dissipated_energy(),
                            balance.constraint_work(), balance.edit_work()}) {
    smallest = std::min(smallest, std::abs(term));
  }
  EXPECT_GT(smallest, 1e-3 * largest);
  EXPECT_NEAR(balance.edit_work(), jumps, 1e-12 * largest);
  EXPECT_LT(std::abs(balance.energy_error()), is_variational(GetParam())
                                                  ? (order(GetParam()) == 2 ? 0.02 : 0.6) * smallest
                                                  : 0.02 * largest);  // it dissipates of itself
}

TEST_P(EditedSession, AnEditIsInForceAtTheNextStepAndNotBefore) {
  Scene scene = spinning_block(GetParam(), 1e-3, 0.02);
  const TetMesh mesh = mesh_of(scene);
  Session edited(scene, mesh);
  Session plain(scene, mesh);
  for (int k = 0; k < 10; ++k) {
    ASSERT_TRUE(edited.step());
    ASSERT_TRUE(plain.step());
  }
  const EnvironmentSettings gravity = testing_support::gravity(9.81);
  edited.apply(SetEnvironment{gravity});
  EXPECT_EQ(edited.state().position, plain.state().position);
  ASSERT_TRUE(edited.step());
  ASSERT_TRUE(plain.step());
  const Vector3 change = edited.balance().momenta().linear - plain.balance().momenta().linear;
  const Vector3 impulse(0.0, -9.81 * edited.system().total_mass() * 1e-3, 0.0);
  EXPECT_LT((change - impulse).norm(), 1e-6 * impulse.norm());
}

// Gravity as a user's own field.
class OwnGravity : public ForceField {
 public:
  explicit OwnGravity(double strength) : strength_(strength) {}
  double value(double mass, const Vector3& q) const override { return mass * strength_ * q.y(); }
  Vector3 gradient(double mass, const Vector3&) const override {
    return {0.0, mass * strength_, 0.0};
  }
  Matrix3 hessian(double, const Vector3&) const override { return Matrix3::Zero(); }

 private:
  double strength_;
};

TEST_P(EditedSession, EditsToCustomMaterialAndFieldAreThoseToTheModelsTheyCopy) {
  Scene scene = spinning_block(GetParam(), 1e-3, 0.04);
  const TetMesh mesh = mesh_of(scene);
  MaterialSettings softer = scene.material;
  softer.model = "stvk";
  softer.youngs_modulus = 5e4;
  MaterialSettings own = scene.material;
  own.custom = CustomMaterial(std::get<StVenantKirchhoff>(make_material(softer)));
  const EnvironmentSettings gravity = testing_support::gravity(5.0);
  EnvironmentSettings own_gravity;
  own_gravity.kind = EnvironmentKind::kCustom;
  own_gravity.field = std::make_shared<OwnGravity>(5.0);

  Session by_name(scene, mesh);
  Session by_hand(scene, mesh);
  while (by_name.step() && by_hand.step()) {
    if (by_name.state().step == 10) {
      by_name.apply(SetMaterial{0, softer});
      by_hand.apply(SetMaterial{0, own});
    }
    if (by_name.state().step == 20) {
      by_name.apply(SetEnvironment{gravity});
      by_hand.apply(SetEnvironment{own_gravity});
    }
    if (by_name.state().step == 30) {  // and back
      by_name.apply(SetMaterial{0, scene.material});
      by_hand.apply(SetMaterial{0, scene.material});
      by_name.apply(SetEnvironment{});
      by_hand.apply(SetEnvironment{});
    }
  }
  ASSERT_EQ(by_hand.state().step, 40) << by_hand.message();
  const Vector moved = by_name.state().position - by_name.system().rest_state().position;
  // The solver's tolerance lies between the two where the rule is implicit.
  const double tolerance = is_implicit(GetParam()) ? 1e-8 : 1e-12;
  EXPECT_LT((by_hand.state().position - by_name.state().position).norm(), tolerance * moved.norm());
  EXPECT_NEAR(by_hand.balance().edit_work(), by_name.balance().edit_work(),
              tolerance * by_name.balance().energy_scale());
  EXPECT_NEAR(by_hand.balance().energy_error(), by_name.balance().energy_error(),
              tolerance * by_name.balance().energy_scale());
}

TEST(Session, TakesACustomSceneFromTheStartAndRefusesAnEmptyField) {
  Scene scene = spinning_block(Integrator::kVerlet, 1e-3, 0.01);
  const LameParameters lame = lame_from_young(1e5, 0.3);
  scene.material = {};
  scene.material.custom = CustomMaterial(NeoHookean(lame.mu, lame.lambda), "mine", lame);
  Session session(scene, mesh_of(scene));
  EXPECT_EQ(material_name(session.system().elastic().materials()[0].model()), "mine");
  EnvironmentSettings empty;
  empty.kind = EnvironmentKind::kCustom;
  EXPECT_THROW(session.apply(SetEnvironment{empty}), InputError);
  EXPECT_EQ(session.run(), RunStatus::kFinished) << session.message();
  EXPECT_TRUE(session.edits().empty());
}

TEST(Session, WarnsWhenAFieldIsTooStiffForTheStep) {
  class Spring : public ForceField {
   public:
    double value(double mass, const Vector3& q) const override {
      return 0.5 * mass * 9e6 * q.squaredNorm();
    }
    Vector3 gradient(double mass, const Vector3& q) const override { return mass * 9e6 * q; }
    Matrix3 hessian(double mass, const Vector3&) const override {
      return mass * 9e6 * Matrix3::Identity();
    }
  };
  Scene scene = spinning_block(Integrator::kVerlet, 1e-3, 0.01);
  Session session(scene, mesh_of(scene));
  EnvironmentSettings stiff;
  stiff.kind = EnvironmentKind::kCustom;
  stiff.field = std::make_shared<Spring>();
  session.apply(SetEnvironment{stiff});
  EXPECT_FALSE(session.edits().back().warning.empty());
  // ω² of the field adds to that of the body.
  EXPECT_NEAR(std::pow(session.current_limit().omega_max, 2),
              9e6 + std::pow(session.initial_limit().omega_max, 2), 0.02 * 9e6);
}

TEST(Session, EventsAndEditsAreOneMechanism) {
  // The same changes by events and by hand give bitwise the same trajectory.
  Scene scene = spinning_block(Integrator::kVerlet, 1e-3, 0.1);
  Scene eventful = scene;
  FixSettings fix = testing_support::fix(SelectVertices{{0}});
  TimeSettings implicit = scene.time;
  implicit.integrator = Integrator::kMidpoint;
  implicit.step = 2e-3;
  const EventSettings first{
      0.02, {SetFix{std::nullopt, fix}, SetDamping{{0.0, 1.0, 0.0}}}, R"({"at":0.02})", {}};
  EventSettings second;
  second.at = 0.0501;  // between two steps: at the next one
  second.edits = {SetTime{implicit}, Unfix{SelectAll{}, {}}};
  second.echo = R"({"at":0.0501})";
  eventful.event = {first, second};
  const TetMesh mesh = mesh_of(scene);
  FinishedRun by_events(eventful, mesh);

  Session by_hand(scene, mesh);
  while (true) {
    if (by_hand.state().step == 20) {
      for (const Edit& edit : first.edits) by_hand.apply(edit);
    }
    if (by_hand.state().step == 51) {
      for (const Edit& edit : second.edits) by_hand.apply(edit);
    }
    if (!by_hand.step()) break;
  }
  EXPECT_EQ(by_events.state().position, by_hand.state().position);
  EXPECT_EQ(by_events.state().momentum, by_hand.state().momentum);
  ASSERT_EQ(by_events.edits().size(), 2u);
  EXPECT_EQ(by_events.edits()[0].step, 20);
  EXPECT_EQ(by_events.edits()[1].step, 51);
  EXPECT_EQ(by_events.state().step, 51 + 25);  // (0.1 − 0.051)/0.002 = 24.5
  EXPECT_EQ(by_events.state().time, 0.1);
}

TEST(Session, ChangingAFixKeepsItsTargetsUnlessTheyAreChanged) {
  Scene scene = spinning_block(Integrator::kVerlet, 1e-3, 0.1);
  scene.initial = {};
  scene.environment.kind = EnvironmentKind::kGravity;
  FixSettings clamp = shifted(SelectPlane{0, 0.0, {}}, {0.02, 0.0, 0.0});
  FixSettings spring = springs(SelectNearest{{2, 1, 1}}, 1e3);
  scene.fix = {clamp, spring};
  const TetMesh mesh = mesh_of(scene);
  Session session(scene, mesh);
  for (int k = 0; k < 20; ++k) ASSERT_TRUE(session.step());
  // A velocity does not add the offset again; a stiffer spring pulls at where it pulled before.
  clamp.velocity = {0.0, 0.1, 0.0};
  session.apply(SetFix{0, clamp});
  EXPECT_NEAR(session.state().position[0], 0.02, 1e-15);
  for (int k = 0; k < 10; ++k) ASSERT_TRUE(session.step());
  EXPECT_NEAR(session.state().position[1], 0.1 * 10e-3, 1e-15);
  session.apply(Unfix{SelectVertices{{0}}, {}});
  EXPECT_TRUE(session.edits().back().warning.empty());
  clamp.velocity.setZero();
  session.apply(SetFix{0, clamp});
  EXPECT_TRUE(session.system().coordinates().is_free(0)) << "released stays released";
  spring.penalty = 2e3;
  session.apply(SetFix{1, spring});
  const Vector origin = Vector::Zero(session.system().dof_count());
  Vector pull = origin;
  session.system().constraints().springs().add_gradient(
      session.system().force_point(origin, session.state().time), pull);
  const Index v = select_vertices(mesh, spring.select).front();
  EXPECT_EQ(Vector3(pull.segment<3>(3 * v)), -2.0 * spring.penalty * Vector3(2, 1, 1));
  // Another offset is meant from where the vertices are.
  clamp.offset = Vector3(0.01, 0.0, 0.0);
  session.apply(SetFix{0, clamp});
  EXPECT_NEAR(session.state().position[3 * 3], 0.03, 1e-15);
  session.apply(Unfix{SelectNearest{{1, 1, 1}}, {}});
  EXPECT_FALSE(session.edits().back().warning.empty()) << "nothing was fixed there";
}

TEST(Session, AnEventThatMovesTheEndMakesLaterOnesHappen) {
  Scene scene = spinning_block(Integrator::kVerlet, 1e-3, 0.02);
  TimeSettings longer = scene.time;
  longer.end = 0.04;
  const EventSettings first{0.01, {SetTime{longer}}, "{}", {}};
  const EventSettings second{0.03, {SetDamping{{0.0, 1.0, 0.0}}}, "{}", {}};
  scene.event = {first, second};
  Session session(scene, mesh_of(scene));
  EXPECT_TRUE(session.warnings().empty());
  EXPECT_EQ(session.run(), RunStatus::kFinished);
  EXPECT_EQ(session.state().step, 40);
  EXPECT_EQ(session.edits().size(), 2u);
}

// The round-off that an event's time may have is counted in steps, and an event may shorten them.
TEST(Session, EventsRightAfterStepsWereMadeMuchShorterAreNotMadeTooEarly) {
  Scene scene = spinning_block(Integrator::kBackwardEuler, 10.0, 30.0);
  scene.initial = {};
  const auto event = [](double at, const Edit& edit) {
    return EventSettings{at, {edit}, "{}", {}};
  };
  scene.event = {event(10.0, SetTime{{Integrator::kBackwardEuler, 1e-6, false, 10.000003}}),
                 event(10.000001, SetDamping{{.drag = 1.0}})};
  Session session(scene, generate_mesh(*scene.mesh.generate));
  ASSERT_TRUE(session.step());
  ASSERT_TRUE(session.step());
  EXPECT_EQ(session.damping().drag, 0.0);
  ASSERT_TRUE(session.step()) << session.message();
  EXPECT_EQ(session.damping().drag, 1.0);
}

TEST(Session, RefusedEditsLeaveEverythingAsItWas) {
  Scene scene = spinning_block(Integrator::kVerlet, 1e-3, 0.1);
  FixSettings fix = testing_support::fix(SelectVertices{{0}});
  fix.where = "fix.0";
  scene.fix = {fix};
  Session session(scene, mesh_of(scene));
  for (int k = 0; k < 10; ++k) ASSERT_TRUE(session.step());
  const State before = session.state();

  MaterialSettings heavier = scene.material;
  heavier.density = 2000.0;
  EXPECT_THROW(session.apply(SetMaterial{0, heavier}), InputError);
  EXPECT_THROW(session.apply(SetMaterial{3, scene.material}), InputError);
  EXPECT_THROW(session.apply(SetDamping{{-1.0, 0.0, 0.0}}), InputError);
  FixSettings elsewhere = fix;
  elsewhere.target = Vector3(0.0, 5.0, 0.0);  // the vertex is held already, and it would invert
  EXPECT_THROW(session.apply(SetFix{std::nullopt, elsewhere}), InputError);
  EXPECT_THROW(session.apply(SetFix{0, elsewhere}), InputError);
  EXPECT_THROW(session.apply(SetFix{7, fix}), InputError);
  ConstraintSettings zero = rod(3, 3);
  EXPECT_THROW(session.apply(SetConstraint{std::nullopt, zero}), InputError);
  EXPECT_TRUE(session.edits().empty());
  EXPECT_EQ(session.state().position, before.position);
  EXPECT_EQ(session.balance().edit_work(), 0.0);

  Session untouched(scene, mesh_of(scene));
  for (int k = 0; k < 20; ++k) ASSERT_TRUE(untouched.step());
  for (int k = 0; k < 10; ++k) ASSERT_TRUE(session.step());
  EXPECT_EQ(session.state().position, untouched.state().position);
}

TEST(Session, AnEventThatCannotBeMadeEndsTheRunWithItsReason) {
  Scene scene = spinning_block(Integrator::kVerlet, 1e-3, 0.1);
  FixSettings impossible = fix(SelectVertices{{0}});
  impossible.target = Vector3(100.0, 0.0, 0.0);
  EventSettings event{0.05, {SetFix{std::nullopt, impossible}}, "{}", {}};
  scene.event = {event};
  Session session(scene, mesh_of(scene));
  EXPECT_EQ(session.run(), RunStatus::kNotConverged);
  EXPECT_EQ(session.state().step, 50);
  EXPECT_NE(session.message().find("event at 0.05 s"), std::string::npos);
  EXPECT_NE(session.message().find("inverts element"), std::string::npos);
}

TEST(Session, WarnsOfLoadsThatNeverAct) {
  Scene scene = spinning_block(Integrator::kVerlet, 1e-3, 0.01);
  ForceSettings past;
  past.from = -2.0;
  past.until = -1.0;
  past.where = "force.0";
  ForceSettings present = past;
  present.until = 0.004;
  present.where = "force.1";
  scene.force = {past, present};
  EventSettings event{0.005, {}, "{}", "event.0"};
  present.where = "event.0.force";
  event.edits = {SetForce{std::nullopt, present}, SetForce{1, present}};
  scene.event = {event};
  const Session session(scene, mesh_of(scene));
  ASSERT_EQ(session.warnings().size(), 2U);
  EXPECT_EQ(session.warnings()[0],
            "force.0 ends at -1 s, and the run starts at 0 s: it never acts.");
  EXPECT_EQ(session.warnings()[1].rfind("event.0.force ends at 0.004 s", 0), 0U);
}

// The momenta of a handle at rest without loads are mere round-off, for which no tolerance is out of
// reach.
TEST(Session, AFreeHandleAtRestHasNoWarningOfRoundOff) {
  for (const char* solver : {"newton", "ceres"}) {
    Scene scene = spinning_block(Integrator::kMidpoint, 1e-2, 0.2);
    scene.initial = {};
    scene.solver.kind = solver;
    scene.constraint = {rigid(SelectPlane{0, 2.0, {}})};
    FinishedRun session(scene);
    EXPECT_EQ(session.balance().steps_limited_by_round_off(), 0);
    for (const std::string& warning : session.warnings()) {
      EXPECT_EQ(warning.find("round-off"), std::string::npos) << warning;
    }
  }
}

TEST(Session, WarnsOfEventsThatAreTooEarlyOrNeverHappen) {
  Scene scene = spinning_block(Integrator::kVerlet, 1e-3, 0.01);
  const EventSettings early{-1.0, {SetDamping{{0.0, 1.0, 0.0}}}, "{}", "event.0"};
  EventSettings late = early;
  late.at = 0.01;
  late.where = "event.1";
  scene.event = {early, late};
  Session session(scene, mesh_of(scene));
  ASSERT_EQ(session.warnings().size(), 2u);
  EXPECT_NE(session.warnings()[0].find("event.0"), std::string::npos);
  EXPECT_NE(session.warnings()[1].find("not happen"), std::string::npos);
  EXPECT_EQ(session.run(), RunStatus::kFinished);
  EXPECT_EQ(session.edits().size(), 1u);
  EXPECT_EQ(session.edits()[0].step, 0);
}

TEST(Session, SeveralMaterialsHaveTheirOwnMassAndEnergies) {
  Scene scene = spinning_block(Integrator::kVerlet, 1e-4, 0.01);
  MaterialRegionSettings half{SelectBox{{1, 0, 0}, {2, 1, 1}}, scene.material, {}};
  half.material.model = "stvk";
  half.material.youngs_modulus = 1e6;
  half.material.density = 3000.0;
  scene.material_region = {half};
  Session session(scene, mesh_of(scene));
  EXPECT_NEAR(session.system().total_mass(), 1000.0 + 3000.0, 1e-9);
  ASSERT_EQ(session.run(), RunStatus::kFinished) << session.message();
  const Vector elastic = session.system().elastic().energies_by_material(session.state().position);
  const Vector kinetic = kinetic_energies_by_region(session.system(), session.state().momentum);
  const Energies& total = session.balance().energies();
  ASSERT_EQ(elastic.size(), 2);
  EXPECT_NEAR(elastic.sum(), total.elastic(), 1e-12 * total.elastic());
  EXPECT_NEAR(kinetic.sum(), total.kinetic(), 1e-12 * total.kinetic());
  EXPECT_GT(elastic.minCoeff(), 0.0);
  EXPECT_GT(kinetic[1], kinetic[0]);
  EXPECT_LT(session.balance().angular_momentum_drift(), 1e-12);
}

TEST(Session, TheSolverCanChangeDuringARun) {
  Scene scene = spinning_block(Integrator::kMidpoint, 1e-2, 0.1);
  scene.solver.kind = "ceres";
  Session session(scene, mesh_of(scene));
  EXPECT_EQ(session.linear_solver(), "") << "before the first step";
  ASSERT_TRUE(session.step());
  EXPECT_EQ(session.linear_solver(), "cholesky");
  EXPECT_EQ(session.total_cg_iterations(), 0);

  SolverSettings newton;
  newton.kind = "newton";
  for (const LinearSolver linear :
       {LinearSolver::kAuto, LinearSolver::kMatrixFree, LinearSolver::kCg, LinearSolver::kFactor}) {
    newton.linear = linear;
    session.apply(SetSolver{newton});
    EXPECT_EQ(session.solver_settings().kind, "newton");
    EXPECT_EQ(session.solver_settings().linear, linear);
    ASSERT_TRUE(session.step()) << session.message();
  }

  // Edits that do not fit are refused and change nothing.
  SolverSettings wrong = newton;
  wrong.kind = "ceres";
  EXPECT_THROW(session.apply(SetSolver{wrong}), InputError);
  wrong.kind = "lbfgs";
  EXPECT_THROW(session.apply(SetSolver{wrong}), InputError);
  EXPECT_EQ(session.solver_settings().kind, "newton");
  EXPECT_TRUE(session.step());
  EXPECT_EQ(session.edits().size(), 4u);
}

TEST(Session, ExplicitRulesHaveNoSolver) {
  Scene scene = spinning_block(Integrator::kVerlet, 1e-3, 0.002);
  scene.solver.kind = "newton";
  scene.solver.linear = LinearSolver::kCg;
  Session session(scene, mesh_of(scene));
  EXPECT_EQ(session.run(), RunStatus::kFinished);
  EXPECT_EQ(session.linear_solver(), "");
  EXPECT_EQ(session.total_iterations(), 0);
}

TEST(Session, PresentSettingsAreThoseInForce) {
  Scene scene = spinning_block(Integrator::kVerlet, 1e-3, 0.1);
  scene.constraint = {rod(2, 11)};
  Session session(scene, mesh_of(scene));
  EXPECT_EQ(session.materials().size(), 1U);
  EXPECT_EQ(session.materials()[0].youngs_modulus, scene.material.youngs_modulus);
  EXPECT_EQ(session.fix_count(), 0U);
  ASSERT_TRUE(session.constraints().at(0).has_value());
  EXPECT_GT(session.constraints()[0]->length.value_or(0.0), 0.0) << "as it was";
  for (int k = 0; k < 10; ++k) ASSERT_TRUE(session.step());

  MaterialSettings softer = scene.material;
  softer.youngs_modulus = 4e4;
  session.apply(SetMaterial{0, softer});
  EXPECT_EQ(session.materials()[0].youngs_modulus, 4e4);
  session.apply(SetDamping{{1.0, 2.0, 3.0}});
  EXPECT_EQ(session.damping().mass_damping, 2.0);
  const EnvironmentSettings gravity = testing_support::gravity(9.81);
  session.apply(SetEnvironment{gravity});
  EXPECT_EQ(session.environment().kind, EnvironmentKind::kGravity);
  ForceSettings force = load(SelectVertices{{1}}, {1, 2, 3});
  session.apply(SetForce{std::nullopt, force});
  ASSERT_EQ(session.forces().size(), 1U);
  EXPECT_EQ(session.next_external_force().segment<3>(3), force.vector);
  session.apply(RemoveConstraint{0});
  EXPECT_FALSE(session.constraints()[0].has_value());
  EXPECT_EQ(session.tension(0), 0.0);
  EXPECT_FALSE(session.system().constraints().has_equations());
  EXPECT_THROW(session.apply(RemoveConstraint{1}), InputError);

  FixSettings moving = testing_support::moving(SelectVertices{{0, 3}}, {0.5, 0.0, 0.0});
  session.apply(SetFix{std::nullopt, moving});
  const Matrix start = session.fix(0).targets;
  for (int k = 0; k < 10; ++k) ASSERT_TRUE(session.step());
  const PresentFix fix = session.fix(0);
  EXPECT_EQ(fix.vertices, (std::vector<Index>{0, 3}));
  EXPECT_NEAR(fix.targets(0, 1) - start(0, 1), 0.005, 1e-15);
  EXPECT_EQ(Vector3(fix.targets.col(1)), Vector3(session.state().position.segment<3>(9)));
}

TEST(Session, OneFixReleasesItsVerticesAndHoldsThemAnew) {
  Scene scene = spinning_block(Integrator::kVerlet, 1e-3, 0.1);
  FixSettings first = fix(SelectVertices{{0, 3}});
  scene.fix = {first, fix(SelectVertices{{3, 6}})};
  Session session(scene, mesh_of(scene));
  session.apply(Unfix{SelectAll{}, {}, 0});
  EXPECT_TRUE(session.fix(0).vertices.empty());
  EXPECT_EQ(session.fix(1).vertices, (std::vector<Index>{3, 6}));
  EXPECT_FALSE(session.system().constraints().is_constrained(0));
  EXPECT_TRUE(session.system().constraints().is_constrained(3));
  for (int k = 0; k < 5; ++k) ASSERT_TRUE(session.step());
  session.apply(SetFix{0, first});  // the same as before, where they are now
  EXPECT_EQ(session.fix(0).vertices, (std::vector<Index>{0, 3}));
  EXPECT_EQ(Vector3(session.fix(0).targets.col(0)),
            Vector3(session.state().position.segment<3>(0)));
  EXPECT_THROW(session.apply(Unfix{SelectAll{}, {}, 2}), InputError);
}

TEST(Session, EachVertexCanHaveItsOwnTarget) {
  Scene scene = spinning_block(Integrator::kVerlet, 1e-3, 0.1);
  Session session(scene, mesh_of(scene));
  FixSettings fix = testing_support::fix(SelectVertices{{6, 0}});  // not in the order of the mesh
  const Vector3 at_6 = session.state().position.segment<3>(18) + Vector3(0.01, 0.0, 0.0);
  const Vector3 at_0 = session.state().position.segment<3>(0) - Vector3(0.0, 0.02, 0.0);
  fix.targets = {at_6, at_0};
  session.apply(SetFix{std::nullopt, fix});
  EXPECT_EQ(Vector3(session.state().position.segment<3>(18)), at_6);
  EXPECT_EQ(Vector3(session.state().position.segment<3>(0)), at_0);
  fix.targets.pop_back();
  EXPECT_THROW(session.apply(SetFix{std::nullopt, fix}), InputError);
  fix.select = SelectNearest{{0, 0, 0}};
  EXPECT_THROW(session.apply(SetFix{std::nullopt, fix}), InputError);
}

TEST(Session, ShiftsMoveAndKickSingleVertices) {
  Scene scene = spinning_block(Integrator::kVerlet, 1e-3, 0.1);
  scene.fix = {fix(SelectVertices{{0}})};
  Session session(scene, mesh_of(scene));
  for (int k = 0; k < 5; ++k) ASSERT_TRUE(session.step());
  const State before = session.state();
  session.apply(ShiftState{{{6, 4, 0},
                            {{0.01, 0, 0}, {0, 0.01, 0}, {0.05, 0, 0}},
                            {{0, 0, 1}, {2, 0, 0}, {7, 7, 7}},
                            {}}});
  const State& after = session.state();
  Vector moved = after.position - before.position;
  Vector kicked = after.momentum - before.momentum;
  EXPECT_NEAR(moved[18], 0.01, 1e-15);
  EXPECT_NEAR(moved[13], 0.01, 1e-15);
  EXPECT_EQ(moved.segment<3>(0).norm(), 0.0) << "it is held";
  EXPECT_EQ(kicked.segment<3>(0).norm(), 0.0);
  EXPECT_NEAR(kicked[20], 1.0, 1e-12);
  EXPECT_NEAR(kicked[12], 2.0, 1e-12);
  moved[18] = moved[13] = kicked[20] = kicked[12] = 0.0;
  EXPECT_EQ(moved.norm(), 0.0);
  EXPECT_LT(kicked.norm(), 1e-12);
  EXPECT_EQ(session.balance().edit_work(), session.edits().back().energy_jump);
  EXPECT_NE(session.balance().edit_work(), 0.0);

  const State state = session.state();
  for (const ShiftSettings& wrong :
       std::vector<ShiftSettings>{{{6}, {{0, 50, 0}}, {}, {}},
                                  {{6}, {}, {}, {}},
                                  {{6, 4}, {{0, 0, 0}}, {}, {}},
                                  {{6, 6}, {}, {{0, 0, 0}, {0, 0, 0}}, {}},
                                  {{600}, {}, {{0, 0, 0}}, {}},
                                  {{6}, {}, {{std::nan(""), 0, 0}}, {}}}) {
    EXPECT_THROW(session.apply(ShiftState{wrong}), InputError);
  }
  EXPECT_EQ(session.state().position, state.position);
  EXPECT_EQ(session.state().momentum, state.momentum);
  EXPECT_EQ(session.edits().size(), 1U);
}

// The forces of a session are those of the last step that led to its state.
TEST_P(EditedSession, AStepThatFailsChangesNoForces) {
  Scene scene = spinning_block(GetParam(), 1e-3, 1.0);
  scene.fix = {fix(SelectBox{{0, 0, 0}, {0, 1, 1}})};
  ForceSettings push = load(SelectPlane{0, 2.0, {}}, {0.0, 10.0, 0.0});
  scene.force = {push};
  Session session(scene, mesh_of(scene));
  for (int k = 0; k < 5; ++k) ASSERT_TRUE(session.step()) << session.message();
  push.vector = {-1e300, 0.0, 0.0};
  session.apply(SetForce{0, push});
  const Vector reaction = session.reaction_force();
  const Vector external = session.external_force();
  EXPECT_GT(reaction.norm(), 0.0);
  EXPECT_GT(external.norm(), 0.0);
  EXPECT_FALSE(session.step());
  EXPECT_EQ(session.state().step, 5);
  EXPECT_EQ(session.reaction_force(), reaction);
  EXPECT_EQ(session.external_force(), external);
}

TEST(Session, WithoutAnEndItGoesOn) {
  Scene scene = spinning_block(Integrator::kVerlet, 1e-3, 0.02);
  Session ended(scene, mesh_of(scene));
  EXPECT_EQ(ended.run(), RunStatus::kFinished);
  scene.time.end = std::numeric_limits<double>::infinity();
  Session session(scene, mesh_of(scene));
  for (int k = 0; k < 20; ++k) ASSERT_TRUE(session.step());
  EXPECT_EQ(session.state().position, ended.state().position);
  EXPECT_EQ(session.status(), RunStatus::kRunning);
  EXPECT_GT(session.step_count(), 1000000);
  TimeSettings finer = session.time_settings();
  finer.step = 1e-4;
  session.apply(SetTime{finer});
  EXPECT_TRUE(session.edits().back().warning.empty());
  EXPECT_TRUE(session.step());
}

TEST(Session, GoesBackToTheStateBeforeAStepThatDidNotConverge) {
  Scene scene = spinning_block(Integrator::kMidpoint, 1e-2, 1.0);
  Session session(scene, mesh_of(scene));
  session.go_back();  // nothing to go back from
  EXPECT_TRUE(session.edits().empty());
  for (int k = 0; k < 5; ++k) ASSERT_TRUE(session.step());
  session.apply(SetSolver{{"newton", LinearSolver::kAuto, 1e-13, 1}});
  const State before = session.state();
  EXPECT_FALSE(session.step());
  EXPECT_EQ(session.status(), RunStatus::kNotConverged);
  EXPECT_FALSE(session.step());
  session.go_back();
  EXPECT_EQ(session.status(), RunStatus::kRunning);
  EXPECT_TRUE(session.message().empty());
  EXPECT_EQ(session.state().position, before.position);
  session.apply(SetSolver{scene.solver});
  EXPECT_TRUE(session.step()) << session.message();

  // The failed attempt leaves nothing in the solver that changes the result.
  Session other(scene, mesh_of(scene));
  for (int k = 0; k < 5; ++k) ASSERT_TRUE(other.step());
  other.apply(SetSolver{scene.solver});
  EXPECT_TRUE(other.step());
  EXPECT_EQ(session.state().position, other.state().position);
}

TEST(Session, GoesBackBehindABlowUpButBehindNoEdit) {
  Scene scene = spinning_block(Integrator::kExplicit, 1e-3, 100.0);
  Session session(scene, mesh_of(scene));
  session.keep_good_states();
  for (int k = 0; k < 37; ++k) ASSERT_TRUE(session.step());
  TimeSettings coarse = scene.time;
  coarse.step = 1.01 * session.current_limit().critical_step;
  session.apply(SetTime{coarse});
  while (session.step()) {
  }
  ASSERT_EQ(session.status(), RunStatus::kUnstable);
  const Index failed = session.state().step;
  session.go_back();
  EXPECT_GE(session.state().step, 37);
  EXPECT_LT(session.state().step, failed);
  EXPECT_LT(session.balance().energy_error(), 0.1 * session.balance().energy_scale());
  session.apply(SetTime{scene.time});
  for (int k = 0; k < 50; ++k) ASSERT_TRUE(session.step()) << session.message();
}

}  // namespace
}  // namespace tetraction
