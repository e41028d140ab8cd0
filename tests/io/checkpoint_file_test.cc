// Checkpoint files: a new session that goes on from one has the same bits as the run that wrote it, and
// no damaged file is taken for a whole one.
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "io/text/check_sum.h"
#include "support/corner_scenes.h"
#include "support/same_run.h"
#include "support/temporary_folder.h"
#include "tetraction/io/checkpoint_file.h"
#include "tetraction/io/initial_fields.h"
#include "tetraction/io/mesh_writer.h"
#include "tetraction/io/scene_reader.h"
#include "tetraction/io/text_file.h"

namespace tetraction {
namespace {

namespace fs = std::filesystem;
using namespace testing_support;

// A rule and a solver, as a scene names them.
struct Way {
  std::string name;
  std::string time{};    // keys of [time] besides step and end
  std::string solver{};  // keys of [solver]
  double step = 4e-3;
  bool has_equations = true;  // distances and free handles
};

void PrintTo(const Way& way, std::ostream* out) {
  *out << way.name;
}

constexpr int kSteps = 60;

class CheckpointFiles : public testing::TestWithParam<Way> {
 protected:
  std::string path(const std::string& name) const { return (folder_.path() / name).string(); }

  static Index vertex_near(const TetMesh& mesh, const Vector3& point) {
    return select_vertices(mesh, SelectNearest{point}).front();
  }

  // Nearly everything that a scene can have, with events before and after step 20, in units of the
  // step, so that each rule sees the same number of steps.
  Scene busy_scene(const Way& way) {
    TetMesh mesh = generate_box({4, 1, 1}, {6, 2, 2});
    Matrix modulus(1, mesh.tetrahedron_count());
    for (Index e = 0; e < modulus.cols(); ++e) modulus(0, e) = 1e6 + 1e3 * static_cast<double>(e);
    mesh.cell_arrays["E"] = modulus;
    write_mesh(mesh, path("mesh.vtu"));
    const double h = way.step;
    const std::string distance = fmt::format("vertices = [{}, {}]", vertex_near(mesh, {2, 0, 0}),
                                             vertex_near(mesh, {2, 1, 1}));
    const std::string other_distance = fmt::format(
        "vertices = [{}, {}]", vertex_near(mesh, {2.667, 0, 0}), vertex_near(mesh, {1.333, 1, 1}));
    const std::string text =
        "[mesh]\nfile = \"mesh.vtu\"\n"
        "[material]\nyoungs_modulus = { array = \"E\" }\npoissons_ratio = 0.4\n"
        "[[material_region]]\nselect = { box = { min = [3, -1, -1], max = [9, 2, 2] } }\n"
        "model = \"stvk\"\nyoungs_modulus = 2e6\npoissons_ratio = 0.3\n" +
        fmt::format("[time]\n{}\nstep = {}\nend = {}\n", way.time, h, kSteps * h) +
        (way.solver.empty() ? "" : "[solver]\n" + way.solver + "\n") +
        "[environment]\nkind = \"gravity\"\namplitude = \"swell\"\n"
        "[damping]\nmass_damping = 0.2\nviscosity = 20.0\n" +
        fmt::format("[[amplitude]]\nname = \"swell\"\nsine = {{ frequency = {}, offset = 1 }}\n",
                    0.02 / h) +
        fmt::format("[[amplitude]]\nname = \"rise\"\nsmooth_step = {{ from = 0, until = {} }}\n",
                    50 * h) +
        "[[fix]]\nselect = { plane = { axis = \"x\", at = 0 } }\n"
        "[[fix]]\nselect = { nearest = [2, 1, 0.5] }\noffset = [0, 0.01, 0]\namplitude = \"rise\"\n"
        "[[fix]]\nselect = { nearest = [2.667, 0.5, 1] }\nmode = \"penalty\"\npenalty = 300.0\n"
        "velocity = [0.1, 0, 0.1]\n" +
        (way.has_equations ? "[[constraint]]\nkind = \"distance\"\n" + distance + "\n"
                           : "[[constraint]]\nkind = \"plane\"\nselect = { nearest = [2, 0, 0] }\n"
                             "normal = [0, 1, 0.2]\n") +
        "[[constraint]]\nkind = \"rigid\"\nselect = { plane = { axis = \"x\", at = 4 } }\n"
        "angular_velocity = [0.5, 0, 0]\nvelocity = [0.02, 0, 0]\namplitude = \"swell\"\n"
        "[[constraint]]\nkind = \"line\"\nselect = { nearest = [1.333, 0, 0] }\n"
        "direction = [1, 0.1, 0]\n"
        "[[pressure]]\nselect = { faces = { normal = [0, 1, 0] } }\nvalue = 200.0\n"
        "amplitude = \"rise\"\n"
        "[[force]]\nselect = { nearest = [3.333, 1, 1] }\nvector = [0, 3, 1]\n" +
        fmt::format("until = {}\n", 35 * h) +
        // Before step 20: what it sets depends on where the vertices are then.
        fmt::format("[[event]]\nat = {}\n", 9 * h) +
        "set = { \"constraint.1.angular_velocity\" = [0.2, 0.3, 0], \"fix.2.penalty\" = 400.0, "
        "\"material_region.0.youngs_modulus\" = 1.8e6 }\n"
        "remove_constraint = 2\n"
        "fix = { select = { nearest = [1.333, 1, 0.5] }, offset = [0, 0.001, 0] }\n" +
        (way.has_equations ? "constraint = { kind = \"distance\", " + other_distance + " }\n"
                           : std::string("traction = { select = { plane = { axis = \"z\", at = 1 } "
                                         "}, vector = [0, 0, 20] }\n")) +
        fmt::format("[[event]]\nat = {}\n", 14 * h) +
        "set = { \"damping.viscosity\" = 30.0, \"fix.1.velocity\" = [0, 0, 0.02] }\n"
        "unfix = { select = { nearest = [0, 0, 0] } }\n"
        "shift = { vertices = [31], impulse = [[0.1, 0, 0]] }\n" +
        // After step 20.
        fmt::format("[[event]]\nat = {}\n", 30 * h) +
        "set = { \"environment.strength\" = 5.0, \"constraint.1.velocity\" = [0, 0.05, 0], "
        "\"pressure.0.value\" = 100.0 }\n"
        "unfix = { select = { all = true }, fix = 2 }\n"
        "[[probe]]\nname = \"tip\"\nselect = { nearest = [3.333, 1, 1] }\n"
        "quantity = \"displacement\"\n";
    write_text_file(path("scene.toml"), text);
    return read_scene(path("scene.toml"));
  }

