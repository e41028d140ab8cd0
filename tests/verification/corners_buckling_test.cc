// Buckling, snap-through and impacts: every linear solver and Ceres end in the same minima.
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "support/corner_scenes.h"

namespace tetraction {
namespace {

using namespace testing_support;

class Corner : public testing::TestWithParam<std::pair<std::string, SolverSettings>> {
 protected:
  Scene scene(double step, double end) const {
    Scene scene = scene_of(elastic(1e6, 0.4));
    scene.time = {Integrator::kBackwardEuler, step, false, end};
    scene.solver = GetParam().second;
    return scene;
  }
  static FixSettings held(double x, const Vector3& velocity = Vector3::Zero()) {
    return moving(SelectPlane{0, x, {}}, velocity);
  }
  static double elastic_energy(const Session& session) {
    double energy = 0.0;
    EXPECT_TRUE(session.system().elastic().value(session.state().position, energy).ok());
    return energy;
  }
};

INSTANTIATE_TEST_SUITE_P(Solvers, Corner, testing::ValuesIn(all_solvers()),
                         [](const auto& test) { return test.param.first; });

// A column is pressed together by an eighth of its length. The straight column's energy at the second
// of ten steps is 51.547 J, that of the buckled one 44.940 J.
TEST_P(Corner, ColumnsBuckle) {
  for (const double tolerance : {1e-8, 1e-4}) {
    Scene pressed = scene(1.0, 10.0);
    pressed.mesh.generate = GeneratorSettings{GeneratorKind::kBeam, {4, 0.2, 0.2}, {40, 2, 2}};
    pressed.fix = {held(0.0), held(4.0, {-0.05, 0, 0})};
    pressed.solver.tolerance = tolerance;
    Session session(pressed, generate_mesh(*pressed.mesh.generate));
    ASSERT_TRUE(session.step() && session.step()) << session.message();
    EXPECT_NEAR(elastic_energy(session), 44.940, 1e-2);
    while (session.step()) {
    }
    ASSERT_EQ(session.status(), RunStatus::kFinished) << session.message();
    EXPECT_NEAR(elastic_energy(session), 316.207, 1e-2);
    if (GetParam().second.kind == "ceres") break;
  }
}

// A shallow arch of 2 m span, 0.2 m high at its crown.
TetMesh arch() {
  TetMesh mesh = generate_box({2, 0.02, 0.1}, {32, 1, 2});
  for (Vector3& x : mesh.vertices.own()) x.y() += 0.2 * std::sin(0.5 * std::numbers::pi * x.x());
  return mesh;
}

// Pushed through at its crown, it gives way: the force falls from 5.15 N to 3.1 N before it rises.
TEST_P(Corner, ArchesGiveWay) {
  Scene pushed = scene(0.25, 3.0);
  FixSettings crown = held(1.0, {0, -0.11, 0});
  crown.components = {false, true, false};
  pushed.fix = {held(0.0), held(2.0), crown};
  const TetMesh mesh = arch();
  Session session(pushed, mesh);
  std::vector<double> force;
  while (session.step()) {
    force.push_back(0.0);
    for (const Index v : select_vertices(mesh, crown.select)) {
      force.back() -= session.reaction_force()[3 * v + 1];
    }
  }
  ASSERT_EQ(session.status(), RunStatus::kFinished) << session.message();
  ASSERT_EQ(force.size(), 12U);
  EXPECT_NEAR(force[2], 5.1536, 0.01);
  EXPECT_NEAR(force[7], 3.1431, 0.01);
  EXPECT_NEAR(force[11], 7.8394, 0.02);
}

// Under more than it bears it snaps through in a single step, over all that lies in between.
TEST_P(Corner, ArchesSnapThrough) {
  Scene loaded = scene(10.0, 20.0);
  ForceSettings force = load(SelectPlane{0, 1.0, {}}, {0.0, -1.0, 0.0});  // on each of six vertices
  loaded.force = {force};
  loaded.fix = {held(0.0), held(2.0)};
  const TetMesh mesh = arch();
  Session session(loaded, mesh);
  ASSERT_TRUE(session.step()) << session.message();
  while (session.step()) {
  }
  ASSERT_EQ(session.status(), RunStatus::kFinished) << session.message();
  for (const Index v : select_vertices(mesh, force.select)) {
    const double rest = mesh.vertices[static_cast<std::size_t>(v)].y();
    EXPECT_LT(session.state().position[3 * v + 1], rest - 0.3);
  }
  EXPECT_NEAR(elastic_energy(session), 1.223584, 1e-4);
}

// Thrown at a wall at three times the speed of sound: elements are pressed nearly flat in one step,
// and most of their Hessians are indefinite on the way.
TEST_P(Corner, ImpactsTakeFewIterations) {
  const bool newton = GetParam().second.kind == "newton";
  const struct {
    double step;
    double energy;
  } cases[] = {{0.1, 3.25859e6}, {0.05, 1.84558e6}};
  for (const auto& [step, energy] : cases) {
    Scene thrown = scene(step, step);
    thrown.mesh.generate = GeneratorSettings{GeneratorKind::kBeam, {4, 1, 1}, {16, 4, 4}};
    thrown.fix = {held(0.0)};
    thrown.initial.velocity = Vector3(-30.0, -100.0, 20.0);
    Session session(thrown, generate_mesh(*thrown.mesh.generate));
    ASSERT_TRUE(session.step()) << session.message();
    EXPECT_NEAR(elastic_energy(session), energy, 1e-5 * energy);
    if (newton) {
      EXPECT_LE(session.last_iterations(), 20) << step;
    }
  }
}

}  // namespace
}  // namespace tetraction
