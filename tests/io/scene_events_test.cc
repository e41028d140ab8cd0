
#include <array>
#include <cstdint>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "support/scene_reading.h"

namespace tetraction {
namespace {

using namespace testing_support;

TEST_F(SceneReader, EventsAreReadInTheOrderOfTheirTimes) {
  EXPECT_TRUE(read(kSmall).event.empty());
  const Scene scene = read(kSmall + kMechanics);
  ASSERT_EQ(scene.event.size(), 2U);
  EXPECT_EQ(scene.event[0].at, 0.25);
  EXPECT_EQ(scene.event[0].where, path_ + ":76:1: event.1");
  EXPECT_EQ(scene.event[1].at, 0.75);
  EXPECT_EQ(scene.event[1].where, path_ + ":71:1: event.0");
  // The scene itself is as it is at the start.
  EXPECT_EQ(scene.time.step, TimeSettings{}.step);
  EXPECT_EQ(scene.damping.drag, 0.25);

  const Scene ties = read(kSmall +
                          "[[event]]\nat = 1\nset = { \"time.end\" = 3 }\n"
                          "[[event]]\nat = 1\nset = { \"time.end\" = 2 }\n");
  ASSERT_EQ(ties.event.size(), 2U);
  EXPECT_EQ(std::get<SetTime>(ties.event[0].edits.at(0)).settings.end, 3.0);
  EXPECT_EQ(std::get<SetTime>(ties.event[1].edits.at(0)).settings.end, 2.0);
}

// The edits of a kind that an event makes.
template <class T>
std::vector<T> edits_of(const EventSettings& event) {
  std::vector<T> edits;
  for (const Edit& edit : event.edits) {
    if (const T* found = std::get_if<T>(&edit)) edits.push_back(*found);
  }
  return edits;
}

TEST_F(SceneReader, EventsSetWhatCanChange) {
  const Scene scene = read(kSmall + kMechanics + R"([[event]]
at = 0.5
set = { "time.integrator" = "backward-euler", "time.step" = 0.1, "solver.tolerance" = 1e-4, "material.youngs_modulus" = 5e5, "material_region.1.poissons_ratio" = 0.2, "damping.viscosity" = 3, "environment.kind" = "gravity", "environment.direction" = [1, 0, 0], "force.0.vector" = [0, 0, 7], "fix.0.velocity" = [0.5, 0, 0], "constraint.0.length" = 0.1 }
)");
  ASSERT_EQ(scene.event.size(), 3U);
  const EventSettings& event = scene.event[1];
  EXPECT_EQ(event.at, 0.5);
  EXPECT_EQ(event.edits.size(), 9U);  // one a section
  const auto time = edits_of<SetTime>(event);
  ASSERT_EQ(time.size(), 1U);
  EXPECT_EQ(time[0].settings.integrator, Integrator::kBackwardEuler);
  EXPECT_EQ(time[0].settings.step, 0.1);
  EXPECT_EQ(time[0].settings.end, TimeSettings{}.end);
  const auto solver = edits_of<SetSolver>(event);
  ASSERT_EQ(solver.size(), 1U);
  EXPECT_EQ(solver[0].settings.tolerance, 1e-4);
  const auto material = edits_of<SetMaterial>(event);
  ASSERT_EQ(material.size(), 2U);
  EXPECT_EQ(material[0].region, 0);
  EXPECT_EQ(material[0].material.youngs_modulus, 5e5);
  EXPECT_EQ(material[0].material.poissons_ratio, 0.4);
  EXPECT_EQ(material[1].region, 2);  // [material] is the first
  EXPECT_EQ(material[1].material.youngs_modulus, 2e6);
  EXPECT_EQ(material[1].material.poissons_ratio, 0.2);
  const auto damping = edits_of<SetDamping>(event);
  ASSERT_EQ(damping.size(), 1U);
  EXPECT_EQ(damping[0].settings.viscosity, 3.0);
  EXPECT_EQ(damping[0].settings.drag, 0.25);
  const auto environment = edits_of<SetEnvironment>(event);
  ASSERT_EQ(environment.size(), 1U);
  EXPECT_EQ(environment[0].settings.kind, EnvironmentKind::kGravity);
  EXPECT_EQ(environment[0].settings.strength, 1e4);
  EXPECT_EQ(environment[0].settings.direction, Vector3(1, 0, 0));
  const auto force = edits_of<SetForce>(event);
  ASSERT_EQ(force.size(), 1U);
  EXPECT_EQ(force[0].index, 0U);
  EXPECT_EQ(force[0].entry.vector, Vector3(0, 0, 7));
  const auto fix = edits_of<SetFix>(event);
  ASSERT_EQ(fix.size(), 1U);
  EXPECT_EQ(fix[0].index, 0U);
  EXPECT_EQ(fix[0].entry.velocity, Vector3(0.5, 0, 0));
  const auto constraint = edits_of<SetConstraint>(event);
  ASSERT_EQ(constraint.size(), 1U);
  EXPECT_EQ(constraint[0].index, 0U);
  EXPECT_EQ(constraint[0].entry.length, 0.1);
}

TEST_F(SceneReader, EventsSetTheSolver) {
  const std::string text = kSmall + "[solver]\nkind = \"ceres\"\ntolerance = 1e-6\n";
  const Scene scene = read(
      text +
      "[[event]]\nat = 0.1\nset = { \"solver.kind\" = \"newton\", \"solver.linear\" = \"cg\" }\n"
      "[[event]]\nat = 0.2\nset = { \"solver.linear\" = \"factor\" }\n"
      "[[event]]\nat = 0.3\nset = { \"solver.kind\" = \"ceres\", \"solver.linear\" = \"auto\" }\n");
  ASSERT_EQ(scene.event.size(), 3U);
  const std::vector<std::pair<std::string, LinearSolver>> expected{
      {"newton", LinearSolver::kCg},
      {"newton", LinearSolver::kFactor},
      {"ceres", LinearSolver::kAuto}};
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const auto edits = edits_of<SetSolver>(scene.event[i]);
    ASSERT_EQ(edits.size(), 1U);
    EXPECT_EQ(edits[0].settings.kind, expected[i].first);
    EXPECT_EQ(edits[0].settings.linear, expected[i].second);
    EXPECT_EQ(edits[0].settings.tolerance, 1e-6);
  }
  EXPECT_EQ(scene.solver.kind, "ceres");
  expect_refusal(text + "[[event]]\nat = 0.1\nset = { \"solver.linear\" = \"cg\" }\n",
                 "scene.toml:12:9: event at 0.1 s: solver.linear", {"ceres"});
}

TEST_F(SceneReader, EventsSetNumbersToTheLastBit) {
  for (const char* number : {"0.1", "0.30000000000000004", "1e-3", "2.2250738585072014e-308",
                             "123456789.12345679", "3", "1_000", "1.7976931348623157e+308"}) {
    const Scene scene = read(kSmall + "[[event]]\nat = 1\nset = { \"damping.drag\" = " + number +
                             " }\n[damping]\nviscosity = " + number + "\n");
    EXPECT_EQ(edits_of<SetDamping>(scene.event.at(0)).at(0).settings.drag, scene.damping.viscosity)
        << number;
  }
  const Scene scene = read(kSmall +
                           "[[event]]\nat = 1\nset = { \"environment.kind\" = \"gravity\", "
                           "\"environment.direction\" = [3, 0.1, 1e-3] }\n");
  EXPECT_EQ(edits_of<SetEnvironment>(scene.event.at(0)).at(0).settings.direction,
            Vector3(3, 0.1, 1e-3).normalized());
}

TEST_F(SceneReader, LaterEventsSeeWhatEarlierOnesSet) {
  const Scene scene = read(kSmall + R"([[event]]
at = 3
set = { "damping.viscosity" = 5 }
[[event]]
at = 1
set = { "damping.drag" = 1, "environment.kind" = "gravity", "time.step" = 1e-3 }
[[event]]
at = 2
set = { "damping.mass_damping" = 2, "environment.strength" = 3, "time.integrator" = "verlet" }
)");
  ASSERT_EQ(scene.event.size(), 3U);
  EXPECT_EQ(edits_of<SetTime>(scene.event[1]).at(0).settings.step, 1e-3);
  EXPECT_EQ(edits_of<SetTime>(scene.event[1]).at(0).settings.integrator, Integrator::kVerlet);
  EXPECT_EQ(edits_of<SetEnvironment>(scene.event[1]).at(0).settings.kind,
            EnvironmentKind::kGravity);
  EXPECT_EQ(edits_of<SetEnvironment>(scene.event[1]).at(0).settings.strength, 3.0);
  const Damping last = edits_of<SetDamping>(scene.event[2]).at(0).settings;
  EXPECT_EQ(last.drag, 1.0);
  EXPECT_EQ(last.mass_damping, 2.0);
  EXPECT_EQ(last.viscosity, 5.0);
  // And so do the checks: what the earlier event set does not go with the later one.
  refuses(
      "[[event]]\nat = 2\nset = { \"environment.strength\" = 3 }\n[[event]]\nat = 1\nset = { "
      "\"environment.direction\" = [1, 0, 0] }\n",
      "12:9: event at 1 s: environment.kind is missing");
}

TEST_F(SceneReader, EventsTakeOneTableOrAList) {
  const std::string event = kSmall + "[[event]]\nat = 0.5\n";
  const std::string fix = "{ select = { all = true }, components = \"z\" }";
  EXPECT_EQ(edits_of<SetFix>(read(event + "fix = " + fix).event[0]).size(), 1U);
  const auto fixes =
      edits_of<SetFix>(read(event + "fix = [" + fix +
                            ", { select = { group = \"a\" }, mode = \"penalty\", penalty = 3 }]\n")
                           .event[0]);
  ASSERT_EQ(fixes.size(), 2U);
  EXPECT_FALSE(fixes[0].index);  // added
  EXPECT_EQ(fixes[0].entry.components, (std::array<bool, 3>{false, false, true}));
  EXPECT_TRUE(fixes[1].entry.is_penalty);
  EXPECT_EQ(fixes[1].entry.penalty, 3.0);

  const std::string force = "{ select = { all = true }, vector = [0, 1, 0], until = 2 }";
  const auto one = edits_of<SetForce>(read(event + "force = " + force).event[0]);
  ASSERT_EQ(one.size(), 1U);
  EXPECT_FALSE(one[0].index);
  EXPECT_EQ(one[0].entry.vector, Vector3(0, 1, 0));
  EXPECT_EQ(one[0].entry.until, 2.0);
  EXPECT_EQ(
      edits_of<SetForce>(read(event + "force = [" + force + ", " + force + "]\n").event[0]).size(),
      2U);

  const std::string momentum = "{ select = { nearest = [0, 0, 0] }, value = [0, 0, 3] }";
  const auto kick = edits_of<SetMomentum>(read(event + "momentum = " + momentum).event[0]);
  ASSERT_EQ(kick.size(), 1U);
  EXPECT_EQ(kick[0].change.value, Vector3(0, 0, 3));
  EXPECT_EQ(edits_of<SetMomentum>(
                read(event + "momentum = [" + momentum + ", " + momentum + "]\n").event[0])
                .size(),
            2U);

  const std::string rod = "{ kind = \"distance\", vertices = [0, 1] }";
  const auto rods = edits_of<SetConstraint>(read(event + "constraint = " + rod).event[0]);
  ASSERT_EQ(rods.size(), 1U);
  EXPECT_FALSE(rods[0].index);
  EXPECT_EQ(rods[0].entry.vertices, (std::array<std::int64_t, 2>{0, 1}));
  EXPECT_EQ(edits_of<SetConstraint>(read(event + "constraint = [" + rod +
                                         ", { kind = \"rigid\", select = { all = true } }]\n")
                                        .event[0])
                .size(),
            2U);

  // As sections of their own.
  const Scene sections =
      read(event +
           "[event.set]\n\"time.step\" = 1e-3\n[event.unfix]\nall = true\n"
           "[[event.fix]]\nselect = { all = true }\n[[event.fix]]\nselect = { group = \"a\" "
           "}\n[event.momentum]\nselect = { all = true }\nvalue = [0, 0, 1]\n");
  EXPECT_EQ(edits_of<SetTime>(sections.event[0]).at(0).settings.step, 1e-3);
  EXPECT_EQ(edits_of<SetFix>(sections.event[0]).size(), 2U);
  EXPECT_EQ(edits_of<SetMomentum>(sections.event[0]).size(), 1U);
  EXPECT_EQ(edits_of<Unfix>(sections.event[0]).size(), 1U);
}

TEST_F(SceneReader, EventsUnfixInBothForms) {
  const std::string event = kSmall + "[[event]]\nat = 0.5\nunfix = ";
  for (const std::string& text :
       {event + "{ select = { plane = { axis = \"y\", at = 2 } } }\n",
        event + "{ plane = { axis = \"y\", at = 2 } }\n",
        kSmall + "[[event]]\nat = 0.5\n[event.unfix.plane]\naxis = \"y\"\nat = 2\n"}) {
    const auto unfix = edits_of<Unfix>(read(text).event[0]);
    ASSERT_EQ(unfix.size(), 1U);
    EXPECT_EQ(std::get<SelectPlane>(unfix[0].select).axis, 1);
    EXPECT_EQ(std::get<SelectPlane>(unfix[0].select).at, 2.0);
    EXPECT_NE(unfix[0].where.find("event.0.unfix"), std::string::npos) << unfix[0].where;
  }
  const std::string at = "[[event]]\nat = 0.5\nunfix = ";
  refuses(at + "{ all = true, select = { all = true } }\n", "9:", {"event.0.unfix"});
  refuses(at + "{}\n", "9:1: event.0.unfix", {"plane, box"});
  refuses(at + "{ select = {} }\n", "9:11: event.0.unfix.select is empty", {"plane, box"});
  refuses(at + "{ all = true, surface = true }\n", "9:1: event.0.unfix", {"both", "one of"});
  refuses(at + "{ plne = { axis = \"x\", at = 0 } }\n", "9:11: unknown key event.0.unfix.plne",
          {"did you mean plane?"});
  refuses(at + "true\n", "9:1: event.0.unfix", {"must be a table"});
}

TEST_F(SceneReader, EventsAreChecked) {
  const auto refused = [this](const std::string& lines, const std::string& start,
                              const std::vector<std::string>& parts = {}) {
    refuses("[[event]]\n" + lines, start, parts);
  };
  refused("", "7:1: event.0.at is missing", {"in s"});
  refused("set = { \"time.step\" = 1e-3 }\n", "7:1: event.0.at is missing");
  refused("at = \"later\"\n", "8:1: event.0.at", {"must be a number"});
  refused("at = nan\n", "8:1: event.0.at", {"finite"});
  refused("at = inf\n", "8:1: event.0.at", {"finite"});
  const std::vector<std::string> every{"set", "fix", "unfix", "constraint", "force", "momentum"};
  refused("at = 1\n", "7:1: event.0 changes nothing", every);
  refused("at = 1\nset = {}\n", "7:1: event.0 changes nothing", every);
  refused("at = 1\nfix = []\n", "7:1: event.0 changes nothing", every);
  refused("at = 1\nset = [1]\n", "9:1: event.0.set", {"must be a table"});
  refused("at = 1\nset = 3\n", "9:1: event.0.set", {"must be a table"});
  refused("at = 1\nfix = 3\n", "9:1: event.0.fix", {"must be a table"});
  refused("at = 1\nfix = { mode = \"exact\" }\n", "9:7: event.0.fix.select is missing");
  refused("at = 1\nfix = [{ select = { all = true } }, { }]\n", "9:37: event.0.fix.1.select");
  refused("at = 1\nfix = { select = { all = true }, mode = \"penalty\" }\n",
          "9:7: event.0.fix.penalty is missing");
  refused("at = 1\nforce = { select = { all = true } }\n", "9:9: event.0.force.vector is missing");
  refused("at = 1\nmomentum = { select = { all = true } }\n",
          "9:12: event.0.momentum.value is missing", {"kg m/s"});
  refused("at = 1\nconstraint = { vertices = [0, 1] }\n",
          "9:14: event.0.constraint.kind is missing");
  refused("at = 1\nconstraint = { kind = \"distance\", vertices = [1, 1] }\n",
          "9:35: event.0.constraint.vertices", {"different"});
  refuses("[event]\nat = 1\n", "7:2: event", {"[[event]]"});
}

// An event at 0.5 s whose `set` stands in line 9, from column 9 on.
TEST_F(SceneReader, EventsSetOnlyWhatCanChange) {
  const auto refused = [this](const std::string& key, const std::string& value,
                              const std::vector<std::string>& parts) {
    refuses("[[event]]\nat = 0.5\nset = { \"" + key + "\" = " + value + " }\n",
            "9:9: event.0.set." + key, parts);
  };
  refused("material.density", "500", {"cannot change", "before the start"});
  refused("material_region.0.density", "500", {"cannot change", "before the start"});
  refused("mesh.scale", "2", {"cannot change"});
  refused("mesh.file", "\"b.vtu\"", {"cannot change"});
  refused("mesh", "3", {"cannot change"});
  refused("initial.velocity", "[0, 0, 1]", {"cannot change", "momentum"});
  refused("initial.momentum.0.value", "[0, 0, 1]", {"cannot change", "momentum"});
  refused("output.every", "2", {"cannot change"});
  refused("enviroment.kind", "\"none\"", {"did you mean environment?"});
  refused("velocity", "3", {"time, solver", "constraint"});
  refused("event.0.at", "3", {"not a key that can change"});
  for (const char* list : {"force", "fix", "constraint", "material_region"}) {
    refused(list, "3", {"number of the entry", std::string(list) + ".0."});
    refused(std::string(list) + ".vector", "[0, 0, 1]", {"number of the entry"});
    refused(std::string(list) + ".-1.vector", "[0, 0, 1]", {"number of the entry"});
    refused(std::string(list) + ".99999999999999999999.vector", "[0, 0, 1]",
            {"number of the entry"});
  }
  refused("time", "{ step = 1e-3 }", {"is a table", "in"});
  refused("fix.0", "{ select = { all = true } }", {"is a table"});
  // Without quotes it is a table too.
  refuses("[[event]]\nat = 0.5\nset = { time.step = 1e-3 }\n", "9:9: event.0.set.time",
          {"quotes", "\"time.step\""});
}

TEST_F(SceneReader, EventsAreToBlameForTheirValues) {
  const auto refused = [this](const std::string& key, const std::string& value,
                              const std::string& rest, const std::vector<std::string>& parts) {
    refuses("[[event]]\nat = 0.5\nset = { \"" + key + "\" = " + value + " }\n",
            "9:9: event at 0.5 s: " + rest, parts);
  };
  refused("time.stp", "1e-3", "unknown key time.stp", {"did you mean step?"});
  refused("time.step", "-1", "time.step = -1", {"above 0"});
  refused("time.step", "nan", "time.step", {"finite"});
  refused("time.step", "\"fast\"", "time.step = \"fast\"", {"\"auto\""});
  refused("time.step", "\"auto\"", "time.step = \"auto\"", {"explicit and verlet"});
  refused("time.end", "[1]", "time.end", {"must be a number", "not a list"});
  refused("time.integrator", "\"mid-point\"", "time.integrator = \"mid-point\"",
          {"did you mean midpoint?"});
  refused("material.youngs_modulus", "0", "material.youngs_modulus = 0", {"above 0"});
  refused("material.poissons_ratio", "0.5", "material.poissons_ratio = 0.5", {"-1 and 0.5"});
  refused("material.mu", "3e5", "material.mu", {"youngs_modulus"});
  refused("solver.tolerance", "2", "solver.tolerance = 2", {"between 0 and 1"});
  refused("damping.drag", "-1", "damping.drag = -1", {"0 or more"});
  refused("environment.kind", "\"wind\"", "environment.kind = \"wind\"", {"attraction"});
  refused("environment.strength", "3", "environment.kind is missing", {"gravity"});
  // The place is that of the event with the value, not of a later one.
  refuses(
      "[[event]]\nat = 2\nset = { \"time.step\" = 1 }\n[[event]]\nat = 1\nset = { \"time.end\" = "
      "-1 }\n",
      "12:9: event at 1 s: time.end = -1");
  refuses("[[event]]\nat = 1\n[event.set]\n\"time.end\" = -1\n",
          "10:1: event at 1 s: time.end = -1");
}

// Each value is right by itself, but not beside what the scene says: the event is named.
TEST_F(SceneReader, EventsAreToBlameForWhatDoesNotFitTheScene) {
  const auto refused = [this](const std::string& lines, const std::string& set,
                              const std::vector<std::string>& parts) {
    const std::string text = kSmall + "[[event]]\nat = 0.5\nset = { " + set + " }\n";
    const std::string message = refusal(text + lines);
    EXPECT_NE(message.find("event at 0.5 s"), std::string::npos) << message;
    EXPECT_NE(message.find("scene.toml:9:9"), std::string::npos) << message;
    for (const std::string& part : parts) {
      EXPECT_NE(message.find(part), std::string::npos) << "no \"" << part << "\" in: " << message;
    }
  };
  refused("[time]\nintegrator = \"verlet\"\nstep = \"auto\"\n",
          "\"time.integrator\" = \"midpoint\"", {"time.step", "auto"});
  refused("[[fix]]\nselect = { all = true }\n", "\"fix.0.mode\" = \"penalty\"",
          {"fix.0.penalty", "missing"});
  refused("[[fix]]\nselect = { all = true }\noffset = [0, 0, 1]\n", "\"fix.0.target\" = [0, 0, 0]",
          {"offset"});
  refused("[[fix]]\nselect = { group = \"a\" }\n", "\"fix.0.select.all\" = true", {"group", "all"});
  refused("[[force]]\nselect = { all = true }\nvector = [0, 0, 1]\nuntil = 1\n",
          "\"force.0.from\" = 2", {"later than from"});
  refused("[[constraint]]\nkind = \"rigid\"\nselect = { all = true }\n",
          "\"constraint.0.kind\" = \"distance\"", {"select", "distance"});
  refused("", "\"material.model\" = \"mooney-rivlin\"", {"ratio"});
}

TEST_F(SceneReader, EventsSetTables) {
  const Scene scene = read(kSmall + R"([[force]]
select = { vertices = [0] }
total = [0, 0, 1]
[[event]]
at = 0.5
set = { "force.0.select" = { all = true }, "damping.ratio" = { at = [10, 100], value = [0.1, 0.2] } }
)");
  const auto force = edits_of<SetForce>(scene.event.at(0));
  ASSERT_EQ(force.size(), 1U);
  EXPECT_TRUE(std::holds_alternative<SelectAll>(force[0].entry.select));
  ASSERT_EQ(edits_of<SetDamping>(scene.event[0]).size(), 1U);
  EXPECT_GT(edits_of<SetDamping>(scene.event[0])[0].settings.viscosity, 0.0);
  expect_refusal(kSmall + "[[event]]\nat = 0.5\nset = { \"time.step\" = { all = true } }\n",
                 "scene.toml:9:9: event at 0.5 s: ", {"time.step", "table"});
}

TEST_F(SceneReader, EventsSetOnlyEntriesThatExist) {
  const std::string region =
      "[[material_region]]\nselect = { all = true }\nyoungs_modulus = 1\npoissons_ratio = 0.3\n";
  const auto refused = [this](const std::string& lines, const std::string& set,
                              const std::vector<std::string>& parts) {
    refuses("[[event]]\nat = 0.5\nset = { " + set + " }\n" + lines, "9:", parts);
  };
  refused(region, "\"material_region.3.youngs_modulus\" = 1",
          {"9:9: event.0.set.material_region.3.youngs_modulus", "the scene has 1 of them"});
  refused("", "\"material_region.0.youngs_modulus\" = 1",
          {"material_region.0", "the scene has 0 of them"});
  refused("[[force]]\nselect = { all = true }\nvector = [0, 0, 1]\n",
          "\"force.2.vector\" = [0, 0, 1]", {"force is a list with 1 entries"});
  refused("[[fix]]\nselect = { all = true }\n", "\"fix.7.velocity\" = [0, 0, 1]",
          {"fix is a list with 1 entries"});
  refused("", "\"constraint.1.length\" = 1", {"event at 0.5 s", "constraint"});
  refused("", "\"force.0.vector\" = [0, 0, 1]", {"event at 0.5 s", "force.0.select is missing"});
  // A material region is part of the body's structure: none can be added or moved during a run.
  refused("",
          "\"material_region.0.select.all\" = true, \"material_region.0.youngs_modulus\" = 1, "
          "\"material_region.0.poissons_ratio\" = 0.1",
          {"material_region.0"});
  refused(region, "\"material_region.0.select.all\" = true", {"material_region.0.select"});
}

// An entry that an earlier event added with `fix = …` is not the one that `set` counts.
TEST_F(SceneReader, EventsSetTheEntryThatTheyName) {
  const Scene scene = read(kSmall + R"([[force]]
select = { vertices = [0] }
vector = [1, 0, 0]
[[event]]
at = 1
force = { select = { vertices = [1] }, vector = [2, 0, 0] }
[[event]]
at = 2
set = { "force.1.select.vertices" = [2], "force.1.vector" = [3, 0, 0] }
[[event]]
at = 3
set = { "force.1.vector" = [4, 0, 0] }
)");
  // The effect of the edits on the run, in order.
  std::vector<ForceSettings> forces = scene.force;
  for (const EventSettings& event : scene.event) {
    for (const SetForce& edit : edits_of<SetForce>(event)) {
      if (edit.index) {
        forces.at(*edit.index) = edit.entry;
      } else {
        forces.push_back(edit.entry);
      }
    }
  }
  // Either the second event changed the first's force, or it added one that the third changed.
  const auto vertex = [&](std::size_t i) {
    return std::get<SelectVertices>(forces.at(i).select).ids.at(0);
  };
  for (std::size_t i = 0; i < forces.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) EXPECT_NE(vertex(i), vertex(j)) << i << " " << j;
  }
  EXPECT_EQ(forces.back().vector, Vector3(4, 0, 0));
}