  static std::unique_ptr<Session> session_of(const Scene& scene) {
    return std::make_unique<Session>(scene, read_scene_mesh(scene));
  }

  // Reads a file as `run --resume` does.
  static std::unique_ptr<Session> resumed(const Scene& scene, const std::string& directory) {
    const std::vector<CheckpointPath> paths = checkpoint_paths(directory);
    EXPECT_FALSE(paths.empty());
    StoredCheckpoint stored = read_checkpoint_file(paths.front().path);
    complete_settings(stored.checkpoint, scene);
    auto session = session_of(scene);
    session->restore(stored.checkpoint);
    return session;
  }

  static StoredCheckpoint stored_now(Session& session, bool is_regular = true) {
    StoredCheckpoint stored;
    stored.version = "test";
    stored.is_regular = is_regular;
    stored.inputs = inputs_of(session);
    stored.checkpoint = session.checkpoint();
    return stored;
  }

  TemporaryFolder folder_;
};

TEST_P(CheckpointFiles, ANewSessionGoesOnWithTheSameBits) {
  const Scene scene = busy_scene(GetParam());
  auto continued = session_of(scene);
  const double h = GetParam().step;  // adaptive steps have other sizes
  while (continued->time() < 19.5 * h) ASSERT_TRUE(continued->step()) << continued->message();
  ASSERT_EQ(continued->edits().size(), 2U);
  write_checkpoint_file(path("."), stored_now(*continued));
  auto restored = resumed(scene, path("."));
  expect_same(*continued, *restored);
  while (continued->time() < 39.5 * h) {
    ASSERT_TRUE(continued->step()) << continued->message();
    ASSERT_TRUE(restored->step()) << restored->message();
    ASSERT_EQ(continued->state().position, restored->state().position) << continued->time();
    ASSERT_EQ(continued->state().momentum, restored->state().momentum) << continued->time();
  }
  EXPECT_EQ(continued->edits().size(), 3U) << "an event came after the checkpoint";
  expect_same(*continued, *restored);
  // From one file to the next one, with an event in between that the first session did not make.
  write_checkpoint_file(path("."), stored_now(*restored));
  auto again = resumed(scene, path("."));
  EXPECT_EQ(again->state().step, continued->state().step);
  continued->checkpoint();
  while (continued->step()) ASSERT_TRUE(again->step()) << again->message();
  EXPECT_FALSE(again->step());
  EXPECT_EQ(continued->status(), RunStatus::kFinished) << continued->message();
  expect_same(*continued, *again);
}

std::vector<Way> ways() {
  std::vector<Way> all;
  for (const char* rule : {"midpoint", "backward-euler", "energy-momentum"}) {
    for (const char* solver : {"linear = \"auto\"", "linear = \"matrix-free\"", "linear = \"cg\"",
                               "linear = \"factor\"", "kind = \"ceres\""}) {
      Way way;
      way.name = std::string(rule) + '_' + solver;
      way.time = fmt::format("integrator = \"{}\"", rule);
      way.solver = solver;
      // The step that conserves energy has its own solver.
      if (way.name.find("energy") == 0 && way.name.find("ceres") != std::string::npos) continue;
      all.push_back(way);
    }
    all.push_back({std::string(rule) + "_error",
                   fmt::format("integrator = \"{}\"\nadapt = \"error\"\ntolerance = 1e-5", rule)});
    all.push_back({std::string(rule) + "_retry",
                   fmt::format("integrator = \"{}\"\nretry = 6", rule), "max_iterations = 3"});
  }
  all.push_back({"midpoint_energy", "integrator = \"midpoint\"\nadapt = \"energy\""});
  for (const char* rule : {"verlet", "explicit"}) {
    const std::string time = fmt::format("integrator = \"{}\"", rule);
    all.push_back({std::string(rule) + "_equations", time, "", 2e-4});
    all.push_back({std::string(rule) + "_free", time, "", 2e-4, false});
    all.push_back(
        {std::string(rule) + "_error", time + "\nadapt = \"error\"\ntolerance = 1e-5", "", 2e-4});
  }
  for (Way& way : all) {
    std::erase_if(way.name, [](char c) { return c == ' ' || c == '=' || c == '"'; });
    std::ranges::replace(way.name, '-', '_');
  }
  return all;
}

INSTANTIATE_TEST_SUITE_P(Ways, CheckpointFiles, testing::ValuesIn(ways()),
                         [](const auto& test) { return test.param.name; });

using CheckpointFile = CheckpointFiles;

Way verlet() {
  return {"verlet", "integrator = \"verlet\"", "", 2e-4};
}

// step = "auto": the limit, its modes and the schedule of its estimates.
TEST_F(CheckpointFile, AutomaticStepsGoOn) {
  for (const char* rule : {"verlet", "explicit"}) {
    std::string text =
        "[mesh]\ngenerate = { kind = \"beam\", size = [0.4, 0.1, 0.1], cells = [8, "
        "2, 2] }\n[material]\nyoungs_modulus = 1e6\npoissons_ratio = 0.4\n"
        "[damping]\nviscosity = 5.0\n"
        "[[fix]]\nselect = { plane = { axis = \"x\", at = 0 } }\n"
        "[[fix]]\nselect = { plane = { axis = \"x\", at = 0.4 } }\n"
        "velocity = [-2, 0, 0]\n[time]\nstep = \"auto\"\nend = 0.1\nintegrator = \"";
    text += rule;
    text += "\"\n[[event]]\nat = 0.01\nset = { \"damping.viscosity\" = 8.0 }\n";
    write_text_file(path("auto.toml"), text);
    const Scene scene = read_scene(path("auto.toml"));
    auto continued = session_of(scene);
    while (continued->time() < 0.05) ASSERT_TRUE(continued->step()) << continued->message();
    ASSERT_EQ(continued->edits().size(), 1U);
    const Index changes = continued->steps().changes;
    write_checkpoint_file(path("."), stored_now(*continued));
    auto restored = resumed(scene, path("."));
    while (continued->step()) ASSERT_TRUE(restored->step()) << restored->message();
    EXPECT_FALSE(restored->step());
    EXPECT_EQ(continued->status(), RunStatus::kFinished) << continued->message();
    EXPECT_GT(continued->steps().changes, changes);
    expect_same(*continued, *restored);
    remove_checkpoints(path("."));
  }
}

// A session that made no checkpoint has the same bits as one that did, with an explicit rule without
// equations: such a step remembers nothing that a new stepper would not compute with the same bits.
TEST_F(CheckpointFile, ExplicitStepsWithoutEquationsDoNotNoticeIt) {
  Way way = verlet();
  way.has_equations = false;
  const Scene scene = busy_scene(way);
  auto plain = session_of(scene);
  auto checked = session_of(scene);
  for (int k = 0; k < 40; ++k) {
    ASSERT_TRUE(plain->step()) << plain->message();
    ASSERT_TRUE(checked->step()) << checked->message();
    if (k % 7 == 0) checked->checkpoint();
  }
  expect_same(*plain, *checked);
}

std::string refusal(const std::function<void()>& call) {
  return message_of<FileError>([&] { call(); });
}

// Every truncation and every flipped bit.
TEST_F(CheckpointFile, NoDamageGoesUnnoticed) {
  write_text_file(path("small.toml"),
                  "[mesh]\ngenerate = { kind = \"tetrahedron\" }\n"
                  "[material]\nyoungs_modulus = 1e6\npoissons_ratio = 0.4\n"
                  "[time]\nintegrator = \"midpoint\"\nstep = 1e-3\nend = 1.0\n"
                  "[environment]\nkind = \"gravity\"\n"
                  "[[fix]]\nselect = { vertices = [0] }\n"
                  "[[constraint]]\nkind = \"distance\"\nvertices = [1, 2]\n");
  auto session = session_of(read_scene(path("small.toml")));
  for (int k = 0; k < 3; ++k) ASSERT_TRUE(session->step());
  const std::string bytes = checkpoint_bytes(stored_now(*session));
  EXPECT_EQ(checkpoint_bytes(checkpoint_from_bytes(bytes, "x")), bytes);
  const std::string said = "x: not a valid checkpoint (";
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const std::string message =
        refusal([&] { checkpoint_from_bytes(std::string_view(bytes).substr(0, size), "x"); });
    ASSERT_EQ(message.rfind(said, 0), 0U) << size << ": " << message;
  }
  std::string damaged = bytes;
  for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
    const auto flip = [&] {
      damaged[bit / 8] = static_cast<char>(damaged[bit / 8] ^ (1 << (bit % 8)));
    };
    flip();
    const std::string message = refusal([&] { checkpoint_from_bytes(damaged, "x"); });
    ASSERT_EQ(message.rfind(said, 0), 0U) << bit << ": " << message;
    flip();
  }
  EXPECT_NE(refusal([&] { checkpoint_from_bytes(bytes + "x", "x"); }), "accepted");
  EXPECT_NE(refusal([&] { checkpoint_from_bytes(bytes + bytes, "x"); }), "accepted");
}

