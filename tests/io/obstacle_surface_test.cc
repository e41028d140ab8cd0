#include "tetraction/io/obstacle_surface.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <fstream>
#include <map>
#include <numbers>
#include <set>

#include "io/vtk/obstacle_grid.h"
#include "support/folder_test.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

using namespace testing_support;

// A body of the diagonal 1 at rest around (2, 0, 0), which is somewhere else now.
BodyPlace body_at(const Vector3& middle) {
  BodyPlace body;
  body.rest_middle = {2.0, 0.0, 0.0};
  body.middle = middle;
  return body;
}

// Turned by a right angle about y and moved.
ObstacleFrame turned() {
  ObstacleFrame frame;
  frame.rotation = Eigen::AngleAxisd(0.5 * std::numbers::pi, Vector3::UnitY()).toRotationMatrix();
  frame.shift = {0.5, 1.0, -2.0};
  return frame;
}

ObstacleSurface surface_of(const ObstacleShape& shape, const ObstacleFrame& frame = {},
                           const Vector3& middle = {2.0, 0.0, 0.0}) {
  ObstacleSurface surface;
  add_obstacle_surface(shape, frame, body_at(middle), 7, surface);
  return surface;
}

std::vector<std::array<Index, 4>> polygons_of(const ObstacleSurface& surface) {
  std::vector<std::array<Index, 4>> polygons = surface.cells;
  std::erase_if(polygons, ObstacleSurface::is_line);
  return polygons;
}

// The area vector of a polygon, towards the side from which its corners are counter-clockwise.
Vector3 area_of(const ObstacleSurface& surface, const std::array<Index, 4>& polygon) {
  const auto at = [&](std::size_t k) {
    return surface.points[static_cast<std::size_t>(polygon[k])];
  };
  Vector3 area = (at(1) - at(0)).cross(at(2) - at(0));
  if (polygon[3] >= 0) area += (at(2) - at(0)).cross(at(3) - at(0));
  return 0.5 * area;
}

Vector3 middle_of(const ObstacleSurface& surface, const std::array<Index, 4>& polygon) {
  Vector3 sum = Vector3::Zero();
  double count = 0.0;
  for (const Index v : polygon) {
    if (v < 0) continue;
    sum += surface.points[static_cast<std::size_t>(v)];
    count += 1.0;
  }
  return sum / count;
}

// That each polygon has an area, that all belong to the obstacle, and that direction(middle) is the direction to the
// side of the body. Returns the whole area.
template <class Direction>
double expect_polygons(const ObstacleSurface& surface, const Direction& direction) {
  double whole = 0.0;
  EXPECT_EQ(surface.obstacle, std::vector<int>(surface.cells.size(), 7));
  for (const auto& polygon : polygons_of(surface)) {
    const Vector3 area = area_of(surface, polygon);
    EXPECT_GT(area.normalized().dot(direction(middle_of(surface, polygon))), 0.99);
    whole += area.norm();
  }
  return whole;
}

// The sum of the area vectors of a closed surface vanishes, and each edge has a polygon on both sides.
void expect_closed(const ObstacleSurface& surface) {
  Vector3 sum = Vector3::Zero();
  std::map<std::pair<Index, Index>, int> edges;
  for (const auto& polygon : polygons_of(surface)) {
    sum += area_of(surface, polygon);
    const std::size_t corners = polygon[3] < 0 ? 3 : 4;
    for (std::size_t k = 0; k < corners; ++k) {
      ++edges[{polygon[k], polygon[(k + 1) % corners]}];
    }
  }
  EXPECT_LT(sum.norm(), 1e-12 * static_cast<double>(edges.size()));
  for (const auto& [edge, count] : edges) {
    EXPECT_EQ(count, 1);
    EXPECT_EQ(edges.count({edge.second, edge.first}), 1U);
  }
}

TEST(ObstacleSurfaceTest, APlaneIsASquareOfThreeDiagonalsAroundTheBody) {
  const PlaneShape plane{{9.0, -1.0, 3.0}, {0.0, 2.0, 0.0}};
  const ObstacleSurface square = surface_of(plane);
  Vector3 low = square.points.front();
  Vector3 high = low;
  for (const Vector3& x : square.points) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  EXPECT_LT((low - Vector3(0.5, -1.0, -1.5)).norm(), 1e-14);
  EXPECT_LT((high - Vector3(3.5, -1.0, 1.5)).norm(), 1e-14);
  EXPECT_NEAR(expect_polygons(square, [](const Vector3&) { return Vector3(0.0, 1.0, 0.0); }), 9.0,
              1e-12);
}

