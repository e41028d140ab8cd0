#include "solver/newton/turning_path.h"

#include <Eigen/Geometry>

#include <cmath>

#include "support/bodies.h"
#include "tetraction/mesh/edge_vertices.h"

namespace tetraction {
namespace {

using namespace testing_support;

struct Held {
  Held(const TetMesh& mesh, const Selection& selection) : system(mesh, all_materials()[0], 1000.0) {
    system.set_constraints(hold(system.mesh(), selection));
  }
  explicit Held(const TetMesh& mesh) : system(mesh, all_materials()[0], 1000.0) {}
  MechanicalSystem system;
};

// A small rotation goes on as a finite one, also of a deformed body, and of a free one up to a translation.
void expect_rotation(const TetMesh& mesh, bool is_free) {
  Held body = is_free ? Held(mesh) : Held(mesh, SelectVertices{{0}});
  const Vector x = jiggled(body.system.mesh().rest_positions(), 0.03);
  const Vector3 fixed = vertex_block(x, 0);
  const Vector3 axis = Vector3(1, 2, 2) / 3.0;
  Vector d(x.size());
  for (Index v = 0; v < body.system.vertex_count(); ++v) {
    vertex_block(d, v) = axis.cross(Vector3(vertex_block(x, v)) - fixed);
  }
  TurningPath path(body.system);
  path.begin(x, d);
  EXPECT_NEAR(path.rate(), std::sqrt(2.0), 1e-12);
  for (const double angle : {-0.3, 1.2}) {
    const Matrix3 turn = Eigen::AngleAxisd(angle, axis).toRotationMatrix();
    const Vector moved = path.at(angle);
    const Vector3 shift = is_free ? Vector3(vertex_block(moved, 0)) : Vector3(0, 0, 0);
    for (Index v = 0; v < body.system.vertex_count(); ++v) {
      const Vector3 arm = Vector3(vertex_block(x, v)) - fixed;
      EXPECT_LT((Vector3(vertex_block(moved, v)) - shift - (turn * arm - arm)).norm(), 1e-9) << v;
    }
  }
}

TEST(TurningPath, ARotationGoesOn) {
  for (const bool is_free : {false, true}) {
    expect_rotation(small_block(), is_free);
    expect_rotation(with_edge_vertices(small_block()), is_free);
  }
}

// The tip of a strip that bends moves on the way of an arc of constant length, not on its tangent.
TEST(TurningPath, AStripBendsToAnArc) {
  const double length = 1.0;
  const double curvature = 1.0;
  Held body(with_edge_vertices(generate_box({length, 0.02, 0.02}, {40, 1, 2})),
            SelectPlane{0, 0.0, {}});
  const Vector x = body.system.mesh().rest_positions();
  Vector d(x.size());
  Index tip = -1;
  for (Index v = 0; v < body.system.vertex_count(); ++v) {
    const Vector3 at = vertex_block(x, v);
    const double z = at.z() - 0.01;
    vertex_block(d, v) = Vector3(-curvature * at.x() * z, 0.0, 0.5 * curvature * at.x() * at.x());
    if (at.x() > length - 1e-9 && std::abs(z) < 1e-9) tip = v;
  }
  ASSERT_GE(tip, 0);
  TurningPath path(body.system);
  path.begin(x, d);
  for (const double t : {0.5, 1.0, 1.5}) {
    const double angle = curvature * t * length;
    const Vector3 moved = vertex_block(path.at(t), tip);
    EXPECT_NEAR(length + moved.x(), length * std::sin(angle) / angle, 1e-4);
    EXPECT_NEAR(moved.z(), length * (1.0 - std::cos(angle)) / angle, 1e-4);
  }
}

// It leaves the straight way to second order.
TEST(TurningPath, BeginsInTheDirection) {
  Held body(small_block(), SelectPlane{0, 0.0, {}});
  const Vector x = jiggled(body.system.mesh().rest_positions(), 0.03);
  const FreeCoordinates& free = body.system.coordinates();
  const Vector d = free.extend(free.restrict(jiggled(Vector::Zero(x.size()), 1.0, 3)));
  TurningPath path(body.system);
  path.begin(x, d);
  const double t = 1e-3;
  const double bend = (path.at(t) - t * d).norm();
  EXPECT_GT(bend, 0.0);
  EXPECT_NEAR((path.at(2.0 * t) - 2.0 * t * d).norm(), 4.0 * bend, 0.02 * bend);
  for (Index v = 0; v < body.system.vertex_count(); ++v) {
    if (free.is_free(v)) continue;
    EXPECT_EQ(Vector3(vertex_block(path.at(0.3), v)), Vector3(Vector3::Zero())) << v;
  }
}

}  // namespace
}  // namespace tetraction
