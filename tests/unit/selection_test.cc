#include "tetraction/mesh/selection.h"

#include <limits>

#include "support/bodies.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

const TetMesh& block() {
  static const TetMesh mesh = [] {
    TetMesh m = testing_support::small_block();  // 2 × 1 × 1 m, 4 × 2 × 2 cells
    for (std::int64_t& id : m.vertex_ids) id += 100;
    m.groups.push_back({"corner", 0, 1, {0}, {}});
    m.report.dropped_vertices = 1;
    return m;
  }();
  return mesh;
}

TEST(Selection, EachKind) {
  EXPECT_EQ(select_vertices(block(), SelectVertices{{103, 100, 103}}), (std::vector<Index>{0, 3}));
  EXPECT_EQ(select_vertices(block(), SelectPlane{0, 2.0, {}}).size(), 9U);
  EXPECT_EQ(select_vertices(block(), SelectPlane{0, 1.9, 0.2}).size(), 9U);
  EXPECT_EQ(select_vertices(block(), SelectBox{{0, 0, 0}, {0.5, 0.5, 0.5}}).size(), 8U);
  EXPECT_EQ(select_vertices(block(), SelectSphere{{0, 0, 0}, 0.5}).size(), 4U);
  EXPECT_EQ(select_vertices(block(), SelectNearest{{-1, 0.1, 0.1}}), std::vector<Index>{0});
  EXPECT_EQ(select_vertices(block(), SelectGroup{"corner"}), std::vector<Index>{0});
  EXPECT_EQ(select_vertices(block(), SelectSurface{}).size(), 45U - 3U);
  EXPECT_EQ(select_vertices(block(), SelectAll{}).size(), 45U);
}

std::string refusal(const Selection& selection) {
  try {
    select_vertices(block(), selection);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Selection, RefusesWhatSelectsNothing) {
  EXPECT_NE(refusal(SelectPlane{1, 7.0, {}}).find("selects no vertex"), std::string::npos);
  EXPECT_NE(refusal(SelectVertices{{5}}).find("vertex 5 is not in the mesh"), std::string::npos);
  EXPECT_NE(refusal(SelectVertices{{5}}).find("100 to 144"), std::string::npos);
  EXPECT_NE(refusal(SelectVertices{{}}).find("selects no vertex"), std::string::npos);
  EXPECT_NE(refusal(SelectVertices{{5}}).find("no tetrahedron uses were dropped"),
            std::string::npos);
  EXPECT_NE(refusal(SelectSphere{{0, 0, 0}, -1.0}).find("selects no vertex"), std::string::npos);
  EXPECT_NE(refusal(SelectGroup{"cornr"}).find("\"corner\""), std::string::npos);
}

TEST(Selection, RefusesWhatMakesNoSense) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(refusal(SelectNearest{{0, nan, 0}}).find("not finite"), std::string::npos);
  EXPECT_NE(refusal(SelectPlane{0, nan, {}}).find("selects no vertex"), std::string::npos);
  EXPECT_NE(refusal(SelectPlane{3, 0.0, {}}).find("0, 1 or 2"), std::string::npos);
  EXPECT_NE(refusal(SelectPlane{-1, 0.0, {}}).find("0, 1 or 2"), std::string::npos);
  EXPECT_THROW(select_vertices(TetMesh{}, SelectNearest{}), InputError);
  EXPECT_THROW(select_vertices(TetMesh{}, SelectPlane{}), InputError);
}

TEST(SelectTetrahedra, ByCentroidGroupOrAllVertices) {
  TetMesh mesh = generate_box({2, 1, 1}, {2, 1, 1});
  const std::vector<Index> right = select_tetrahedra(mesh, SelectBox{{1, 0, 0}, {2, 1, 1}});
  EXPECT_EQ(right.size(), 6u);
  for (const Index e : right) {
    double x = 0.0;
    for (const Index v : mesh.tetrahedra[static_cast<std::size_t>(e)]) {
      x += mesh.vertices[static_cast<std::size_t>(v)].x() / 4.0;
    }
    EXPECT_GT(x, 1.0);
  }
  EXPECT_EQ(select_tetrahedra(mesh, SelectAll{}).size(), 12u);
  EXPECT_EQ(select_tetrahedra(mesh, SelectSphere{{0.5, 0.5, 0.5}, 0.6}).size(), 6u);
  mesh.groups.push_back({"core", 3, 7, {}, {2, 5}});
  EXPECT_EQ(select_tetrahedra(mesh, SelectGroup{"core"}), (std::vector<Index>{2, 5}));
  EXPECT_THROW(select_tetrahedra(mesh, SelectPlane{0, 0.0, {}}), InputError);
  EXPECT_THROW(select_tetrahedra(mesh, SelectGroup{"shell"}), InputError);
}

}  // namespace
}  // namespace tetraction
