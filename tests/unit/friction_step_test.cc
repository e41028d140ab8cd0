// Friction in a step: derivatives, heat, and independence of the frame.
#include "dynamics/contact/friction/friction_step.h"

#include <Eigen/Geometry>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "core/decompositions.h"
#include "support/bodies.h"

namespace tetraction {
namespace {

using namespace testing_support;

constexpr double kFrictionBegin = 0.2;
constexpr double kFrictionStep = 0.01;
constexpr double kFrictionEnd = kFrictionBegin + kFrictionStep;
constexpr double kFriction = 0.4;
constexpr double kSlipSpeed = 0.3;

struct FrictionCase {
  std::string name;
  ObstacleShape shape;
  bool moves = false;
};

std::vector<FrictionCase> friction_cases() {
  const std::vector<std::pair<std::string, ObstacleShape>> shapes{
      {"plane", PlaneShape{{0.1, -0.05, 0.1}, {0.1, 1.0, 0.2}}},
      {"sphere", SphereShape{{0.15, -0.5, 0.12}, 0.47, false}},
      {"cylinder_inside", CylinderShape{{0.15, 0.1, 0.12}, {1.0, 0.2, -0.3}, 0.24, true}},
      {"room", RoomShape{{-0.06, -0.05, -0.04}, {0.38, 0.27, 0.33}}}};
  std::vector<FrictionCase> all;
  for (const auto& [name, shape] : shapes) {
    all.push_back({name, shape});
    all.push_back({name + "_that_moves", shape, true});
  }
  return all;
}

// A box near an obstacle with friction, in a step in which parts of it stick and others slip.
class FrictionSteps : public testing::TestWithParam<FrictionCase> {
 protected:
  FrictionSteps()
      : mesh_(generate_box({0.3, 0.2, 0.25}, {2, 2, 2})),
        mass_(Vector::Ones(mesh_.vertex_count())) {
    obstacle_.name = "wall";
    obstacle_.shape = GetParam().shape;
    obstacle_.thickness = 0.15;
    obstacle_.stiffness = 2e3;
    obstacle_.friction = kFriction;
    obstacle_.slip_speed = kSlipSpeed;
    obstacle_.surface = boundary_faces(mesh_);
    if (GetParam().moves) {
      obstacle_.motion.velocity = {0.7, -0.4, 0.2};
      obstacle_.motion.angular_velocity = {0.5, 1.8, -0.9};
      obstacle_.motion.about = {0.1, 0.3, -0.2};
    }
    start_ = moved_along(jiggled(mesh_.rest_positions(), 6e-3, 1), kFrictionBegin);
    // Slips of 0 to 0.6 m/s as the obstacle sees them.
    Vector seen = jiggled(mesh_.rest_positions(), 6e-3, 1);
    seen = jiggled(seen, 0.4 * kFrictionStep, 2);
    end_ = moved_along(seen, kFrictionEnd);
  }
  // Positions in the frame of the obstacle, at a time.
  Vector moved_along(Vector x, double time) const {
    const ObstacleFrame frame = frame_at(obstacle_.motion, time);
    for (Index v = 0; v < mesh_.vertex_count(); ++v) {
      vertex_block(x, v) = frame.to_world(vertex_block(x, v));
    }
    return x;
  }
  Vector velocity() const { return (end_ - start_) / kFrictionStep; }
  // The step with the normal forces of its end.
  FrictionStep step(const Contact& contact, NormalForces forces) const {
    FrictionStep step;
    step.begin(contact, start_, kFrictionBegin, kFrictionEnd, forces);
    step.take(mass_, end_);
    return step;
  }
  Vector forces(const FrictionStep& step, const Vector& v) const {
    Vector sum = Vector::Zero(v.size());
    step.for_each_force(v, [&](std::size_t, Index vertex, const Vector3& force) {
      vertex_block(sum, vertex) += force;
    });
    return sum;
  }

