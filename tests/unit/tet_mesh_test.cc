#include "tetraction/mesh/tet_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <vector>

#include "support/bodies.h"
#include "support/messages.h"
#include "tetraction/core/error.h"
#include "tetraction/mesh/generate.h"

namespace tetraction {
namespace {

// A unit corner tetrahedron with one vertex more than it needs; ids 10, 20, 30, 40, 50.
RawMesh raw_tetrahedron() {
  RawMesh raw;
  raw.source = "test.msh";
  raw.vertices = {{0, 0, 0}, {1, 0, 0}, {9, 9, 9}, {0, 1, 0}, {0, 0, 1}};
  raw.vertex_ids = {10, 20, 30, 40, 50};
  raw.cells = {{CellType::kTetrahedron, 7, {10, 20, 40, 50}, 3, {}}};
  return raw;
}

// The message with which build_mesh() refuses.
std::string refusal(RawMesh raw) {
  return testing_support::message_of<FileError>([&] { build_mesh(std::move(raw)); });
}

TEST(BuildMesh, KeepsTheFilesIdsAndDropsUnusedVertices) {
  const TetMesh mesh = build_mesh(raw_tetrahedron(), 2.0);
  EXPECT_EQ(mesh.vertex_ids, (std::vector<std::int64_t>{10, 20, 40, 50}));
  EXPECT_EQ(mesh.tetrahedron_ids, std::vector<std::int64_t>{7});
  EXPECT_EQ(mesh.regions, std::vector<int>{3});
  EXPECT_EQ(mesh.report.dropped_vertices, 1);
  EXPECT_EQ(mesh.report.reoriented, 0);
  EXPECT_NEAR(mesh.total_volume(), 8.0 / 6.0, 1e-15);
}

TEST(BuildMesh, ReorientsInvertedTetrahedraAndCountsThem) {
  RawMesh raw = raw_tetrahedron();
  std::swap(raw.cells[0].vertices[0], raw.cells[0].vertices[1]);
  const TetMesh mesh = build_mesh(raw);
  EXPECT_EQ(mesh.report.reoriented, 1);
  EXPECT_GT(mesh.volume(0), 0.0);
}

TEST(BuildMesh, ReportsOtherCellsAndKeepsTheirGroups) {
  RawMesh raw = raw_tetrahedron();
  raw.groups = {{"face", 2, 5}, {"body", 3, 1}};
  raw.cells.push_back({CellType::kTriangle, 8, {10, 20, 40}, 0, {0}});
  raw.cells.push_back({CellType::kLine, 9, {10, 30}, 0, {0}});
  raw.cells[0].groups = {1};
  const TetMesh mesh = build_mesh(raw);
  // A selection can take the triangle, but not the line: the group is one of triangles.
  EXPECT_EQ(mesh.report.skipped_cells, (std::map<CellType, Index>{{CellType::kLine, 1}}));
  EXPECT_EQ(mesh.groups[0].vertices, (std::vector<Index>{0, 1, 2})) << "30 was dropped";
  EXPECT_EQ(mesh.groups[1].tetrahedra, std::vector<Index>{0});
}

TEST(BuildMesh, RefusesWithTheElementsOwnId) {
  RawMesh flat = raw_tetrahedron();
  flat.vertices[4] = {0.3, 0.3, 0.0};
  EXPECT_NE(refusal(flat).find("element 7 has no volume"), std::string::npos);

  RawMesh nan = raw_tetrahedron();
  nan.vertices[3].y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(refusal(nan).find("vertex 40 (of element 7)"), std::string::npos);

  RawMesh missing = raw_tetrahedron();
  missing.cells[0].vertices[2] = 41;
  EXPECT_NE(refusal(missing).find("element 7 refers to vertex 41"), std::string::npos);

  RawMesh twice = raw_tetrahedron();
  twice.cells[0].vertices[2] = 10;
  EXPECT_NE(refusal(twice).find("element 7 has vertex 10 twice"), std::string::npos);

  RawMesh duplicate = raw_tetrahedron();
  duplicate.vertex_ids[1] = 10;
  EXPECT_NE(refusal(duplicate).find("vertex 10 is defined twice"), std::string::npos);

  RawMesh numbers = raw_tetrahedron();
  numbers.vertices.emplace_back(1, 1, 1);
  numbers.vertex_ids.push_back(60);
  numbers.cells.push_back(numbers.cells[0]);
  EXPECT_EQ(refusal(numbers), "accepted") << "the same element once more";
  numbers.cells[1].vertices[0] = 60;
  EXPECT_NE(refusal(numbers).find("element 7 is defined twice, with different vertices"),
            std::string::npos);

  RawMesh none = raw_tetrahedron();
  none.cells[0].type = CellType::kHexahedron;
  EXPECT_NE(refusal(none).find("no tetrahedra (only 1 of type hexahedron)"), std::string::npos);

  RawMesh quadratic = raw_tetrahedron();
  quadratic.cells[0].type = CellType::kQuadraticTetrahedron;
  EXPECT_NE(refusal(quadratic).find("element 7 is a tetrahedron with 4 nodes"), std::string::npos);
}

TEST(BuildMesh, RefusesMeaninglessScalesAndGroups) {
  for (const double scale : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN(),
                             std::numeric_limits<double>::infinity()}) {
    EXPECT_THROW(build_mesh(raw_tetrahedron(), scale), InputError) << scale;
  }
  RawMesh group = raw_tetrahedron();
  group.cells[0].groups = {0};
  EXPECT_NE(refusal(group).find("group 0, which does not exist"), std::string::npos);
}

TEST(BoundaryFaces, CloseTheBodyAndPointOutward) {
  const TetMesh mesh = testing_support::small_block();
  // Gauss: the flux of x through the boundary is three times the volume.
  double flux = 0.0;
  for (const auto& f : boundary_faces(mesh)) {
    const Vector3& a = mesh.vertices[static_cast<std::size_t>(f[0])];
    const Vector3& b = mesh.vertices[static_cast<std::size_t>(f[1])];
    const Vector3& c = mesh.vertices[static_cast<std::size_t>(f[2])];
    Matrix3 corners;
    corners << a, b, c;
    flux += 0.5 * jacobian(corners);
  }
  EXPECT_NEAR(flux, 3.0 * mesh.total_volume(), 1e-12);
}

// A face of the boundary belongs to one tetrahedron. They come in the order of their sorted vertices, also if a mesh
// has more tetrahedra than are compared together.
TEST(BoundaryFaces, AreThoseOfOneTetrahedronInTheOrderOfTheirVertices) {
  for (const int cells : {3, 36}) {
    const TetMesh mesh = generate_box({1, 1, 1}, {cells, cells, cells});
    std::map<std::array<Index, 3>, int> counts;
    for (const auto t : mesh.tetrahedra) {
      for (std::size_t left_out = 0; left_out < 4; ++left_out) {
        std::array<Index, 3> face{};
        for (std::size_t a = 0, k = 0; a < 4; ++a) {
          if (a != left_out) face[k++] = t[a];
        }
        std::sort(face.begin(), face.end());
        ++counts[face];
      }
    }
    std::vector<std::array<Index, 3>> expected;
    for (const auto& [face, count] : counts) {
      if (count == 1) expected.push_back(face);
    }
    std::vector<std::array<Index, 3>> found = boundary_faces(mesh);
    for (auto& face : found) std::sort(face.begin(), face.end());
    EXPECT_EQ(found, expected);
    EXPECT_EQ(static_cast<Index>(found.size()), 12 * cells * cells);
  }
}

// Each tetrahedron becomes eight with the same orientation that fill it.
TEST(RefinedMesh, KeepsVolumeVerticesAndFields) {
  TetMesh mesh = generate_box({2, 1, 1}, {2, 1, 1});
  const auto count = static_cast<std::size_t>(mesh.tetrahedron_count());
  mesh.regions.assign(count, 0);
  mesh.regions.back() = 5;
  mesh.cell_arrays["density"] = Matrix::Constant(1, mesh.tetrahedron_count(), 3.0);
  mesh.cell_arrays["density"](0, 1) = 7.0;
  mesh.point_arrays["displacement"] = Matrix(3, mesh.vertex_count());
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    mesh.point_arrays["displacement"].col(v) = 2.0 * mesh.vertices[static_cast<std::size_t>(v)];
  }
  Group face{"face", 2, 0, {}, {}};
  for (const auto& triangle : boundary_faces(mesh)) {
    const bool is_at_start = std::all_of(triangle.begin(), triangle.end(), [&](Index v) {
      return mesh.vertices[static_cast<std::size_t>(v)].x() == 0.0;
    });
    if (!is_at_start) continue;
    face.triangles.push_back(triangle);
    face.vertices.insert(face.vertices.end(), triangle.begin(), triangle.end());
  }
  std::sort(face.vertices.begin(), face.vertices.end());
  face.vertices.erase(std::unique(face.vertices.begin(), face.vertices.end()), face.vertices.end());
  Group volume{"volume", 3, 0, {}, {}};
  volume.tetrahedra = {1};
  mesh.groups = {face, volume};

