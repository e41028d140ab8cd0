// Equilibria in which the forces of distances and rigid handles turn with the body.
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "support/runs.h"
#include "tetraction/mesh/edge_vertices.h"
#include "tetraction/simulation/equilibrium.h"
#include "tetraction/simulation/scene_modes.h"
#include "tetraction/solver/normal_modes.h"

namespace tetraction {
namespace {

using namespace testing_support;

ConstraintSettings handle(Selection select) {
  return rigid(std::move(select));
}

Scene beam(const Vector3& size, const std::array<int, 3>& cells, double youngs_modulus) {
  Scene scene = scene_of({GeneratorKind::kBeam, size, cells}, elastic(youngs_modulus, 0.3));
  scene.fix = {fix(SelectPlane{0, 0.0, {}})};
  return scene;
}

struct Solver {
  std::string name;
  std::string kind;
};

class ConstrainedEquilibrium : public testing::TestWithParam<Solver> {
 protected:
  void solve(Session& session) const {
    ASSERT_EQ(session.run(), RunStatus::kFinished) << session.message();
    EXPECT_TRUE(session.load_path()->limit_points.empty()) << session.message();
    expect_balance(session);
  }
  Session session(Scene scene, const TetMesh& mesh) const {
    scene.solver.kind = GetParam().kind;
    return {scene, mesh, Analysis::kEquilibrium};
  }

