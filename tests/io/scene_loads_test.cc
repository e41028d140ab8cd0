// Loads and amplitudes in scene files: reading, messages, writing, events.
#include <filesystem>

#include "support/folder_test.h"
#include "support/runs.h"
#include "tetraction/io/scene_echo.h"
#include "tetraction/io/scene_reader.h"
#include "tetraction/io/scene_writer.h"

namespace tetraction {
namespace {

using namespace testing_support;

namespace fs = std::filesystem;

const char* const kHead = R"([mesh]
generate = { kind = "box", size = [0.4, 0.2, 0.2], cells = [4, 2, 2] }
[material]
youngs_modulus = 5e4
poissons_ratio = 0.3
[time]
integrator = "midpoint"
step = 1e-3
end = 0.02
[[fix]]
select = { plane = { axis = "x", at = 0.0 } }
)";

class SceneLoads : public FolderTest {
 protected:
  Scene read(const std::string& text) const { return read_scene(file("scene.toml", kHead + text)); }
  // The message with which the scene is refused.
  std::string refusal(const std::string& text) const {
    return message_of<Error>(
        [&] {
          const Scene scene = read(text);
          Session(scene, generate_mesh(*scene.mesh.generate));
        },
        "nothing");
  }
  void expect_refusal(const std::string& text, const std::string& part) const {
    const std::string message = refusal(text);
    EXPECT_NE(message.find(part), std::string::npos) << text << "\n→ " << message;
  }
};

const char* const kEveryLoad = R"(
[[force]]
select = { plane = { axis = "x", at = 0.4 } }
total = [0.0, 0.3, 0.0]
share = "surface"
amplitude = "hat"
[[force]]
select = { nearest = [0.4, 0.2, 0.2] }
vector = [0.0, 0.0, 0.1]
from = 0.001
until = 0.005
[[moment]]
select = { plane = { axis = "x", at = 0.4 } }
vector = [0.02, 0.0, 0.0]
[[traction]]
select = { faces = { normal = [0, 1, 0], angle = 10 } }
vector = [5.0, 0.0, 0.0]
amplitude = "wave"
[[pressure]]
select = { surface = true }
value = 200.0
amplitude = "rise"
[[body_force]]
select = { all = true }
acceleration = [0.0, -3.0, 0.0]
[[body_force]]
select = { all = true }
vector = [0.0, 0.0, 80.0]
amplitude = "table"
[[amplitude]]
name = "hat"
points = [[0.0, 0.0], [2.5e-3, 2.5], [5e-3, 0.0]]
[[amplitude]]
name = "wave"
sine = { frequency = 50.0, phase = 0.3 }
[[amplitude]]
name = "rise"
smooth_step = { from = 0.0, until = 0.01 }
[[amplitude]]
name = "table"
file = "table.csv"
[environment]
kind = "gravity"
amplitude = "rise"
)";

TEST_F(SceneLoads, AllAreReadWrittenAndRead) {
  file("table.csv", "time; factor\n# a comment\n0.0; 1.0\n\n0.01; +2.0\n");
  const Scene scene = read(kEveryLoad);
  ASSERT_EQ(scene.force.size(), 2U);
  EXPECT_EQ(scene.force[0].total, Vector3(0.0, 0.3, 0.0));
  EXPECT_EQ(scene.force[0].share, LoadShare::kSurface);
  ASSERT_EQ(scene.body_force.size(), 2U);
  EXPECT_EQ(scene.body_force[0].acceleration, Vector3(0.0, -3.0, 0.0));
  EXPECT_EQ(scene.pressure.at(0).value, 200.0);
  EXPECT_EQ(scene.pressure[0].kind, LoadKind::kPressure);
  ASSERT_EQ(scene.amplitude.size(), 4U);
  EXPECT_EQ(scene.amplitude[1].phase, 0.3);
  ASSERT_EQ(scene.amplitude[3].points.size(), 2U);
  EXPECT_EQ(scene.amplitude[3].points[1], std::pair(0.01, 2.0));

  const fs::path other = folder_ / "other";
  fs::create_directories(other);
  write_scene(scene, (other / "scene.toml").string());
  const Scene again = read_scene((other / "scene.toml").string());
  Session a(scene, generate_mesh(*scene.mesh.generate));
  Session b(again, generate_mesh(*again.mesh.generate));
  a.run();
  b.run();
  EXPECT_EQ(a.status(), RunStatus::kFinished) << a.message();
  EXPECT_EQ(a.state().position, b.state().position);
  EXPECT_NE(scene_echo(again).find("\"smooth_step\""), std::string::npos);
  EXPECT_GT(a.balance().external_work(), 0.0);
}