  const TetMesh fine = refined_mesh(mesh);
  ASSERT_EQ(fine.tetrahedron_count(), 8 * mesh.tetrahedron_count());
  EXPECT_EQ(fine.vertex_count(), 5 * 3 * 3);
  EXPECT_FALSE(fine.is_quadratic());
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    EXPECT_EQ(fine.vertices[v], mesh.vertices[v]);
  }
  for (Index e = 0; e < fine.tetrahedron_count(); ++e) {
    EXPECT_NEAR(fine.volume(e), mesh.volume(e / 8) / 8.0, 1e-15) << e;
    EXPECT_EQ(fine.region(e), mesh.region(e / 8));
    EXPECT_EQ(fine.cell_arrays.at("density")(0, e), mesh.cell_arrays.at("density")(0, e / 8));
  }
  for (Index v = 0; v < fine.vertex_count(); ++v) {
    const Vector3 x = fine.vertices[static_cast<std::size_t>(v)];
    EXPECT_EQ(Vector3(fine.point_arrays.at("displacement").col(v)), Vector3(2.0 * x));
  }
  EXPECT_EQ(fine.groups[0].triangles.size(), 4 * face.triangles.size());
  EXPECT_EQ(fine.groups[0].vertices.size(), 9U);
  EXPECT_EQ(fine.groups[1].tetrahedra, (std::vector<Index>{8, 9, 10, 11, 12, 13, 14, 15}));
  EXPECT_EQ(boundary_faces(fine).size(), 4 * boundary_faces(mesh).size());

  const TetMesh quadratic = refined_mesh(with_edge_vertices(mesh));
  EXPECT_TRUE(quadratic.is_quadratic());
  EXPECT_EQ(quadratic.tetrahedron_count(), fine.tetrahedron_count());
  EXPECT_NEAR(quadratic.total_volume(), 2.0, 1e-14);
}

