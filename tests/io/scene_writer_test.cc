#include "tetraction/io/scene_writer.h"

#include <filesystem>
#include <fstream>

#include "support/folder_test.h"
#include "support/obstacles.h"
#include "support/runs.h"
#include "tetraction/io/mesh_reader.h"
#include "tetraction/io/scene_echo.h"
#include "tetraction/io/scene_reader.h"

namespace tetraction {
namespace {

using namespace testing_support;

namespace fs = std::filesystem;

class SceneWriter : public FolderTest {
 protected:
  Scene written_and_read(const Scene& scene) const {
    const std::string path = (folder_ / "scene.toml").string();
    write_scene(scene, path);
    return read_scene(path);
  }
};

// Everything that a scene says but its places and the paths of files.
std::string without_events_and_files(Scene scene) {
  scene.event.clear();
  scene.mesh.file = fs::weakly_canonical(scene.mesh.file).string();
  return scene_echo(scene);
}

// An edit as a scene that says what it does, to compare.
std::string text_of(const Edit& edit) {
  Scene scene = scene_of(GeneratorSettings{}, elastic(1e6, 0.3));
  std::string number;
  // An edit that changes an entry is shown like one that adds it, with its number.
  const auto shown = [&](auto part) -> Edit {
    if (part.index) number = std::to_string(*part.index);
    part.index.reset();
    return part;
  };
  Edit change = edit;
  if (const auto* material = std::get_if<SetMaterial>(&edit)) {
    number = std::to_string(material->region);
    scene.material = material->material;
    change = SetDamping{};
  }
  if (const auto* force = std::get_if<SetForce>(&edit)) change = shown(*force);
  if (const auto* fix = std::get_if<SetFix>(&edit)) change = shown(*fix);
  if (const auto* constraint = std::get_if<SetConstraint>(&edit)) change = shown(*constraint);
  if (const auto* obstacle = std::get_if<SetObstacle>(&edit)) change = shown(*obstacle);
  EventSettings event;
  event.edits = {change};
  scene.event = {event};
  return std::to_string(edit.index()) + " " + number + "\n" + scene_text(scene, "");
}

void expect_equal(const Scene& a, const Scene& b) {
  EXPECT_EQ(without_events_and_files(a), without_events_and_files(b));
  ASSERT_EQ(a.event.size(), b.event.size());
  for (std::size_t i = 0; i < a.event.size(); ++i) {
    EXPECT_EQ(a.event[i].at, b.event[i].at);
    ASSERT_EQ(a.event[i].edits.size(), b.event[i].edits.size()) << "event " << i;
    for (std::size_t j = 0; j < a.event[i].edits.size(); ++j) {
      EXPECT_EQ(text_of(a.event[i].edits[j]), text_of(b.event[i].edits[j]));
    }
  }
}

TEST_F(SceneWriter, ShippedScenesReadBackEqual) {
  int count = 0;
  for (const auto& entry : fs::directory_iterator(TETRACTION_SCENES)) {
    if (entry.path().extension() != ".toml") continue;
    SCOPED_TRACE(entry.path().filename().string());
    const Scene scene = read_scene(entry.path().string());
    const Scene read = written_and_read(scene);
    expect_equal(read, scene);
    expect_equal(written_and_read(read), scene);
    ++count;
  }
  EXPECT_GE(count, 10);
}

Scene full_scene() {
  Scene scene = testing_support::spinning_block(Integrator::kMidpoint, 1.0 / 3.0 * 1e-2, 0.1);
  scene.mesh.copies = {{{3.0, 0.0, 1.0 / 3.0}, {0, 0, 45}, {-1, 0, 0}, {}},
                       {{0.0, 9.0, 0.0}, {}, {}, {0, 0, 1.0 / 7.0}}};
  MaterialRegionSettings region{SelectSphere{{2, 1, 1}, 1.3}, scene.material, {}};
  region.material.density = 1234.5;
  scene.material_region = {region};
  scene.solver = {"newton", LinearSolver::kFactor, 1e-10, 37};
  scene.damping = {0.1, 0.2, 0.3};
  scene.environment = {EnvironmentKind::kGravity, 3.3, Vector3(1, 2, 3).normalized(), 0.0};
  FixSettings exact = fix(SelectPlane{0, 0.0, 1e-3}, {true, false, true});
  exact.velocity = {0, 0, -0.0625};
  FixSettings spring = springs(SelectVertices{{11, 10}}, 1e3);
  spring.targets = {{2, 1, 1.01}, {1, 1.1, 1}};
  FixSettings placed = fix(SelectNearest{{2, 0, 0}});
  placed.target = Vector3(2.0, 0.0, -1e-300);
  scene.fix = {exact, spring, placed};
  ConstraintSettings rod = testing_support::rod(4, 7, 1.4);
  ConstraintSettings plane = on_plane(SelectVertices{{7}}, {0, 2, 0.1});
  plane.point = Vector3(0, 0.5, 0);
  ConstraintSettings line = plane;
  line.kind = ConstraintKind::kLine;
  ConstraintSettings handle =
      driven(SelectBox{{2, 0, 0}, {2, 1, 1}}, Vector3(1, 0, 0), Vector3(0, 0, 2));
  handle.point = Vector3(0.5, 1, -2);
  scene.constraint = {rod, plane, line, handle};
  ObstacleSettings roller =
      cylinder_obstacle("a \"roller\"", {1, 1.0 / 3.0, 9}, {0, 0, 2}, 1.0 / 7.0, true);
  roller.friction = 1.0 / 3.0;
  roller.slip_speed = 1e-4;
  roller.thickness = 1e-3;
  roller.stiffness = 1e5;
  roller.select = SelectFaces{{0, 1, 0}, 5.0};
  roller.velocity = {0.1, 0, 0};
  roller.angular_velocity = {0, 0, 1.0 / 3.0};
  roller.about = Vector3(1, 2, 3);
  roller.from = 0.25;
  roller.until = 0.75;
  roller.offset = {0, 1e-17, 0};
  scene.obstacle = {roller, plane_obstacle("floor", {0, -3, 0}, {0.1, 2, 0})};
  ForceSettings force = load(SelectSurface{}, {1, -0.0, 1e22});
  force.from = 0.25;
  force.until = 0.75;
  ForceSettings forever;
  forever.vector = {0.1, 0.2, 0.3};
  scene.force = {force, forever};
  scene.initial.momentum = {{SelectGroup{"a \"group\" \\ of\tall"}, {1, 2, 3}, {}}};
  scene.initial.displacement_array = "u";
  scene.initial.velocity_array = "v";
  scene.output = {"out/dir", 3};
  scene.output.history_every = 4;
  scene.output.fields = {"default", "first_piola"};
  scene.output.precision = FramePrecision::kFloat32;
  scene.output.compression = FrameCompression::kZlib;
  scene.probe = {probe_at("inside", ProbeQuantity::kVonMises, {1.0 / 3.0, 0.2, 0.3}),
                 probe_of("end_1", ProbeQuantity::kReaction, SelectPlane{0, 2.0, {}}, 7)};
  // Selections of selections, by name and without.
  const SelectSet side{SetOperation::kAllOf,
                       {{SelectFaces{{0, 0, 1.0 / 3.0}, 12.5}},
                        {SelectSet{SetOperation::kNot, {{SelectPlane{0, 0.0, 1e-3}}}}}}};
  const SelectNamed top{"top", {{side}}};
  const SelectSet only_top{SetOperation::kAnyOf, {{top}}};
  const SelectNamed odd{"an \"odd\" name", {{only_top}}};
  scene.selection = {{"an \"odd\" name", only_top}, {"top", side}};
  ForceSettings named = forever;
  named.select = odd;
  ForceSettings unnamed = forever;
  unnamed.select =
      SelectSet{SetOperation::kAnyOf, {{top}, {SelectSet{SetOperation::kNot, {{odd}}}}, {side}}};
  scene.force.push_back(named);
  scene.force.push_back(unnamed);
  return scene;
}

TEST_F(SceneWriter, EveryKeyReadsBackEqual) {
  const Scene scene = full_scene();
  expect_equal(written_and_read(scene), scene);
  Scene other = scene;
  for (const auto& [kind, cells] :
       std::vector<std::pair<GeneratorKind, int>>{{GeneratorKind::kBeam, 3},
                                                  {GeneratorKind::kCube, 4},
                                                  {GeneratorKind::kTetrahedron, 1}}) {
    other.mesh = {};
    other.mesh.generate = GeneratorSettings{kind, {0.1, 0.1, 0.1}, {cells, cells, cells}};
    if (kind == GeneratorKind::kBeam) other.mesh.quadratic = true;
    if (kind == GeneratorKind::kCube) other.mesh.volume = VolumeRule::kNodal;
    other.material = {};
    other.material.model = "mooney-rivlin";
    other.material.numbers["mu1"] = 1e5;
    other.material.numbers["mu2"] = 0.0;
    other.material.numbers["lambda"] = 1e6;
    other.time = {};
    other.time.integrator = Integrator::kVerlet;
    other.time.automatic = true;
    other.environment = {EnvironmentKind::kAttraction, 2.0, -Vector3::UnitX(), 0.125};
    expect_equal(written_and_read(other), other);
  }
}

// Every kind of edit, some of which take keys out again, each an event.
std::vector<Edit> every_edit(const Scene& scene) {
  MaterialSettings moduli;
  moduli.model = "stvk";
  moduli.numbers["mu"] = 3e4;
  moduli.numbers["lambda"] = 1e5 / 3.0;
  MaterialSettings in_region = moduli;
  in_region.density = 1234.5;
  MaterialSettings rubber = scene.material;
  rubber.model = "mooney-rivlin";
  rubber.numbers["ratio"] = 0.25;
  FixSettings fix = scene.fix[0];
  fix.select = SelectAll{};
  fix.velocity.setZero();
  FixSettings placed = scene.fix[2];
  placed.target.reset();
  placed.offset = Vector3(0.1, 0.2, 0.3);
  FixSettings exact = scene.fix[1];
  exact.is_penalty = false;
  exact.penalty = 0.0;
  exact.targets.clear();
  ForceSettings forever = scene.force[0];
  forever.until = std::numeric_limits<double>::infinity();
  forever.select = SelectVertices{{1, 2, 3}};
  ForceSettings inside_out = scene.force[2];
  inside_out.select = SelectSet{SetOperation::kNot,
                                {{SelectSet{SetOperation::kNot, {{SelectSphere{{1, 2, 3}, 4}}}}}}};
  ForceSettings of_nothing = scene.force[2];
  of_nothing.select = SelectSet{SetOperation::kNot, {{scene.force[2].select}}};
  ConstraintSettings now_a_line = scene.constraint[2];
  ConstraintSettings now_a_rod = scene.constraint[0];
  TimeSettings automatic;
  automatic.integrator = Integrator::kExplicit;
  automatic.automatic = true;
  automatic.end = 2.0;
  ObstacleSettings drum = scene.obstacle.at(0);
  drum.velocity = {0.1, 1e-17, 3};
  drum.friction = 0.25;
  ObstacleSettings wall;
  wall.name = "another wall";
  wall.kind = ObstacleKind::kPlane;
  wall.point = {1, 2, 3};
  MomentumSettings kick;
  kick.value = {1e-17, 0, 3};
  return {SetMaterial{0, rubber},
          SetMaterial{0, moduli},
          SetMaterial{0, scene.material},
          SetMaterial{1, in_region},
          SetTime{automatic},
          SetTime{scene.time},
          SetSolver{{"ceres", LinearSolver::kAuto, 1e-7, 50}},
          SetDamping{},
          SetDamping{},  // which changes nothing, and is an edit all the same
          SetEnvironment{{EnvironmentKind::kNone, 1.0, Vector3::UnitX(), 0.5}},
          SetPull{{{2, 1}, {0.1, 1e-17, 3}, 40.0, 2.0}},
          SetPull{},
          SetForce{0, forever},
          SetForce{std::nullopt, forever},
          SetForce{4, scene.force[0]},
          SetForce{4, scene.force[2]},
          SetForce{4, scene.force[3]},
          SetForce{2, inside_out},
          SetForce{3, of_nothing},
          SetFix{0, fix},
          SetFix{1, exact},
          SetFix{1, scene.fix[1]},
          SetFix{2, placed},
          SetFix{std::nullopt, placed},
          SetFix{3, fix},
          Unfix{},
          Unfix{SelectVertices{{1, 2}}, {}, 3},
          SetConstraint{0, now_a_line},
          SetConstraint{3, now_a_rod},
          SetConstraint{std::nullopt, scene.constraint[3]},
          RemoveConstraint{4},
          SetConstraint{4, scene.constraint[1]},
          SetObstacle{0, drum},
          SetObstacle{std::nullopt, wall},
          RemoveObstacle{0},
          SetMomentum{kick},
          ShiftState{{{1, 2}, {{1, 2, 3}, {0.1, 0.2, 0.3}}, {}, {}}},
          ShiftState{{{7}, {}, {{0, 0, 1}}, {}}}};
}

TEST_F(SceneWriter, EveryEditReadsBackEqual) {
  Scene scene = full_scene();
  double at = 0.0;
  for (const Edit& edit : every_edit(scene)) {
    EventSettings event;
    event.at = at += 1.0 / 3.0;
    event.note = "a note\nof two lines";
    event.edits = {edit};
    scene.event.push_back(event);
  }
  expect_equal(written_and_read(scene), scene);
}

TEST_F(SceneWriter, EditsOfOneEventKeepTheirOrder) {
  Scene scene = full_scene();
  const EventSettings event{0.5, every_edit(scene), {}, {}};
  scene.event = {event};
  const Scene read = written_and_read(scene);
  EXPECT_GT(read.event.size(), 1U);
  std::vector<Edit> edits;
  for (const EventSettings& part : read.event) {
    EXPECT_EQ(part.at, 0.5);
    edits.insert(edits.end(), part.edits.begin(), part.edits.end());
  }
  ASSERT_EQ(edits.size(), event.edits.size());
  for (std::size_t i = 0; i < edits.size(); ++i) {
    EXPECT_EQ(text_of(edits[i]), text_of(event.edits[i])) << i;
  }
}

TEST_F(SceneWriter, NamesMeshFilesRelativeToTheScene) {
  Scene scene = full_scene();
  scene.mesh = {};
  scene.mesh.file = (folder_ / "meshes" / "body.vtu").string();
  scene.mesh.scale = 0.001;
  expect_part(scene_text(scene, folder_.string()), "file = \"meshes/body.vtu\"");
  expect_part(scene_text(scene, (folder_ / "scenes").string()), "file = \"../meshes/body.vtu\"");
  expect_part(scene_text(scene, "/nowhere/else"), "file = \"" + scene.mesh.file + "\"");
  expect_equal(written_and_read(scene), scene);
}

TEST_F(SceneWriter, NamesSurfacesOfObstaclesRelativeToTheScene) {
  Scene scene = full_scene();
  ObstacleSettings step;
  step.name = "step";
  step.kind = ObstacleKind::kMesh;
  step.file = (folder_ / "step.obj").string();
  std::ofstream(step.file) << "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  scene.obstacle.push_back(step);
  EventSettings event;
  event.at = 0.5;
  step.name = "later";
  event.edits = {SetObstacle{std::nullopt, step}};
  scene.event = {event};
  fs::create_directory(folder_ / "scenes");
  const std::string path = (folder_ / "scenes" / "scene.toml").string();
  write_scene(scene, path);
  const std::string text = scene_text(scene, (folder_ / "scenes").string());
  EXPECT_EQ(text.find(step.file), std::string::npos);
  const Scene read = read_scene(path);
  ASSERT_TRUE(read.obstacle.back().surface);
  EXPECT_EQ(read.obstacle.back().surface->triangles.size(), 1U);
  const auto& added = std::get<SetObstacle>(read.event.at(0).edits.at(0));
  EXPECT_EQ(added.entry.name, "later");
  EXPECT_EQ(added.entry.surface, read.obstacle.back().surface);  // read once
}

TEST_F(SceneWriter, RefusesWhatASceneFileCannotSay) {
  const Scene scene = full_scene();
  Scene custom = scene;
  custom.material.custom = NeoHookean(1e5, 1e5);
  EXPECT_THROW(scene_text(custom, ""), InputError);
  Scene endless = scene;
  endless.time.end = std::numeric_limits<double>::infinity();
  EXPECT_THROW(scene_text(endless, ""), InputError);
  Scene bodiless = scene;
  bodiless.mesh = {};
  EXPECT_THROW(scene_text(bodiless, ""), InputError);
  EXPECT_THROW(write_scene(scene, (folder_ / "no" / "such.toml").string()), OutputError);
  EXPECT_TRUE(fs::is_empty(folder_));
}

}  // namespace
}  // namespace tetraction
