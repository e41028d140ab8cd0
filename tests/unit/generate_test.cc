#include "tetraction/mesh/generate.h"

#include <gtest/gtest.h>

#include <limits>
#include <set>

#include "tetraction/core/error.h"

namespace tetraction {
namespace {

TEST(GenerateBox, SixPositiveTetrahedraACellAroundTheDiagonal) {
  const TetMesh mesh = generate_box({4, 1, 2}, {5, 2, 3});
  EXPECT_EQ(mesh.vertex_count(), 6 * 3 * 4);
  EXPECT_EQ(mesh.tetrahedron_count(), 6 * 5 * 2 * 3);
  EXPECT_NEAR(mesh.total_volume(), 8.0, 1e-13);
  for (Index e = 0; e < mesh.tetrahedron_count(); ++e) {
    EXPECT_NEAR(mesh.volume(e), 8.0 / 180.0, 1e-14);
    // The two ends of the cell's diagonal are among the vertices.
    const auto& t = mesh.tetrahedra[static_cast<std::size_t>(e)];
    double longest = 0.0;
    for (const Index a : t) {
      for (const Index b : t) {
        const Vector3 d =
            mesh.vertices[static_cast<std::size_t>(a)] - mesh.vertices[static_cast<std::size_t>(b)];
        if ((d.array() > 1e-9).all()) longest = std::max(longest, d.norm());
      }
    }
    EXPECT_NEAR(longest, Vector3(0.8, 0.5, 2.0 / 3.0).norm(), 1e-12);
  }
}

TEST(GenerateBox, BeamOfTheUsualSize) {
  const TetMesh beam = generate_box({4, 1, 1}, {20, 4, 4});
  EXPECT_EQ(beam.vertex_count(), 21 * 5 * 5);
  EXPECT_EQ(beam.tetrahedron_count(), 1920);
  EXPECT_NEAR(beam.total_volume(), 4.0, 1e-13);
  // x runs fastest, then y, then z; the far corner lies exactly at the size.
  EXPECT_EQ(beam.vertices[1], Vector3(0.2, 0, 0));
  EXPECT_EQ(beam.vertices[21], Vector3(0, 0.25, 0));
  EXPECT_EQ(beam.vertices[105], Vector3(0, 0, 0.25));
  EXPECT_EQ(beam.vertices.back(), Vector3(4, 1, 1));
  EXPECT_EQ(beam.vertex_ids.front(), 0);
}

TEST(GenerateBox, IsConforming) {
  const TetMesh mesh = generate_box({1, 1, 1}, {3, 4, 2});
  // Faces on the boundary of the box: two triangles a cell face.
  EXPECT_EQ(boundary_faces(mesh).size(), 2U * 2U * (3U * 4U + 4U * 2U + 3U * 2U));
}

TEST(GenerateTetrahedron, UnitCorner) {
  EXPECT_NEAR(generate_tetrahedron().total_volume(), 1.0 / 6.0, 1e-16);
  EXPECT_NEAR(generate_tetrahedron(2.0).total_volume(), 8.0 / 6.0, 1e-15);
}

TEST(Generate, RefusesMeaninglessSizes) {
  EXPECT_THROW(generate_box({0, 1, 1}, {1, 1, 1}), InputError);
  EXPECT_THROW(generate_box({1, 1, std::numeric_limits<double>::infinity()}, {1, 1, 1}),
               InputError);
  EXPECT_THROW(generate_box({1, 1, 1}, {1, 0, 1}), InputError);
  EXPECT_THROW(generate_box({1, 1, 1}, {100000, 100000, 100000}), InputError);
  EXPECT_THROW(generate_box({1, 1, 1}, {300, 300, 300}), InputError);
  EXPECT_THROW(generate_box({1e-200, 1e-200, 1e-200}, {1, 1, 1}), InputError);
  EXPECT_THROW(generate_tetrahedron(-1.0), InputError);
  EXPECT_THROW(generate_tetrahedron(1e200), InputError);
}

}  // namespace
}  // namespace tetraction