// x = X + a quadratic polynomial, which the elements of ten nodes represent exactly.
Vector3 bent_place(const Vector3& x) {
  return {x.x() + 0.1 * x.y() * x.y(), x.y() + 0.2 * x.x() * x.z() - 0.05 * x.x() * x.x(),
          x.z() - 0.15 * x.x() * x.y()};
}

// The mean ratio of the worst tetrahedron, 12 (3V)^(2/3)/(sum of the squared edges), which is 1 for a regular one.
double worst_shape(const TetMesh& mesh) {
  double worst = 1.0;
  for (Index e = 0; e < mesh.tetrahedron_count(); ++e) {
    const auto& corners = mesh.tetrahedra[static_cast<std::size_t>(e)];
    double edges = 0.0;
    for (const auto& [a, b] : kTetrahedronEdges) {
      edges += (mesh.vertices[static_cast<std::size_t>(corners[a])] -
                mesh.vertices[static_cast<std::size_t>(corners[b])])
                   .squaredNorm();
    }
    worst = std::min(worst, 12.0 * std::cbrt(std::pow(3.0 * mesh.volume(e), 2)) / edges);
  }
  return worst;
}

// A box of cubes or cuboids has the same tetrahedra with half their size. Others do not become ever flatter: each
// has at most three shapes (J. Bey, Computing 55, 1995), if the diagonal of the octahedron is chosen well.
TEST(RefinedMesh, KeepsTheShapesOfTetrahedra) {
  for (const Vector3& size : {Vector3(1, 1, 1), Vector3(4, 1, 1), Vector3(1, 2, 3)}) {
    TetMesh mesh = generate_box(size, {1, 1, 1});
    const double before = worst_shape(mesh);
    for (int i = 0; i < 3; ++i) {
      mesh = refined_mesh(mesh);
      EXPECT_NEAR(worst_shape(mesh), before, 1e-12) << size.transpose() << ", " << i;
    }
  }
  TetMesh tetrahedron = generate_tetrahedron(1.0);
  tetrahedron.vertices.own() = {{0, 0, 0}, {1.1, 0.1, 0}, {0.3, 0.9, -0.1}, {0.4, 0.2, 0.7}};
  double before = worst_shape(refined_mesh(tetrahedron));
  for (int i = 0; i < 4; ++i) {
    tetrahedron = refined_mesh(tetrahedron);
    EXPECT_GE(worst_shape(tetrahedron), 0.9 * before) << i;
  }
}

