// Walls without edges: distances, mean normals, and when a straight way touches them.
#include "dynamics/contact/smooth_contact.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace tetraction {
namespace {

struct NamedWall {
  std::string name;
  SmoothWall wall;
  // The distance as its definition says.
  std::function<double(const Vector3&)> distance;
};

// The distance of x to the line through `point` along `axis`.
double distance_to_line(const Vector3& x, const Vector3& point, const Vector3& axis) {
  const Vector3 unit = axis.normalized();
  const Vector3 arm = x - point;
  return (arm - arm.dot(unit) * unit).norm();
}

std::vector<NamedWall> smooth_walls() {
  const Vector3 point(0.2, -0.3, 0.1);
  const Vector3 axis(0.5, 2.0, -1.0);
  return {{"plane", SmoothWall::plane(point, axis),
           [=](const Vector3& x) { return axis.normalized().dot(x - point); }},
          {"sphere", SmoothWall::sphere(point, 0.7, false),
           [=](const Vector3& x) { return (x - point).norm() - 0.7; }},
          {"sphere_inside", SmoothWall::sphere(point, 2.3, true),
           [=](const Vector3& x) { return 2.3 - (x - point).norm(); }},
          {"cylinder", SmoothWall::cylinder(point, axis, 0.4, false),
           [=](const Vector3& x) { return distance_to_line(x, point, axis) - 0.4; }},
          {"cylinder_inside", SmoothWall::cylinder(point, axis, 1.9, true),
           [=](const Vector3& x) { return 1.9 - distance_to_line(x, point, axis); }}};
}

// Points on the free side, at most two metres away from the origin along each axis.
std::vector<Vector3> free_points(const NamedWall& wall, int count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(-2.0, 2.0);
  std::vector<Vector3> points;
  while (static_cast<int>(points.size()) < count) {
    const Vector3 x(place(random), place(random), place(random));
    if (wall.distance(x) > 0.0) points.push_back(x);
  }
  return points;
}

class SmoothWalls : public testing::TestWithParam<NamedWall> {};

TEST_P(SmoothWalls, HaveTheirDistanceAndItsDerivatives) {
  const SmoothWall& wall = GetParam().wall;
  constexpr double kStep = 1e-5;
  for (const Vector3& x : free_points(GetParam(), 50, 1)) {
    EXPECT_NEAR(wall.distance(x), GetParam().distance(x), 1e-14);
    const Vector3 normal = wall.normal(x);
    const Matrix3 curvature = wall.curvature(x);
    EXPECT_NEAR(normal.norm(), 1.0, 1e-14);
    for (int i = 0; i < 3; ++i) {
      const Vector3 step = kStep * Vector3::Unit(i);
      const double slope = (wall.distance(x + step) - wall.distance(x - step)) / (2.0 * kStep);
      EXPECT_NEAR(normal[i], slope, 1e-8);
      const Vector3 turn = (wall.normal(x + step) - wall.normal(x - step)) / (2.0 * kStep);
      EXPECT_LT((curvature.col(i) - turn).norm(), 1e-7);
    }
  }
}

TEST_P(SmoothWalls, HaveAMeanNormalThatGivesTheChangeOfTheDistance) {
  const SmoothWall& wall = GetParam().wall;
  const std::vector<Vector3> from = free_points(GetParam(), 60, 2);
  const std::vector<Vector3> to = free_points(GetParam(), 60, 3);
  for (std::size_t i = 0; i < from.size(); ++i) {
    // Far apart, near each other, and equal.
    for (const double way : {1.0, 1e-6, 0.0}) {
      const Vector3& a = from[i];
      const Vector3 b = a + way * (to[i] - a);
      const double change = GetParam().distance(b) - GetParam().distance(a);
      EXPECT_NEAR(wall.mean_normal(a, b).dot(b - a), change, 5e-15) << i << ", " << way;
      EXPECT_LE(wall.mean_normal(a, b).norm(), 1.0 + 1e-14);
      if (way < 1.0) {
        EXPECT_LT((wall.mean_normal(a, b) - wall.normal(a)).norm(), 1e-4);
      }
      const Matrix3 rate = wall.mean_normal_rate(a, b);
      constexpr double kStep = 1e-5;
      for (int k = 0; k < 3; ++k) {
        const Vector3 step = kStep * Vector3::Unit(k);
        const Vector3 turn =
            (wall.mean_normal(a, b + step) - wall.mean_normal(a, b - step)) / (2.0 * kStep);
        EXPECT_LT((rate.col(k) - turn).norm(), 1e-6);
      }
    }
  }
}

// The first of the roots of d(x + t way) that a walk in small parts finds.
TEST_P(SmoothWalls, TellWhenAStraightWayTouchesThem) {
  const SmoothWall& wall = GetParam().wall;
  const std::vector<Vector3> points = free_points(GetParam(), 500, 4);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> length(-4.0, 4.0);
  int touches = 0;
  for (const Vector3& x : points) {
    const Vector3 way(length(random), length(random), length(random));
    const double touch = wall.first_touch(x, way);
    constexpr int kParts = 2000;
    double walked = std::numeric_limits<double>::infinity();
    for (int k = 1; k <= kParts && walked > 1.0; ++k) {
      const double t = static_cast<double>(k) / kParts;
      if (!(GetParam().distance(x + t * way) > 0.0)) walked = t;
    }
    if (walked <= 1.0) {
      ++touches;
      EXPECT_LE(touch, walked + 1e-12);
      EXPECT_GT(touch, walked - 1.5 / kParts);
      EXPECT_NEAR(GetParam().distance(x + touch * way), 0.0, 1e-13);
      EXPECT_NEAR(wall.first_touch(x, 10.0 * way), 0.1 * touch, 1e-14) << "a way ten times as long";
    } else {
      // A way that grazes the wall between two parts touches it by less than the walk sees.
      EXPECT_TRUE(touch > 1.0 || GetParam().distance(x + touch * way) > -1e-13);
    }
  }
  EXPECT_GT(touches, 10);
}

TEST_P(SmoothWalls, AreNeverTouchedByAWayThatLeavesThem) {
  const SmoothWall& wall = GetParam().wall;
  for (const Vector3& x : free_points(GetParam(), 20, 6)) {
    EXPECT_GT(wall.first_touch(x, Vector3::Zero()), 1e300);
    const double d = wall.distance(x);
    // Straight at the wall it is touched after the distance.
    EXPECT_NEAR(wall.first_touch(x, -2.0 * d * wall.normal(x)), 0.5, 1e-13);
    if (GetParam().name.ends_with("inside")) continue;
    EXPECT_GT(wall.first_touch(x, 5.0 * wall.normal(x)), 1e300);
  }
}

// A touch right at the start: the distance to a far wall is not lost in the radius.
TEST(SmoothWall, TellsATouchOfAPointThatIsNearALargeBall) {
  const SmoothWall wall = SmoothWall::sphere({0.0, -1e3, 0.0}, 1e3, false);
  const Vector3 x(0.0, 1e-6, 0.0);
  EXPECT_NEAR(wall.first_touch(x, {0.0, -1.0, 0.0}), 1e-6, 1e-12);
  EXPECT_NEAR(wall.distance(x), 1e-6, 1e-12);
}

INSTANTIATE_TEST_SUITE_P(Kinds, SmoothWalls, testing::ValuesIn(smooth_walls()),
                         [](const auto& test) { return test.param.name; });

struct NamedShape {
  std::string name;
  ObstacleShape shape;
};

std::vector<NamedShape> obstacle_shapes() {
  const Vector3 center(0.1, -0.2, 0.3);
  return {{"plane", PlaneShape{center, {1.0, 3.0, -2.0}}},
          {"sphere", SphereShape{center, 0.8, false}},
          {"sphere_inside", SphereShape{center, 1.5, true}},
          {"cylinder", CylinderShape{center, {1.0, 1.0, 0.2}, 0.6, false}},
          {"cylinder_inside", CylinderShape{center, {1.0, 1.0, 0.2}, 1.2, true}},
          {"room", RoomShape{{-1.1, -0.9, -1.0}, {1.3, 0.8, 1.2}}}};
}

class SmoothContacts : public testing::TestWithParam<NamedShape> {
 protected:
  static constexpr int kPoints = 200;
  static constexpr Barrier kBarrier{0.1, 1e3};