// The bytes with another word of eight bytes in one place, and with the check sum of a whole file.
std::string forged(std::string bytes, std::size_t place, std::uint64_t word) {
  std::memcpy(bytes.data() + place, &word, sizeof word);
  const std::uint64_t sum =
      check_sum(std::string_view(bytes).substr(0, bytes.size() - sizeof(std::uint64_t)));
  std::memcpy(bytes.data() + bytes.size() - sizeof sum, &sum, sizeof sum);
  return bytes;
}

// A file with any number in any place is refused, or the run goes on with finite numbers.
TEST_F(CheckpointFile, ForgedNumbersAreRefused) {
  for (const std::string& rule : {std::string("integrator = \"midpoint\"\nstep = 1e-3"),
                                  std::string("integrator = \"verlet\"\nstep = \"auto\"")}) {
    write_text_file(path("small.toml"),
                    "[mesh]\ngenerate = { kind = \"tetrahedron\" }\n"
                    "[material]\nyoungs_modulus = 1e6\npoissons_ratio = 0.4\n[time]\n" +
                        rule +
                        "\nend = 1.0\n[damping]\nviscosity = 1.0\n"
                        "[environment]\nkind = \"gravity\"\n"
                        "[[fix]]\nselect = { vertices = [0] }\n"
                        "[[constraint]]\nkind = \"distance\"\nvertices = [1, 2]\n"
                        "[[constraint]]\nkind = \"plane\"\nselect = { vertices = [3] }\n"
                        "normal = [0, 0, 1]\n"
                        "[[event]]\nat = 1e-9\nset = { \"environment.strength\" = 5.0 }\n");
    const Scene scene = read_scene(path("small.toml"));
    auto session = session_of(scene);
    for (int k = 0; k < 3; ++k) ASSERT_TRUE(session->step());
    const std::string bytes = checkpoint_bytes(stored_now(*session));
    const auto bits = [](double value) { return std::bit_cast<std::uint64_t>(value); };
    const double huge = std::numeric_limits<double>::max();
    const std::vector<std::uint64_t> words{bits(std::numeric_limits<double>::quiet_NaN()),
                                           bits(std::numeric_limits<double>::infinity()),
                                           bits(huge),
                                           bits(-1.0),
                                           0,
                                           1,
                                           1000000,
                                           std::uint64_t{1} << 62,
                                           ~std::uint64_t{0}};
    const std::size_t begin = bytes.find('\n') + 1 + 16;  // after the format and the size
    // Texts have any length, so that a number may begin at any byte; their places have a period of eight.
    for (std::size_t place = begin; place + 16 <= bytes.size(); ++place) {
      for (const std::uint64_t word : words) {
        const std::string file = forged(bytes, place, word);
        try {
          Checkpoint checkpoint = checkpoint_from_bytes(file, "x").checkpoint;
          complete_settings(checkpoint, scene);
          auto own = session_of(scene);
          checkpoint.body = own->checkpoint().body;
          own->restore(checkpoint);
          for (int k = 0; k < 2; ++k) own->step();
          EXPECT_TRUE(own->state().position.allFinite()) << place;
        } catch (const FileError&) {
        } catch (const InputError&) {
        }
      }
    }
  }
}

