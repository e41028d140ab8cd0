// Edits that are refused, or fail half-way, leave everything as it was; edits that a solver cannot
// follow give it up.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

#include "support/bodies.h"
#include "support/fibre_rubber.h"
#include "support/rules.h"
#include "support/scene_parts.h"
#include "tetraction/core/error.h"
#include "tetraction/simulation/session.h"

namespace tetraction {
namespace {

using namespace testing_support;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// A material and a field of a user that have a flaw.
class FailingRubber {
 public:
  static constexpr const char* kName = "failing-rubber";
  FailingRubber(const LameParameters& lame, std::shared_ptr<bool> fails)
      : rubber_(lame.mu, lame.lambda), fails_(std::move(fails)) {}
  bool admissible(const Matrix3& f) const { return rubber_.admissible(f); }
  double energy_density(const Matrix3& f) const {
    if (*fails_) throw std::runtime_error("no energy");
    return rubber_.energy_density(f);
  }
  Matrix3 first_piola(const Matrix3& f) const { return rubber_.first_piola(f); }
  Matrix9 stiffness(const Matrix3& f) const { return rubber_.stiffness(f); }
  LameParameters initial_lame() const { return rubber_.initial_lame(); }

 private:
  NeoHookean rubber_;
  std::shared_ptr<bool> fails_;
};

class FailingField : public ForceField {
 public:
  double value(double, const Vector3&) const override { throw std::runtime_error("no value"); }
  Vector3 gradient(double, const Vector3&) const override { return Vector3::Zero(); }
  Matrix3 hessian(double, const Vector3&) const override { return Matrix3::Zero(); }
};

// All that can be read of a session.
void expect_all_same(const Session& a, const Session& b, const std::string& edit) {
  EXPECT_EQ(a.state().position, b.state().position) << edit;
  EXPECT_EQ(a.state().momentum, b.state().momentum) << edit;
  EXPECT_EQ(a.state().velocity, b.state().velocity) << edit;
  EXPECT_EQ(a.state().time, b.state().time) << edit;
  EXPECT_EQ(a.state().step, b.state().step) << edit;
  EXPECT_EQ(a.time_step(), b.time_step()) << edit;
  EXPECT_EQ(a.step_count(), b.step_count()) << edit;
  EXPECT_EQ(a.time_settings().integrator, b.time_settings().integrator) << edit;
  EXPECT_EQ(a.time_settings().step, b.time_settings().step) << edit;
  EXPECT_EQ(a.time_settings().end, b.time_settings().end) << edit;
  EXPECT_EQ(a.solver_settings().kind, b.solver_settings().kind) << edit;
  EXPECT_EQ(a.solver_settings().linear, b.solver_settings().linear) << edit;
  ASSERT_EQ(a.materials().size(), b.materials().size()) << edit;
  EXPECT_EQ(a.materials()[0].custom.has_value(), b.materials()[0].custom.has_value()) << edit;
  EXPECT_EQ(a.materials()[0].youngs_modulus, b.materials()[0].youngs_modulus) << edit;
  EXPECT_EQ(material_name(a.system().elastic().materials()[0].model()),
            material_name(b.system().elastic().materials()[0].model()))
      << edit;
  EXPECT_EQ(a.damping().drag, b.damping().drag) << edit;
  EXPECT_EQ(a.environment().kind, b.environment().kind) << edit;
  EXPECT_EQ(a.system().environment().is_uniform(), b.system().environment().is_uniform()) << edit;
  EXPECT_EQ(a.forces().size(), b.forces().size()) << edit;
  EXPECT_EQ(a.system().forces().size(), b.system().forces().size()) << edit;
  EXPECT_EQ(a.next_external_force(), b.next_external_force()) << edit;
  EXPECT_EQ(a.fix_count(), b.fix_count()) << edit;
  EXPECT_EQ(a.constraints().size(), b.constraints().size()) << edit;
  EXPECT_EQ(a.system().coordinates().count(), b.system().coordinates().count()) << edit;
  EXPECT_EQ(a.system().constraints().equation_count(), b.system().constraints().equation_count())
      << edit;
  EXPECT_EQ(a.edits().size(), b.edits().size()) << edit;
  EXPECT_EQ(a.balance().energies().total(), b.balance().energies().total()) << edit;
  EXPECT_EQ(a.balance().edit_work(), b.balance().edit_work()) << edit;
  EXPECT_EQ(a.balance().energy_error(), b.balance().energy_error()) << edit;
  EXPECT_EQ(a.status(), b.status()) << edit;
}

struct NamedEdit {
  std::string name;
  Edit edit;
};

// Every edit fails, and what comes after is bitwise as if it had never been tried.
void expect_all_refused(const Scene& scene, const std::vector<NamedEdit>& edits) {
  const TetMesh mesh = mesh_of(scene);
  Session session(scene, mesh);
  Session untouched(scene, mesh);
  for (int k = 0; k < 3; ++k) {
    ASSERT_TRUE(session.step()) << session.message();
    ASSERT_TRUE(untouched.step());
  }
  for (const NamedEdit& edit : edits) {
    EXPECT_THROW(session.apply(edit.edit), std::exception) << edit.name;
    expect_all_same(session, untouched, edit.name);
    ASSERT_TRUE(session.step()) << edit.name << ": " << session.message();
    ASSERT_TRUE(untouched.step());
    expect_all_same(session, untouched, edit.name + ", and a step");
    EXPECT_EQ(session.reaction_force(), untouched.reaction_force()) << edit.name;
  }
}

Scene edited_scene(Integrator integrator) {
  Scene scene = spinning_block(integrator, 1e-3, 0.1);
  scene.environment.kind = EnvironmentKind::kGravity;
  scene.damping.drag = 1.0;
  FixSettings fix;
  fix.select = SelectVertices{{0}};
  fix.where = "fix.0";
  scene.fix = {fix};
  ConstraintSettings rod;
  rod.vertices = {2, 11};
  scene.constraint = {rod};
  scene.force = {load(SelectPlane{0, 2.0, {}}, {5.0, -2.0, 1.0})};
  return scene;
}

ConstraintSettings free_handle() {
  ConstraintSettings handle;
  handle.kind = ConstraintKind::kRigid;
  handle.select = SelectPlane{0, 1.0, {}};
  return handle;
}

MaterialSettings custom(const Scene& scene, CustomMaterial material) {
  MaterialSettings settings = scene.material;
  settings.custom = std::move(material);
  return settings;
}

// One or more for each kind of edit, wherever it can fail.
std::vector<NamedEdit> wrong_edits(const Scene& scene) {
  MaterialSettings heavier = scene.material;
  heavier.density = 2000.0;
  MaterialSettings impossible = scene.material;
  impossible.poissons_ratio = 0.7;
  TimeSettings too_many = scene.time;
  too_many.step = 1e-300;
  TimeSettings no_step = scene.time;
  no_step.step = kNan;
  SolverSettings unknown;
  unknown.kind = "lbfgs";
  EnvironmentSettings without_field;
  without_field.kind = EnvironmentKind::kCustom;
  EnvironmentSettings failing_field = without_field;
  failing_field.field = std::make_shared<FailingField>();
  ForceSettings nowhere = scene.force[0];
  nowhere.select = SelectPlane{1, 99.0, {}};
  ForceSettings not_finite = scene.force[0];
  not_finite.vector.x() = kNan;
  FixSettings elsewhere = scene.fix[0];
  elsewhere.target = Vector3(0.0, 5.0, 0.0);  // inverts elements
  FixSettings contradiction = scene.fix[0];
  contradiction.offset = Vector3(0.0, 1e-3, 0.0);
  FixSettings soft = scene.fix[0];
  soft.is_penalty = true;
  soft.penalty = -1.0;
  ConstraintSettings same_vertex = scene.constraint[0];
  same_vertex.vertices = {3, 3};
  ConstraintSettings unreachable = scene.constraint[0];
  unreachable.length = 0.5;  // beside the one there is
  ConstraintSettings over_the_fix = free_handle();
  over_the_fix.select = SelectPlane{0, 0.0, {}};
  MomentumSettings momentum;
  momentum.value.y() = kNan;
  MomentumSettings momentum_nowhere;
  momentum_nowhere.select = SelectPlane{1, 99.0, {}};
  ShiftSettings inverting;
  inverting.vertices = {5};
  inverting.displacement = {Vector3(-9.0, 0.0, 0.0)};
  ShiftSettings unknown_vertex = inverting;
  unknown_vertex.vertices = {99};
  ShiftSettings infinite;
  infinite.vertices = {5};
  infinite.impulse = {Vector3(kNan, 0.0, 0.0)};
  const auto fails = std::make_shared<bool>(false);  // not yet: a material is tried when it is made
  const MaterialSettings failing =
      custom(scene, CustomMaterial(FailingRubber(lame_from_young(1e5, 0.3), fails)));
  *fails = true;
  return {{"density", SetMaterial{0, heavier}},
          {"region", SetMaterial{3, scene.material}},
          {"Poisson's ratio", SetMaterial{0, impossible}},
          {"material that throws", SetMaterial{0, failing}},
          {"too many steps", SetTime{too_many}},
          {"step that is no number", SetTime{no_step}},
          {"solver", SetSolver{unknown}},
          {"damping", SetDamping{{-1.0, 0.0, 0.0}}},
          {"environment without field", SetEnvironment{without_field}},
          {"field that throws", SetEnvironment{failing_field}},
          {"force nowhere", SetForce{std::nullopt, nowhere}},
          {"force that is no number", SetForce{std::nullopt, not_finite}},
          {"force that is no number", SetForce{0, not_finite}},
          {"force number", SetForce{7, scene.force[0]}},
          {"fix elsewhere", SetFix{0, elsewhere}},
          {"fix twice", SetFix{std::nullopt, contradiction}},
          {"fix number", SetFix{7, scene.fix[0]}},
          {"penalty", SetFix{std::nullopt, soft}},
          {"unfix number", Unfix{SelectAll{}, {}, 7}},
          {"unfix nowhere", Unfix{SelectPlane{1, 99.0, {}}, {}, {}}},
          {"distance of one vertex", SetConstraint{std::nullopt, same_vertex}},
          {"another length", SetConstraint{std::nullopt, unreachable}},
          {"constraint number", SetConstraint{7, scene.constraint[0]}},
          {"handle over a fix", SetConstraint{std::nullopt, over_the_fix}},
          {"no such constraint", RemoveConstraint{7}},
          {"momentum", SetMomentum{momentum}},
          {"momentum nowhere", SetMomentum{momentum_nowhere}},
          {"inverting shift", ShiftState{inverting}},
          {"unknown vertex", ShiftState{unknown_vertex}},
          {"impulse that is no number", ShiftState{infinite}}};
}

class RefusedEdits : public testing::TestWithParam<Integrator> {};

INSTANTIATE_TEST_SUITE_P(Rules, RefusedEdits, testing::ValuesIn(all_rules()), name_of_rule);

TEST_P(RefusedEdits, OfEveryKindLeaveEverythingAsItWas) {
  const Scene scene = edited_scene(GetParam());
  expect_all_refused(scene, wrong_edits(scene));
}

// The stepper comes last: by then constraints, material or step are known to be right by themselves.
TEST(RefusedEdits, ThatNoStepperCanBeMadeForLeaveEverythingAsItWas) {
  const CustomMaterial rubber(FibreRubber(lame_from_young(1e5, 0.3), 1e3, 1.0, Vector3::UnitX()));
  Scene scene = edited_scene(Integrator::kMidpoint);
  scene.solver.linear = LinearSolver::kMatrixFree;
  expect_all_refused(scene, {{"free handle", SetConstraint{std::nullopt, free_handle()}},
                             {"custom material", SetMaterial{0, custom(scene, rubber)}}});

  scene = edited_scene(Integrator::kVerlet);
  scene.solver.linear = LinearSolver::kMatrixFree;
  scene.constraint.push_back(free_handle());
  TimeSettings implicit = scene.time;
  implicit.integrator = Integrator::kMidpoint;
  implicit.step = 2e-3;
  expect_all_refused(scene, {{"implicit rule", SetTime{implicit}}});

  scene = edited_scene(Integrator::kBackwardEuler);
  scene.constraint.push_back(free_handle());
  SolverSettings matrix_free;
  matrix_free.linear = LinearSolver::kMatrixFree;
  expect_all_refused(scene, {{"solver", SetSolver{matrix_free}}});
}

// A solver that does without a matrix knows the built-in materials only.
TEST(Edits, FromABuiltInToACustomMaterialTakeAnotherSolver) {
  for (const Integrator integrator : {Integrator::kMidpoint, Integrator::kBackwardEuler}) {
    Scene scene = spinning_block(integrator, 5e-3, 0.1);
    const CustomMaterial rubber(
        FibreRubber(lame_from_young(5e4, 0.3), 2e4, 2.0, Vector3(1.0, 1.0, 0.0)));
    Session by_default(scene, mesh_of(scene));
    scene.solver.linear = LinearSolver::kFactor;
    Session by_factor(scene, mesh_of(scene));
    const auto both_step = [&] { return by_default.step() && by_factor.step(); };
    for (int k = 0; k < 5; ++k) ASSERT_TRUE(both_step());
    EXPECT_EQ(by_default.linear_solver(), "matrix-free");
    for (Session* session : {&by_default, &by_factor}) {
      session->apply(SetMaterial{0, custom(scene, rubber)});
    }
    for (int k = 0; k < 5; ++k) ASSERT_TRUE(both_step()) << by_default.message();
    EXPECT_EQ(by_default.linear_solver(), "factor");
    // Quadratic convergence: the solver has the tangent of the material that is there.
    EXPECT_LE(by_default.last_iterations(), 5);
    for (Session* session : {&by_default, &by_factor}) {
      session->apply(SetMaterial{0, scene.material});
    }
    for (int k = 0; k < 5; ++k) ASSERT_TRUE(both_step());
    EXPECT_EQ(by_default.linear_solver(), "matrix-free");
    const Vector moved = by_factor.state().position - by_factor.system().rest_state().position;
    EXPECT_LT((by_default.state().position - by_factor.state().position).norm(),
              1e-7 * moved.norm());
  }
}

// The energy of the Gent model is defined only while Ī₁ − 3 is below its parameter jm.
TEST(Edits, ThatTakeAMaterialBeyondItsLimitAreRefused) {
  Scene scene;
  scene.mesh.generate = GeneratorSettings{GeneratorKind::kTetrahedron, {1.0, 1.0, 1.0}, {1, 1, 1}};
  scene.material = elastic(1e5, 0.3, 1000.0, "gent");
  set_number(scene.material, "jm", 5.0);
  scene.initial.stretch = {1.5, 1.0, 1.0};  // Ī₁ − 3 = (1.5² + 2)/1.5^(2/3) − 3 = 0.243
  scene.time = {Integrator::kMidpoint, 1e-4, false, 1e-3};
  const TetMesh mesh = mesh_of(scene);
  SetMaterial shorter{0, scene.material};
  set_number(shorter.material, "jm", 0.2);
  // The height above the opposite face becomes ten times as large, and so does the volume: Ī₁ is at
  // least 10²/15^(2/3) = 16.4.
  ShiftState longer;
  longer.change.vertices = {mesh.vertex_id(0)};
  longer.change.displacement = {
      9.0 * Vector3(1.5, 1.0, 1.0)
                .cwiseProduct(Vector3(mesh.vertices[0]) -
                              (mesh.vertices[1] + mesh.vertices[2] + mesh.vertices[3]) / 3.0)};
  const std::string told = "stretches element " + std::to_string(mesh.tetrahedron_id(0)) +
                           " beyond the limit of its material";
  for (const NamedEdit& edit : {NamedEdit{"jm", shorter}, NamedEdit{"shift", longer}}) {
    SCOPED_TRACE(edit.name);
    Session session(scene, mesh);
    const Vector start = session.state().position;
    try {
      session.apply(edit.edit);
      ADD_FAILURE() << "it was made";
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(told), std::string::npos) << error.what();
    }
    EXPECT_EQ(session.state().position, start);
    EXPECT_EQ(number_of(session.materials()[0], "jm"), 5.0);
    EXPECT_TRUE(session.step()) << session.message();

    // The same as an event of the scene.
    Scene with_event = scene;
    with_event.event.resize(1);
    with_event.event[0].edits = {edit.edit};
    Session run(with_event, mesh);
    EXPECT_FALSE(run.step());
    EXPECT_EQ(run.status(), RunStatus::kNotConverged);
    EXPECT_NE(run.message().find(told), std::string::npos) << run.message();
    EXPECT_EQ(run.state().position, start);
  }
  // A little less is allowed.
  Session session(scene, mesh);
  set_number(shorter.material, "jm", 0.3);
  session.apply(shorter);
  EXPECT_TRUE(session.step()) << session.message();
}

// A mesh on the caller's arrays has no list of ids: they count from 0.
TEST(Edits, WorkOnAMeshWithoutIds) {
  const TetMesh block = generate_box({2, 1, 1}, {2, 1, 1});
  std::vector<double> positions;
  std::vector<std::int64_t> tetrahedra;
  for (const Vector3 x : block.vertices) positions.insert(positions.end(), x.begin(), x.end());
  for (const auto nodes : block.tetrahedra) {
    for (const Index v : nodes) tetrahedra.push_back(v);
  }
  Scene scene = edited_scene(Integrator::kVerlet);
  FixSettings own;
  own.select = SelectVertices{{9, 3}};
  own.targets = {block.vertices[9], block.vertices[3]};
  scene.fix.push_back(own);
  Session viewed(scene, view_mesh(positions, tetrahedra));
  Session owned(scene, block);
  ShiftSettings shift;
  shift.vertices = {7, 5};
  shift.displacement = {Vector3(0.01, 0.0, 0.0), Vector3(0.0, 0.02, 0.0)};
  shift.impulse = {Vector3(1.0, 0.0, 0.0), Vector3(0.0, 0.0, 2.0)};
  for (Session* session : {&viewed, &owned}) {
    ASSERT_TRUE(session->step());
    session->apply(ShiftState{shift});
    ASSERT_TRUE(session->step());
  }
  EXPECT_EQ(viewed.state().position, owned.state().position);
  // Everything that names an element or a vertex.
  for (const NamedEdit& edit : wrong_edits(scene)) {
    std::string told[2];
    std::size_t i = 0;
    for (Session* session : {&viewed, &owned}) {
      try {
        session->apply(edit.edit);
      } catch (const std::exception& error) {
        told[i] = error.what();
      }
      ++i;
    }
    EXPECT_FALSE(told[0].empty()) << edit.name;
    EXPECT_EQ(told[0], told[1]) << edit.name;
  }
}

}  // namespace
}  // namespace tetraction
