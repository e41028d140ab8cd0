// Constraints are met by every rule, and their reactions balance.
#include <Eigen/Geometry>

#include <cmath>
#include <memory>
#include <optional>
#include <vector>

#include "support/runs.h"

namespace tetraction {
namespace {

using namespace testing_support;

class ConstrainedBy : public testing::TestWithParam<Integrator> {
 protected:
  bool implicit() const { return is_implicit(GetParam()); }

  // A soft block under gravity; its explicit limit is about 6 ms.
  Scene hanging_block(double end = 0.3) const {
    Scene scene = scene_of({GeneratorKind::kBox, {2, 1, 1}, {2, 1, 1}}, elastic(1e5, 0.3));
    scene.time = {GetParam(), implicit() ? 5e-3 : 1e-3, false, end};
    scene.environment.kind = EnvironmentKind::kGravity;
    return scene;
  }

  // Δp of every step is the impulse of loads and reactions.
  static void expect_balance(const Session& session, const Vector3& before, double tolerance) {
    Vector3 reaction = Vector3::Zero();
    const Vector& r = session.reaction_force();
    for (Index v = 0; v < session.system().vertex_count(); ++v) reaction += vertex_block(r, v);
    const Vector3 weight(0.0, -9.81 * session.system().total_mass(), 0.0);
    const Vector3 change = session.balance().momenta().linear - before;
    EXPECT_LT((change - session.time_step() * (weight + reaction)).norm(),
              tolerance * session.time_step() * weight.norm())
        << "step " << session.state().step;
  }
};

INSTANTIATE_TEST_SUITE_P(Rules, ConstrainedBy, testing::ValuesIn(all_rules()), name_of_rule);

TEST_P(ConstrainedBy, FixedVerticesAreBitwiseAtTheirTargetsAndReactionsBalance) {
  Scene scene = hanging_block();
  FixSettings fix = shifted(SelectPlane{0, 0.0, {}}, {0.01, 0.1, -0.02});
  scene.fix = {fix};
  // With backward Euler what a step leaves of the forces goes into the momentum: in 60 steps, here,
  // some ten times the tolerance.
  scene.solver.tolerance = 1e-9;
  const TetMesh mesh = mesh_of(scene);
  Session session(scene, mesh);
  while (true) {
    const Vector3 before = session.balance().momenta().linear;
    if (!session.step()) break;
    for (const Index v : select_vertices(mesh, fix.select)) {
      const Vector3 target = mesh.vertices[static_cast<std::size_t>(v)] + *fix.offset;
      EXPECT_EQ(Vector3(session.state().position.segment<3>(3 * v)), target);
    }
    EXPECT_EQ(session.constraint_error(), 0.0);
    expect_balance(session, before, GetParam() == Integrator::kBackwardEuler ? 1e-6 : 1e-10);
  }
  EXPECT_EQ(session.status(), RunStatus::kFinished) << session.message();
  EXPECT_EQ(session.balance().constraint_work(), 0.0);
  EXPECT_LT(session.balance().linear_momentum_drift(), implicit() ? 1e-8 : 1e-12);
}

TEST_P(ConstrainedBy, MovingTargetsAreMetExactlyAndTheirWorkIsInTheBooks) {
  Scene scene = hanging_block(0.5);
  scene.environment.kind = EnvironmentKind::kNone;
  FixSettings fix = moving(SelectPlane{0, 0.0, {}}, {0.3, 0.1, -0.2});
  scene.fix = {fix};
  scene.time.step *= 0.5;
  const TetMesh mesh = mesh_of(scene);
  Session session(scene, mesh);
  while (session.step()) {
    for (const Index v : select_vertices(mesh, fix.select)) {
      const Vector3 target =
          mesh.vertices[static_cast<std::size_t>(v)] + session.state().time * fix.velocity;
      EXPECT_EQ(Vector3(session.state().position.segment<3>(3 * v)), target);
      EXPECT_LT(
          (session.state().momentum.segment<3>(3 * v) - session.system().mass()[v] * fix.velocity)
              .norm(),
          1e-12);
    }
  }
  ASSERT_EQ(session.status(), RunStatus::kFinished) << session.message();
  // The body was taken along: the work of the grip is what it now has.
  const double gained =
      session.balance().energies().total() - 0.5 * (session.system().mass()[0] * 0.0);
  EXPECT_GT(session.balance().constraint_work(), 10.0);
  EXPECT_GT(gained, 0.0);
  const double tolerance = GetParam() == Integrator::kBackwardEuler ? 0.25 : 0.05;
  EXPECT_LT(session.balance().max_relative_energy_drift(), tolerance);
  EXPECT_LT(session.balance().linear_momentum_drift(), implicit() ? 1e-7 : 1e-12);
  if (GetParam() != Integrator::kBackwardEuler) {
    EXPECT_LT(session.balance().angular_momentum_drift(), implicit() ? 1e-7 : 1e-12);
  }
}

TEST_P(ConstrainedBy, VerticesStayOnSkewPlanesAndLines) {
  Scene scene = hanging_block();
  ConstraintSettings plane = on_plane(SelectPlane{1, 0.0, {}}, {0.0, 2.0, 1.0});
  plane.point = Vector3(0, 0, 0);
  ConstraintSettings line = on_line(SelectNearest{{2, 1, 1}}, {1.0, 1.0, -3.0});
  scene.constraint = {plane, line};
  const TetMesh mesh = mesh_of(scene);
  Session session(scene, mesh);
  const Vector3 normal = plane.direction.normalized();
  const Vector3 along = line.direction.normalized();
  const Index slider = select_vertices(mesh, line.select).front();
  const Vector3 start = session.state().position.segment<3>(3 * slider);
  while (true) {
    const Vector3 before = session.balance().momenta().linear;
    if (!session.step()) break;
    for (const Index v : select_vertices(mesh, plane.select)) {
      EXPECT_LT(std::abs(normal.dot(session.state().position.segment<3>(3 * v))), 1e-14);
      EXPECT_LT(std::abs(normal.dot(session.state().momentum.segment<3>(3 * v))), 1e-10);
    }
    const Vector3 moved = session.state().position.segment<3>(3 * slider) - start;
    EXPECT_LT(moved.cross(along).norm(), 1e-14);
    EXPECT_LT(session.constraint_error(), 1e-14);
    expect_balance(session, before, GetParam() == Integrator::kBackwardEuler ? 1e-6 : 1e-10);
  }
  ASSERT_EQ(session.status(), RunStatus::kFinished) << session.message();
  const Vector3 last = session.state().position.segment<3>(3 * slider);
  EXPECT_GT((last - start).norm(), 0.01);
}

TEST_P(ConstrainedBy, ADistanceIsKept) {
  Scene scene = hanging_block(0.5);
  scene.fix = {fix(SelectVertices{{0}})};
  ConstraintSettings rod = testing_support::rod(2, 11);  // opposite corners of the far half
  ConstraintSettings hanger = testing_support::rod(0, 8);
  scene.constraint = {rod, hanger};
  const TetMesh mesh = mesh_of(scene);
  Session session(scene, mesh);
  const auto length = [&](const ConstraintSettings& c) {
    return (session.state().position.segment<3>(3 * c.vertices[0]) -
            session.state().position.segment<3>(3 * c.vertices[1]))
        .norm();
  };
  const double rod_length = length(rod);
  const double hanger_length = length(hanger);
  double largest_tension = 0.0;
  while (true) {
    const Vector3 before = session.balance().momenta().linear;
    if (!session.step()) break;
    EXPECT_NEAR(length(rod), rod_length, 1e-10 * rod_length);
    EXPECT_NEAR(length(hanger), hanger_length, 1e-10 * hanger_length);
    expect_balance(session, before, GetParam() == Integrator::kBackwardEuler ? 1e-6 : 1e-10);
    largest_tension = std::max(largest_tension, std::abs(session.tension(1)));
  }
  ASSERT_EQ(session.status(), RunStatus::kFinished) << session.message();
  EXPECT_GT(largest_tension, 100.0);
  if (GetParam() == Integrator::kBackwardEuler) return;
  EXPECT_LT(session.balance().angular_momentum_drift(), implicit() ? 1e-6 : 1e-12);
  EXPECT_LT(session.balance().max_relative_energy_drift(), order(GetParam()) == 2 ? 0.02 : 0.1);
}

// Distances of all pairs of a set.
double largest_change_of_shape(const std::vector<Index>& vertices, const Vector& a,
                               const Vector& b) {
  double largest = 0.0;
  for (const Index v : vertices) {
    for (const Index w : vertices) {
      const double before = (a.segment<3>(3 * v) - a.segment<3>(3 * w)).norm();
      const double after = (b.segment<3>(3 * v) - b.segment<3>(3 * w)).norm();
      if (v != w) largest = std::max(largest, std::abs(after - before) / before);
    }
  }
  return largest;
}

class HandleBy : public ConstrainedBy {};

INSTANTIATE_TEST_SUITE_P(Rules, HandleBy, testing::ValuesIn(all_rules()), name_of_rule);

TEST_P(HandleBy, AFreeHandleStaysRigidWhileTheBodySpins) {
  // Free handles of rank 3 (a box of vertices), 2 (a face) and 1 (an edge).
  const std::vector<Selection> selections{SelectBox{{1, 0, 0}, {2, 1, 1}}, SelectPlane{0, 0.0, {}},
                                          SelectBox{{0, 0, 0}, {2, 0, 0}}};
  for (const Selection& selection : selections) {
    Scene scene = spinning_block(GetParam(), implicit() ? 5e-3 : 1e-3, 0.5);
    scene.solver.tolerance = 1e-10;
    ConstraintSettings handle = rigid(selection);
    scene.constraint = {handle};
    const TetMesh mesh = mesh_of(scene);
    const std::vector<Index> vertices = select_vertices(mesh, selection);
    Session session(scene, mesh);
    const Vector start = session.state().position;
    while (session.step()) {
      EXPECT_LT(largest_change_of_shape(vertices, start, session.state().position), 1e-10);
    }
    ASSERT_EQ(session.status(), RunStatus::kFinished) << session.message();
    if (GetParam() == Integrator::kBackwardEuler) continue;
    EXPECT_LT(session.balance().linear_momentum_drift(), 1e-12) << selection.index();
    EXPECT_LT(session.balance().angular_momentum_drift(), implicit() ? 1e-7 : 1e-12);
    EXPECT_LT(session.balance().max_relative_energy_drift(), order(GetParam()) == 2 ? 0.01 : 0.1);
    // The handle pulls at the rest of the body, but not from outside.
    Vector3 sum = Vector3::Zero();
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
      sum += session.reaction_force().segment<3>(3 * v);
    }
    EXPECT_LT(sum.norm(), 1e-9 * session.reaction_force().norm());
    EXPECT_GT(session.reaction_force().norm(), 1.0);
  }
}

TEST_P(HandleBy, ADrivenHandleFollowsItsMotion) {
  Scene scene = hanging_block(0.4);
  ConstraintSettings grip =
      driven(SelectPlane{0, 0.0, {}}, Vector3(0.0, 0.5, 0.0), Vector3(4.0, 0.0, 0.0));
  scene.constraint = {grip};
  const TetMesh mesh = mesh_of(scene);
  const std::vector<Index> vertices = select_vertices(mesh, grip.select);
  Session session(scene, mesh);
  const Vector start = session.state().position;
  const Vector3 center(0.0, 0.5, 0.5);
  while (true) {
    const Vector3 before = session.balance().momenta().linear;
    if (!session.step()) break;
    const double t = session.state().time;
    const Matrix3 r = Eigen::AngleAxisd(4.0 * t, Vector3::UnitX()).toRotationMatrix();
    for (const Index v : vertices) {
      // The centre is that of the face's area, whatever the masses of its vertices are.
      const Vector3 x = session.state().position.segment<3>(3 * v);
      const Vector3 x0 = start.segment<3>(3 * v);
      EXPECT_LT((center + t * *grip.velocity + r * (x0 - center) - x).norm(), 1e-13);
    }
    EXPECT_LT(largest_change_of_shape(vertices, start, session.state().position), 1e-12);
    EXPECT_LT(session.constraint_error(), 1e-13);
    expect_balance(session, before, GetParam() == Integrator::kBackwardEuler ? 1e-6 : 1e-9);
  }
  ASSERT_EQ(session.status(), RunStatus::kFinished) << session.message();
  EXPECT_GT(std::abs(session.balance().constraint_work()), 100.0);
  // The work of the grip is the energy of the body (to the rule's own error).
  EXPECT_LT(session.balance().max_relative_energy_drift(),
            GetParam() == Integrator::kBackwardEuler ? 0.3
            : GetParam() == Integrator::kExplicit    ? 0.1
                                                     : 0.02);
  if (GetParam() != Integrator::kBackwardEuler) {
    EXPECT_LT(session.balance().angular_momentum_drift(), implicit() ? 1e-6 : 1e-11);
  }
}

// The point that stays where it is if a handle turns: for a face the centre of its area, for tetrahedra their centre of
// mass, otherwise that of the lumped masses; or the point that the scene names.
TEST(DrivenHandle, TurnsAboutItsCentreOrAboutAPoint) {
  struct Case {
    Selection select;
    std::optional<Vector3> about;
    Vector3 expected;
  };
  Scene scene = scene_of({GeneratorKind::kBox, {2, 1, 1}, {4, 2, 2}}, elastic(1e5, 0.3));
  const TetMesh mesh = mesh_of(scene);
  // Three corners of the face x = 0, which are those of no triangle.
  const std::vector<Index> ends{select_vertices(mesh, SelectNearest{{0, 0, 0}}).front(),
                                select_vertices(mesh, SelectNearest{{0, 1, 1}}).front(),
                                select_vertices(mesh, SelectNearest{{0, 1, 0}}).front()};
  const std::unique_ptr<MechanicalSystem> system = make_system(scene, mesh);
  Vector3 of_masses = Vector3::Zero();
  double mass = 0.0;
  for (const Index v : ends) {
    of_masses += system->mass()[v] * mesh.vertices[static_cast<std::size_t>(v)];
    mass += system->mass()[v];
  }
  of_masses /= mass;
  const std::vector<Case> cases{
      {SelectPlane{0, 0.0, {}}, {}, Vector3(0.0, 0.5, 0.5)},
      {SelectPlane{0, 0.0, {}}, Vector3(0.1, -0.2, 0.3), Vector3(0.1, -0.2, 0.3)},
      {SelectAll{}, {}, Vector3(1.0, 0.5, 0.5)},
      {SelectVertices{{mesh.vertex_id(ends[0]), mesh.vertex_id(ends[1]), mesh.vertex_id(ends[2])}},
       {},
       of_masses}};
  for (const Case& c : cases) {
    SCOPED_TRACE(c.select.index());
    ConstraintSettings grip = driven(c.select, {}, Vector3(0.0, 0.0, 2.0));
    grip.point = c.about;
    scene.constraint = {grip};
    scene.time = {Integrator::kBackwardEuler, 0.01, false, 0.01};
    Session session(scene, mesh);
    const Vector start = session.state().position;
    ASSERT_TRUE(session.step()) << session.message();
    const Matrix3 r = Eigen::AngleAxisd(0.02, Vector3::UnitZ()).toRotationMatrix();
    for (const Index v : select_vertices(mesh, c.select)) {
      const Vector3 expected = c.expected + r * (Vector3(start.segment<3>(3 * v)) - c.expected);
      EXPECT_LT((expected - Vector3(session.state().position.segment<3>(3 * v))).norm(), 1e-13);
    }
  }
}

TEST(Pendulum, KeepsItsLengthOver100000Steps) {
  for (const Integrator integrator : {Integrator::kExplicit, Integrator::kMidpoint}) {
    // A small body hung from a distance of 1 m: one vertex held, its far end on a rod.
    Scene scene = scene_of({GeneratorKind::kTetrahedron, {1, 1, 1}, {1, 1, 1}}, elastic(1e6, 0.3));
    scene.time = {integrator, 2e-4, false, 20.0};
    scene.environment.kind = EnvironmentKind::kGravity;
    scene.fix = {fix(SelectVertices{{0}})};
    scene.constraint = {rod(0, 1)};
    Session session(scene, generate_tetrahedron());
    double worst = 0.0;
    double lowest = 0.0;
    while (session.step()) {
      const Vector3 end = session.state().position.segment<3>(3);
      worst = std::max(worst, std::abs(end.norm() - 1.0));
      lowest = std::min(lowest, end.y());
    }
    ASSERT_EQ(session.status(), RunStatus::kFinished) << session.message();
    EXPECT_EQ(session.state().step, 100000);
    EXPECT_LT(worst, 1e-10) << to_string(integrator);
    EXPECT_LT(lowest, -0.5) << "it swings";
    EXPECT_LT(session.balance().max_relative_energy_drift(), 0.05) << to_string(integrator);
  }
}

TEST(Pendulum, BackwardEulerSettlesAtLargeSteps) {
  // A rubber bar on a hinge with a rod inside, let go horizontally: the steps are up to 500 times the
  // explicit limit and a quarter of the period of the swing.
  for (const double step : {0.05, 0.2, 0.5}) {
    Scene scene = scene_of({GeneratorKind::kBeam, {1.0, 0.1, 0.1}, {16, 2, 2}}, elastic(5e5, 0.4));
    scene.time = {Integrator::kBackwardEuler, step, false, 60 * step};
    scene.environment.kind = EnvironmentKind::kGravity;
    scene.fix = {fix(SelectBox{{0.0, 0.1, 0.0}, {0.0, 0.1, 0.1}})};
    scene.constraint = {rod(85, 101)};
    FinishedRun session(scene);
    const Vector arm =
        session.state().position.segment<3>(3 * 101) - session.state().position.segment<3>(3 * 85);
    EXPECT_NEAR(arm.norm(), 1.0, 1e-12);
    EXPECT_LT(session.total_iterations(), 40 * session.state().step) << step;
    if (step > 0.1) {
      EXPECT_LT(arm.y(), -0.99);  // it hangs
    }
  }
}

TEST(Statics, AHeavyBeamOnFourFixedVerticesReportsItsWeight) {
  // Run to rest with backward Euler at a large step, which takes all motion out.
  Scene scene = scene_of({GeneratorKind::kBeam, {4, 1, 1}, {8, 2, 2}}, elastic(2e6, 0.4));
  scene.time = {Integrator::kBackwardEuler, 0.5, false, 60.0};
  scene.environment.kind = EnvironmentKind::kGravity;
  scene.solver.tolerance = 1e-10;
  FixSettings supports = fix(SelectVertices{{0, 8, 54 + 8 + 10, 54 + 10}});
  const TetMesh mesh = mesh_of(scene);
  std::vector<std::int64_t> corners;
  for (const Vector3& corner :
       {Vector3(0, 0, 0), Vector3(4, 0, 0), Vector3(0, 0, 1), Vector3(4, 0, 1)}) {
    corners.push_back(select_vertices(mesh, SelectNearest{corner}).front());
  }
  supports.select = SelectVertices{corners};
  scene.fix = {supports};
  FinishedRun session(scene, mesh);
  Vector3 sum = Vector3::Zero();
  for (const std::int64_t v : corners) {
    EXPECT_GT(session.reaction_force()[3 * v + 1], 0.0);
    sum += session.reaction_force().segment<3>(3 * v);
  }
  const double weight = 9.81 * session.system().total_mass();
  EXPECT_LT((sum - Vector3(0.0, weight, 0.0)).norm(), 1e-8 * weight);
}

TEST(Penalty, BlowsUpWhereTheExactConstraintRuns) {
  Scene scene = scene_of({GeneratorKind::kBox, {2, 1, 1}, {4, 2, 2}}, elastic(1e5, 0.3));
  scene.time = {Integrator::kExplicit, 1e-3, false, 1.0};
  scene.environment.kind = EnvironmentKind::kGravity;
  FixSettings fix = springs(SelectPlane{0, 0.0, {}}, 1e8);
  scene.fix = {fix};
  const TetMesh mesh = mesh_of(scene);
  Session springs(scene, mesh);
  EXPECT_LT(springs.initial_limit().critical_step, 1e-3);
  EXPECT_FALSE(springs.warnings().empty());
  EXPECT_EQ(springs.run(), RunStatus::kUnstable);
  scene.fix[0].is_penalty = false;
  Session exact(scene, mesh);
  EXPECT_EQ(exact.run(), RunStatus::kFinished) << exact.message();
  // With a step below the penalty's own limit, and implicitly, it holds to about force/(2γ).
  scene.fix[0].is_penalty = true;
  for (const Integrator integrator :
       {Integrator::kVerlet, Integrator::kMidpoint, Integrator::kBackwardEuler}) {
    scene.time = {integrator, is_implicit(integrator) ? 5e-3 : 1e-5, false, 0.05};
    FinishedRun gentle(scene, mesh);
    for (const Index v : select_vertices(mesh, fix.select)) {
      const Vector3 gap =
          gentle.state().position.segment<3>(3 * v) - mesh.vertices[static_cast<std::size_t>(v)];
      EXPECT_LT(gap.norm(), 1e-3);
    }
    if (integrator == Integrator::kBackwardEuler) continue;
    EXPECT_LT(gentle.balance().max_relative_energy_drift(), 0.02) << to_string(integrator);
    EXPECT_LT(gentle.balance().linear_momentum_drift(), 1e-10);
  }
}

}  // namespace
}  // namespace tetraction