// Names of groups are any text, and numbers any number, also where a later event reads them again.
TEST_F(SceneReader, EventsKeepWhatEarlierOnesAdded) {
  for (const char* name : {R"("plain")", R"("with \"quotes\"")", R"("it's")", R"("a\\b")",
                           R"("two\nlines")", R"("tab\there")", R"("\u00e9\u4e2d")",
                           R"("a = 1 # no comment")", R"("'''\"\"\"")", R"("\u0001")"}) {
    const std::string select = std::string("select = { group = ") + name + " }";
    const Scene scene =
        read(kSmall + ("[[event]]\nat = 1\nfix = { " + select +
                       ", velocity = [0.1, 1e-300, 0] }\nforce = [{ " + select +
                       ", vector = [1, 2, 3], until = inf }, { " + select +
                       ", vector = [0.30000000000000004, 0, 0] }]\n"
                       "constraint = { kind = \"rigid\", " +
                       select +
                       " }\n[[event]]\nat = 2\nset = { \"fix.0.components\" = \"xy\", "
                       "\"force.1.until\" = 7, \"constraint.0.velocity\" = [0, 0, 1] }\n"));
    ASSERT_EQ(scene.event.size(), 2U) << name;
    const auto before = edits_of<SetFix>(scene.event[0]);
    const auto fix = edits_of<SetFix>(scene.event[1]);
    ASSERT_EQ(fix.size(), 1U) << name;
    EXPECT_EQ(std::get<SelectGroup>(fix[0].entry.select).name,
              std::get<SelectGroup>(before.at(0).entry.select).name);
    EXPECT_EQ(fix[0].index, 0U);
    EXPECT_EQ(fix[0].entry.velocity, Vector3(0.1, 1e-300, 0));
    EXPECT_EQ(fix[0].entry.components, (std::array<bool, 3>{true, true, false}));
    const auto force = edits_of<SetForce>(scene.event[1]);
    ASSERT_EQ(force.size(), 1U) << name;
    EXPECT_EQ(force[0].index, 1U);
    EXPECT_EQ(force[0].entry.vector, Vector3(0.30000000000000004, 0, 0));
    EXPECT_EQ(force[0].entry.until, 7.0);
    const auto constraint = edits_of<SetConstraint>(scene.event[1]);
    ASSERT_EQ(constraint.size(), 1U) << name;
    EXPECT_EQ(constraint[0].index, 0U);
    EXPECT_TRUE(constraint[0].entry.is_driven());
  }
}

