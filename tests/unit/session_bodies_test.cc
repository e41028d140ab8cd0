// Contact between bodies at the start of a run and in edits: what is refused, and the layer that is taken.
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "support/body_contact.h"
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
  expect_refused(two_cubes({1.0, 0.0, 0.0}), {"exactly on another body", "Contact needs a gap"});
  // The round-off of the place is no gap.
  expect_refused(two_cubes({1.0 + 1e-15, 0.0, 0.0}), {"exactly on another body"});
  expect_refused(two_cubes({1.0 - 1e-15, 0.0, 0.0}), {"exactly on another body"});
  // As a whole inside, where no edge crosses a face.
  Scene scene = two_cubes({3.0, 0.0, 0.0});
  RawMesh raw;
  for (const double size : {1.0, 0.2}) {
    const TetMesh cube = mesh_of(scene);
    const Vector rest = cube.rest_positions();
    const auto first = static_cast<std::int64_t>(raw.vertices.size());
    for (Index v = 0; v < cube.vertex_count(); ++v) {
      raw.vertices.emplace_back(size * vertex_block(rest, v) +
                                Vector3::Constant(size < 1.0 ? 0.4 : 0.0));
      raw.vertex_ids.push_back(first + v);
    }
    for (const auto& corners : cube.tetrahedra) {
      RawCell cell;
      cell.type = CellType::kTetrahedron;
      cell.id = static_cast<std::int64_t>(raw.cells.size());
      for (const Index v : corners) cell.vertices.push_back(first + v);
      raw.cells.push_back(cell);
    }
  }
  scene.mesh.copies.clear();
  const TetMesh mesh = build_mesh(std::move(raw));
  expect_error([&] { Session(scene, mesh); }, {"penetrates another body", "0.4 m deep"});
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

}  // namespace
}  // namespace tetraction