  static ContactSurface surface(std::size_t count) {
    ContactSurface surface;
    surface.areas.assign(count, 0.01);
    return surface;
  }
  SmoothContact contact() const { return {GetParam().shape, kBarrier, surface(kPoints)}; }

  // Points that are free; half of them close to a wall.
  Vector starts() const {
    const SmoothContact one(GetParam().shape, kBarrier, surface(1));
    std::mt19937 random(7);
    std::uniform_real_distribution<double> place(-2.0, 2.0);
    Vector x(3 * kPoints);
    for (int i = 0; i < kPoints;) {
      Vector point(3);
      for (int k = 0; k < 3; ++k) point[k] = place(random);
      if (one.penetrating_vertex(point) >= 0) continue;
      if (i % 2 == 0) {
        Vector way(3);
        for (int k = 0; k < 3; ++k) way[k] = place(random);
        const double touch = one.longest_step(point, way);
        if (touch < 1.0) point += (1.0 - 1e-4) * touch * way;
      }
      if (one.penetrating_vertex(point) >= 0) continue;
      x.segment<3>(3 * i) = point;
      ++i;
    }
    return x;
  }
};

TEST_P(SmoothContacts, ClearEveryWay) {
  const SmoothContact law = contact();
  const Vector from = starts();
  std::mt19937 random(11);
  // Ways of a hundredth of the body's size to a hundred times it.
  for (const double size : {0.02, 0.3, 3.0, 200.0}) {
    std::uniform_real_distribution<double> move(-size, size);
    Vector to = from;
    for (Index i = 0; i < to.size(); ++i) to[i] += move(random);
    Vector cleared = to;
    law.clear_way(from, cleared);
    EXPECT_EQ(law.penetrating_vertex(cleared), -1) << size;
    EXPECT_EQ(law.longest_step(from, cleared - from), 1.0) << size;
    // What crosses nothing and ends outside of the layer stays as it is.
    int kept = 0;
    for (int v = 0; v < kPoints; ++v) {
      const SmoothContact one(GetParam().shape, kBarrier, surface(1));
      const Vector a = from.segment<3>(3 * v);
      const Vector b = to.segment<3>(3 * v);
      if (one.penetrating_vertex(b) >= 0 || one.longest_step(a, b - a) < 1.0 ||
          one.energy(b) > 0.0) {
        continue;
      }
      ++kept;
      EXPECT_EQ(Vector3(cleared.segment<3>(3 * v)), Vector3(b)) << v;
    }
    if (size < 1.0) {
      EXPECT_GT(kept, 10) << size;
    }
  }
}

TEST_P(SmoothContacts, HaveLongestStepsThatEndAtAWall) {
  const SmoothContact law(GetParam().shape, kBarrier, surface(1));
  const Vector from = starts();
  std::mt19937 random(13);
  std::uniform_real_distribution<double> move(-4.0, 4.0);
  int cut = 0;
  for (int v = 0; v < kPoints; ++v) {
    const Vector a = from.segment<3>(3 * v);
    Vector way(3);
    for (int k = 0; k < 3; ++k) way[k] = move(random);
    const double longest = law.longest_step(a, way);
    ASSERT_GT(longest, 0.0);
    ASSERT_LE(longest, 1.0);
    EXPECT_EQ(law.penetrating_vertex(a + 0.99 * longest * way), -1);
    if (longest == 1.0) continue;
    ++cut;
    Vector gaps;
    law.vertex_gaps(a + (1.0 - 1e-9) * longest * way, gaps);
    EXPECT_LT(gaps[0], 1e-6);
  }
  EXPECT_GT(cut, 5);
}

INSTANTIATE_TEST_SUITE_P(Shapes, SmoothContacts, testing::ValuesIn(obstacle_shapes()),
                         [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace tetraction