TEST_F(SceneLoads, EventsChangeAndAddLoads) {
  file("table.csv", "0 1\n0.01 2\n");
  const Scene scene = read(std::string(kEveryLoad) + R"(
[[event]]
at = 0.004
set = { "pressure.0.value" = 100.0, "body_force.0.acceleration" = [0, 0, 0], "force.1.until" = 0.02 }
[[event]]
at = 0.006
pressure = { select = { plane = { axis = "y", at = 0.2 } }, value = 50.0 }
moment = { select = { plane = { axis = "x", at = 0.4 } }, vector = [0, 0.01, 0] }
[[event]]
at = 0.008
set = { "pressure.1.value" = 70.0, "moment.1.amplitude" = "hat" }
)");
  Session session(scene, generate_mesh(*scene.mesh.generate));
  EXPECT_EQ(session.run(), RunStatus::kFinished) << session.message();
  const LoadLists& loads = session.loads();
  EXPECT_EQ(loads.pressure.at(0).value, 100.0);
  EXPECT_EQ(loads.pressure.at(1).value, 70.0);
  EXPECT_EQ(loads.moment.at(1).amplitude, "hat");
  EXPECT_EQ(loads.body_force.at(0).acceleration, Vector3(0.0, 0.0, 0.0));
  EXPECT_EQ(loads.force.at(1).until, 0.02);
  ASSERT_EQ(session.system().pressures().size(), 2U);
  EXPECT_EQ(session.system().pressures()[1].value, 70.0);
  // The dead loads of the system are in the order of their kinds.
  ASSERT_EQ(session.system().forces().size(), 2U + 2U + 1U + 2U);
  EXPECT_NE(session.system().forces()[3].history.amplitude, nullptr);
  EXPECT_LT(session.balance().max_relative_energy_drift(), 1e-2);

  // A scene that is written with its events runs in the same way.
  const fs::path other = folder_ / "events";
  fs::create_directories(other);
  write_scene(scene, (other / "scene.toml").string());
  const Scene again = read_scene((other / "scene.toml").string());
  Session replay(again, generate_mesh(*again.mesh.generate));
  replay.run();
  EXPECT_EQ(session.state().position, replay.state().position);
}

