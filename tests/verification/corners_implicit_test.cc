// Implicit steps in the corners: thin bodies whose forces drown in the round-off of positions, steps of
// any length at rest and in free fall, prescribed motion of more than an element a step.
#include <algorithm>
#include <cmath>

#include "support/corner_scenes.h"

namespace tetraction {
namespace {

using namespace testing_support;

class ImplicitCorner : public testing::TestWithParam<RuleWithSolver> {
 protected:
  Scene with_way(Scene scene, double step, double end) const {
    scene.time = {GetParam().integrator, step, false, end};
    scene.solver = GetParam().solver;
    return scene;
  }
  bool midpoint() const { return GetParam().integrator == Integrator::kMidpoint; }
  bool ceres() const { return GetParam().solver.kind == "ceres"; }
};

INSTANTIATE_TEST_SUITE_P(All, ImplicitCorner, testing::ValuesIn(implicit_rules_with_solvers()),
                         name_with_solver);

// Bodies that come to rest, or that the midpoint rule itself would invert: with backward Euler alone.
class RestCorner : public ImplicitCorner {};
std::vector<RuleWithSolver> ways_to_rest() {
  std::vector<RuleWithSolver> ways = implicit_rules_with_solvers();
  std::erase_if(
      ways, [](const RuleWithSolver& way) { return way.integrator != Integrator::kBackwardEuler; });
  return ways;
}

INSTANTIATE_TEST_SUITE_P(All, RestCorner, testing::ValuesIn(ways_to_rest()), name_with_solver);

// A steel sheet a two-thousandth as thick as it is long, standing on its narrow side.
Scene steel_sheet() {
  Scene scene = clamped_beam({1, 0.1, 0.0005}, {50, 5, 1});
  scene.material.youngs_modulus = 210e9;
  scene.material.poissons_ratio = 0.3;
  scene.material.density = 7800.0;
  scene.environment.kind = EnvironmentKind::kGravity;
  return scene;
}

// At rest the clamp carries the weight. Positions that are rounded by half a unit of the last digit change
// the forces by 5.7e-5 of their scale (PotentialProblem::round_off()), and the last digits depend on the
// processor's instructions: no step may end with more than four times as much.
TEST_P(RestCorner, AThinSheetHasItsWeightInTheClamp) {
  const Scene scene = with_way(steel_sheet(), 0.1, 8.0);
  Session session(scene, mesh_of(scene));
  while (session.step()) {
    // Not a step is taken for converged at its beginning while the sheet moves.
    if (session.state().step < 5) {
      EXPECT_GT(session.last_iterations(), 0);
    }
  }
  ASSERT_EQ(session.status(), RunStatus::kFinished) << session.message();
  const double weight = session.system().total_mass() * 9.81;
  EXPECT_NEAR(total_reaction(session).y(), weight, 1e-6 * weight);
  EXPECT_LE(session.balance().residual_over_tolerance() * GetParam().solver.tolerance, 4 * 5.7e-5);
}

// Across the sheet the weight is a small difference of large stresses, and the tolerance is out of
// reach. The run goes on with what double precision leaves, and the balance says so.
TEST_P(RestCorner, AToleranceOutOfReachIsTold) {
  if (GetParam().solver.linear == LinearSolver::kCg) {
    GTEST_SKIP() << "conjugate gradients with the diagonal give up before: they say so";
  }
  Scene scene = with_way(steel_sheet(), 0.1, 3.0);
  scene.environment.direction = {0.0, 0.0, -1.0};
  FinishedRun session(scene);
  const double weight = session.system().total_mass() * 9.81;
  EXPECT_NEAR(total_reaction(session).z(), weight, 1e-4 * weight);
  EXPECT_GT(session.balance().steps_limited_by_round_off(), 0);
  EXPECT_GT(session.balance().residual_over_tolerance(), 1.0);
  EXPECT_LT(session.balance().residual_over_tolerance(), 1e5);
  const auto tells = [](const std::string& warning) {
    return warning.find("solver.tolerance") != std::string::npos;
  };
  EXPECT_TRUE(std::any_of(session.warnings().begin(), session.warnings().end(), tells));
}

// One flat tetrahedron in a beam, its fourth vertex 1e-9 of its edges above the plane of the others.
TEST(ImplicitRoundOff, ASliverDoesNotMoveTheTip) {
  Scene scene = clamped_beam({4, 1, 1}, {8, 2, 2});
  scene.environment.kind = EnvironmentKind::kGravity;
  scene.time = {Integrator::kBackwardEuler, 0.5, false, 30.0};
  const TetMesh good = mesh_of(scene);
  const auto tip = [&](const TetMesh& mesh) {
    Session session(scene, mesh);
    EXPECT_EQ(session.run(), RunStatus::kFinished) << session.message();
    double sum = 0.0;
    for (Index v = 0; v < good.vertex_count(); ++v) {
      const Vector3 rest = good.vertices[static_cast<std::size_t>(v)];
      if (rest.x() == 4.0) sum += session.state().position[3 * v + 1] - rest.y();
    }
    return sum;
  };
  std::vector<double> positions;
  std::vector<std::int64_t> tetrahedra;
  std::array<std::int64_t, 3> face{-1, -1, -1};
  for (Index v = 0; v < good.vertex_count(); ++v) {
    const Vector3 x = good.vertices[static_cast<std::size_t>(v)];
    positions.insert(positions.end(), {x.x(), x.y(), x.z()});
    if (x == Vector3(1.5, 1.0, 0.5)) face[0] = v;
    if (x == Vector3(2.0, 1.0, 1.0)) face[1] = v;
    if (x == Vector3(2.5, 1.0, 0.5)) face[2] = v;
  }
  ASSERT_TRUE(face[0] >= 0 && face[1] >= 0 && face[2] >= 0);
  for (Index e = 0; e < good.tetrahedron_count(); ++e) {
    for (const Index v : good.tetrahedra[static_cast<std::size_t>(e)]) tetrahedra.push_back(v);
  }
  // The sliver stands on the top face and has next to no volume.
  positions.insert(positions.end(), {2.0, 1.0 + 1e-9, 0.7});
  tetrahedra.insert(tetrahedra.end(), {face[0], face[1], face[2], good.vertex_count()});
  const double expected = tip(good);
  const double found = tip(view_mesh(positions, tetrahedra));
  EXPECT_NEAR(found, expected, 1e-5 * std::abs(expected));
}

// A step of any length under gravity: at rest where the clamp holds the body, in free fall where
// nothing does.
TEST_P(RestCorner, HugeStepsUnderGravity) {
  for (const double step : {1e2, 1e5, 1e7}) {
    Scene scene = clamped_beam({4, 1, 1}, {8, 2, 2});
    scene.environment.kind = EnvironmentKind::kGravity;
    scene = with_way(scene, step, 5.0 * step);
    Session session(scene, mesh_of(scene));
    int later = 0;
    while (session.step()) {
      if (session.state().step > 2) later += session.last_iterations();
    }
    ASSERT_EQ(session.status(), RunStatus::kFinished) << step << ": " << session.message();
    const double weight = session.system().total_mass() * 9.81;
    EXPECT_NEAR(total_reaction(session).y(), weight, 1e-6 * weight) << step;
    // The body is at rest after a step or two: nothing is left to do.
    EXPECT_LE(later, 3) << step;
  }
}

TEST_P(ImplicitCorner, FreeFallWithHugeSteps) {
  for (const double step : {1.0, midpoint() ? 1e2 : 1e4}) {
    Scene scene = clamped_beam({4, 1, 1}, {8, 2, 2});
    scene.fix.clear();
    scene.environment.kind = EnvironmentKind::kGravity;
    scene = with_way(scene, step, 2.0 * step);
    Session session(scene, mesh_of(scene));
    ASSERT_EQ(session.run(), RunStatus::kFinished) << step << ": " << session.message();
    const double speed = 9.81 * 2.0 * step;
    const double mass = session.system().total_mass();
    EXPECT_NEAR(session.balance().momenta().linear.y(), -mass * speed, 1e-9 * mass * speed);
  }
}

// Turned and pushed by more than an element a step, the end takes the body along.
TEST_P(ImplicitCorner, PrescribedMotionOfMoreThanAnElementAStep) {
  Scene scene = clamped_beam({4, 1, 1}, {16, 4, 4});
  scene.constraint.push_back(driven(SelectPlane{0, 4.0, {}}, {},
                                    Vector3(0.4 * 3.14159265358979, 0.0, 0.0)));  // 72° a second
  if (ceres()) scene.mesh.generate->cells = {8, 2, 2};  // 25 times as slow
  scene = with_way(scene, midpoint() ? 0.25 : 1.0, 1.0);
  FinishedRun session(scene);
  EXPECT_LT(session.constraint_error(), 1e-10);
  // The middle has turned about half as far: St Venant's torsion of a prism.
  double turn = 0.0;
  Index count = 0;
  const TetMesh& mesh = session.system().mesh();
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    const Vector3 rest = mesh.vertices[static_cast<std::size_t>(v)];
    const Vector3 arm = rest - Vector3(2.0, 0.5, 0.5);
    if (std::abs(arm.x()) > 1e-9 || arm.norm() < 0.3) continue;
    const Vector3 now = session.state().position.segment<3>(3 * v) - Vector3(2.0, 0.5, 0.5);
    turn +=
        std::atan2(arm.y() * now.z() - arm.z() * now.y(), arm.y() * now.y() + arm.z() * now.z());
    ++count;
  }
  if (!midpoint()) {
    EXPECT_NEAR(turn / static_cast<double>(count), 0.2 * 3.14159265358979, 0.1);
  }
}

TEST_P(RestCorner, ABeamPushedTogetherByTwoElementsAStep) {
  Scene scene = clamped_beam({4, 1, 1}, {16, 4, 4});
  if (ceres()) scene.mesh.generate->cells = {8, 2, 2};
  scene.fix.push_back(moving(SelectPlane{0, 4.0, {}}, {-1.0, 0.0, 0.0}));
  scene = with_way(scene, 0.5, 1.0);
  FinishedRun session(scene);
  EXPECT_EQ(session.constraint_error(), 0.0);
}

// A steel strip a thousand times as long as it is thick, that nothing holds, under a force that is below
// the round-off of its stresses: it is moved and turned all the same.
TEST(ImplicitRoundOff, TinyForcesMoveAFreeStrip) {
  for (const char* kind : {"newton", "ceres"}) {
    Scene scene = clamped_beam({1, 0.001, 0.001}, {10, 1, 1});
    scene.fix.clear();
    scene.material.youngs_modulus = 2e11;
    scene.material.poissons_ratio = 0.3;
    scene.material.density = 7800.0;
    scene.force.push_back(load(SelectPlane{0, 1.0, {}}, {0.0, -2.5e-7, 0.0}));
    scene.solver.kind = kind;
    scene.time = {Integrator::kBackwardEuler, 1.0, false, 20.0};
    Session session(scene, mesh_of(scene));
    ASSERT_EQ(session.run(), RunStatus::kFinished) << kind << ": " << session.message();
    EXPECT_NEAR(session.balance().momenta().linear.y(), -2e-5, 1e-9) << kind;
  }
}

class FlatElements : public testing::TestWithParam<std::string> {};

// Bars of flat and long elements under small loads: small strains, so that all materials agree.
TEST_P(FlatElements, CarryTheirWeight) {
  for (const double thickness : {0.002, 0.01}) {
    Scene scene = clamped_beam({1, thickness, thickness}, {20, 1, 1});
    scene.material.model = GetParam();
    scene.material.youngs_modulus = 2e11;
    scene.material.poissons_ratio = 0.3;
    scene.material.density = 7800.0;
    if (GetParam() == "mooney-rivlin") scene.material.numbers["ratio"] = 0.5;
    scene.environment.kind = EnvironmentKind::kGravity;
    scene.time = {Integrator::kBackwardEuler, 1.0, false, 10.0};
    Session session(scene, mesh_of(scene));
    ASSERT_EQ(session.run(), RunStatus::kFinished) << thickness << ": " << session.message();
    const double weight = session.system().total_mass() * 9.81;
    EXPECT_NEAR(total_reaction(session).y(), weight, 1e-5 * weight) << thickness;
  }
}

INSTANTIATE_TEST_SUITE_P(Materials, FlatElements,
                         testing::Values("stvk", "neo-hookean", "mooney-rivlin"), name_of_rule);

// I₂ as a sum of squares: the guess of inertia alone stretches the body by 10⁹, and its energy must not
// come out lower than that of a body at rest.
TEST(LargeSteps, MooneyRivlinComesToRestWithAnyStep) {
  double expected = 0.0;
  for (const double step : {10.0, 1e4, 1e6}) {
    Scene scene = clamped_beam({4, 1, 1}, {8, 2, 2});
    scene.material.model = "mooney-rivlin";
    scene.material.numbers["ratio"] = 0.3;
    scene.environment.kind = EnvironmentKind::kGravity;
    scene.time = {Integrator::kBackwardEuler, step, false, 10.0 * step};
    Session session(scene, mesh_of(scene));
    ASSERT_EQ(session.run(), RunStatus::kFinished) << step << ": " << session.message();
    const double elastic = session.balance().energies().elastic();
    if (expected == 0.0) expected = elastic;
    EXPECT_NEAR(elastic, expected, 1e-3 * expected) << step;
  }
}

}  // namespace
}  // namespace tetraction
