#include "dynamics/steppers/rotated_guess.h"

#include <Eigen/Geometry>

#include <Eigen/Geometry>
#include <cmath>

#include "support/bodies.h"
#include "tetraction/dynamics/body_sums.h"

namespace tetraction {
namespace {

using namespace testing_support;

// A body that turns about the axis z through its centre.
struct Spinning {
  explicit Spinning(double speed)
      : system(generate_box({2, 1, 0.5}, {4, 2, 2}), all_materials()[1], 1000.0),
        center(center_of_mass(system, system.mesh().rest_positions())) {
    state.position = system.mesh().rest_positions();
    state.momentum.resize(state.position.size());
    for (Index v = 0; v < system.vertex_count(); ++v) {
      const Vector3 arm = vertex_block(state.position, v) - center;
      vertex_block(state.momentum, v) = system.mass()[v] * Vector3(0, 0, speed).cross(arm);
    }
  }

  MechanicalSystem system;
  Vector3 center;
  State state;
};

// The angular momentum about the axis of the step's velocity (q₁ − q₀)/h at the middle is that of the state.
TEST(RotatedGuess, KeepsTheAngularMomentum) {
  const double h = 0.3;
  for (const double speed : {0.1, 1.0, 3.0}) {
    const Spinning body(speed);
    for (const GuessedStrain strain : {GuessedStrain::kKept, GuessedStrain::kMirrored}) {
      Vector x;
      guess_rotated(body.system, body.state, h, Vector3::Zero(), strain, x);
      Vector3 before = Vector3::Zero();
      Vector3 middle = Vector3::Zero();
      for (Index v = 0; v < body.system.vertex_count(); ++v) {
        const Vector3 from = vertex_block(body.state.position, v);
        const Vector3 at = vertex_block(x, v);
        before += from.cross(Vector3(vertex_block(body.state.momentum, v)));
        middle += (at - body.center).cross(Vector3(body.system.mass()[v] * 2.0 * (at - from) / h));
      }
      EXPECT_NEAR(middle.z(), before.z(), 1e-12 * before.z()) << speed;
    }
  }
}

// Faster turns are not possible for a rigid body: the guess is then a quarter of a turn.
TEST(RotatedGuess, TurnsByARightAngleAtMost) {
  const Spinning body(100.0);
  Vector x;
  guess_rotated(body.system, body.state, 0.3, Vector3::Zero(), GuessedStrain::kKept, x);
  for (Index v = 0; v < body.system.vertex_count(); ++v) {
    const Vector3 arm = vertex_block(body.state.position, v) - body.center;
    const Vector3 end =
        2.0 * vertex_block(x, v) - vertex_block(body.state.position, v) - body.center;
    EXPECT_LT((end - Vector3(-arm.y(), arm.x(), arm.z())).norm(), 1e-14);
  }
}

// Without a spin the middle between mirrored strains is the shape at rest, moved with the centre.
TEST(RotatedGuess, MirrorsStrains) {
  Spinning body(0.0);
  const Vector rest = body.state.position;
  for (Index v = 0; v < body.system.vertex_count(); ++v) {
    Vector3 arm = vertex_block(rest, v) - body.center;
    arm *= 1.2;
    vertex_block(body.state.position, v) = body.center + arm;
  }
  const Vector3 move(0.4, 0.0, -0.2);
  Vector x;
  guess_rotated(body.system, body.state, 0.3, move, GuessedStrain::kMirrored, x);
  for (Index v = 0; v < body.system.vertex_count(); ++v) {
    EXPECT_LT((vertex_block(x, v) - vertex_block(rest, v) - 0.5 * move).norm(), 1e-14);
  }
}

}  // namespace
}  // namespace tetraction
