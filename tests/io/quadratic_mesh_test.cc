// Quadratic tetrahedra in mesh files and scenes.

#include <filesystem>
#include <fstream>

#include "support/folder_test.h"
#include "support/runs.h"
#include "tetraction/io/initial_fields.h"
#include "tetraction/io/mesh_quality.h"
#include "tetraction/io/mesh_reader.h"
#include "tetraction/io/mesh_writer.h"
#include "tetraction/io/run_recorder.h"
#include "tetraction/io/scene_reader.h"
#include "tetraction/mesh/edge_vertices.h"
#include "tetraction/simulation/probe.h"

namespace tetraction {
namespace {

using namespace testing_support;

class QuadraticMesh : public FolderTest {
 protected:
  static TetMesh curved() {
    TetMesh mesh = with_edge_vertices(generate_box({2, 1, 1}, {2, 1, 1}));
    for (Vector3& x : mesh.vertices.own()) x.z() += 0.1 * x.x() * x.x();
    mesh.groups.push_back({"end", 2, 5, {}, {}, {}, {}});
    for (const auto& face : boundary_faces(mesh)) {
      const auto at_end = [&](Index v) {
        return mesh.vertices[static_cast<std::size_t>(v)].x() > 1.99;
      };
      if (at_end(face[0]) && at_end(face[1]) && at_end(face[2])) {
        mesh.groups[0].triangles.push_back(face);
      }
    }
    return mesh;
  }

  std::string refusal(RawMesh raw) {
    return message_of<FileError>([&] { build_mesh(std::move(raw)); });
  }