TEST(ObstacleSurfaceTest, APlaneFollowsTheBodyInWholeDiagonalsAndMovesWithItsFrame) {
  const PlaneShape plane{{0.0, -1.0, 0.0}, {0.0, 1.0, 0.0}};
  const ObstacleSurface at_rest = surface_of(plane);
  EXPECT_EQ(surface_of(plane, {}, {2.4, 5.0, -0.3}), at_rest);  // less than half a diagonal away
  const ObstacleSurface farther = surface_of(plane, {}, {4.8, 0.0, 0.0});
  ASSERT_EQ(farther.points.size(), at_rest.points.size());
  for (std::size_t i = 0; i < farther.points.size(); ++i) {
    EXPECT_LT((farther.points[i] - at_rest.points[i] - Vector3(3.0, 0.0, 0.0)).norm(), 1e-14);
  }
  // A body that moves with the plane keeps its place on it.
  const ObstacleFrame frame = turned();
  const ObstacleSurface moved = surface_of(plane, frame, frame.to_world({2.0, 0.0, 0.0}));
  for (std::size_t i = 0; i < moved.points.size(); ++i) {
    EXPECT_LT((moved.points[i] - frame.to_world(at_rest.points[i])).norm(), 1e-14);
  }
}

TEST(ObstacleSurfaceTest, ASphereIsClosedAndItsCornersAreOnIt) {
  for (const bool inside : {false, true}) {
    const SphereShape sphere{{1.0, 2.0, 3.0}, 0.5, inside};
    const ObstacleFrame frame = turned();
    const ObstacleSurface surface = surface_of(sphere, frame);
    const Vector3 center = frame.to_world(sphere.center);
    for (const Vector3& x : surface.points) EXPECT_NEAR((x - center).norm(), 0.5, 1e-14);
    expect_closed(surface);
    const double area = expect_polygons(surface, [&](const Vector3& x) {
      return Vector3((inside ? center - x : x - center).normalized());
    });
    // 32 edges around: less than 1 % of the area is missing.
    EXPECT_NEAR(area, 4.0 * std::numbers::pi * 0.25, 0.01 * std::numbers::pi);
  }
}

TEST(ObstacleSurfaceTest, ChordsStayNearLargeSpheresAndCylinders) {
  for (const double radius : {0.1, 1.0, 10.0, 40.0}) {
    for (const ObstacleShape& shape :
         {ObstacleShape(SphereShape{{0.0, 0.0, 0.0}, radius, false}),
          ObstacleShape(CylinderShape{{0.0, 0.0, 0.0}, {0.0, 0.0, 1.0}, radius, false})}) {
      const ObstacleSurface surface = surface_of(shape);
      const bool is_sphere = std::holds_alternative<SphereShape>(shape);
      double least = radius;
      for (const auto& polygon : polygons_of(surface)) {
        const Vector3 x = middle_of(surface, polygon);
        least = std::min(least, is_sphere ? x.norm() : std::hypot(x.x(), x.y()));
      }
      // Of the diagonal, which is 1.
      EXPECT_LT(radius - least, 0.007) << radius;
    }
  }
}

// Sixteen meridians with 32 edges around, and a circle after each two of the 16 rows but the poles.
TEST(ObstacleSurfaceTest, LinesOfAGridAreOnTheSurface) {
  const ObstacleSurface surface = surface_of(SphereShape{{0.0, 0.0, 0.0}, 0.5, false});
  std::size_t meridians = 0;
  std::size_t circles = 0;
  for (const auto& cell : surface.cells) {
    if (!ObstacleSurface::is_line(cell)) continue;
    const Vector3& a = surface.points[static_cast<std::size_t>(cell[0])];
    const Vector3& b = surface.points[static_cast<std::size_t>(cell[1])];
    const bool is_level = std::abs(a.y() - b.y()) < 1e-14;
    ++(is_level ? circles : meridians);
    if (!is_level) {
      EXPECT_LT(std::abs(a.x() * b.z() - a.z() * b.x()), 1e-15);
    }
    EXPECT_LT((a - b).norm(), 2.0 * std::numbers::pi * 0.5 / 32.0);
  }
  EXPECT_EQ(meridians, 16U * 16U);
  EXPECT_EQ(circles, 7U * 32U);
}

TEST(ObstacleSurfaceTest, ACylinderIsAsLongAsThreeDiagonalsAroundTheBody) {
  for (const bool inside : {false, true}) {
    const CylinderShape cylinder{{7.0, 1.0, 0.0}, {-3.0, 0.0, 0.0}, 0.25, inside};
    const ObstacleSurface surface = surface_of(cylinder);
    double low = 1e9;
    double high = -1e9;
    for (const Vector3& x : surface.points) {
      EXPECT_NEAR(std::hypot(x.y() - 1.0, x.z()), 0.25, 1e-14);
      low = std::min(low, x.x());
      high = std::max(high, x.x());
    }
    EXPECT_NEAR(low, 0.5, 1e-14);
    EXPECT_NEAR(high, 3.5, 1e-14);
    expect_polygons(surface, [&](const Vector3& x) {
      const Vector3 out = Vector3(0.0, x.y() - 1.0, x.z()).normalized();
      return Vector3(inside ? -out : out);
    });
  }
}

