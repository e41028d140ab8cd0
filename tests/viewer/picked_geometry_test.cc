// Faces up to their edges, and distances and angles of vertices.
#include "viewer/picked_geometry.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>

namespace tetraction::viewer {
namespace {

struct Surface {
  std::vector<std::array<Index, 3>> triangles;
  Vector position;
};

// A strip of squares, each divided into two triangles, that turns by `angle` (degrees) from one to the next.
Surface strip(int squares, double angle) {
  Surface surface;
  surface.position.resize(6 * (squares + 1));
  Vector3 place = Vector3::Zero();
  for (int i = 0; i <= squares; ++i) {
    for (int side = 0; side < 2; ++side) {
      vertex_block(surface.position, 2 * i + side) = place + side * Vector3::UnitY();
    }
    const double turned = i * angle * std::numbers::pi / 180.0;
    place += Vector3(std::cos(turned), 0.0, std::sin(turned));
  }
  for (Index i = 0; i < 2 * squares; i += 2) {
    surface.triangles.push_back({i, i + 2, i + 3});
    surface.triangles.push_back({i, i + 3, i + 1});
  }
  return surface;
}

TEST(PickedGeometry, AFaceEndsWhereTheSurfaceTurnsMore) {
  const Surface bent = strip(4, 30.0);
  EXPECT_EQ(face_vertices(bent.triangles, bent.position, 2, 29.9),
            (std::vector<Index>{2, 3, 4, 5}));
  EXPECT_EQ(face_vertices(bent.triangles, bent.position, 2, 30.1).size(), 10U);
  // The angle is that of neighbours: a curved face may turn by more as a whole.
  const Surface round = strip(20, 10.0);
  EXPECT_EQ(face_vertices(round.triangles, round.position, 0, 15.0).size(), 42U);
}

TEST(PickedGeometry, DistancesAndAngles) {
  Vector position(9);
  position << 0.0, 0.0, 0.0, 0.03, 0.0, 0.0, 0.0, 0.03, 0.0;
  EXPECT_EQ(measure(position, {0, 1}, {"7", "8"}), "Distance of 7 and 8: 30 mm");
  EXPECT_EQ(measure(position, {0, 1, 2}, {"7", "8", "9"}),
            "Angles at 7: 90.00°, at 8: 45.00°, at 9: 45.00°");
  EXPECT_EQ(measure(position, {0}, {"7"}), "");
  EXPECT_EQ(measure(position, {}, {}), "");
}

}  // namespace
}  // namespace tetraction::viewer