TEST_F(CheckpointFile, UnreadableFilesAreNamed) {
  expect_part(refusal([&] { read_checkpoint_file(path("none.ckpt")); }), "none.ckpt: cannot");
  expect_part(refusal([&] { read_checkpoint_file(path(".")); }), "cannot be read");
  write_text_file(path("empty.ckpt"), "");
  expect_part(refusal([&] { read_checkpoint_file(path("empty.ckpt")); }), "not a valid");
}

// A file of a size that no machine has the memory for: it is refused before it is read.
TEST_F(CheckpointFile, AnAnnouncedSizeIsCheckedBeforeReading) {
  auto session = session_of(busy_scene(verlet()));
  write_checkpoint_file(path("."), stored_now(*session));
  const std::string file = checkpoint_paths(path(".")).front().path;
  fs::resize_file(file, std::uintmax_t{1} << 40);  // a sparse file
  expect_part(refusal([&] { read_checkpoint_file(file); }), "(its size is wrong)");
  write_text_file(file, "no checkpoint at all, and longer than the beginning of one");
  fs::resize_file(file, std::uintmax_t{1} << 40);
  expect_part(refusal([&] { read_checkpoint_file(file); }), "does not begin as one");
}

TEST_F(CheckpointFile, AFolderOfThatNameIsLeftAlone) {
  auto session = session_of(busy_scene(verlet()));
  fs::create_directories(path("checkpoints/step_000000002.ckpt"));
  fs::create_directories(path("checkpoints/step_000000009.ckpt"));
  for (int k = 0; k < 4; ++k) {
    ASSERT_TRUE(session->step());
    write_checkpoint_file(path("."), stored_now(*session));
  }
  remove_checkpoints_after(path("."), 3, true);
  EXPECT_TRUE(fs::is_directory(path("checkpoints/step_000000002.ckpt")));
  EXPECT_TRUE(fs::is_directory(path("checkpoints/step_000000009.ckpt")));
  EXPECT_TRUE(fs::is_regular_file(path("checkpoints/step_000000003.ckpt")));
  EXPECT_FALSE(fs::exists(path("checkpoints/step_000000004.ckpt")));
}