TEST(ObstacleSurfaceTest, ARoomHasSixWallsThatAreSeenFromInside) {
  const RoomShape room{{-1.0, 0.0, 1.0}, {1.0, 3.0, 2.0}};
  const ObstacleSurface surface = surface_of(room);
  std::map<std::array<int, 3>, double> areas;
  for (const auto& polygon : polygons_of(surface)) {
    const Vector3 area = area_of(surface, polygon);
    const Vector3 inward = area.normalized();
    areas[{static_cast<int>(std::lround(inward.x())), static_cast<int>(std::lround(inward.y())),
           static_cast<int>(std::lround(inward.z()))}] += area.norm();
    const Vector3 x = middle_of(surface, polygon) + 1e-3 * inward;
    EXPECT_TRUE((x.array() > room.min.array()).all() && (x.array() < room.max.array()).all());
  }
  ASSERT_EQ(areas.size(), 6U);
  for (const auto& [direction, area] : areas) {
    const double expected = direction[0] != 0 ? 3.0 : direction[1] != 0 ? 2.0 : 6.0;
    EXPECT_NEAR(area, expected, 1e-12);
  }
}

TEST(ObstacleSurfaceTest, AMeshHasItsTrianglesSeenFromBothSides) {
  const MeshShape mesh{{{0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}},
                       {{0, 1, 2}, {0, 3, 1}}};
  ObstacleSurface surface = surface_of(PlaneShape{});
  const std::size_t before = surface.cells.size();
  const auto first = static_cast<Index>(surface.points.size());
  const ObstacleFrame frame = turned();
  add_obstacle_surface(mesh, frame, body_at({2.0, 0.0, 0.0}), 8, surface);
  ASSERT_EQ(surface.cells.size(), before + 4 + 5) << "two triangles, twice, and five edges";
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    EXPECT_EQ(surface.points[static_cast<std::size_t>(first) + i], frame.to_world(mesh.points[i]));
  }
  for (std::size_t t = 0; t < 2; ++t) {
    const auto& front = surface.cells[before + 2 * t];
    const auto& back = surface.cells[before + 2 * t + 1];
    EXPECT_EQ(front[0], first + mesh.triangles[t][0]);
    EXPECT_LT((area_of(surface, front) + area_of(surface, back)).norm(), 1e-15);
    EXPECT_NEAR(area_of(surface, front).norm(), 0.5, 1e-15);
  }
  std::set<std::array<Index, 2>> edges;
  for (std::size_t i = before + 4; i < surface.cells.size(); ++i) {
    EXPECT_TRUE(ObstacleSurface::is_line(surface.cells[i]));
    edges.insert({surface.cells[i][0] - first, surface.cells[i][1] - first});
  }
  EXPECT_EQ(edges, (std::set<std::array<Index, 2>>{{0, 1}, {0, 2}, {1, 2}, {0, 3}, {1, 3}}));
  EXPECT_EQ(surface.obstacle.back(), 8);
}

TEST(ObstacleSurfaceTest, TheBodysPlaceIsThatOfItsBox) {
  Vector rest = Vector::Zero(6);
  rest.tail<3>() = Vector3(3.0, 4.0, 12.0);
  Vector position = Vector::Zero(6);
  position.tail<3>() = rest.tail<3>();
  position[0] = -1.0;
  const BodyPlace place = body_place(rest, position);
  EXPECT_EQ(place.diagonal, 13.0);
  EXPECT_EQ(place.rest_middle, Vector3(1.5, 2.0, 6.0));
  EXPECT_EQ(place.middle, Vector3(1.0, 2.0, 6.0));
  position[4] = std::nan("");
  EXPECT_EQ(body_place(rest, position).middle, place.rest_middle);
}

class ObstacleFileTest : public FolderTest {
 protected:
  std::string write(const ObstacleSurface& surface) const {
    std::string path = (folder_ / "obstacles_000001.vtu").string();
    std::ofstream(path, std::ios::binary) << obstacle_file(surface, path, FrameCompression::kLz4);
    return path;
  }
};

TEST_F(ObstacleFileTest, AFileReadsBackExactly) {
  ObstacleSurface surface = surface_of(SphereShape{{0.1, 0.2, 0.3}, 0.7, false});
  add_obstacle_surface(RoomShape{}, {}, body_at(Vector3::Zero()), 9, surface);
  EXPECT_EQ(*read_obstacle_file(write(surface)), surface);
}

TEST_F(ObstacleFileTest, WhatIsNoSurfaceIsRefused) {
  ObstacleSurface surface = surface_of(RoomShape{});
  surface.points[3].x() = std::nan("");
  EXPECT_THROW(read_obstacle_file(write(surface)), FileError);
  const std::string path = write(surface_of(RoomShape{}));
  std::string text = contents(path);
  std::ofstream(path, std::ios::binary) << text.substr(0, text.size() / 2);
  EXPECT_THROW(read_obstacle_file(path), FileError);
  EXPECT_THROW(read_obstacle_file((folder_ / "none.vtu").string()), FileError);
}

}  // namespace
}  // namespace tetraction