TEST_F(SceneReader, OverridesChangeEvents) {
  const std::string text = kSmall + kMechanics;
  const Scene scene =
      read(text, {"event.0.at=0.125", "event.0.set={\"time.step\"=1e-4}",
                  "event.1.fix={select={all=true}}", "event.2={at=2, unfix={all=true}}"});
  ASSERT_EQ(scene.event.size(), 3U);
  EXPECT_EQ(scene.event[0].at, 0.125);
  EXPECT_EQ(edits_of<SetTime>(scene.event[0]).at(0).settings.step, 1e-4);
  EXPECT_TRUE(edits_of<SetDamping>(scene.event[0]).empty());
  EXPECT_EQ(edits_of<SetFix>(scene.event[1]).size(), 1U);
  EXPECT_EQ(scene.event[2].at, 2.0);
  // Events change the scene with the overrides in it.
  EXPECT_EQ(edits_of<SetTime>(read(text, {"time.end=7"}).event[1]).at(0).settings.end, 7.0);

  expect_refusal(text, "--set event.0.at=soon: event.0.at", {"must be a number"},
                 {"event.0.at=soon"});
  expect_refusal(text, "--set event.5.at=1: event is a list with 2 entries", {}, {"event.5.at=1"});
  expect_refusal(text, "--set event.0.set={\"time.step\"=-1}: event at 0.75 s: time.step = -1",
                 {"above 0"}, {"event.0.set={\"time.step\"=-1}"});
  expect_refusal(text, "--set damping.drag=-1: damping.drag = -1", {"0 or more"},
                 {"damping.drag=-1"});
  expect_refusal(text, "--set constraint.0.length=0: constraint.0.length = 0", {"above 0"},
                 {"constraint.0.length=0"});
}