TEST(RefinedMesh, CurvedEdgesKeepTheirForm) {
  const TetMesh straight = with_edge_vertices(generate_box({2, 1, 1}, {2, 1, 1}));
  TetMesh mesh = straight;
  for (Vector3& x : mesh.vertices.own()) x = bent_place(x);
  Group skin{"skin", 2, 0, {}, {}};
  skin.triangles = boundary_faces(mesh);
  mesh.groups = {skin};
  const auto square = [](const Vector3& x) { return x.x() * x.x() - 3.0 * x.y() * x.z(); };
  const auto values_on = [&](const TetMesh& of) {
    Matrix values(1, of.vertex_count());
    for (Index v = 0; v < of.vertex_count(); ++v) {
      values(0, v) = square(of.vertices[static_cast<std::size_t>(v)]);
    }
    return values;
  };
  mesh.point_arrays["square"] = values_on(straight);

  const TetMesh fine = refined_mesh(mesh);
  const TetMesh flat = refined_mesh(straight);
  ASSERT_EQ(fine.vertex_count(), flat.vertex_count());
  for (std::size_t v = 0; v < fine.vertices.size(); ++v) {
    EXPECT_LE((fine.vertices[v] - bent_place(flat.vertices[v])).norm(), 1e-15 * 8) << v;
  }
  EXPECT_LE((fine.point_arrays.at("square") - values_on(flat)).cwiseAbs().maxCoeff(), 1e-15 * 8);
  for (Index e = 0; e < mesh.tetrahedron_count(); ++e) {
    double sum = 0.0;
    for (Index part = 8 * e; part < 8 * e + 8; ++part) {
      EXPECT_GT(fine.volume(part), 0.0) << part;
      sum += fine.volume(part);
    }
    EXPECT_NEAR(sum, mesh.volume(e), 1e-15) << e;
  }
  // The triangles of groups are faces of the boundary with the same orientation.
  const auto rotated = [](std::array<Index, 3> face) {
    std::rotate(face.begin(), std::min_element(face.begin(), face.end()), face.end());
    return face;
  };
  const auto sorted = [&](std::vector<std::array<Index, 3>> faces) {
    std::transform(faces.begin(), faces.end(), faces.begin(), rotated);
    std::sort(faces.begin(), faces.end());
    return faces;
  };
  EXPECT_EQ(sorted(fine.groups[0].triangles), sorted(boundary_faces(fine)));
  TetMesh linear = generate_box({2, 1, 1}, {2, 1, 1});
  skin.triangles = boundary_faces(linear);
  linear.groups = {skin};
  const TetMesh fine_linear = refined_mesh(linear);
  EXPECT_EQ(sorted(fine_linear.groups[0].triangles), sorted(boundary_faces(fine_linear)));
}

}  // namespace
}  // namespace tetraction
