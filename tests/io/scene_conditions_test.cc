
#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "support/messages.h"
#include "support/scene_reading.h"

namespace tetraction {
namespace {

using namespace testing_support;

TEST_F(SceneReader, ReadsEverySelection) {
  const auto select = [this](const std::string& what) {
    return read(kSmall + "[[fix]]\nselect = { " + what + " }\n").fix[0].select;
  };
  EXPECT_EQ(std::get<SelectVertices>(select("vertices = [5, 0]")).ids,
            (std::vector<std::int64_t>{5, 0}));
  const auto plane =
      std::get<SelectPlane>(select("plane = { axis = \"z\", at = 1, tolerance = 0.5 }"));
  EXPECT_EQ(plane.axis, 2);
  EXPECT_EQ(plane.at, 1.0);
  EXPECT_EQ(plane.tolerance, 0.5);
  const auto box = std::get<SelectBox>(select("box = { min = [0, 1, 2], max = [3, 1, 4] }"));
  EXPECT_EQ(box.min, Vector3(0, 1, 2));
  EXPECT_EQ(box.max, Vector3(3, 1, 4));
  const auto sphere = std::get<SelectSphere>(select("sphere = { center=[1,2,3], radius=4 }"));
  EXPECT_EQ(sphere.center, Vector3(1, 2, 3));
  EXPECT_EQ(sphere.radius, 4.0);
  EXPECT_EQ(std::get<SelectNearest>(select("nearest = [1, 2, 3]")).point, Vector3(1, 2, 3));
  EXPECT_EQ(std::get<SelectGroup>(select("group = \"clamp\"")).name, "clamp");
  EXPECT_TRUE(std::holds_alternative<SelectSurface>(select("surface = true")));
  EXPECT_TRUE(std::holds_alternative<SelectAll>(select("all = true")));
  const auto faces = std::get<SelectFaces>(select("faces = { normal = [0, 2, 0] }"));
  EXPECT_EQ(faces.normal, Vector3(0, 2, 0));
  EXPECT_EQ(faces.angle, 30.0);
  const SelectPlane low{1, 0.0, {}};
  const SelectNearest tip{{1, 2, 3}};
  const std::string parts = "[{ plane = { axis = \"y\", at = 0 } }, { nearest = [1, 2, 3] }]";
  EXPECT_EQ(select("all_of = " + parts),
            Selection(SelectSet{SetOperation::kAllOf, {{low}, {tip}}}));
  EXPECT_EQ(select("any_of = " + parts),
            Selection(SelectSet{SetOperation::kAnyOf, {{low}, {tip}}}));
  const SelectSet outside{SetOperation::kNot, {{SelectSet{SetOperation::kAnyOf, {{low}, {tip}}}}}};
  EXPECT_EQ(select("not = { any_of = " + parts + " }"), Selection(outside));
}

TEST_F(SceneReader, ReadsNamedSelections) {
  const std::string names =
      "[selection.clamp]\nplane = { axis = \"x\", at = 0 }\n"
      "[selection.\"the rest\"]\nnot = \"clamp\"\n"
      "[selection.both]\nany_of = [\"the rest\", \"clamp\", { nearest = [1, 2, 3] }]\n";
  const Scene scene =
      read(kSmall +
           "[[fix]]\nselect = \"clamp\"\n"
           "[[force]]\nselect = { all_of = [\"both\", { surface = true }] }\nvector = [1, 0, 0]\n"
           "[[event]]\nat = 0.1\nunfix = { select = \"clamp\" }\n"
           "[[event]]\nat = 0.2\nset = { \"fix.0.select\" = \"the rest\" }\n"
           "[[event]]\nat = 0.3\nfix = { select = \"both\" }\n" +
           names);
  const SelectNamed clamp{"clamp", {{SelectPlane{0, 0.0, {}}}}};
  const SelectNamed rest{"the rest", {{SelectSet{SetOperation::kNot, {{clamp}}}}}};
  const SelectNamed both{
      "both", {{SelectSet{SetOperation::kAnyOf, {{rest}, {clamp}, {SelectNearest{{1, 2, 3}}}}}}}};
  EXPECT_EQ(scene.fix[0].select, Selection(clamp));
  EXPECT_EQ(scene.force[0].select,
            Selection(SelectSet{SetOperation::kAllOf, {{both}, {SelectSurface{}}}}));
  ASSERT_EQ(scene.selection.size(), 3U);
  EXPECT_EQ(scene.selection[0].name, "both");
  EXPECT_EQ(scene.selection[0].select, both.of[0].selection);
  EXPECT_EQ(std::get<Unfix>(scene.event[0].edits[0]).select, Selection(clamp));
  EXPECT_EQ(std::get<SetFix>(scene.event[1].edits[0]).entry.select, Selection(rest));
  EXPECT_EQ(std::get<SetFix>(scene.event[2].edits[0]).entry.select, Selection(both));
  const auto echo = nlohmann::json::parse(scene.echo);
  EXPECT_EQ(echo["fix"][0]["select"], "clamp");
  EXPECT_EQ(echo["selection"]["the rest"]["not"], "clamp");
  EXPECT_EQ(echo["selection"]["both"]["any_of"].size(), 3U);
}

TEST_F(SceneReader, RefusesNamedSelectionsThatMakeNoSense) {
  const auto refused = [this](const std::string& select, const std::string& names) {
    return refusal(kSmall + "[[fix]]\nselect = " + select + "\n" + names);
  };
  const std::string clamp = "[selection.clamp]\nsurface = true\n[selection.tip]\nall = true\n";
  const std::string unknown = refused("\"clmp\"", clamp);
  EXPECT_NE(unknown.find("8:1: fix.0.select = \"clmp\""), std::string::npos) << unknown;
  expect_part(unknown, "did you mean clamp? the scene has clamp or tip.");
  const std::string inner = refused("{ not = { all_of = [\"clamp\", \"tipp\"] } }", clamp);
  EXPECT_NE(inner.find("fix.0.select.not.all_of = \"tipp\""), std::string::npos) << inner;
  EXPECT_NE(refused("\"clamp\"", "").find("no named selections"), std::string::npos);
  const std::string itself = refused("\"a\"",
                                     "[selection.a]\nnot = \"b\"\n"
                                     "[selection.b]\nany_of = [{ all = true }, \"a\"]\n");
  EXPECT_NE(itself.find("refer to itself: a → b → a."), std::string::npos) << itself;
  EXPECT_NE(refused("7", clamp).find("must be a selection"), std::string::npos);
  EXPECT_NE(refused("{ all_of = [] }", clamp).find("one or more selections"), std::string::npos);
  EXPECT_NE(refused("{ all_of = \"clamp\" }", clamp).find("must be a list"), std::string::npos);
  EXPECT_NE(refused("{ any_of = [3] }", clamp).find("not a"), std::string::npos);
  EXPECT_NE(refused("{ not = [\"clamp\"] }", clamp).find("must be a selection"), std::string::npos);
  expect_part(refused("\"clamp\"", "[selection]\nclamp = \"tip\"\n"), "must be a table");
  expect_part(refused("\"clamp\"", "[[selection]]\nall = true\n"), "must be a table");
  expect_part(refused("{ faces = { normal = [0, 0, 0] } }", ""), "must not be zero");
  // A definition that nobody uses is checked as well.
  expect_part(refused("{ all = true }", "[selection.c]\nall = false\n"), "selection.c.all");
  expect_part(
      refusal(kSmall + clamp + "[[event]]\nat = 0.1\nset = { \"selection.clamp.all\" = true }\n"),
      "cannot change during a run");
  // Names within names, which would stand for 2^40 selections.
  std::string doubled = "[selection.n0]\nall = true\n";
  for (int i = 1; i <= 40; ++i) {
    doubled += "[selection.n" + std::to_string(i) + "]\nany_of = [\"n" + std::to_string(i - 1) +
               "\", \"n" + std::to_string(i - 1) + "\"]\n";
  }
  expect_part(refused("{ all = true }", doubled), "more than 10000 selections");
}

TEST_F(SceneReader, TheEnvironmentIsChecked) {
  const std::string gravity = "[environment]\nkind = \"gravity\"\n";
  refuses(gravity + "strength = -1\n", "9:1: environment.strength = -1",
          {"0 or more", "direction"});
  refuses(gravity + "direction = [0, 0, 0]\n", "9:1: environment.direction", {"not be zero"});
  EXPECT_EQ(read(kSmall + gravity + "strength = 0\n").environment.strength, 0.0);
  // Neither overflow nor underflow in the norm.
  EXPECT_EQ(read(kSmall + gravity + "direction = [1e-200, 0, 0]\n").environment.direction,
            Vector3(1, 0, 0));
  EXPECT_EQ(read(kSmall + gravity + "direction = [0, -1e200, 0]\n").environment.direction,
            Vector3(0, -1, 0));
}

// The messages about two selections or two targets.
TEST_F(SceneReader, KeysTooManyAreToldWithTheOthers) {
  const std::string fix = "[[fix]]\nselect = { vertices = [3, 4] }\n";
  refuses(fix + "targets = [[0, 0, 0]]\n", "9:1: fix.0.targets", {"1 places for the 2 vertices"});
  refuses(fix + "targets = [[0, 0, 0], [0, 0, 1]]\ntarget = [0, 0, 0]\n", "9:1: fix.0.targets",
          {"Leave all but one of them out"});
  refuses("[[fix]]\nselect = { all = true }\ntargets = [[0, 0, 0]]\n", "9:1: fix.0.targets",
          {"needs select = { vertices = [...] }"});
  refuses("[[event]]\nat = 0\nunfix = { all = true, select = { all = true } }\n",
          "9:23: event.0.unfix.select", {"selected in two ways"});
  refuses("[[event]]\nat = 0\nunfix = { all = true, fix = 0 }\n", "9:23: event.0.unfix.fix = 0",
          {"at that time there is no [[fix]]"});
  refuses(fix + "[[event]]\nat = 0\nunfix = { all = true, fix = 1 }\n",
          "11:23: event.0.unfix.fix = 1", {"the only [[fix]] has the number 0"});
}

TEST_F(SceneReader, SelectionsAreOfOneKind) {
  const auto refused = [this](const std::string& what, const std::string& start,
                              const std::vector<std::string>& parts) {
    refuses("[[fix]]\nselect = { " + what + " }\n", "8:" + start, parts);
  };
  refused("", "1: fix.0.select is empty", {"vertices, plane, box"});
  refused("all = true, group = \"a\"", "1: fix.0.select has both group and all", {"one of"});
  refused("all = false", "12: fix.0.select.all", {"only be true"});
  refused("surface = false", "12: fix.0.select.surface", {"only be true"});
  refused("vertices = []", "12: fix.0.select.vertices has 0 entries", {"at least one"});
  refused("vertices = [-1]", "12: fix.0.select.vertices holds -1", {"0 or more"});
  refused("group = \"\"", "12: fix.0.select.group is empty", {});
  refused("plane = { axis = \"w\", at = 0 }", "22: fix.0.select.plane.axis", {"x, y or z"});
  refused("plane = { axis = \"x\", at = 0, tolerance = -1 }", "42: fix.0.select.plane.tolerance",
          {"0 or more"});
  refused("sphere = { center = [0, 0, 0], radius = 0 }", "43: fix.0.select.sphere.radius",
          {"above 0"});
  refused("box = { min = [0, 0, 1], max = [1, 1, 0] }", "37: fix.0.select.box.max", {"below min"});
}

TEST_F(SceneReader, FixesAreChecked) {
  const std::string fix = "[[fix]]\nselect = { all = true }\n";
  refuses(fix + "target = [0, 0, 0]\noffset = [0, 0, 0]\n", "10:1: fix.0.offset",
          {"target and offset", "Leave one"});
  for (const char* components : {"xw", "xx", "X", "x,y"}) {
    refuses(fix + "components = \"" + components + "\"\n",
            std::string("9:1: fix.0.components = \"") + components + "\"", {"each once"});
  }
  refuses(fix + "components = \"\"\n", "9:1: fix.0.components is empty");
  refuses(fix + "components = [\"x\"]\n", "9:1: fix.0.components", {"not a list"});
}

TEST_F(SceneReader, ForcesEndAfterTheyBegin) {
  const std::string force = "[[force]]\nselect = { all = true }\nvector = [0, 0, 1]\n";
  refuses(force + "from = 1\nuntil = 1\n", "11:1: force.0.until", {"later than from"});
  refuses(force + "until = 0\n", "10:1: force.0.until", {"from 0 s"});
}

TEST_F(SceneReader, ReadsProbesAndTheKeysOfOutput) {
  const Scene scene = read(kSmall + R"(
[output]
history_every = 5
fields = ["default", "pressure"]
precision = "float32"
compression = "none"
[[probe]]
name = "tip_1"
select = { plane = { axis = "x", at = 4.0 } }
quantity = "reaction"
every = 3
[[probe]]
name = "middle"
point = [2.0, 0.5, 0.5]
quantity = "cauchy_stress"
)");
  EXPECT_EQ(scene.output.history_every, 5);
  EXPECT_EQ(scene.output.fields, (std::vector<std::string>{"default", "pressure"}));
  EXPECT_EQ(scene.output.precision, FramePrecision::kFloat32);
  EXPECT_EQ(scene.output.compression, FrameCompression::kNone);
  ASSERT_EQ(scene.probe.size(), 2U);
  EXPECT_EQ(scene.probe[0].name, "tip_1");
  EXPECT_EQ(std::get<SelectPlane>(scene.probe[0].select).at, 4.0);
  EXPECT_FALSE(scene.probe[0].point.has_value());
  EXPECT_EQ(scene.probe[0].quantity, ProbeQuantity::kReaction);
  EXPECT_EQ(scene.probe[0].every, 3);
  EXPECT_EQ(*scene.probe[1].point, Vector3(2.0, 0.5, 0.5));
  EXPECT_EQ(scene.probe[1].quantity, ProbeQuantity::kCauchyStress);
  EXPECT_EQ(scene.probe[1].every, 1);
  EXPECT_NE(scene.echo.find("\"middle\""), std::string::npos);
}

TEST_F(SceneReader, ProbesAndTheKeysOfOutputAreChecked) {
  const std::string tip = "[[probe]]\nname = \"tip\"\n";
  const std::string all = "select = { all = true }\n";
  refuses(tip + "quantity = \"velocity\"\n", "7:1: probe.0.select", {"point = [x, y, z]"});
  refuses(tip + all + "point = [0, 0, 0]\nquantity = \"velocity\"\n",
          "10:1: probe.0.point is one key too many");
  refuses(tip + all + "quantity = \"velocty\"\n", "10:1: probe.0.quantity = \"velocty\"",
          {"did you mean velocity?"});
  refuses(tip + all, "7:1: probe.0.quantity is missing");
  refuses("[[probe]]\nquantity = \"force\"\n" + all, "7:1: probe.0.name is missing");
  refuses("[[probe]]\nname = \"a b\"\nquantity = \"force\"\n" + all, "8:1: probe.0.name = \"a b\"",
          {"letters"});
  refuses(tip + "point = [0, 0, 0]\nquantity = \"force\"\n",
          "10:1: probe.0.quantity = \"force\" is a sum");
  refuses(tip + all + "quantity = \"force\"\nevery = 0\n", "11:1: probe.0.every");
  refuses("[output]\nfields = [\"displacment\"]\n", "8:1: output.fields has \"displacment\"",
          {"did you mean \"displacement\"?", "von_mises_nodal"});
  refuses("[output]\ncompression = \"gzip\"\n", "8:1: output.compression", {"lz4, zlib or none"});
  refuses("[output]\nprecision = \"double\"\n", "8:1: output.precision", {"float32 or float64"});
  refuses("[output]\nhistory_every = 0\n", "8:1: output.history_every");
}

TEST_F(SceneReader, DampingIsReadAndNotNegative) {
  const Scene none = read(kSmall);
  EXPECT_EQ(none.damping.drag, 0.0);
  EXPECT_EQ(none.damping.mass_damping, 0.0);
  EXPECT_EQ(none.damping.viscosity, 0.0);
  const Scene scene = read(kSmall + kMechanics);
  EXPECT_EQ(scene.damping.drag, 0.25);
  EXPECT_EQ(scene.damping.mass_damping, 2.0);
  EXPECT_EQ(scene.damping.viscosity, 40.5);
  for (const std::string key : {"drag", "mass_damping", "viscosity"}) {
    refuses("[damping]\n" + key + " = -0.1\n", "8:1: damping." + key + " = -0.1", {"0 or more"});
    for (const std::string value : {"inf", "nan"}) {
      refuses("[damping]\n" + key + " = " + value + "\n", "8:1: damping." + key, {"finite"});
    }
    refuses("[damping]\n" + key + " = \"strong\"\n", "8:1: damping." + key, {"must be a number"});
  }
}

TEST_F(SceneReader, AttractionIsRead) {
  EXPECT_EQ(read(kSmall).environment.softening, 0.0);
  const Scene scene = read(kSmall + kMechanics);
  EXPECT_EQ(scene.environment.kind, EnvironmentKind::kAttraction);
  EXPECT_EQ(scene.environment.strength, 1e4);
  EXPECT_EQ(scene.environment.softening, 0.125);
  const std::string attraction = "[environment]\nkind = \"attraction\"\n";
  EXPECT_EQ(read(kSmall + attraction).environment.softening, 0.0);
  EXPECT_EQ(read(kSmall + attraction).environment.strength, EnvironmentSettings{}.strength);
  refuses(attraction + "strength = -1\n", "9:1: environment.strength = -1", {"0 or more"});
  refuses(attraction + "softening = -1e-3\n", "9:1: environment.softening",
          {"-0.001", "0 or more"});
  refuses(attraction + "softening = inf\n", "9:1: environment.softening", {"finite"});
}

TEST_F(SceneReader, MovingFixesAndPenaltiesAreRead) {
  const Scene scene = read(kSmall + kMechanics);
  ASSERT_EQ(scene.fix.size(), 2U);
  EXPECT_EQ(scene.fix[0].velocity, Vector3(0, 0.5, 0));
  EXPECT_EQ(scene.fix[0].components, (std::array<bool, 3>{true, true, false}));
  EXPECT_FALSE(scene.fix[0].is_penalty);
  EXPECT_EQ(scene.fix[1].velocity, Vector3::Zero());
  EXPECT_TRUE(scene.fix[1].is_penalty);
  EXPECT_EQ(scene.fix[1].penalty, 1e5);
  EXPECT_EQ(scene.fix[1].offset, Vector3(0, 0, 0.1));
  EXPECT_FALSE(scene.fix[1].target);

  const std::string fix = "[[fix]]\nselect = { all = true }\n";
  refuses(fix + "mode = \"penalty\"\n", "7:1: fix.0.penalty is missing", {"N/m"});
  for (const char* value : {"0", "-1e5"}) {
    refuses(fix + "mode = \"penalty\"\npenalty = " + value + "\n", "10:1: fix.0.penalty",
            {"above 0"});
  }
  refuses(fix + "mode = \"penalty\"\npenalty = inf\n", "10:1: fix.0.penalty", {"finite"});
  refuses(fix + "velocity = 1\n", "9:1: fix.0.velocity", {"must be a list"});
  refuses(fix + "velocity = [0, nan, 0]\n", "9:1: fix.0.velocity", {"finite"});
}

TEST_F(SceneReader, ConstraintsAreRead) {
  EXPECT_TRUE(read(kSmall).constraint.empty());
  const Scene scene = read(kSmall + kMechanics);
  ASSERT_EQ(scene.constraint.size(), 5U);
  const ConstraintSettings& distance = scene.constraint[0];
  EXPECT_EQ(distance.kind, ConstraintKind::kDistance);
  EXPECT_EQ(distance.vertices, (std::array<std::int64_t, 2>{3, 40}));
  EXPECT_EQ(distance.length, 1.5);
  EXPECT_EQ(distance.where, path_ + ":41:1: constraint.0");
  const ConstraintSettings& plane = scene.constraint[1];
  EXPECT_EQ(plane.kind, ConstraintKind::kPlane);
  EXPECT_EQ(std::get<SelectVertices>(plane.select).ids, (std::vector<std::int64_t>{5}));
  EXPECT_EQ(plane.point, Vector3(0, 0, 1));
  EXPECT_EQ(plane.direction.normalized(), Vector3(0, 0, 1));
  const ConstraintSettings& line = scene.constraint[2];
  EXPECT_EQ(line.kind, ConstraintKind::kLine);
  EXPECT_FALSE(line.point);
  EXPECT_LT((line.direction.normalized() - Vector3(0, 0.6, 0.8)).norm(), 1e-15);
  const ConstraintSettings& free_handle = scene.constraint[3];
  EXPECT_EQ(free_handle.kind, ConstraintKind::kRigid);
  EXPECT_FALSE(free_handle.is_driven());
  const ConstraintSettings& driven = scene.constraint[4];
  EXPECT_EQ(driven.kind, ConstraintKind::kRigid);
  EXPECT_EQ(std::get<SelectGroup>(driven.select).name, "grip");
  EXPECT_TRUE(driven.is_driven());
  EXPECT_EQ(driven.velocity, Vector3(1, 0, 0));
  EXPECT_EQ(driven.angular_velocity, Vector3(0, 0, 2));

  const std::string rest = "[[constraint]]\nkind = \"distance\"\nvertices = [0, 1]\n";
  EXPECT_FALSE(read(kSmall + rest).constraint[0].length);
  EXPECT_TRUE(read(kSmall + "[[constraint]]\nkind = \"rigid\"\nselect = { all = true }\n"
                            "velocity = [0, 0, 0]\n")
                  .constraint[0]
                  .is_driven());
}

TEST_F(SceneReader, ConstraintsAreChecked) {
  const auto refused = [this](const std::string& lines, const std::string& start,
                              const std::vector<std::string>& parts = {}) {
    refuses("[[constraint]]\n" + lines, start, parts);
  };
  refused("", "7:1: constraint.0.kind is missing", {"\"distance\"", "\"rigid\""});
  refused("vertices = [0, 1]\n", "7:1: constraint.0.kind is missing");
  refused("kind = 3\n", "8:1: constraint.0.kind", {"text in quotes"});

  const std::string distance = "kind = \"distance\"\n";
  refused(distance, "7:1: constraint.0.vertices is missing", {"[a, b]"});
  for (const char* pair : {"[4, 4]", "[4]", "[1, 2, 3]"}) {
    refused(distance + "vertices = " + pair + "\n", "9:1: constraint.0.vertices",
            {"two different vertices"});
  }
  refused(distance + "vertices = []\n", "9:1: constraint.0.vertices", {"has 0 entries"});
  refused(distance + "vertices = [-1, 2]\n", "9:1: constraint.0.vertices holds -1", {"0 or more"});
  refused(distance + "vertices = 3\n", "9:1: constraint.0.vertices", {"must be a list"});
  for (const char* length : {"0", "-1.0"}) {
    refused(distance + "vertices = [0, 1]\nlength = " + length + "\n", "10:1: constraint.0.length",
            {"above 0"});
  }
  refused(distance + "vertices = [0, 1]\nlength = inf\n", "10:1: constraint.0.length", {"finite"});

  const std::string all = "select = { all = true }\n";
  for (const auto& [kind, key] : {std::pair("plane", "normal"), std::pair("line", "direction")}) {
    const std::string head = std::string("kind = \"") + kind + "\"\n";
    const std::string name = std::string("constraint.0.") + key;
    refused(head + key + " = [1, 0, 0]\n", "7:1: constraint.0.select is missing");
    refused(head + all, "7:1: " + name + " is missing", {"[", "]"});
    refused(head + all + key + " = [0, 0.0, 0]\n", "10:1: " + name, {"not be zero"});
    refused(head + all + key + " = [0, 1]\n", "10:1: " + name, {"has 2 entries"});
    refused(head + all + key + " = [0, inf, 0]\n", "10:1: " + name, {"finite"});
    refused(head + all + key + " = [0, 1, 0]\npoint = 0\n", "11:1: constraint.0.point",
            {"must be a list"});
  }
  refused("kind = \"rigid\"\n", "7:1: constraint.0.select is missing");
  refused("kind = \"rigid\"\n" + all + "velocity = [1, 0, 0]\nabout = [0, 0, 0]\n",
          "11:1: constraint.0.about", {"needs `angular_velocity`"});
  refused("kind = \"rigid\"\n" + all + "angular_velocity = 3\n",
          "10:1: constraint.0.angular_velocity", {"must be a list"});

  refuses("[constraint]\n", "7:2: constraint", {"[[constraint]]"});
}

TEST_F(SceneReader, ConstraintsTakeTheKeysOfTheirKindOnly) {
  const auto refused = [this](const std::string& kind, const std::string& own,
                              const std::string& key, const std::string& value,
                              const std::string& takes) {
    refuses("[[constraint]]\n" + key + " = " + value + "\nkind = \"" + kind + "\"\n" + own,
            "8:1: constraint.0." + key, {"\"" + kind + "\"", takes});
  };
  const std::string all = "select = { all = true }\n";
  const std::string pair = "vertices = [0, 1]\n";
  refused("distance", pair, "select", "{ all = true }", "vertices or length");
  refused("distance", pair, "normal", "[1, 0, 0]", "vertices or length");
  refused("distance", pair, "velocity", "[1, 0, 0]", "vertices or length");
  refused("plane", all + "normal = [1, 0, 0]\n", "direction", "[1, 0, 0]",
          "select, point or normal");
  refused("plane", all + "normal = [1, 0, 0]\n", "length", "1", "select, point or normal");
  refused("line", all + "direction = [1, 0, 0]\n", "normal", "[1, 0, 0]",
          "select, point or direction");
  refused("line", all + "direction = [1, 0, 0]\n", "vertices", "[1, 2]",
          "select, point or direction");
  refused("rigid", all, "point", "[1, 0, 0]",
          "select, velocity, angular_velocity, about or amplitude");
  refused("rigid", all, "length", "1", "select, velocity, angular_velocity, about or amplitude");
}

}  // namespace
}  // namespace tetraction
