#include "tetraction/mesh/mesh_copies.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "tetraction/core/error.h"
#include "tetraction/mesh/generate.h"
#include "tetraction/mesh/selection.h"

namespace tetraction {
namespace {

TetMesh small_box() {
  TetMesh mesh = generate_box({1.0, 2.0, 3.0}, {1, 2, 1});
  Group side;
  side.name = "side";
  side.dimension = 2;
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    if (mesh.vertices[static_cast<std::size_t>(v)].x() == 0.0) side.vertices.push_back(v);
  }
  mesh.groups.push_back(side);
  mesh.point_arrays["u"] = Matrix::Constant(3, mesh.vertex_count(), 2.0);
  return mesh;
}

MeshPlace mesh_place(const Vector3& at, const Vector3& turn = Vector3::Zero()) {
  MeshPlace result;
  result.at = at;
  result.turn = turn;
  return result;
}

TEST(MeshCopies, ArePlacedTurnedAndNumbered) {
  const TetMesh one = small_box();
  const Index n = one.vertex_count();
  const Index m = one.tetrahedron_count();
  const std::vector<MeshPlace> places{mesh_place({5.0, 0.0, 0.0}),
                                      mesh_place({0.0, 0.0, 7.0}, {0.0, 0.0, 90.0})};
  const TetMesh three = with_copies(one, places);
  ASSERT_EQ(three.vertex_count(), 3 * n);
  ASSERT_EQ(three.tetrahedron_count(), 3 * m);
  EXPECT_NEAR(three.total_volume(), 3.0 * one.total_volume(), 1e-12);
  for (Index v = 0; v < n; ++v) {
    const auto at = [&](Index k) -> Vector3 {
      return three.vertices[static_cast<std::size_t>(v + k * n)];
    };
    const Vector3 x = one.vertices[static_cast<std::size_t>(v)];
    EXPECT_EQ(at(0), x);
    EXPECT_EQ(at(1), Vector3(x + Vector3(5.0, 0.0, 0.0)));
    // A quarter turn about (0.5, 1, ·).
    EXPECT_LT((at(2) - Vector3(0.5 - (x.y() - 1.0), 1.0 + (x.x() - 0.5), x.z() + 7.0)).norm(),
              1e-14);
  }
  for (Index e = 0; e < 3 * m; ++e) EXPECT_GT(three.volume(e), 0.0);
  for (Index k = 0; k < 3; ++k) {
    const std::vector<Index> body =
        select_vertices(three, SelectGroup{group_of_copy(static_cast<std::size_t>(k))});
    EXPECT_EQ(body.size(), static_cast<std::size_t>(n));
    EXPECT_EQ(body.front(), k * n);
    EXPECT_EQ(
        select_tetrahedra(three, SelectGroup{group_of_copy(static_cast<std::size_t>(k))}).size(),
        static_cast<std::size_t>(m));
  }
  EXPECT_EQ(select_vertices(three, SelectGroup{"side"}).size(),
            3 * select_vertices(one, SelectGroup{"side"}).size());
  EXPECT_EQ(three.point_arrays.at("u").cols(), 3 * n);
}

TEST(MeshCopies, KeepTheNumbersOfTheFile) {
  TetMesh one = small_box();
  one.vertex_ids.clear();
  for (Index v = 0; v < one.vertex_count(); ++v) one.vertex_ids.push_back(10 * v + 7);
  const TetMesh two = with_copies(one, std::vector{mesh_place({9.0, 0.0, 0.0})});
  const std::int64_t last = one.vertex_ids.back();
  EXPECT_EQ(two.vertex_id(0), 7);
  EXPECT_EQ(two.vertex_id(one.vertex_count()), 7 + last + 1);
}

TEST(MeshCopies, OfQuadraticTetrahedraKeepTheirEdges) {
  const TetMesh one = with_edge_vertices(generate_box({1.0, 1.0, 1.0}, {1, 1, 1}));
  const TetMesh two = with_copies(one, std::vector{mesh_place({2.0, 0.0, 0.0}, {30.0, 0.0, 0.0})});
  EXPECT_TRUE(two.is_quadratic());
  EXPECT_NEAR(two.total_volume(), 2.0, 1e-12);
}

TEST(MeshCopies, RefuseNamesThatAreTaken) {
  TetMesh one = small_box();
  one.groups.front().name = "body_1";
  EXPECT_THROW(with_copies(one, std::vector{MeshPlace{}}), InputError);
  EXPECT_EQ(with_copies(one, {}).vertex_count(), one.vertex_count());
}

}  // namespace
}  // namespace tetraction