  // One quadratic tetrahedron as a reader would give it.
  static RawMesh one_element() {
    const TetMesh mesh = with_edge_vertices(generate_tetrahedron(1.0));
    RawMesh raw;
    raw.source = "one.msh";
    for (Index v = 0; v < 10; ++v) {
      raw.vertices.push_back(mesh.vertices[static_cast<std::size_t>(v)]);
      raw.vertex_ids.push_back(v + 1);
    }
    RawCell cell;
    cell.type = CellType::kQuadraticTetrahedron;
    cell.id = 7;
    for (const Index v : RestState(mesh).nodes(0)) cell.vertices.push_back(v + 1);
    raw.cells = {cell};
    return raw;
  }
};

class QuadraticFormat : public QuadraticMesh, public testing::WithParamInterface<const char*> {};

TEST_P(QuadraticFormat, IsReadAsItWasWritten) {
  const TetMesh mesh = curved();
  const std::string file = path(std::string("mesh") + GetParam());
  write_mesh(mesh, file);
  const TetMesh read = read_mesh(file);
  ASSERT_TRUE(read.is_quadratic());
  EXPECT_EQ(read.report.reoriented, 0);
  ASSERT_EQ(read.tetrahedron_count(), mesh.tetrahedron_count());
  const RestState before(mesh);
  const RestState after(read);
  double difference = 0.0;
  for (Index e = 0; e < mesh.tetrahedron_count(); ++e) {
    for (std::size_t a = 0; a < 10; ++a) {
      difference +=
          (before.position(before.nodes(e)[a]) - after.position(after.nodes(e)[a])).norm();
    }
  }
  EXPECT_EQ(difference, 0.0);
  if (std::string(GetParam()) == ".msh") {
    ASSERT_EQ(read.groups.size(), 1U);
    EXPECT_EQ(read.groups[0].triangles.size(), 2U);
    EXPECT_EQ(read.groups[0].vertices.size(), 9U);
  }
}
INSTANTIATE_TEST_SUITE_P(All, QuadraticFormat, testing::Values(".vtu", ".vtk", ".msh"));

TEST_F(QuadraticMesh, OtherFormatsCannotHoldIt) {
  for (const char* ending : {".veg", ".node"}) {
    EXPECT_THROW(write_mesh(curved(), path(std::string("mesh") + ending)), InputError);
  }
}

TEST_F(QuadraticMesh, FileOfGmsh) {
  // A sphere of radius 1 by another program: curved edges come much nearer to its volume than
  // straight ones.
  const TetMesh mesh = read_mesh(TETRACTION_TEST_DATA "/meshes/sphere_p2.msh");
  ASSERT_TRUE(mesh.is_quadratic());
  const double curved_volume = mesh.total_volume();
  const double straight_volume = without_edge_vertices(mesh).total_volume();
  double radius = 0.0;
  for (const Vector3& x : mesh.vertices) radius = std::max(radius, x.norm());
  const double exact = 4.0 / 3.0 * M_PI * radius * radius * radius;
  EXPECT_LT(std::abs(curved_volume - exact), 0.2 * std::abs(straight_volume - exact));
  EXPECT_EQ(mesh_quality(mesh).front().values.size(), mesh.tetrahedra.size());
}

TEST_F(QuadraticMesh, BadElementsAreRefused) {
  EXPECT_EQ(refusal(one_element()), "accepted");
  RawMesh raw = one_element();
  std::swap(raw.cells[0].vertices[4], raw.cells[0].vertices[9]);
  EXPECT_NE(refusal(raw).find("order of another program"), std::string::npos) << refusal(raw);
  raw = one_element();
  raw.vertices[4] += Vector3(0.0, 0.0, 0.6);
  EXPECT_NE(refusal(raw).find("half of the edge"), std::string::npos) << refusal(raw);
  raw = one_element();
  raw.vertices[4] += Vector3(0.0, 0.4, 0.0);  // within half of the edge
  raw.vertices[4] += Vector3(0.0, 0.0, 0.25);
  EXPECT_NE(refusal(raw).find("inside out"), std::string::npos) << refusal(raw);
  raw = one_element();
  raw.cells[0].vertices[5] = raw.cells[0].vertices[4];
  EXPECT_NE(refusal(raw).find("twice"), std::string::npos) << refusal(raw);
  raw = one_element();
  raw.cells[0].vertices.resize(20, 1);
  EXPECT_NE(refusal(raw).find("20 nodes"), std::string::npos) << refusal(raw);
  raw = one_element();
  RawCell linear = raw.cells[0];
  linear.type = CellType::kTetrahedron;
  linear.vertices.resize(4);
  std::swap(linear.vertices[3], raw.cells[0].vertices[3]);
  linear.id = 8;
  raw = one_element();
  raw.cells.push_back(linear);
  EXPECT_NE(refusal(raw).find("one order"), std::string::npos) << refusal(raw);
  // Turned round: the middles go with the corners.
  raw = one_element();
  std::swap(raw.cells[0].vertices[2], raw.cells[0].vertices[3]);
  std::swap(raw.cells[0].vertices[6], raw.cells[0].vertices[7]);
  std::swap(raw.cells[0].vertices[5], raw.cells[0].vertices[8]);
  EXPECT_EQ(build_mesh(raw).report.reoriented, 1);
}

// The same corners with other middles are another shape.
TEST_F(QuadraticMesh, RepeatedElementsHaveTheSameMiddles) {
  RawMesh raw = one_element();
  raw.cells.push_back(raw.cells[0]);
  raw.cells[1].id = 77;
  EXPECT_EQ(build_mesh(raw).tetrahedron_count(), 1);
  raw.vertices.push_back(raw.vertices[9]);
  raw.vertex_ids.push_back(1000);
  raw.cells[1].vertices[9] = 1000;
  expect_part(message_of<FileError>([&] { build_mesh(raw); }),
              "element 77 has the corners of element");
}

// det(∂X/∂ξ) is at least 0.26 everywhere, but det[X1−X0, X2−X0, X3−X0] = −0.004.
RawMesh element_with_negative_corners() {
  RawMesh raw;
  raw.source = "curved.msh";
  raw.vertices = {{0, 0, 0},
                  {1, 0, 0},
                  {0, 1, 0},
                  {0.33, 0.33, -0.004},
                  {0.501768, -0.047418, -0.142064},
                  {0.56738, 0.541193, -0.196013},
                  {-0.074692, 0.548255, -0.120383},
                  {0.189528, 0.106953, -0.029424},
                  {0.712574, 0.20133, -0.057377},
                  {0.074754, 0.68853, -0.041516}};
  RawCell cell;
  cell.type = CellType::kQuadraticTetrahedron;
  cell.id = 1;
  for (std::int64_t v = 1; v <= 10; ++v) {
    raw.vertex_ids.push_back(v);
    cell.vertices.push_back(v);
  }
  raw.cells = {cell};
  return raw;
}

// The order of nodes that turns the element inside out.
RawMesh turned(RawMesh raw) {
  std::vector<std::int64_t>& v = raw.cells[0].vertices;
  std::swap(v[2], v[3]);
  std::swap(v[6], v[7]);
  std::swap(v[5], v[8]);
  return raw;
}

TEST_F(QuadraticMesh, OrientationIsThatOfTheCurvedElement) {
  for (const bool in_a_plane : {false, true}) {
    RawMesh raw = element_with_negative_corners();
    if (in_a_plane) raw.vertices[3].z() = 0.0;
    ASSERT_EQ(refusal(raw), "accepted") << in_a_plane;
    const TetMesh mesh = build_mesh(raw);
    EXPECT_EQ(mesh.report.reoriented, 0);
    EXPECT_GT(mesh.volume(0), 0.26 / 6.0 * (in_a_plane ? 0.9 : 1.0));
    const RestState rest(mesh);
    for (Index p = 0; p < 4; ++p) EXPECT_GT(rest.point_volume(p), 0.2 / 24.0);
    ASSERT_EQ(refusal(turned(raw)), "accepted");
    const TetMesh corrected = build_mesh(turned(raw));
    EXPECT_EQ(corrected.report.reoriented, 1);
    EXPECT_NEAR(corrected.volume(0), mesh.volume(0), 1e-15);
    // Probes find places in it.
    Scene scene = scene_of(elastic(1e5, 0.3));
    Vector3 inside = Vector3::Zero();  // N_a = −1/8 and 1/4 at the centroid
    for (std::size_t a = 0; a < 10; ++a) {
      inside += (a < 4 ? -0.125 : 0.25) * rest.position(rest.nodes(0)[a]);
    }
    scene.probe = {probe_at("p", ProbeQuantity::kPosition, inside)};
    Session session(scene, mesh);
    std::vector<double> found(3);
    session.probes().evaluate(session, found.data());
    EXPECT_LT((Vector3(found[0], found[1], found[2]) - inside).norm(), 1e-13);
  }
  // An element whose corners and curved edges are all in a plane has no volume.
  RawMesh flat = element_with_negative_corners();
  for (Vector3& x : flat.vertices) x.z() = 0.0;
  EXPECT_NE(refusal(flat).find("no volume"), std::string::npos) << refusal(flat);
}

TEST_F(QuadraticMesh, GroupsOfLinesHaveTheMiddlesOfTheirOwnEdges) {
  RawMesh raw = one_element();
  raw.cells[0].type = CellType::kTetrahedron;
  raw.cells[0].vertices.resize(4);
  raw.groups = {{"rim", 1, 3}};
  // The third edge of the triangle 1 2 3 is no line of the group.
  for (const auto& ends : {std::array{1, 2}, std::array{2, 3}}) {
    RawCell line;
    line.type = CellType::kLine;
    line.id = 8 + static_cast<std::int64_t>(raw.cells.size());
    line.vertices = {ends[0], ends[1]};
    line.groups = {0};
    raw.cells.push_back(line);
  }
  const TetMesh linear = build_mesh(raw);
  const TetMesh mesh = with_edge_vertices(linear);
  ASSERT_EQ(mesh.groups.size(), 1U);
  EXPECT_EQ(mesh.groups[0].vertices.size(), 5U);
  EXPECT_TRUE(write_mesh(mesh, path("lines.msh")).lost_groups.empty());
  const TetMesh read = read_mesh(path("lines.msh"));
  ASSERT_TRUE(read.is_quadratic());
  ASSERT_EQ(read.groups.size(), 1U);
  EXPECT_EQ(read.groups[0].vertices.size(), 5U);
  EXPECT_EQ(read.groups[0].lines.size(), 2U);
  EXPECT_EQ(without_edge_vertices(mesh).groups[0].vertices, linear.groups[0].vertices);
}

TEST_F(QuadraticMesh, SceneWithTheKey) {
  write_mesh(curved(), path("q.vtu"));
  const auto scene_text = [](const std::string& mesh) {
    return "[mesh]\n" + mesh +
           "\n[material]\nyoungs_modulus = 1e5\npoissons_ratio = 0.3\n[environment]\n"
           "kind = \"gravity\"\n[[fix]]\nselect = { plane = { axis = \"x\", at = 0.0 } }\n"
           "[time]\nintegrator = \"midpoint\"\nstep = 0.01\nend = 0.05\n";
  };
  const auto write = [&](const std::string& mesh) {
    std::ofstream(path("s.toml")) << scene_text(mesh);
    return path("s.toml");
  };
  EXPECT_THROW(read_scene_mesh(read_scene(write("file = \"q.vtu\""))), FileError);
  for (const char* mesh : {"file = \"q.vtu\"\nelement = \"quadratic\"",
                           "generate = { kind = \"box\", size = [2, 1, 1], cells = [2, 1, 1] "
                           "}\nelement = \"quadratic\""}) {
    const Scene scene = read_scene(write(mesh));
    const TetMesh read = read_scene_mesh(scene);
    EXPECT_TRUE(read.is_quadratic());
    Session session(scene, read);
    EXPECT_EQ(session.run(), RunStatus::kFinished) << session.message();
    EXPECT_LT(session.balance().max_relative_energy_drift(), 1e-3);
  }
}

}  // namespace
}  // namespace tetraction
