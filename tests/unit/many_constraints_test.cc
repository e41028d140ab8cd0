// Many distances at once: the sparse equations have the same solution as a few dense ones.

#include <cmath>
#include <memory>
#include <string>
#include <utility>

#include "support/corner_scenes.h"
#include "tetraction/dynamics/constraints/multipliers.h"

namespace tetraction {
namespace {

using namespace testing_support;

// Rods along the edges of tetrahedra in a free beam; neighbours share vertices, and some rods are
// given twice.
class ManyDistances : public testing::Test {
 protected:
  static constexpr Index kCount = 160;

  ManyDistances()
      : mesh_(generate_box({4, 1, 1}, {16, 4, 4})),
        system_(mesh_, testing_support::all_materials()[1], 1000.0),
        rest_(mesh_.rest_positions()) {
    ConstraintList list;
    for (Index i = 0; i < kCount; ++i) {
      const auto nodes = mesh_.tetrahedra[static_cast<std::size_t>(5 * i)];
      list.distances.push_back({nodes[0], nodes[1], length(nodes[0], nodes[1]), ""});
      if (i % 20 == 0) list.distances.push_back(list.distances.back());
    }
    constraints_ = std::make_unique<Constraints>(std::move(list), mesh_, system_.mass());
    moved_ = rest_;
    for (Index i = 0; i < moved_.size(); ++i) {
      moved_[i] += 0.003 * std::sin(12.9898 * static_cast<double>(i + 1));
    }
  }
  double length(Index a, Index b) const {
    return (rest_.segment<3>(3 * a) - rest_.segment<3>(3 * b)).norm();
  }