  TetMesh mesh_;
  Vector mass_;
  Obstacle obstacle_;
  Vector start_;
  Vector end_;
};

TEST_P(FrictionSteps, HaveForcesThatAreTheDerivativesOfTheirPotential) {
  const Contact contact(mesh_, {obstacle_});
  for (const NormalForces kind : {NormalForces::kEnd, NormalForces::kMean}) {
    const FrictionStep step = this->step(contact, kind);
    ASSERT_FALSE(step.is_idle());
    const Vector v = velocity();
    Vector gradient = Vector::Zero(v.size());
    step.add_gradient(v, gradient);
    EXPECT_GT(gradient.norm(), 0.1);
    EXPECT_EQ(gradient, -forces(step, v));
    HessianBlocks hessian;
    hessian.reset(mesh_.vertex_count());
    step.add_hessian(v, hessian);
    constexpr double kMove = 1e-5;
    for (Index i = 0; i < v.size(); ++i) {
      Vector ahead = v;
      Vector behind = v;
      ahead[i] += kMove;
      behind[i] -= kMove;
      const double slope = (step.potential(ahead) - step.potential(behind)) / (2.0 * kMove);
      EXPECT_NEAR(gradient[i], slope, 1e-8 * gradient.norm()) << i;
      Vector change = Vector::Zero(v.size());
      step.add_gradient(ahead, change);
      change = -change;
      step.add_gradient(behind, change);
      Vector column = Vector::Zero(v.size());
      hessian.add_product(Vector::Unit(v.size(), i), column);
      EXPECT_LT((column + change / (2.0 * kMove)).norm(), 1e-4 * (1.0 + column.norm())) << i;
    }
    for (Index w = 0; w < mesh_.vertex_count(); ++w) {
      EXPECT_GT(symmetric_eigen(Matrix(hessian.diagonal(w))).values.minCoeff(), -1e-10);
    }
  }
}

// Coulomb's law: no force is larger than μ times the normal force, and it is that large where the slip is fast.
TEST_P(FrictionSteps, KeepCoulombsLaw) {
  if (GetParam().name.starts_with("room")) return;  // a vertex may touch several walls
  const Contact contact(mesh_, {obstacle_});
  const FrictionStep step = this->step(contact, NormalForces::kEnd);
  Vector normal = Vector::Zero(end_.size());
  contact.add_gradient({mass_, end_, kFrictionEnd}, normal);
  const Vector rubbing = forces(step, velocity());
  for (Index v = 0; v < mesh_.vertex_count(); ++v) {
    EXPECT_LE(vertex_block(rubbing, v).norm(),
              kFriction * vertex_block(normal, v).norm() * (1.0 + 1e-12));
  }
  const Vector fast = forces(step, 1e4 * jiggled(Vector::Zero(end_.size()), 1.0, 3));
  for (Index v = 0; v < mesh_.vertex_count(); ++v) {
    const double most = kFriction * vertex_block(normal, v).norm();
    EXPECT_NEAR(vertex_block(fast, v).norm(), most, 1e-9 * most);
    EXPECT_NEAR(vertex_block(fast, v).dot(vertex_block(normal, v)), 0.0, 1e-9 * most * most);
  }
}

TEST_P(FrictionSteps, MakeHeatOfTheWorkThatTheyTake) {
  const Contact contact(mesh_, {obstacle_});
  for (const NormalForces kind : {NormalForces::kEnd, NormalForces::kMean}) {
    const FrictionStep step = this->step(contact, kind);
    for (const unsigned seed : {4U, 5U, 6U}) {
      const Vector v = velocity() + jiggled(Vector::Zero(end_.size()), 0.5, seed);
      const FrictionPower power = step.power(v);
      EXPECT_GT(power.dissipated, 0.0);
      // What friction does to the body is the work of obstacles less the heat.
      EXPECT_NEAR(forces(step, v).dot(v), power.of_obstacles - power.dissipated,
                  1e-12 * (power.dissipated + std::abs(power.of_obstacles)));
      if (!GetParam().moves) {
        EXPECT_LT(std::abs(power.of_obstacles), 1e-12 * power.dissipated);
      }
    }
  }
}

// What moves with the obstacle does not slip, however the obstacle moves.
TEST_P(FrictionSteps, DoNothingToWhatMovesWithTheObstacle) {
  const Contact contact(mesh_, {obstacle_});
  end_ = moved_along(jiggled(mesh_.rest_positions(), 6e-3, 1), kFrictionEnd);
  const FrictionStep step = this->step(contact, NormalForces::kMean);
  ASSERT_FALSE(step.is_idle());
  EXPECT_LT(step.power(velocity()).dissipated, 1e-20);
  EXPECT_LT(forces(step, velocity()).norm(), 1e-10);
}

// A common rigid motion of body and obstacle changes neither the heat nor, seen by the obstacle, the forces.
TEST_P(FrictionSteps, AreIndependentOfTheFrame) {
  if (!GetParam().moves) return;  // compared by the case that moves
  const Contact contact(mesh_, {obstacle_});
  Obstacle resting = obstacle_;
  resting.motion = {};
  const Contact at_rest(mesh_, {resting});
  const ObstacleFrame begin = frame_at(obstacle_.motion, kFrictionBegin);
  const ObstacleFrame end = frame_at(obstacle_.motion, kFrictionEnd);
  Vector start_seen = start_;
  Vector end_seen = end_;
  for (Index v = 0; v < mesh_.vertex_count(); ++v) {
    vertex_block(start_seen, v) = begin.to_local(vertex_block(start_, v));
    vertex_block(end_seen, v) = end.to_local(vertex_block(end_, v));
  }
  for (const NormalForces kind : {NormalForces::kEnd, NormalForces::kMean}) {
    const FrictionStep step = this->step(contact, kind);
    FrictionStep seen;
    seen.begin(at_rest, start_seen, kFrictionBegin, kFrictionEnd, kind);
    seen.take(mass_, end_seen);
    const Vector v = velocity();
    const Vector v_seen = (end_seen - start_seen) / kFrictionStep;
    const double heat = seen.power(v_seen).dissipated;
    EXPECT_GT(heat, 1e-3);
    EXPECT_NEAR(step.power(v).dissipated, heat, 1e-11 * heat);
    const Vector force = forces(step, v);
    const Vector force_seen = forces(seen, v_seen);
    for (Index w = 0; w < mesh_.vertex_count(); ++w) {
      const Vector3 turned = end.rotation * vertex_block(force_seen, w);
      EXPECT_LT((vertex_block(force, w) - turned).norm(), 1e-10 * force.norm());
    }
  }
}

// The part of the derivative that the normal forces have, on a wall whose normal does not turn.
TEST_P(FrictionSteps, KnowHowTheNormalForcesChange) {
  // The normals of round walls are kept.
  if (!std::holds_alternative<PlaneShape>(GetParam().shape)) return;
  const Contact contact(mesh_, {obstacle_});
  const Vector v = velocity();
  for (const NormalForces kind : {NormalForces::kEnd, NormalForces::kMean}) {
    FrictionStep step = this->step(contact, kind);
    constexpr double kRate = 2.0;
    LoadStiffness stiffness;
    step.add_force_stiffness(v, kRate, stiffness);
    constexpr double kMove = 1e-6;
    for (Index i = 0; i < end_.size(); ++i) {
      Vector x = end_;
      Vector change = Vector::Zero(v.size());
      x[i] = end_[i] - kMove;
      step.take(mass_, x);
      step.add_gradient(v, change);
      change = -change;
      x[i] = end_[i] + kMove;
      step.take(mass_, x);
      step.add_gradient(v, change);
      Vector column = Vector::Zero(v.size());
      stiffness.add_product(Vector::Unit(v.size(), i), column);
      EXPECT_LT((column - kRate * change / (2.0 * kMove)).norm(), 1e-5 * (1.0 + column.norm()))
          << i;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Cases, FrictionSteps, testing::ValuesIn(friction_cases()),
                         [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace tetraction