TEST_F(CheckpointFile, TheNewestTwoRegularOnesAreKept) {
  const Scene scene = busy_scene(verlet());
  auto session = session_of(scene);
  const auto make = [&](bool is_regular) {
    ASSERT_TRUE(session->step());
    write_checkpoint_file(path("."), stored_now(*session, is_regular));
  };
  const auto names = [&] {
    std::vector<std::string> all;
    for (const CheckpointPath& file : checkpoint_paths(path("."))) {
      all.push_back(fs::path(file.path).filename().string());
    }
    return all;
  };
  EXPECT_TRUE(names().empty());
  for (int i = 0; i < 3; ++i) make(true);
  EXPECT_EQ(names(), (std::vector<std::string>{"step_000000003.ckpt", "step_000000002.ckpt"}));
  make(false);
  make(false);
  EXPECT_EQ(names(), (std::vector<std::string>{"stop_000000005.ckpt", "step_000000003.ckpt",
                                               "step_000000002.ckpt"}));
  make(true);
  EXPECT_EQ(names(), (std::vector<std::string>{"step_000000006.ckpt", "step_000000003.ckpt"}));
  write_text_file(path("checkpoints/step_x.ckpt"), "no number");
  write_text_file(path("checkpoints/notes.txt"), "of the user");
  EXPECT_EQ(names().size(), 2U);
  remove_checkpoints(path("."));
  EXPECT_TRUE(names().empty());
  EXPECT_TRUE(fs::exists(path("checkpoints/notes.txt")));
}