TEST_F(SceneReader, EventsTakeKeysOutAndMoveSingleVertices) {
  const Scene scene = read(kSmall + R"([[fix]]
select = { vertices = [0, 1] }
targets = [[0, 0, 0], [1, 0, 0]]
[[constraint]]
kind = "distance"
vertices = [1, 2]
length = 1.0
[[event]]
at = 1
unset = ["fix.0.targets", "constraint.0.length", "fix.0.select"]
set = { "fix.0.select.vertices" = [2] }
unfix = { all = true, fix = 0 }
remove_constraint = 0
shift = { vertices = [1, 2], displacement = [[0, 0, 1], [0, 1, 0]] }
[[event]]
at = 2
shift = [{ vertices = [0], impulse = [[1, 2, 3]] }, { vertices = [1], impulse = [[1, 2, 3]] }]
)");
  ASSERT_EQ(scene.fix.at(0).targets.size(), 2U);
  EXPECT_EQ(scene.fix[0].targets[1], Vector3::UnitX());
  const EventSettings& event = scene.event.at(0);
  ASSERT_EQ(event.edits.size(), 5U);
  const SetConstraint rod = edits_of<SetConstraint>(event).at(0);
  EXPECT_FALSE(rod.entry.length.has_value());
  const SetFix fix = edits_of<SetFix>(event).at(0);
  EXPECT_EQ(fix.index, 0U);
  EXPECT_TRUE(fix.entry.targets.empty());
  EXPECT_EQ(fix.entry.select, Selection(SelectVertices{{2}}));
  EXPECT_EQ(edits_of<Unfix>(event).at(0).fix, 0U);
  EXPECT_EQ(edits_of<RemoveConstraint>(event).at(0).index, 0U);
  const ShiftSettings shift = edits_of<ShiftState>(event).at(0).change;
  EXPECT_EQ(shift.vertices, (std::vector<std::int64_t>{1, 2}));
  EXPECT_EQ(shift.displacement.at(1), Vector3::UnitY());
  EXPECT_TRUE(shift.impulse.empty());
  EXPECT_EQ(edits_of<ShiftState>(scene.event.at(1)).size(), 2U);

  const std::string event_head = kSmall + "[[event]]\nat = 1\n";
  const auto refused = [&](const std::string& line, const std::string& message) {
    expect_refusal(event_head + line + "\n", "scene.toml:9:", {message});
  };
  refused("unset = [\"material.ratio\"]", "material.ratio is not set at that time");
  refused("unset = [\"material.youngs_modulus\"]", "poissons_ratio");
  refused("unset = [\"material.density\"]", "cannot change during a run");
  refused("unset = [\"mesh.scale\"]", "cannot change during a run");
  refused("unset = []", "at least one");
  refused("unset = [3]", "a list of texts");
  refused("unfix = { all = true, fix = 0 }", "at that time there is no [[fix]]");
  refused("remove_constraint = 0", "at that time there is no [[constraint]]");
  refused("shift = { displacement = [[0, 0, 1]] }", "vertices is missing");
  refused("shift = { vertices = [1] }", "does nothing");
  refused("shift = { vertices = [1, 2], impulse = [[0, 0, 1]] }", "1 entries for 2 vertices");
  refused("shift = { vertices = [1], impulse = [[0, 0]] }", "2 entries");
  refused("fix = { select = { all = true }, targets = [[0, 0, 1]] }",
          "needs select = { vertices = [...] }");
  refused("fix = { select = { vertices = [1] }, targets = [[0, 0, 1]], offset = [0, 0, 1] }",
          "Leave all but one of them out");
}

}  // namespace
}  // namespace tetraction