  // All forces from outside and all their moments sum to zero.
  static void expect_balance(const Session& session) {
    const Vector& x = session.state().position;
    Vector forces = session.external_force() + session.reaction_force();
    const MechanicalSystem& system = session.system();
    for (const ForceTerm* term : system.force_terms()) {
      if (!term->has_potential() || term->account() != EnergyAccount::kStored) continue;
      Vector gradient = Vector::Zero(x.size());
      term->add_gradient(system.force_point(x, 0.0), gradient);
      forces -= gradient;
    }
    Vector3 force = Vector3::Zero();
    Vector3 moment = Vector3::Zero();
    double size = 0.0;
    for (Index v = 0; 3 * v < x.size(); ++v) {
      const Vector3 each = forces.segment<3>(3 * v);
      force += each;
      moment += x.segment<3>(3 * v).cross(each);
      size += each.norm();
    }
    EXPECT_LT(force.norm(), 1e-9 * size);
    EXPECT_LT(moment.norm(), 1e-8 * size);
  }
};

INSTANTIATE_TEST_SUITE_P(Solvers, ConstrainedEquilibrium,
                         testing::Values(Solver{"newton", "newton"}, Solver{"ceres", "ceres"}),
                         [](const auto& test) { return test.param.name; });

Vector3 displacement(const Session& session, const Vector3& point) {
  const TetMesh& mesh = session.system().mesh();
  const Index v = select_vertices(mesh, SelectNearest{point}).front();
  return session.state().position.segment<3>(3 * v) - mesh.vertices[static_cast<std::size_t>(v)];
}

// An archer's bow: a string from the clamp to the free corner is shortened. A string turns with its end, so that
// the bow carries some four times the pull that it carries as a dead load.
TEST_P(ConstrainedEquilibrium, BowBendsUnderItsString) {
  Scene scene = beam({3, 1, 1}, {6, 2, 2}, 2e5);
  ConstraintSettings string = rod(0, 62, 2.9);
  scene.constraint = {string};
  Session session = this->session(scene, generate_mesh(*scene.mesh.generate));
  ASSERT_NO_FATAL_FAILURE(solve(session));
  EXPECT_LT(session.constraint_error(), 1e-11);
  EXPECT_GT(session.tension(0), 0.0);
  // Small motions about it are vibrations, with the force in the string.
  NormalModeOptions options;
  options.count = 1;
  options.multipliers =
      balancing_multipliers(session.system(), session.state().position, session.external_force());
  EXPECT_GT(
      normal_modes(session.system(), session.state().position, options).modes[0].omega_squared,
      0.0);
}

// Bodies of one mesh, each at its height.
TetMesh stack(const std::vector<TetMesh>& bodies, const std::vector<double>& heights) {
  RawMesh raw;
  raw.source = "stack";
  for (std::size_t k = 0; k < bodies.size(); ++k) {
    append_body(raw, bodies[k], Vector3(0.0, 0.0, heights[k]));
  }
  return build_mesh(std::move(raw));
}

// A block on four struts, which springs keep from falling over. With the weight W on struts of the length L, the
// stiffness k of the springs is lessened by W/L, and a small force F moves the block by F/(k − W/L).
TEST_P(ConstrainedEquilibrium, StrutsUnderABlockOnSprings) {
  constexpr double kLength = 0.5;  // of the struts
  const TetMesh block = generate_box({1, 1, 1}, {2, 2, 2});
  const TetMesh mesh = stack({generate_box({1, 1, 0.5}, {2, 2, 1}), block}, {0.0, 0.5 + kLength});
  Scene scene = scene_of(elastic(1e9, 0.3));
  scene.environment = gravity(9.81, {0, 0, -1});
  scene.fix = {fix(SelectBox{{-1, -1, -1}, {2, 2, 0.51}})};
  for (const double x : {0.0, 1.0}) {
    for (const double y : {0.0, 1.0}) {
      scene.constraint.push_back(
          rod(select_vertices(mesh, SelectNearest{{x, y, 0.5}}).front(),
              select_vertices(mesh, SelectNearest{{x, y, 0.5 + kLength}}).front()));
    }
  }
  const double weight = 9.81 * 1000.0;
  const double stiffness = 3.0 * weight / kLength;  // 1.5 would let the block turn about z
  scene.fix.push_back(springs(SelectBox{{-1, -1, 0.9}, {2, 2, 3}},
                              0.5 * stiffness / static_cast<double>(block.vertices.size())));
  scene.force = {total_load(SelectBox{{-1, -1, 0.9}, {2, 2, 3}}, {1e-3 * weight, 0, 0})};
  Session session = this->session(scene, mesh);
  ASSERT_NO_FATAL_FAILURE(solve(session));
  const Vector3 moved = displacement(session, {0.5, 0.5, 1.5});
  EXPECT_NEAR(moved.x() * (stiffness - weight / kLength) / (1e-3 * weight), 1.0, 2e-3);
}

// The pressure on the end of a bar, which a rigid handle keeps plane.
TEST_P(ConstrainedEquilibrium, PressureOnARigidEnd) {
  Scene scene = beam({2, 1, 1}, {3, 1, 1}, 1e6);
  scene.constraint = {handle(SelectPlane{0, 2.0, {}})};
  scene.pressure = {pressure(SelectPlane{0, 2.0, {}}, 2e5)};
  Session session = this->session(scene, generate_mesh(*scene.mesh.generate));
  ASSERT_NO_FATAL_FAILURE(solve(session));
  // The pressure acts along the normal of the plane end, whose area does not change.
  const Vector& load = session.external_force();
  Vector3 sum = Vector3::Zero();
  for (Index v = 0; 3 * v < load.size(); ++v) sum += load.segment<3>(3 * v);
  EXPECT_NEAR(sum.norm(), 2e5, 1e-6 * 2e5);
}

// So large a pressure that loads do not settle if the potential is minimised again and again.
TEST_P(ConstrainedEquilibrium, LargePressureOnARigidEnd) {
  Scene scene = beam({2, 1, 1}, {2, 1, 1}, 1e6);
  scene.constraint = {handle(SelectPlane{0, 2.0, {}})};
  scene.pressure = {pressure(SelectPlane{0, 2.0, {}}, 3e5)};
  const TetMesh mesh = with_edge_vertices(generate_mesh(*scene.mesh.generate));
  Session session = this->session(scene, mesh);
  ASSERT_NO_FATAL_FAILURE(solve(session));
  Session other(scene, mesh, Analysis::kEquilibrium, 0.1);  // another solver and another path
  ASSERT_NO_FATAL_FAILURE(solve(other));
  const double energy = other.balance().energies().elastic();
  EXPECT_NEAR(session.balance().energies().elastic(), energy, 1e-9 * energy);
}

// A pull that follows the end and a force across it. The result was found independently, by Newton's method on
// the whole saddle-point system.
TEST_P(ConstrainedEquilibrium, PullAndForceOnARigidEnd) {
  Scene scene = beam({10, 1, 1}, {10, 1, 1}, 1e6);
  scene.constraint = {handle(SelectPlane{0, 10.0, {}})};
  scene.pressure = {pressure(SelectPlane{0, 10.0, {}}, -5000)};
  scene.force = {total_load(SelectPlane{0, 10.0, {}}, {0, 200, 0})};
  Session session = this->session(scene, with_edge_vertices(generate_mesh(*scene.mesh.generate)));
  ASSERT_NO_FATAL_FAILURE(solve(session));
  EXPECT_NEAR(displacement(session, {10, 0, 0}).y(), 1.362, 5e-4);
}

}  // namespace
}  // namespace tetraction