  TetMesh mesh_;
  MechanicalSystem system_;
  Vector rest_;
  Vector moved_;
  std::unique_ptr<Constraints> constraints_;
};

TEST_F(ManyDistances, AreMetAlongEveryDirection) {
  const Constraints& c = *constraints_;
  const Vector start = c.configuration(rest_);
  const Vector free_end = c.configuration(moved_);
  for (const ConstraintDirection direction :
       {ConstraintDirection::kStart, ConstraintDirection::kMiddle, ConstraintDirection::kEnd}) {
    const MultiplierSolution sparse =
        solve_multipliers(c, free_end, c.sparse_inverse_mass(), start, direction);
    const MultiplierSolution dense =
        solve_multipliers(c, free_end, c.inverse_mass(), start, direction);
    for (const MultiplierSolution& solution : {sparse, dense}) {
      ASSERT_TRUE(solution.ok);
      EXPECT_LT(c.values(solution.end).cwiseAbs().maxCoeff(), 1e-12);
      const Vector w = direction == ConstraintDirection::kStart ? start
                       : direction == ConstraintDirection::kEnd
                           ? solution.end
                           : Vector(0.5 * (start + solution.end));
      const Vector force = c.gradients(w) * solution.multipliers;
      EXPECT_LT((force - solution.forces).norm(), 1e-9 * force.norm());
      EXPECT_LT((free_end + c.inverse_mass() * solution.forces - solution.end).norm(), 1e-9);
    }
    EXPECT_LT((sparse.end - dense.end).norm(), 1e-10);
    // Rods that are given twice share their force.
    EXPECT_NEAR(sparse.multipliers[0], sparse.multipliers[1],
                1e-5 * sparse.multipliers.cwiseAbs().maxCoeff());
  }
}

TEST_F(ManyDistances, PositionsAndMomentaAreProjected) {
  const Constraints& c = *constraints_;
  Vector q = moved_;
  ASSERT_EQ(project_positions(c, 0.0, q), "");
  EXPECT_LT(c.relative_error(q), 1e-11);
  EXPECT_LT((q - moved_).norm(), 2.0 * (moved_ - rest_).norm());
  Vector momentum(system_.dof_count());
  for (Index i = 0; i < momentum.size(); ++i) {
    momentum[i] = system_.mass()[i / 3] * std::sin(78.233 * static_cast<double>(i + 1));
  }
  const Vector before = momentum;
  project_to_constraints(c, system_.mass(), q, 0.0, momentum);
  const Vector rates =
      c.gradients(c.configuration(q)).transpose() * c.configuration(system_.velocity_of(momentum));
  EXPECT_LT(rates.cwiseAbs().maxCoeff(), 1e-9);
  // The projection is orthogonal in M⁻¹: what it takes away does no work on what is left.
  EXPECT_LT(std::abs((before - momentum).dot(system_.velocity_of(momentum))),
            1e-10 * before.dot(system_.velocity_of(before)));
}

Scene rods(int count, Integrator rule) {
  Scene scene = scene_of({GeneratorKind::kBeam, {4, 1, 1}, {16, 4, 4}}, elastic(1e6, 0.4));
  scene.initial.angular_velocity = {0.5, 0.2, 1.0};
  scene.time = {rule, 1e-4, false, 2e-3};
  const TetMesh mesh = mesh_of(scene);
  for (int i = 0; i < count; ++i) {
    const auto nodes = mesh.tetrahedra[static_cast<std::size_t>(5 * i)];
    ConstraintSettings& rod = scene.constraint.emplace_back();
    rod.kind = ConstraintKind::kDistance;
    rod.vertices = {nodes[0], nodes[1]};
  }
  return scene;
}

TEST(ManyRods, KeepTheirLengthsInARun) {
  for (const Integrator rule : {Integrator::kExplicit, Integrator::kVerlet}) {
    Scene scene = rods(150, rule);
    Session session(scene, mesh_of(scene));
    const Momenta start = session.balance().momenta();
    ASSERT_EQ(session.run(), RunStatus::kFinished) << session.message();
    EXPECT_LT(session.constraint_error(), 1e-12);
    const Momenta& end = session.balance().momenta();
    EXPECT_LT((end.angular - start.angular).norm(), 1e-12 * start.angular_scale);
    EXPECT_LT((end.linear - start.linear).norm(), 1e-12 * start.linear_scale);
  }
}

TEST(ManyRods, OnesThatAreGivenTwiceAreOneConstraintAndAWarning) {
  Scene once = rods(3, Integrator::kVerlet);
  Scene twice = once;
  twice.constraint.push_back(once.constraint[1]);
  std::swap(twice.constraint.back().vertices[0], twice.constraint.back().vertices[1]);
  Session one(once, mesh_of(once));
  Session two(twice, mesh_of(twice));
  EXPECT_FALSE(any_warning(one, "same distance"));
  EXPECT_TRUE(any_warning(two, "constraint.3 is the same distance as constraint.1"));
  EXPECT_EQ(two.system().constraints().equation_count(), 3);
  ASSERT_EQ(one.run(), RunStatus::kFinished);
  ASSERT_EQ(two.run(), RunStatus::kFinished);
  EXPECT_EQ(one.state().position, two.state().position);
  EXPECT_NE(one.tension(1), 0.0);
  EXPECT_DOUBLE_EQ(two.tension(1), 0.5 * one.tension(1));
  EXPECT_EQ(two.tension(3), two.tension(1));
  EXPECT_EQ(two.tension(2), one.tension(2));
}

TEST(ManyRods, ImplicitStepsRefuseMoreThanTheyCanSolve) {
  Scene scene = rods(0, Integrator::kMidpoint);
  scene.mesh.generate->cells = {20, 10, 10};
  const Index half = mesh_of(scene).vertex_count() / 2;
  for (Index i = 0; i < 1001; ++i) {
    ConstraintSettings& rod = scene.constraint.emplace_back();
    rod.kind = ConstraintKind::kDistance;
    rod.vertices = {i, i + half};
  }
  expect_error([&] { const Session session(scene, mesh_of(scene)); }, {"1001 equations"});
  scene.time.integrator = Integrator::kVerlet;
  EXPECT_NO_THROW(Session(scene, mesh_of(scene)));
}

}  // namespace
}  // namespace tetraction