TEST_F(SceneLoads, WrongOnesAreRefusedWithTheirPlace) {
  const std::string face = "select = { plane = { axis = \"x\", at = 0.4 } }\n";
  expect_refusal("[[force]]\n" + face + "amplitude = \"hut\"\nvector = [1,0,0]\n" +
                     "[[amplitude]]\nname = \"hat\"\npoints = [[0, 1]]\n",
                 "scene.toml:12:1: force.0: amplitude = \"hut\" is not defined: did you mean hat?");
  expect_refusal("[[force]]\n" + face, "force.0.vector is missing");
  expect_refusal("[[force]]\n" + face + "vector = [1, 0, 0]\ntotal = [1, 0, 0]\n",
                 "one key too many");
  expect_refusal("[[force]]\n" + face + "vector = [1, 0, 0]\nshare = \"surface\"\n",
                 "force.0.share has no effect");
  expect_refusal("[environment]\nkind = \"none\"\namplitude = \"a\"\n",
                 "environment.amplitude has no effect");
  expect_refusal("[[constraint]]\nkind = \"rigid\"\namplitude = \"a\"\n" + face,
                 "constraint.0.amplitude needs `velocity` or `angular_velocity`");
  expect_refusal("[[body_force]]\nselect = { all = true }\n", "body_force.0.vector is missing");
  expect_refusal("[[traction]]\n" + face, "traction.0.vector is missing");
  expect_refusal("[[pressure]]\n" + face + "vector = [1, 0, 0]\n", "vector");
  expect_refusal("[[pressure]]\nselect = { nearest = [0, 0, 0] }\nvalue = 1.0\n",
                 "scene.toml:12:1: pressure.0: ");
  expect_refusal("[[moment]]\nselect = { nearest = [0.4, 0, 0] }\nvector = [1, 0, 0]\n",
                 "cannot carry this moment");
  expect_refusal("[[amplitude]]\nname = \"a\"\n", "needs one of points, file, sine or smooth_step");
  expect_refusal("[[amplitude]]\nname = \"a\"\npoints = [[0, 0]]\nsine = { frequency = 1 }\n",
                 "one key too many");
  expect_refusal("[[amplitude]]\nname = \"a\"\npoints = [[0, 0], [1, 1], [1, 2]]\n",
                 "must increase, but point 2 has 1 s after 1 s");
  expect_refusal("[[amplitude]]\nname = \"a\"\npoints = [[0, 1e308], [1, -1e308]]\n",
                 "point 1 has -1e+308 after 1e+308");
  expect_refusal("[[amplitude]]\nname = \"a\"\nsine = { frequency = -1 }\n", "frequency");
  expect_refusal("[[amplitude]]\nname = \"a\"\nsine = { phase = 1 }\n", "frequency is missing");
  expect_refusal("[[amplitude]]\nname = \"a\"\nsmooth_step = { from = 1.0, until = 1.0 }\n",
                 "from < until");
  expect_refusal(
      "[[amplitude]]\nname = \"a\"\npoints = [[0, 0]]\n"
      "[[amplitude]]\nname = \"a\"\npoints = [[0, 0]]\n",
      "is the name of another amplitude already");
  expect_refusal("[[amplitude]]\nname = \"a\"\nfile = \"nothing.csv\"\n", "nothing.csv");
  file("words.csv", "t,a\n0.0,1.0\n0.5,one\n");
  expect_refusal("[[amplitude]]\nname = \"a\"\nfile = \"words.csv\"\n", "words.csv:3: \"one\"");
  file("back.csv", "# t a\n0.0 1.0\n0.5 2.0\n0.5 3.0\n");
  expect_refusal("[[amplitude]]\nname = \"a\"\nfile = \"back.csv\"\n",
                 "back.csv:4: the times must increase");
  file("far.csv", "0,0\n1,1e308\n2,-1e308\n");
  expect_refusal("[[amplitude]]\nname = \"a\"\nfile = \"far.csv\"\n",
                 "far.csv:3: neighbouring values may differ by up to 1.8e308, but -1e+308");
  file("three.csv", "0.0,1.0,2.0\n");
  expect_refusal("[[amplitude]]\nname = \"a\"\nfile = \"three.csv\"\n",
                 "three.csv:1: an amplitude");
  expect_refusal("[environment]\nkind = \"gravity\"\namplitude = \"nope\"\n",
                 "scene.toml:12:1: environment: amplitude = \"nope\" is not defined");
  expect_refusal("[[moment]]\n" + face + "vector = [1e308, 1e308, 1e308]\n",
                 "scene.toml:12:1: moment.0: its forces are too large");
  expect_refusal(
      "[[event]]\nat = 0.01\nset = { \"environment.amplitude\" = \"nope\", "
      "\"environment.kind\" = \"gravity\" }\n",
      "event at 0.01 s");
  expect_refusal("[[event]]\nat = 0.01\nset = { \"amplitude.0.name\" = \"b\" }\n",
                 "cannot change during a run");
  expect_refusal("[[event]]\nat = 0.01\nset = { \"pressure.0.value\" = 1.0 }\n", "pressure");
}

}  // namespace
}  // namespace tetraction