TEST_F(CheckpointFile, OnlyTheEventsOfTheSceneMayHaveEditedTheRun) {
  const Scene scene = busy_scene(verlet());
  auto session = session_of(scene);
  ASSERT_TRUE(session->step());
  session->apply(SetDamping{{0.0, 0.0, 10.0}});
  EXPECT_THROW(checkpoint_bytes(stored_now(*session)), InputError);
}

TEST_F(CheckpointFile, ChangesOfSceneAndMeshAreFound) {
  const Scene scene = busy_scene(verlet());
  const auto changed = [&](const std::string& override_text) {
    return changed_keys(scene.echo, read_scene(path("scene.toml"), {override_text}).echo);
  };
  using Keys = std::vector<std::string>;
  EXPECT_EQ(changed_keys(scene.echo, scene.echo), Keys{});
  EXPECT_EQ(changed("output.every=3"), Keys{});
  EXPECT_EQ(changed("output.checkpoint_every=100"), Keys{});
  EXPECT_EQ(changed("time.end=0.5"), Keys{"time.end"});
  EXPECT_EQ(changed("force.0.vector=[0, 3, 2]"), Keys{"force.0.vector"});
  EXPECT_EQ(changed("solver.tolerance=1e-9"), Keys{"solver.tolerance"});
  EXPECT_EQ(changed("event.1.at=0.003"), Keys{"event.1.at"});

  const auto inputs = [](const Scene& of) { return inputs_of(*session_of(of)); };
  const RunInputs before = inputs(scene);
  Scene other = scene;
  other.amplitude[1].points = {{0.0, 1.0}};
  EXPECT_NE(inputs(other).amplitudes, before.amplitudes);
  EXPECT_EQ(inputs(other).numbers, before.numbers);
  EXPECT_EQ(inputs(other).fields, before.fields);

  // Surfaces of obstacles, which the scene has from files.
  ObstacleSettings wall;
  wall.name = "wall";
  wall.kind = ObstacleKind::kMesh;
  wall.file = "wall.stl";
  MeshShape surface{{{100, 0, 0}, {100, 1, 0}, {100, 0, 1}}, {{0, 1, 2}}};
  wall.surface = std::make_shared<const MeshShape>(surface);
  other = scene;
  other.obstacle.push_back(wall);
  const std::uint64_t with_wall = inputs(other).surfaces;
  EXPECT_NE(with_wall, before.surfaces);
  EXPECT_EQ(inputs(other).surfaces, with_wall);
  surface.points[1].y() += 0.01;
  other.obstacle[0].surface = std::make_shared<const MeshShape>(surface);
  EXPECT_NE(inputs(other).surfaces, with_wall);
  // Those of events count, too.
  other = scene;
  other.event[0].edits.emplace_back(SetObstacle{std::nullopt, wall});
  EXPECT_EQ(inputs(other).surfaces, with_wall);

  // A checkpoint of a scene whose constraints are others does not fit.
  auto session = session_of(scene);
  ASSERT_TRUE(session->step());
  StoredCheckpoint stored = stored_now(*session);
  stored = checkpoint_from_bytes(checkpoint_bytes(stored), "x");
  other = scene;
  other.constraint.pop_back();
  other.event.clear();
  EXPECT_THROW(complete_settings(stored.checkpoint, other), InputError);
}

}  // namespace
}  // namespace tetraction
