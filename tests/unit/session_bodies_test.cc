// Contact between bodies at the start of a run and in edits: what is refused, and the layer that is taken.
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "simulation/facts/free_motions.h"
#include "support/body_contact.h"
#include "support/cubes.h"
#include "tetraction/dynamics/contact/contact.h"

namespace tetraction {
namespace {

using namespace testing_support;

// Two cubes of 1 m with 2 × 2 × 2 cells, the second one at `at`.
Scene two_cubes(const Vector3& at) {
  Scene scene = scene_of({GeneratorKind::kCube, {1.0, 1.0, 1.0}, {2, 2, 2}}, elastic(1e6, 0.3));
  scene.time = {Integrator::kEnergyMomentum, 1e-3, false, 1e-2};
  MeshCopySettings copy;
  copy.at = at;
  scene.mesh.copies = {copy};
  scene.contact.between = ContactBetween::kBodies;
  return scene;
}

// Adds a mesh as a body, with its points mapped.
template <class Map>
void add_body(RawMesh& raw, const TetMesh& mesh, const Map& map) {
  const Vector rest = mesh.rest_positions();
  const auto first = static_cast<std::int64_t>(raw.vertices.size());
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    raw.vertices.emplace_back(map(Vector3(vertex_block(rest, v))));
    raw.vertex_ids.push_back(first + v);
  }
  for (const auto& corners : mesh.tetrahedra) {
    RawCell cell;
    cell.type = CellType::kTetrahedron;
    cell.id = static_cast<std::int64_t>(raw.cells.size());
    for (const Index v : corners) cell.vertices.push_back(first + v);
    raw.cells.push_back(cell);
  }
}

double thickness_of(const Scene& scene) {
  return Session(scene, mesh_of_bodies(scene)).system().contact()->between()->thickness;
}

void expect_refused(const Scene& scene, const std::vector<std::string>& parts) {
  expect_error([&] { Session(scene, mesh_of_bodies(scene)); }, parts);
}

TEST(SessionBodies, TheLayerIsNeverThickerThanAGapAtRest) {
  Scene scene = two_cubes({3.0, 0.0, 0.0});
  // The mean of edges of the length 0.5, their diagonals on the faces.
  const double usual = thickness_of(scene);
  EXPECT_GT(usual, 0.05);
  EXPECT_LT(usual, 0.0708);
  scene = two_cubes({1.02, 0.0, 0.0});
  EXPECT_NEAR(thickness_of(scene), 0.02, 1e-12);
  const Session session(scene, mesh_of_bodies(scene));
  EXPECT_TRUE(std::isinf(present_gap(session)));
  EXPECT_NEAR(thickness_of(two_cubes({1.0 + 1e-5, 0.0, 0.0})), 0.01 * usual, 1e-12);
  scene.contact.thickness = 0.03;
  scene.contact.stiffness = 5e4;
  EXPECT_EQ(thickness_of(scene), 0.03);
  EXPECT_NEAR(present_gap(Session(scene, mesh_of_bodies(scene))), 0.02, 1e-12);
}

TEST(SessionBodies, RefuseAStartThatPenetrates) {
  expect_refused(two_cubes({0.9, 0.1, 0.1}), {"penetrates another body", "up to 0.1 m deep",
                                              "vertices (", "contact.thickness"});
  expect_refused(two_cubes({1.0, 0.0, 0.0}),
                 {"that touch another body", "nearer than 5.", "1e-04 of the thickness",
                  "Contact needs a larger gap"});
  // The round-off of the place is no gap, and neither is what is below 1e-4 of the layer.
  expect_refused(two_cubes({1.0 + 1e-6, 0.0, 0.0}), {"that touch another body"});
  expect_refused(two_cubes({1.0 + 1e-15, 0.0, 0.0}), {"that touch another body"});
  expect_refused(two_cubes({1.0 - 1e-15, 0.0, 0.0}), {"that touch another body"});
  // As a whole inside, where no edge crosses a face.
  Scene scene = two_cubes({3.0, 0.0, 0.0});
  RawMesh raw;
  for (const double size : {1.0, 0.2}) {
    add_body(raw, mesh_of(scene), [&](const Vector3& p) {
      return Vector3(size * p + Vector3::Constant(size < 1.0 ? 0.4 : 0.0));
    });
  }
  scene.mesh.copies.clear();
  const TetMesh mesh = build_mesh(std::move(raw));
  expect_error([&] { Session(scene, mesh); },
               {"penetrates another body", "26 vertices", "0.4 m deep"});
  // Edges that cross without a vertex inside have no depth.
  scene = two_cubes({0.0, 0.0, 0.0});
  scene.mesh.copies[0].turn = {0.0, 0.0, 45.0};
  scene.mesh.copies[0].at = {0.0, 0.0, 0.5};
  EXPECT_NE(message_of([&] { Session(scene, mesh_of_bodies(scene)); }), "accepted");
}

TEST(SessionBodies, RefuseWhatIsNotOffered) {
  const Scene fair = two_cubes({1.5, 0.0, 0.0});
  EXPECT_EQ(message_of([&] { Session(fair, mesh_of_bodies(fair)); }), "accepted");
  Scene scene = fair;
  scene.contact.friction = -0.3;
  expect_refused(scene, {"contact.friction", "0 or more"});
  scene = fair;
  scene.contact.between = ContactBetween::kNone;
  scene.contact.friction = 0.3;
  expect_refused(scene, {"contact.friction", "contact.between", "\"bodies\" or \"all\""});
  scene = fair;
  scene.contact.between = ContactBetween::kNone;
  scene.contact.thickness = 0.01;
  expect_refused(scene, {"contact.thickness", "contact.between", "\"bodies\" or \"all\""});
  scene = fair;
  scene.solver.kind = "ceres";
  scene.time.integrator = Integrator::kBackwardEuler;
  expect_refused(scene, {"Ceres cannot take contact.between", "newton"});
  scene = fair;
  scene.mesh.copies.clear();
  expect_refused(scene, {"belong to one body", "contact.between = \"all\""});
  scene = fair;
  scene.contact.thickness = -0.01;
  expect_refused(scene, {"contact.thickness", "above 0"});
  scene.contact.thickness = 1.01;
  expect_refused(scene, {"contact.thickness", "1.01 m", "1 m long", "much smaller"});
  scene = fair;
  scene.contact.select = SelectSphere{Vector3(9.0, 9.0, 9.0), 0.1};
  expect_refused(scene, {"contact.select"});
}

// What [contact] leaves out passes through.
TEST(SessionBodies, SelectedFacesTouch) {
  Scene scene = two_cubes({0.9, 0.1, 0.1});
  scene.contact.select = SelectBox{Vector3(-0.1, -0.1, -0.1), Vector3(0.2, 2.0, 2.0)};
  expect_refused(scene, {"belong to one body"});
  scene.contact.select = SelectBox{Vector3(1.8, -0.1, -0.1), Vector3(3.0, 2.0, 2.0)};
  expect_refused(scene, {"belong to one body"});
}

TEST(SessionBodies, EditsThatPutABodyIntoAnotherOneAreRefused) {
  const Scene scene = two_cubes({1.5, 0.0, 0.0});
  Session session(scene, mesh_of_bodies(scene));
  ShiftSettings shift;
  for (Index v = 0; v < session.system().vertex_count() / 2; ++v) {
    shift.vertices.push_back(session.system().mesh().vertex_id(v));
    shift.displacement.emplace_back(0.7, 0.0, 0.0);
  }
  const Vector before = session.state().position;
  expect_error([&] { session.apply(ShiftState{shift}); }, {"another body"});
  EXPECT_EQ(session.state().position, before);
  // Edits of obstacles and materials keep the contact between bodies as it is.
  const BodyContact between = *session.system().contact()->between();
  session.apply(SetObstacle{std::nullopt, plane_obstacle("floor", {0.0, -0.5, 0.0})});
  ASSERT_NE(session.system().contact()->between(), nullptr);
  EXPECT_EQ(*session.system().contact()->between(), between);
  EXPECT_EQ(session.system().contact()->size(), 1U);
}

std::vector<std::string> free_motions_of(const Scene& scene, const TetMesh& mesh) {
  const Session session(scene, mesh);
  return find_free_motions(session.system()).whole;
}

// Within the layer and at its edge, whether the faces overlap as a whole or not.
TEST(SessionBodies, FlatFacesSupportEachOtherAcrossThemOnly) {
  for (const Vector3& at : {Vector3(0.0, 1.02, 0.0), Vector3(0.31, 1.02, -0.17),
                            Vector3(0.02, 1.02, 0.96), Vector3(0.0, 1.04, 0.3)}) {
    for (const double thickness : {0.0, 0.01, 0.05, 0.3}) {
      Scene scene = two_cubes(at);
      if (thickness > 0.0) scene.contact.thickness = thickness;
      scene.fix = {fix(SelectPlane{1, 0.0, {}})};
      const std::vector<std::string> motions = free_motions_of(scene, mesh_of_bodies(scene));
      ASSERT_EQ(motions.size(), 3U) << at.transpose() << ' ' << thickness;
      EXPECT_EQ(motions[0].substr(0, 12), "move along x");
      EXPECT_EQ(motions[1].substr(0, 12), "move along z");
      EXPECT_EQ(motions[2].substr(0, 12), "rotate about") << motions[2];
      scene.fix.push_back(fix(SelectPlane{1, 1.0 + at.y(), {}}, {true, false, true}));
      EXPECT_TRUE(free_motions_of(scene, mesh_of_bodies(scene)).empty());
    }
  }
}

// A ball in a wider bowl, and a block in a box without a lid: the faces of both support along their own normals.
TEST(SessionBodies, CupsHoldWhatIsInThem) {
  Scene scene = two_cubes({3.0, 0.0, 0.0});
  scene.mesh.copies.clear();
  scene.contact.thickness = 0.03;
  for (const double radius : {0.15, 0.2, 0.25}) {
    RawMesh raw;
    add_body(raw, generate_box({1.0, 1.0, 1.0}, {6, 6, 1}), [](const Vector3& p) {
      const Vector3 down = Vector3(2.0 * p.x() - 1.0, 2.0 * p.y() - 1.0, -1.1).normalized();
      return Vector3((0.3 + 0.1 * (1.0 - p.z())) * down);
    });
    add_body(raw, generate_box({2.0, 2.0, 2.0}, {3, 3, 3}), [&](const Vector3& p) {
      const Vector3 seen = p - Vector3::Ones();
      const double length = seen.norm();
      const Vector3 unit = length > 0.0 ? Vector3(seen / length) : seen;
      return Vector3(radius * seen.cwiseAbs().maxCoeff() * unit -
                     (0.3 - radius - 0.025) * Vector3::UnitZ());
    });
    scene.fix = {fix(SelectSphere{Vector3(0.0, 0.0, -0.4), 0.2})};
    for (const std::string& motion : free_motions_of(scene, build_mesh(std::move(raw)))) {
      EXPECT_EQ(motion.find("move along"), std::string::npos) << radius << ' ' << motion;
    }
  }
  RawMesh raw;
  std::vector<std::array<int, 3>> places;
  for (int x = 0; x < 3; ++x) {
    for (int y = 0; y < 3; ++y) {
      for (int z = 0; z < 2; ++z) {
        if (x != 1 || y != 1 || z != 1) places.push_back({x, y, z});
      }
    }
  }
  add_body(raw, cubes(places), [](const Vector3& p) { return p; });
  add_body(raw, cubes({{0, 0, 0}}),
           [](const Vector3& p) { return Vector3(0.96 * p + Vector3(1.02, 1.02, 1.02)); });
  scene.fix = {fix(SelectPlane{2, 0.0, {}})};
  EXPECT_TRUE(free_motions_of(scene, build_mesh(std::move(raw))).empty());
}

}  // namespace
}  // namespace tetraction
