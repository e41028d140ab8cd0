// Buckling, snap-through and impacts: every linear solver and Ceres end in the same minima.
#include <cmath>
#include <numbers>
#include <string>

#include "support/bodies.h"
#include "tetraction/simulation/session.h"

namespace tetraction {
namespace {

struct Choice {
  std::string name;
  std::string kind;
  LinearSolver linear = LinearSolver::kAuto;
};

class Corner : public testing::TestWithParam<Choice> {
 protected:
  Scene scene(double step, double end) const {
    Scene scene;
    scene.material.youngs_modulus = 1e6;
    scene.material.poissons_ratio = 0.4;
    scene.material.density = 1000.0;
    scene.time = {Integrator::kBackwardEuler, step, false, end};
    scene.solver.kind = GetParam().kind;
    scene.solver.linear = GetParam().linear;
    return scene;
  }
  static FixSettings fix(double x, const Vector3& velocity = Vector3::Zero()) {
    FixSettings fix;
    fix.select = SelectPlane{0, x, {}};
    fix.velocity = velocity;
    return fix;
  }
  static double elastic(const Session& session) {
    double energy = 0.0;
    EXPECT_TRUE(session.system().elastic().value(session.state().position, energy).ok());
    return energy;
  }
};

INSTANTIATE_TEST_SUITE_P(Solvers, Corner,
                         testing::Values(Choice{"auto", "newton", LinearSolver::kAuto},
                                         Choice{"matrixfree", "newton", LinearSolver::kMatrixFree},
                                         Choice{"cg", "newton", LinearSolver::kCg},
                                         Choice{"factor", "newton", LinearSolver::kFactor},
                                         Choice{"ceres", "ceres", LinearSolver::kAuto}),
                         [](const auto& test) { return test.param.name; });

// A column is pressed together by an eighth of its length. The straight column's energy at the second
// of ten steps is 51.547 J, that of the buckled one 44.940 J.
TEST_P(Corner, ColumnsBuckle) {
  for (const double tolerance : {1e-8, 1e-4}) {
    Scene pressed = scene(1.0, 10.0);
    pressed.mesh.generate = GeneratorSettings{GeneratorKind::kBeam, {4, 0.2, 0.2}, {40, 2, 2}};
    pressed.fix = {fix(0.0), fix(4.0, {-0.05, 0, 0})};
    pressed.solver.tolerance = tolerance;
    Session session(pressed, generate_mesh(*pressed.mesh.generate));
    ASSERT_TRUE(session.step() && session.step()) << session.message();
    EXPECT_NEAR(elastic(session), 44.940, 1e-2);
    while (session.step()) {
    }
    ASSERT_EQ(session.status(), RunStatus::kFinished) << session.message();
    EXPECT_NEAR(elastic(session), 316.207, 1e-2);
    if (GetParam().kind == "ceres") break;
  }
}

// A shallow arch is pushed through at its crown and snaps to the other side: the force on the crown
// changes its sign on the way.
TEST_P(Corner, ArchesSnapThrough) {
  Scene pushed = scene(0.25, 4.0);
  pushed.mesh.generate = GeneratorSettings{GeneratorKind::kBox, {2, 0.05, 0.1}, {24, 1, 2}};
  TetMesh mesh = generate_mesh(*pushed.mesh.generate);
  for (Vector3& x : mesh.vertices.own()) x.y() += 0.15 * std::sin(0.5 * std::numbers::pi * x.x());
  FixSettings crown = fix(1.0, {0, -0.1, 0});
  crown.components = {false, true, false};
  pushed.fix = {fix(0.0), fix(2.0), crown};
  Session session(pushed, mesh);
  double most = 0.0;
  double push = 0.0;
  double pull = 0.0;
  while (session.step()) {
    most = std::max(most, elastic(session));
    double force = 0.0;
    for (const Index v : select_vertices(mesh, crown.select)) {
      force += session.reaction_force()[3 * v + 1];
    }
    push = std::min(push, force);
    pull = std::max(pull, force);
  }
  ASSERT_EQ(session.status(), RunStatus::kFinished) << session.message();
  EXPECT_LT(push, -0.1);
  EXPECT_GT(pull, 0.1);
  RecordProperty("most", std::to_string(most));
  RecordProperty("last", std::to_string(elastic(session)));
}

// Thrown at a wall at three times the speed of sound: elements are pressed nearly flat in one step,
// and most of their Hessians are indefinite on the way.
TEST_P(Corner, ImpactsTakeFewIterations) {
  const bool newton = GetParam().kind == "newton";
  const struct {
    double step;
    double energy;
  } cases[] = {{0.1, 3.25859e6}, {0.05, 1.84558e6}};
  for (const auto& [step, energy] : cases) {
    Scene thrown = scene(step, step);
    thrown.mesh.generate = GeneratorSettings{GeneratorKind::kBeam, {4, 1, 1}, {16, 4, 4}};
    thrown.fix = {fix(0.0)};
    thrown.initial.velocity = Vector3(-30.0, -100.0, 20.0);
    Session session(thrown, generate_mesh(*thrown.mesh.generate));
    ASSERT_TRUE(session.step()) << session.message();
    EXPECT_NEAR(elastic(session), energy, 1e-5 * energy);
    if (newton) {
      EXPECT_LE(session.last_iterations(), 20) << step;
    }
  }
}

}  // namespace
}  // namespace tetraction
