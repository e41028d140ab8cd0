#include "tetraction/mesh/selection.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <utility>

#include "support/bodies.h"
#include "support/messages.h"

namespace tetraction {
namespace {

using namespace testing_support;

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
  return message_of([&] { select_vertices(block(), selection); });
}

TEST(Selection, RefusesWhatSelectsNothing) {
  EXPECT_NE(refusal(SelectPlane{1, 7.0, {}}).find("selects no vertex"), std::string::npos);
  EXPECT_NE(refusal(SelectVertices{{5}}).find("vertex 5 is not in the mesh"), std::string::npos);
  EXPECT_NE(refusal(SelectVertices{{5}}).find("100 to 144"), std::string::npos);
  EXPECT_NE(refusal(SelectVertices{{}}).find("selects no vertex"), std::string::npos);
  expect_part(refusal(SelectVertices{{5}}), "no tetrahedron uses were dropped");
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

Selection all_of(std::vector<SelectionPart> parts) {
  return SelectSet{SetOperation::kAllOf, std::move(parts)};
}
Selection any_of(std::vector<SelectionPart> parts) {
  return SelectSet{SetOperation::kAnyOf, std::move(parts)};
}
Selection not_in(const Selection& selection) {
  return SelectSet{SetOperation::kNot, {{selection}}};
}

const SelectPlane kLeft{0, 0.0, {}};
const SelectPlane kFloor{1, 0.0, {}};

TEST(SelectionSets, OfVertices) {
  EXPECT_EQ(select_vertices(block(), all_of({{kLeft}, {kFloor}})).size(), 3U);
  EXPECT_EQ(select_vertices(block(), any_of({{kLeft}, {kFloor}})).size(), 9U + 15U - 3U);
  EXPECT_EQ(select_vertices(block(), not_in(kLeft)).size(), 45U - 9U);
  EXPECT_EQ(select_vertices(block(), not_in(SelectSurface{})).size(), 3U);
  EXPECT_EQ(select_vertices(block(), all_of({{kLeft}})).size(), 9U);
  // Nested, with a name; parts may select nothing.
  const SelectNamed left{"left", {{kLeft}}};
  const SelectSphere nothing{{9, 9, 9}, 1.0};
  EXPECT_EQ(select_vertices(block(), all_of({{left}, {not_in(kFloor)}, {not_in(nothing)}})).size(),
            6U);
  EXPECT_EQ(select_vertices(block(), any_of({{nothing}, {left}})), select_vertices(block(), kLeft));
  EXPECT_EQ(select_vertices(block(), SelectFaces{{-2, 0, 0}, 1.0}),
            select_vertices(block(), kLeft));
}

TEST(SelectionSets, AreEqualIfTheirPartsAre) {
  EXPECT_EQ(all_of({{kLeft}, {kFloor}}), all_of({{kLeft}, {kFloor}}));
  EXPECT_NE(all_of({{kLeft}, {kFloor}}), any_of({{kLeft}, {kFloor}}));
  EXPECT_NE(all_of({{kLeft}, {kFloor}}), all_of({{kLeft}, {kLeft}}));
  EXPECT_EQ(Selection(SelectNamed{"a", {{kLeft}}}), Selection(SelectNamed{"a", {{kLeft}}}));
  EXPECT_NE(Selection(SelectNamed{"a", {{kLeft}}}), Selection(SelectNamed{"b", {{kLeft}}}));
}

TEST(SelectionSets, RefuseWhatMakesNoSense) {
  expect_part(refusal(all_of({{kLeft}, {not_in(kLeft)}})), "selects no vertex");
  EXPECT_NE(refusal(all_of({})).find("all_of has 0 selections"), std::string::npos);
  expect_part(refusal(SelectSet{SetOperation::kNot, {{kLeft}, {kLeft}}}), "it takes one");
  EXPECT_NE(refusal(SelectNamed{"left", {}}).find("\"left\""), std::string::npos);
  // An error within a name says so.
  expect_part(refusal(SelectNamed{"tip", {{SelectGroup{"cornr"}}}}), "selection \"tip\": ");
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const Vector3& normal : {Vector3(0, 0, 0), Vector3(nan, 0, 0)}) {
    EXPECT_NE(refusal(SelectFaces{normal, 30.0}).find("not zero"), std::string::npos);
  }
  for (const double angle : {-1.0, 181.0, nan}) {
    EXPECT_NE(refusal(SelectFaces{{0, 0, 1}, angle}).find("0 to 180"), std::string::npos);
  }
}

TEST(SelectTetrahedra, SetsAreSetsOfTetrahedra) {
  TetMesh mesh = generate_box({2, 1, 1}, {2, 1, 1});
  mesh.groups.push_back({"core", 3, 7, {}, {2, 5}});
  const SelectBox right{{1, 0, 0}, {2, 1, 1}};
  const std::vector<Index> inside = select_tetrahedra(mesh, right);
  const std::vector<Index> outside = select_tetrahedra(mesh, not_in(right));
  EXPECT_EQ(inside.size() + outside.size(), 12u);
  for (const Index e : inside) EXPECT_EQ(std::count(outside.begin(), outside.end(), e), 0);
  EXPECT_EQ(select_tetrahedra(mesh, not_in(SelectGroup{"core"})).size(), 10u);
  EXPECT_EQ(select_tetrahedra(mesh, any_of({{SelectGroup{"core"}}, {right}})),
            select_tetrahedra(mesh, not_in(all_of({{not_in(SelectGroup{"core"})},
                                                   {SelectNamed{"rest", {{not_in(right)}}}}}))));
  EXPECT_THROW(select_tetrahedra(mesh, not_in(SelectAll{})), InputError);
}

double area(const TetMesh& mesh, const std::vector<std::array<Index, 3>>& triangles,
            Vector3* sum = nullptr) {
  double total = 0.0;
  Vector3 vector = Vector3::Zero();
  for (const auto& t : triangles) {
    const Vector3 a = mesh.vertices[static_cast<std::size_t>(t[0])];
    const Vector3 b = mesh.vertices[static_cast<std::size_t>(t[1])];
    const Vector3 c = mesh.vertices[static_cast<std::size_t>(t[2])];
    total += 0.5 * (b - a).cross(c - a).norm();
    vector += 0.5 * (b - a).cross(c - a);
  }
  if (sum != nullptr) *sum = vector;
  return total;
}

TEST(SelectTriangles, OfPlanesFacesAndSets) {
  const TetMesh& mesh = block();
  Vector3 sum;
  EXPECT_NEAR(area(mesh, select_triangles(mesh, SelectAll{}), &sum), 10.0, 1e-13);
  EXPECT_LT(sum.norm(), 1e-14);  // a closed surface
  const auto left = select_triangles(mesh, kLeft);
  EXPECT_NEAR(area(mesh, left, &sum), 1.0, 1e-14);
  EXPECT_LT((sum - Vector3(-1, 0, 0)).norm(), 1e-14);  // outward
  EXPECT_EQ(select_triangles(mesh, SelectFaces{{-3, 0, 0}, 0.0}), left);
  EXPECT_EQ(select_triangles(mesh, SelectFaces{{-3, 0, 0}, 89.0}), left);
  EXPECT_NEAR(area(mesh, select_triangles(mesh, SelectFaces{{-3, 0, 0}, 90.0})), 9.0, 1e-13);
  EXPECT_NEAR(area(mesh, select_triangles(mesh, SelectFaces{{-1, -1, 0}, 45.0})), 3.0, 1e-13);
  EXPECT_EQ(select_triangles(mesh, SelectFaces{{1, 2, 3}, 180.0}).size(),
            boundary_faces(mesh).size());
  // With faces, sets are sets of triangles: the complement of one side is the other five.
  EXPECT_NEAR(area(mesh, select_triangles(mesh, not_in(SelectFaces{{-1, 0, 0}, 30.0}))), 9.0,
              1e-13);
  EXPECT_NEAR(
      area(mesh, select_triangles(
                     mesh, all_of({{SelectFaces{{0, -1, 0}, 30.0}},
                                   {SelectNamed{"half", {{SelectBox{{0, 0, 0}, {1, 1, 1}}}}}}}))),
      1.0, 1e-14);
  // Without, triangles have three selected vertices: none on the left side at all.
  EXPECT_NEAR(area(mesh, select_triangles(mesh, not_in(kLeft))), 1.0 + 4 * 1.5, 1e-13);
}

std::string triangle_refusal(const TetMesh& mesh, const Selection& selection) {
  return message_of([&] { select_triangles(mesh, selection); });
}

// A box with groups of triangles: some of its floor, one inside, one on a vertex beside the box.
RawMesh box_with_triangles() {
  const TetMesh box = generate_box({1, 1, 1}, {1, 1, 1});
  RawMesh raw;
  raw.source = "box";
  for (Index v = 0; v < 8; ++v) {
    raw.vertices.push_back(box.vertices[static_cast<std::size_t>(v)]);
    raw.vertex_ids.push_back(100 + v);
  }
  raw.vertices.emplace_back(5, 5, 5);
  raw.vertex_ids.push_back(200);
  raw.groups = {{"floor", 2, 1}, {"cut", 2, 2}, {"stray", 2, 3}, {"line", 1, 4}};
  for (Index e = 0; e < box.tetrahedron_count(); ++e) {
    RawCell cell{CellType::kTetrahedron, e, {}, 0, {}};
    for (const Index v : box.tetrahedra[static_cast<std::size_t>(e)]) {
      cell.vertices.push_back(100 + v);
    }
    raw.cells.push_back(cell);
  }
  std::int64_t id = 10;
  const auto add = [&](std::array<std::int64_t, 3> v, std::vector<int> groups) {
    raw.cells.push_back({CellType::kTriangle, id++, {v.begin(), v.end()}, 0, std::move(groups)});
  };
  // Either order of the vertices, and one triangle twice.
  bool flip = false;
  for (const auto& face : boundary_faces(box)) {
    const auto z = [&](Index v) { return box.vertices[static_cast<std::size_t>(v)][2]; };
    if (z(face[0]) + z(face[1]) + z(face[2]) > 0.0) continue;
    add({100 + face[0], 100 + face[flip ? 2 : 1], 100 + face[flip ? 1 : 2]}, {0});
    flip = true;
  }
  add({raw.cells.back().vertices[1], raw.cells.back().vertices[2], raw.cells.back().vertices[0]},
      {0});
  const auto t = box.tetrahedra[0];
  for (const std::array<std::size_t, 3> f :
       {std::array<std::size_t, 3>{0, 1, 2}, {0, 1, 3}, {0, 2, 3}, {1, 2, 3}}) {
    add({100 + t[f[0]], 100 + t[f[1]], 100 + t[f[2]]}, {1});
  }
  add({100, 101, 200}, {2});
  return raw;
}

TEST(SelectTriangles, OfGroups) {
  const TetMesh mesh = build_mesh(box_with_triangles());
  Vector3 sum;
  const auto floor = select_triangles(mesh, SelectGroup{"floor"});
  EXPECT_EQ(floor.size(), 2U);
  EXPECT_NEAR(area(mesh, floor, &sum), 1.0, 1e-15);
  EXPECT_LT((sum - Vector3(0, 0, -1)).norm(), 1e-15);  // outward, whatever the file's order
  EXPECT_EQ(select_triangles(mesh, SelectFaces{{0, 0, -1}, 10.0}), floor);
  EXPECT_EQ(select_triangles(mesh, not_in(SelectGroup{"floor"})).size(), 10U);
  EXPECT_EQ(select_vertices(mesh, SelectGroup{"floor"}).size(), 4U);
  for (const Group& group : mesh.groups) {
    EXPECT_EQ(group.triangles.size(), group.name == "floor" ? 3U : group.name == "cut" ? 4U : 0U);
  }
}

TEST(SelectTriangles, RefusesTrianglesThatAreNotOnTheBoundary) {
  const TetMesh mesh = build_mesh(box_with_triangles());
  const std::string inside = triangle_refusal(mesh, SelectGroup{"cut"});
  EXPECT_NE(inside.find("\"cut\""), std::string::npos) << inside;
  EXPECT_NE(inside.find("not on the boundary"), std::string::npos) << inside;
  const std::string stray = triangle_refusal(mesh, not_in(SelectGroup{"stray"}));
  EXPECT_NE(stray.find("(100, 101, 200) of the group \"stray\""), std::string::npos) << stray;
  // As vertices, both can still be selected.
  EXPECT_EQ(select_vertices(mesh, SelectGroup{"cut"}).size(), 4U);
  EXPECT_EQ(select_vertices(mesh, SelectGroup{"stray"}).size(), 2U);
  const SelectNearest one{{0, 0, 0}};
  EXPECT_NE(triangle_refusal(mesh, one).find("selects no triangle"), std::string::npos);
  EXPECT_NE(triangle_refusal(mesh, SelectGroup{"flor"}).find("\"floor\""), std::string::npos);
}

}  // namespace
}  // namespace tetraction
