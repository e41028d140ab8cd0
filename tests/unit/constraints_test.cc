#include "tetraction/dynamics/constraints/constraints.h"

#include <cmath>
#include <numeric>

#include "support/bodies.h"
#include "support/messages.h"
#include "tetraction/dynamics/constraints/multipliers.h"

namespace tetraction {
namespace {

using namespace testing_support;

class ConstraintsOfABlock : public testing::Test {
 protected:
  const TetMesh mesh_ = generate_box({2, 1, 1}, {2, 1, 1});
  const MechanicalSystem system_{mesh_, all_materials()[1], 1000.0};
  const Vector rest_ = mesh_.rest_positions();

  Constraints make(ConstraintList list) const { return {std::move(list), mesh_, system_.mass()}; }

  // The message of the refusal.
  std::string refusal(ConstraintList list) const {
    return message_of([&] { make(std::move(list)); }, "");
  }

  PrescribedVertices held(std::vector<Index> vertices, const std::string& name) const {
    return prescribe_at_rest(mesh_, std::move(vertices), name);
  }
  RigidHandle handle(std::vector<Index> vertices, const std::string& name) const {
    return {vertices, held(vertices, name).start, name};
  }
};

TEST_F(ConstraintsOfABlock, PrescribedMotionIsARotationAboutItsMovingCentre) {
  PrescribedMotion motion;
  motion.since = 1.0;
  motion.center = {1.0, 0.0, 0.0};
  motion.velocity = {0.0, 0.0, 2.0};
  motion.angular_velocity = {0.0, 0.0, 0.5 * 3.14159265358979323846};
  const Vector3 start(2.0, 0.0, 0.0);
  EXPECT_EQ(motion.position(start, 1.0), start);
  EXPECT_LT((motion.position(start, 2.0) - Vector3(1.0, 1.0, 2.0)).norm(), 1e-15);
  const double h = 1e-6;
  const Vector3 rate =
      (motion.position(start, 1.7 + h) - motion.position(start, 1.7 - h)) / (2.0 * h);
  EXPECT_LT((motion.rate(start, 1.7) - rate).norm(), 1e-9);
}

TEST_F(ConstraintsOfABlock, RefusesContradictionsByName) {
  PrescribedVertices moved = held({0, 1}, "fix.1");
  moved.start.col(0) += Vector3::UnitX();
  const std::string twice = refusal({{held({0}, "fix.0"), moved}, {}, {}, {}});
  EXPECT_NE(twice.find("fix.0"), std::string::npos) << twice;
  EXPECT_NE(twice.find("fix.1"), std::string::npos);
  EXPECT_NE(twice.find("vertex 0"), std::string::npos);

  GuidedVertices guide{{0}, Matrix(Vector3::UnitX()), Vector3(0.0, 0.5, 0.0), "constraint.0"};
  const std::string apart = refusal({{held({0}, "fix.0")}, {guide}, {}, {}});
  EXPECT_NE(apart.find("constraint.0"), std::string::npos) << apart;

  const std::string both = refusal({{held({0}, "fix.0")}, {}, {}, {handle({0, 1, 2}, "grip")}});
  EXPECT_NE(both.find("grip"), std::string::npos) << both;
  const std::string shared =
      refusal({{}, {}, {}, {handle({0, 1, 2}, "left"), handle({2, 3, 4}, "right")}});
  EXPECT_NE(shared.find("left"), std::string::npos) << shared;
  EXPECT_NE(shared.find("right"), std::string::npos);

  EXPECT_NE(refusal({{}, {}, {{3, 3, 1.0, "rod"}}, {}}).find("rod"), std::string::npos);
  EXPECT_NE(refusal({{}, {}, {{3, 4, 0.0, "rod"}}, {}}).find("above 0"), std::string::npos);
  EXPECT_NE(refusal({{}, {}, {}, {handle({5}, "grip")}}).find("grip"), std::string::npos);
}

TEST_F(ConstraintsOfABlock, AllVerticesMayBeHeld) {
  std::vector<Index> all(12);
  std::iota(all.begin(), all.end(), 0);
  const double length = (rest_.segment<3>(6) - rest_.segment<3>(15)).norm();
  const Constraints constraints = make({{held(all, "all")}, {}, {{2, 5, length, "rod"}}, {}});
  EXPECT_EQ(constraints.coordinates().count(), 0);
  EXPECT_TRUE(constraints.inverse_mass().isZero(0.0));
  Vector q = jiggled(rest_, 0.02);
  EXPECT_EQ(project_positions(constraints, 0.0, q), "");
  EXPECT_EQ(q, rest_);
  Vector momentum = jiggled(Vector::Zero(36), 1.0);
  project_to_constraints(constraints, system_.mass(), q, 0.0, momentum);
  EXPECT_TRUE(momentum.isZero(0.0));
}

// Two motions of one vertex agree where those of its prescribed components do.
TEST_F(ConstraintsOfABlock, MotionsThatAgreeInTheComponentsTheyShareAreAllowed) {
  PrescribedVertices along_x = held({0, 1}, "along x");
  along_x.motion.velocity = {0.3, 0.0, 0.0};
  PrescribedVertices sides = held({0, 1}, "sides");
  sides.components = {false, true, true};
  const Constraints both = make({{along_x, sides}, {}, {}, {}});
  EXPECT_EQ(both.coordinates().count(), 3 * 10);
  Vector q = rest_;
  both.prescribe(2.0, q);
  EXPECT_NEAR(q[0] - rest_[0], 0.6, 1e-15);
  EXPECT_EQ(q[1], rest_[1]);

  sides.motion.velocity = {7.0, 0.0, 0.0};  // of a component that it does not hold
  EXPECT_EQ(refusal({{along_x, sides}, {}, {}, {}}), "");
  sides.motion.velocity = {0.0, 0.1, 0.0};
  EXPECT_NE(refusal({{along_x, sides}, {}, {}, {}}).find("different targets"), std::string::npos);

  // A turn about x leaves x alone, and all of a vertex on its axis.
  PrescribedVertices turning = held({4, 7}, "turning");
  turning.motion.angular_velocity = {2.0, 0.0, 0.0};
  turning.motion.center = rest_.segment<3>(12);
  PrescribedVertices still = held({4, 7}, "still");
  still.components = {true, false, false};
  EXPECT_EQ(refusal({{turning, still}, {}, {}, {}}), "");
  still.components = {false, true, false};
  PrescribedVertices moved_center = turning;
  moved_center.motion.center += Vector3(0.0, 0.2, 0.0);
  EXPECT_NE(refusal({{moved_center, still}, {}, {}, {}}), "");
  still.vertices = {4};
  still.start = rest_.segment<3>(12);
  EXPECT_EQ(refusal({{turning, still}, {}, {}, {}}), "");

  // The same turn, told from two moments and centres on its axis.
  PrescribedVertices later = turning;
  later.motion.since = 0.5;
  later.motion.center.x() += 3.0;
  for (Index i = 0; i < 2; ++i) {
    later.start.col(i) = turning.motion.position(turning.start.col(i), 0.5);
  }
  EXPECT_EQ(refusal({{turning, later}, {}, {}, {}}), "");
  later.motion.angular_velocity *= 1.1;
  EXPECT_NE(refusal({{turning, later}, {}, {}, {}}), "");
}

// Whether two places are the same is judged by the size of the body, whatever the unit.
TEST_F(ConstraintsOfABlock, TargetsAreComparedOnTheScaleOfTheBody) {
  for (const double scale : {1e-9, 1.0, 1e3}) {
    const TetMesh mesh = generate_box({2 * scale, scale, scale}, {2, 1, 1});
    const auto refused = [&](const Vector3& shift) {
      PrescribedVertices first = prescribe_at_rest(mesh, {1}, "first");
      GuidedVertices on_line{{1}, Matrix(Vector3::UnitX()), Matrix(first.start), "line"};
      on_line.points.colwise() += scale * shift;
      PrescribedVertices second = first;
      second.start.colwise() += scale * shift;
      bool held_refused = false;
      bool line_refused = false;
      try {
        Constraints({{first, second}, {}, {}, {}}, mesh, system_.mass());
      } catch (const InputError&) {
        held_refused = true;
      }
      try {
        Constraints({{first}, {on_line}, {}, {}}, mesh, system_.mass());
      } catch (const InputError&) {
        line_refused = true;
      }
      EXPECT_EQ(held_refused, line_refused) << scale;
      return held_refused;
    };
    EXPECT_FALSE(refused({0.0, 1e-15, 0.0})) << scale;
    EXPECT_TRUE(refused({0.0, 1e-3, 0.0})) << scale;
  }
}

// A distance of 1 mm with masses of mg beside a handle of 1 m and tonnes.
TEST_F(ConstraintsOfABlock, MultipliersOfDifferentScaleAreNotTakenForRedundant) {
  const double length = 1e-4 * (rest_.segment<3>(6) - rest_.segment<3>(15)).norm();
  Vector mass = system_.mass();
  for (const Index v : {2, 5}) mass[v] *= 1e-9;
  const Constraints constraints(
      {{}, {}, {{2, 5, length, "rod"}}, {handle({0, 3, 6, 9, 1}, "grip")}}, mesh_, mass);
  Vector start = constraints.configuration(rest_);
  start.tail<3>() *= 1e-4;
  ASSERT_LT(constraints.values(start).cwiseAbs().maxCoeff(), 1e-12);
  Vector free_end = start;
  free_end.head(9) = jiggled(start.head(9), 0.05);
  free_end.tail<3>() = jiggled(start.tail<3>(), 0.1 * length);
  for (const ConstraintDirection direction :
       {ConstraintDirection::kStart, ConstraintDirection::kEnd}) {
    const MultiplierSolution solution =
        solve_multipliers(constraints, free_end, constraints.inverse_mass(), start, direction);
    ASSERT_TRUE(solution.ok);
    EXPECT_LT(constraints.values(solution.end).cwiseAbs().maxCoeff(), 1e-13);
    const Vector moved = free_end + constraints.inverse_mass() * solution.forces - solution.end;
    EXPECT_LT(moved.head(9).norm(), 1e-10);
    EXPECT_LT(moved.tail<3>().norm(), 1e-10 * length);
  }
  Vector momentum = jiggled(Vector::Zero(36), 1.0);
  for (Index v = 0; v < 12; ++v) momentum.segment<3>(3 * v) *= mass[v];
  Vector q = rest_;
  ASSERT_EQ(project_positions(constraints, 0.0, q), "");
  project_to_constraints(constraints, mass, q, 0.0, momentum);
  Vector velocity = momentum;
  for (Index i = 0; i < velocity.size(); ++i) velocity[i] /= mass[i / 3];
  const Vector w = constraints.configuration(q);
  const Vector rates = constraints.gradients(w).transpose() * constraints.configuration(velocity);
  EXPECT_LT(rates.head(6).norm(), 1e-12);
  EXPECT_LT(length * std::abs(rates[6]), 1e-12);
}

TEST_F(ConstraintsOfABlock, ConsistentRepetitionsAreAllowed) {
  const Constraints twice = make({{held({0, 1}, "a"), held({1, 2}, "b")}, {}, {}, {}});
  EXPECT_EQ(twice.coordinates().count(), 3 * 9);
  // A line within a plane within a held component: one direction is left.
  Matrix plane(3, 2);
  plane << 1, 0, 0, 1, 0, 0;
  GuidedVertices on_plane{{4}, plane, rest_.segment<3>(12), "plane"};
  GuidedVertices on_line{{4}, Matrix(Vector3::UnitX()), rest_.segment<3>(12), "line"};
  PrescribedVertices z = held({4}, "z");
  z.components = {false, false, true};
  EXPECT_EQ(make({{z}, {on_plane, on_line}, {}, {}}).coordinates().count(), 3 * 11 + 1);
}

TEST_F(ConstraintsOfABlock, RedundantDistancesShareAndContradictoryOnesAreNamed) {
  const double length = (rest_.segment<3>(6) - rest_.segment<3>(15)).norm();
  const Constraints redundant = make({{}, {}, {{2, 5, length, "one"}, {2, 5, length, "two"}}, {}});
  Vector q = jiggled(rest_, 0.02);
  EXPECT_EQ(project_positions(redundant, 0.0, q), "");
  EXPECT_NEAR((q.segment<3>(6) - q.segment<3>(15)).norm(), length, 1e-12);

  const Constraints contradictory =
      make({{}, {}, {{2, 5, length, "one"}, {2, 5, 2.0 * length, "two"}}, {}});
  q = rest_;
  EXPECT_EQ(project_positions(contradictory, 0.0, q), "two");
  // Both ends held: nothing can be moved.
  const Constraints stuck = make({{held({2, 5}, "fix")}, {}, {{2, 5, 1.5 * length, "rod"}}, {}});
  q = rest_;
  EXPECT_EQ(project_positions(stuck, 0.0, q), "rod");
  // Also without a name.
  const Constraints unnamed = make({{held({2, 5}, "")}, {}, {{2, 5, 1.5 * length, ""}}, {}});
  q = rest_;
  EXPECT_EQ(project_positions(unnamed, 0.0, q), "the distance of vertices 2 and 5");
}

TEST_F(ConstraintsOfABlock, GradientsAndCurvatureAreDerivatives) {
  const Constraints constraints =
      make({{}, {}, {{2, 5, 0.7, "rod"}}, {handle({0, 3, 6, 9}, "face"), handle({1, 4}, "edge")}});
  ASSERT_EQ(constraints.configuration_size(), 6 + 3 + 3);
  ASSERT_EQ(constraints.equation_count(), 3 + 1 + 1);
  const Vector w = constraints.configuration(jiggled(rest_, 0.1));
  const Matrix gradients = constraints.gradients(w);
  const Vector multipliers = Vector::LinSpaced(5, 1.0, 2.0);
  const Matrix curvature = constraints.curvature(multipliers);
  const double h = 1e-6;
  for (Index i = 0; i < w.size(); ++i) {
    const Vector e = h * Vector::Unit(w.size(), i);
    const Vector slope = (constraints.values(w + e) - constraints.values(w - e)) / (2.0 * h);
    EXPECT_LT((gradients.row(i).transpose() - slope).norm(), 1e-8);
    const Vector bend =
        (constraints.gradients(w + e) - constraints.gradients(w - e)) * multipliers / (2.0 * h);
    EXPECT_LT((curvature.col(i) - bend).norm(), 1e-7);
  }
}

TEST_F(ConstraintsOfABlock, ProjectionLeavesNoRateAndIsIdempotent) {
  PrescribedVertices moving = held({7}, "mover");
  moving.motion.velocity = {1.0, -2.0, 0.5};
  const Constraints constraints =
      make({{moving},
            {},
            {{2, 7, 0.0 + (rest_.segment<3>(6) - rest_.segment<3>(21)).norm(), "rod"}},
            {handle({0, 3, 6, 9}, "face")}});
  const Vector q = rest_;
  Vector p = jiggled(Vector::Zero(q.size()), 50.0);
  project_to_constraints(constraints, system_.mass(), q, 0.0, p);
  const Vector rates = constraints.gradients(constraints.configuration(q)).transpose() *
                       constraints.configuration(system_.velocity_of(p));
  EXPECT_LT(rates.norm(), 1e-14);
  EXPECT_EQ(Vector3(p.segment<3>(21)), Vector3(system_.mass()[7] * moving.motion.velocity));
  Vector again = p;
  project_to_constraints(constraints, system_.mass(), q, 0.0, again);
  EXPECT_LT((again - p).norm(), 1e-13 * p.norm());
}

TEST_F(ConstraintsOfABlock, MultipliersMeetTheConstraintsInBothDirections) {
  const Constraints constraints =
      make({{},
            {},
            {{2, 5, (rest_.segment<3>(6) - rest_.segment<3>(15)).norm(), "rod"}},
            {handle({0, 3, 6, 9, 1}, "grip")}});
  const Vector start = constraints.configuration(rest_);
  const Vector free_end = jiggled(start, 0.05);
  for (const double softness : {1e-12, 1.0, 1e9}) {
    const Matrix response = softness * constraints.inverse_mass();
    for (const ConstraintDirection direction :
         {ConstraintDirection::kStart, ConstraintDirection::kEnd}) {
      const MultiplierSolution solution =
          solve_multipliers(constraints, free_end, response, start, direction);
      ASSERT_TRUE(solution.ok);
      EXPECT_LT(constraints.values(solution.end).cwiseAbs().maxCoeff(), 1e-13);
      EXPECT_LT((free_end + response * solution.forces - solution.end).norm(), 1e-10);
      const Vector at = direction == ConstraintDirection::kStart ? start : solution.end;
      EXPECT_LT((constraints.gradients(at) * solution.multipliers - solution.forces).norm(),
                1e-12 * solution.forces.norm());
    }
  }
  // Backward Euler's direction has a solution wherever the step would go; the other has not.
  Vector far = start;
  far.tail<3>() = Vector3(-3.0, 5.0, 1.0);
  EXPECT_TRUE(solve_multipliers(constraints, far, constraints.inverse_mass(), start,
                                ConstraintDirection::kEnd)
                  .ok);
  const MultiplierSolution lost = solve_multipliers(constraints, far, constraints.inverse_mass(),
                                                    start, ConstraintDirection::kStart);
  EXPECT_FALSE(lost.ok);
  EXPECT_EQ(constraints.name_of_equation(lost.worst), "rod");
}

}  // namespace
}  // namespace tetraction
