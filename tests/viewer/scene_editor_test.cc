// The tree of the scene, its fields and its changes, without a window.
#include "viewer/scene/scene_editor.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <set>

#include "document/scene_json.h"
#include "simulation/scene/setting_keys.h"
#include "tetraction/io/initial_fields.h"
#include "tetraction/io/scene_reader.h"
#include "tetraction/io/scene_writer.h"
#include "viewer_support.h"

namespace tetraction::viewer {
namespace {

using namespace testing_support;
using Kind = SceneChange::Kind;

constexpr const char* kScene = R"(
[mesh]
generate = { kind = "box", size = [0.4, 0.1, 0.1], cells = [4, 1, 1] }
[material]
model = "neo-hookean"
youngs_modulus = 1e6
poissons_ratio = 0.3
density = 1000.0
[time]
step = 1e-3
end = 0.02
[[fix]]
select = { plane = { axis = "x", at = 0.0 } }
[[force]]
select = "tip"
vector = [0.0, -1.0, 0.0]
amplitude = "ramp"
[[force]]
select = { nearest = [0.4, 0.1, 0.1] }
vector = [0.0, 0.0, 0.5]
[[amplitude]]
name = "ramp"
points = [[0.0, 0.0], [0.01, 1.0]]
[selection.tip]
plane = { axis = "x", at = 0.4 }
[[event]]
at = 0.01
set = { "force.1.vector" = [0.0, 0.0, 1.0] }
)";

class SceneEditing : public ::testing::Test {
 protected:
  void open(const std::string& text) {
    Scene scene = read_scene_text(text, "/tmp/scene.toml");
    simulation_ = std::make_unique<Simulation>(scene, read_scene_mesh(scene));
    editor_ = std::make_unique<SceneEditor>(*simulation_);
  }
  void SetUp() override { open(kScene); }

  // Makes a change that must be possible.
  void make(const SceneChange& change) {
    EXPECT_EQ(editor_->change(change), "");
    wait();
  }
  void wait() {
    settle(*simulation_);
    const auto refusal = simulation_->take_refusal();
    EXPECT_FALSE(refusal) << *refusal;
    for (const Notice& notice : simulation_->take_notices()) {
      EXPECT_NE(notice.kind, Notice::Kind::kRefused) << notice.text;
    }
    editor_->update();
  }
  void set(const EntryPlace& place, const std::vector<std::string>& path, const Json& value) {
    make({Kind::kSet, place, path, value});
  }
  Json value(const EntryPlace& place, const std::vector<std::string>& path) const {
    Json tables = editor_->scene();
    const Json* node = &table_of(tables, place);
    for (const std::string& key : path) {
      node = node->is_array() ? &node->at(std::stoul(key)) : &node->at(key);
    }
    return *node;
  }
  std::vector<std::string> names_of_fields(const EntryPlace& place) const {
    std::vector<std::string> names;
    for (const Field& field : editor_->fields(place)) names.push_back(field.path.back());
    return names;
  }
  bool has_field(const EntryPlace& place, const std::string& name) const {
    const std::vector<std::string> names = names_of_fields(place);
    return std::find(names.begin(), names.end(), name) != names.end();
  }
  // The saved scene gives the same history as the run so far.
  void expect_same_when_saved(int steps) {
    simulation_->set_steps_per_snapshot(1000000);
    make_steps(*simulation_, steps);
    const Scene saved =
        read_scene_text(scene_text(simulation_->recorded_scene(), "/tmp"), "/tmp/saved.toml");
    expect_bitwise_equal(simulation_->history(0), history_of_run(saved, read_scene_mesh(saved)));
  }

  // The numbers of the vertices right of a place.
  Json ids_from(double x) const {
    const TetMesh& mesh = simulation_->mesh();
    Json ids = Json::array();
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
      if (mesh.vertices[static_cast<std::size_t>(v)].x() > x) ids.push_back(mesh.vertex_id(v));
    }
    return ids;
  }

  std::unique_ptr<Simulation> simulation_;
  std::unique_ptr<SceneEditor> editor_;
};

TEST_F(SceneEditing, TheTreeHasEverySectionOfAScene) {
  std::set<std::string> sections;
  for (const OutlineGroup& group : editor_->outline()) {
    sections.insert(group.section);
    EXPECT_FALSE(group.title.empty());
  }
  for (const ScenePart& part : scene_parts()) EXPECT_TRUE(sections.contains(part.section->name));
  EXPECT_TRUE(sections.contains("event"));
  EXPECT_TRUE(sections.contains("selection"));
  EXPECT_EQ(sections.size(), scene_parts().size() + 2);
}

TEST_F(SceneEditing, EntriesHaveLabels) {
  std::vector<std::string> labels;
  for (const OutlineGroup& group : editor_->outline()) {
    if (!group.is_list) continue;
    for (const OutlineEntry& entry : group.entries) labels.push_back(entry.label);
  }
  EXPECT_EQ(labels,
            (std::vector<std::string>{"0 · plane x = 0", "0 · tip", "1 · nearest 0.4, 0.1, 0.1",
                                      "ramp", "at 0.01 s", "tip"}));
}

TEST_F(SceneEditing, LabelsHaveTheUnitsOfTheWindow) {
  SceneChange add = addition_to("fix");
  add.value = {{"select", {{"plane", {{"axis", "y"}, {"at", 0.1}}}}}};
  make(add);
  EXPECT_FALSE(editor_->update());
  set_unit_system(UnitSystem::kMillimetres);
  EXPECT_TRUE(editor_->update());
  std::vector<std::string> labels;
  for (const OutlineGroup& group : editor_->outline()) {
    if (!group.is_list) continue;
    for (const OutlineEntry& entry : group.entries) labels.push_back(entry.label);
  }
  EXPECT_EQ(labels,
            (std::vector<std::string>{"0 · plane x = 0", "1 · plane y = 100", "0 · tip",
                                      "1 · nearest 400, 100, 100", "ramp", "at 10 ms", "tip"}));
  set_unit_system(UnitSystem::kPrefixes);
  EXPECT_TRUE(editor_->update());
}

TEST_F(SceneEditing, OnlyKeysWithAMeaningAreFields) {
  EXPECT_TRUE(has_field({"material"}, "youngs_modulus"));
  EXPECT_TRUE(has_field({"material"}, "mu"));
  EXPECT_FALSE(has_field({"material"}, "jm"));
  EXPECT_FALSE(has_field({"material"}, "ratio"));
  EXPECT_FALSE(has_field({"fix", 0}, "penalty"));
  set({"fix", 0}, {"mode"}, "penalty");
  EXPECT_TRUE(has_field({"fix", 0}, "penalty"));
  EXPECT_FALSE(has_field({"time"}, "tolerance"));
  set({"time"}, {"adapt"}, "error");
  EXPECT_TRUE(has_field({"time"}, "tolerance"));
}

TEST_F(SceneEditing, FieldsHaveWhatTheTablesSay) {
  const std::vector<Field> fields = editor_->fields({"damping"});
  const auto drag = std::find_if(fields.begin(), fields.end(),
                                 [](const Field& field) { return field.path.back() == "drag"; });
  ASSERT_NE(drag, fields.end());
  EXPECT_EQ(drag->kind, FieldKind::kNumber);
  EXPECT_EQ(drag->title, "Drag");
  EXPECT_EQ(drag->unit, "kg/s per vertex");
  EXPECT_EQ(drag->usual, 1.0);
  EXPECT_EQ(drag->standard, 0.0);
  // Other models have lists of them.
  for (const Field& field : editor_->fields({"material"})) {
    if (field.name() == "mu") {
      EXPECT_EQ(field.kind, FieldKind::kNumber);
    } else if (field.name() == "youngs_modulus") {
      EXPECT_EQ(field.title, "Young's modulus");
    }
  }
  const std::vector<Field> mesh = editor_->fields({"mesh"});
  const auto generate = std::find_if(
      mesh.begin(), mesh.end(), [](const Field& field) { return field.path.back() == "generate"; });
  ASSERT_NE(generate, mesh.end());
  EXPECT_EQ(generate->kind, FieldKind::kTable);
  ASSERT_EQ(generate->fields.size(), 3U);
  EXPECT_EQ(generate->fields[1].path, (std::vector<std::string>{"generate", "size"}));
  EXPECT_EQ(generate->fields[1].kind, FieldKind::kVector);
  const std::vector<Field> force = editor_->fields({"force", 0});
  const auto amplitude = std::find_if(force.begin(), force.end(), [](const Field& field) {
    return field.path.back() == "amplitude";
  });
  EXPECT_EQ(amplitude->names, (std::vector<std::string>{"", "ramp"}));
}

TEST_F(SceneEditing, ValuesOfTheSessionAreEditedWhileItRuns) {
  make_steps(*simulation_, 3);
  set({"material"}, {"youngs_modulus"}, 2e6);
  set({"damping"}, {"mass_damping"}, 5.0);
  set({"force", 1}, {"vector"}, Json{0.0, 0.0, 2.0});
  set({"fix", 0}, {"components"}, "xy");
  set({"environment"}, {"kind"}, "gravity");
  EXPECT_EQ(simulation_->snapshot()->step, 3);
  EXPECT_EQ(simulation_->settings().materials.front().youngs_modulus, 2e6);
  EXPECT_EQ(simulation_->settings().damping.mass_damping, 5.0);
  EXPECT_EQ(simulation_->settings().loads.force[1].vector.z(), 2.0);
  EXPECT_EQ(value({"fix", 0}, {"components"}), "xy");
  EXPECT_EQ(simulation_->undo_text(), "Kind gravity");
  undo(*simulation_);
  editor_->update();
  EXPECT_EQ(simulation_->settings().environment.kind, EnvironmentKind::kNone);
  expect_same_when_saved(4);
}

TEST_F(SceneEditing, OtherValuesSetUpTheRunAgain) {
  set({"damping"}, {"mass_damping"}, 5.0);
  make_steps(*simulation_, 3);
  set({"material"}, {"density"}, 2000.0);
  EXPECT_EQ(simulation_->snapshot()->step, 0);
  EXPECT_NEAR(simulation_->settings().mean_density, 2000.0, 1e-9);
  EXPECT_EQ(simulation_->settings().damping.mass_damping, 5.0) << "an edit before stays";
  EXPECT_EQ(simulation_->undo_text(), "Set up again: Density 2000 kg/m³");
  EXPECT_EQ(simulation_->recorded_scene().material.density, 2000.0);
  expect_same_when_saved(15);

  const auto later = simulation_->snapshot();
  undo(*simulation_);
  editor_->update();
  EXPECT_EQ(simulation_->snapshot()->step, 3) << "the run before goes on";
  EXPECT_EQ(simulation_->history(0).size(), 4U);
  EXPECT_NEAR(simulation_->settings().mean_density, 1000.0, 1e-9);
  EXPECT_EQ(simulation_->settings().damping.mass_damping, 5.0);
  EXPECT_EQ(simulation_->undo_text(), "Mass damping 5 1/s");
  EXPECT_EQ(simulation_->redo_text(), "Set up again: Density 2000 kg/m³");
  undo(*simulation_);
  EXPECT_EQ(simulation_->settings().damping.mass_damping, 0.0);
  redo(*simulation_);
  redo(*simulation_);
  editor_->update();
  EXPECT_NEAR(simulation_->settings().mean_density, 2000.0, 1e-9);
  EXPECT_EQ(simulation_->settings().damping.mass_damping, 5.0);
  EXPECT_EQ(simulation_->snapshot()->step, 15);
  EXPECT_EQ(simulation_->snapshot()->position, later->position);
  expect_same_when_saved(2);
}

// Each undo leads to the run as it was left, also over a restart and another mesh.
TEST_F(SceneEditing, UndoOverSeveralSetUpsRestoresTheStates) {
  make_steps(*simulation_, 2);
  const auto first = simulation_->snapshot();
  set({"mesh"}, {"generate", "cells"}, Json{6, 1, 1});
  make_steps(*simulation_, 3);
  const auto second = simulation_->snapshot();
  restart(*simulation_);
  editor_->update();
  set({"material"}, {"density"}, 2000.0);
  make_steps(*simulation_, 4);
  const auto third = simulation_->snapshot();
  const std::vector<std::pair<std::string, Vector>> back{
      {"Set up again: Density 2000 kg/m³", {}},
      {"Restart", second->position},
      {"Set up again: Cells 6, 1, 1", first->position}};
  for (const auto& [text, position] : back) {
    EXPECT_EQ(simulation_->undo_text(), text);
    undo(*simulation_);
    if (position.size() > 0) {
      EXPECT_EQ(simulation_->snapshot()->position, position);
    }
  }
  EXPECT_EQ(simulation_->undo_text(), "");
  for (int i = 0; i < 3; ++i) redo(*simulation_);
  EXPECT_EQ(simulation_->redo_text(), "");
  EXPECT_EQ(simulation_->snapshot()->position, third->position);
  editor_->update();
  expect_same_when_saved(2);
}

// A file has them as comments, so that the window knows them again.
TEST_F(SceneEditing, EntriesThatAreOffAreSaved) {
  EXPECT_EQ(
      editor_->switch_off({"force", 1}),
      "This entry (force 1) is changed by the event at 0.01 s: change or delete the event first.");
  make({Kind::kRemove, {"event", 0}});
  EXPECT_EQ(editor_->switch_off({"force", 1}), "");
  wait();
  EXPECT_EQ(editor_->switch_off({"force", 0}), "");
  wait();
  EXPECT_EQ(editor_->switch_off({"selection", 0}), "");
  wait();
  const std::vector<OffEntry> off = editor_->off_now();
  ASSERT_EQ(off.size(), 3U);
  const std::string text =
      scene_text(simulation_->recorded_scene(), "/tmp") + off_entries_text(off);
  open(text);
  EXPECT_EQ(entry_count(editor_->scene(), "force"), 0U);
  const std::vector<OffEntry> read = off_entries_in(text);
  editor_ = std::make_unique<SceneEditor>(*simulation_, read);
  ASSERT_EQ(editor_->off_now().size(), 3U);
  EXPECT_EQ(read[2].label, "tip");
  EXPECT_EQ(read[0].label, "nearest 0.4, 0.1, 0.1");
  for (const std::size_t i : {2U, 1U, 0U}) {
    EXPECT_EQ(editor_->switch_on(i), "");
    wait();
  }
  EXPECT_TRUE(editor_->off_now().empty());
  EXPECT_EQ(simulation_->settings().loads.force.size(), 2U);
  EXPECT_EQ(simulation_->settings().loads.force[0].amplitude, "ramp");
  EXPECT_TRUE(off_entries_in("#: [[no_section]]\n#: a = 1\n#: = \n").empty());
}

TEST_F(SceneEditing, TheNoteOfASetUpGoesWithTheNextCommand) {
  EXPECT_EQ(editor_->change({Kind::kSet, {"material"}, {"density"}, 2000.0}), "");
  settle(*simulation_);
  std::vector<Notice> notices = simulation_->take_notices();
  std::erase_if(notices, [](const Notice& notice) { return notice.text == blas_warning(); });
  ASSERT_EQ(notices.size(), 1U);
  EXPECT_EQ(notices[0].kind, Notice::Kind::kNote);
  simulation_->take_ended_causes();
  make_steps(*simulation_, 1);
  EXPECT_EQ(simulation_->take_ended_causes(), std::vector<std::string>{notices[0].cause});
}

TEST_F(SceneEditing, AnEditAfterAnUndoneSetUpEndsItsRedo) {
  set({"material"}, {"density"}, 2000.0);
  undo(*simulation_);
  editor_->update();
  set({"damping"}, {"drag"}, 0.5);
  EXPECT_EQ(simulation_->redo_text(), "");
}

TEST_F(SceneEditing, ASceneWithoutEndIsEdited) {
  Scene scene = read_scene_text(kScene, "/tmp/scene.toml");
  scene.time.end = std::numeric_limits<double>::infinity();
  simulation_ = std::make_unique<Simulation>(scene, read_scene_mesh(scene));
  editor_ = std::make_unique<SceneEditor>(*simulation_);
  set({"time"}, {"step"}, 2e-3);
  EXPECT_EQ(simulation_->settings().time.step, 2e-3);
  set({"material"}, {"density"}, 2000.0);
  EXPECT_TRUE(std::isinf(simulation_->scene().time.end));
  set({"time"}, {"end"}, 0.5);
  EXPECT_EQ(simulation_->scene().time.end, 0.5);
  set({"time"}, {"end"}, Json());
  expect_same_when_saved(3);
}

TEST_F(SceneEditing, AnotherMeshIsAnotherBody) {
  const Index before = simulation_->mesh().vertex_count();
  set({"mesh"}, {"generate", "cells"}, Json{6, 1, 1});
  EXPECT_GT(simulation_->mesh().vertex_count(), before);
  EXPECT_EQ(simulation_->snapshot()->position.size(), 3 * simulation_->mesh().vertex_count());
  undo(*simulation_);
  EXPECT_EQ(simulation_->mesh().vertex_count(), before);
}

TEST_F(SceneEditing, AKindBringsTheKeysThatItNeeds) {
  const std::string scene = kScene;
  open(scene.substr(0, scene.find("[[fix]]")));  // without selections of the box
  set({"mesh"}, {"generate", "kind"}, "cube");
  EXPECT_TRUE(value({"mesh"}, {"generate", "size"}).is_number());
  EXPECT_EQ(simulation_->scene().mesh.generate->kind, GeneratorKind::kCube);
}

TEST_F(SceneEditing, ObstaclesOfEveryKindBeginApartFromTheBody) {
  make({Kind::kAdd, {"obstacle"}});
  // The first one sets the scene up again. Then the run knows contact, and obstacles are edits.
  make_steps(*simulation_, 2);
  set({"obstacle", 0}, {"friction"}, 0.3);
  EXPECT_EQ(simulation_->peek()->step, 2);
  for (const char* kind : {"sphere", "cylinder", "box", "plane"}) {
    SCOPED_TRACE(kind);
    set({"obstacle", 0}, {"kind"}, kind);
    const ObstacleSettings obstacle = simulation_->settings().obstacles.at(0).settings;
    EXPECT_STREQ(name_of(obstacle.kind), kind);
    EXPECT_EQ(obstacle.name, "floor");
    EXPECT_EQ(obstacle.friction, 0.3) << "what is not of the shape stays";
    EXPECT_EQ(has_field({"obstacle", 0}, "radius"),
              obstacle.kind == ObstacleKind::kSphere || obstacle.kind == ObstacleKind::kCylinder);
    EXPECT_EQ(simulation_->snapshot()->contact_force.norm(), 0.0);
    expect_same_when_saved(2);
  }
  EXPECT_EQ(simulation_->settings().obstacles.at(0).settings.point.y(), -0.03)
      << "a number of few digits";
  make({Kind::kRemove, {"obstacle", 0}});
  EXPECT_TRUE(editor_->scene().value("obstacle", Json::array()).empty());
  make({Kind::kAdd, {"obstacle"}});
  EXPECT_EQ(editor_->scene().at("obstacle").size(), 1U);
  EXPECT_GE(simulation_->peek()->step, 2);
}

TEST_F(SceneEditing, AModelGetsTheSameModuli) {
  const LameParameters before = simulation_->settings().moduli.front().least;
  for (const MaterialChoice& choice : material_choices()) {
    set({"material"}, {"model"}, choice.name);
    const LameParameters now = simulation_->settings().moduli.front().least;
    EXPECT_EQ(value({"material"}, {"model"}), choice.name);
    EXPECT_NEAR(now.mu, before.mu, 1e-9 * before.mu) << choice.name;
    EXPECT_NEAR(now.lambda, before.lambda, 1e-6 * before.lambda) << choice.name;
  }
}

TEST_F(SceneEditing, AValueStandsInPlaceOfAnother) {
  make({Kind::kRemove, {"event", 0}});  // it needs the vector
  set({"force", 1}, {"total"}, Json{0.0, 0.0, 3.0});
  const ForceSettings force = simulation_->settings().loads.force[1];
  ASSERT_TRUE(force.total);
  EXPECT_EQ(force.total->z(), 3.0);
  EXPECT_TRUE(force.vector.isZero());
  set({"amplitude", 0}, {"sine"}, Json::object());
  EXPECT_EQ(simulation_->scene().amplitude.front().kind, AmplitudeKind::kSine);
}

TEST_F(SceneEditing, WrongValuesChangeNothing) {
  const Json before = editor_->scene();
  const auto refusal = [&](const EntryPlace& place, const std::vector<std::string>& path,
                           const Json& wrong) {
    const std::string text = editor_->change({Kind::kSet, place, path, wrong});
    wait();
    EXPECT_EQ(editor_->scene(), before);
    EXPECT_EQ(simulation_->undo_text(), "");
    return text;
  };
  EXPECT_NE(refusal({"material"}, {"density"}, -1.0).find("material.density = -1"),
            std::string::npos);
  EXPECT_NE(refusal({"time"}, {"step"}, "fast").find("time.step"), std::string::npos);
  EXPECT_NE(refusal({"force", 0}, {"amplitude"}, "rump").find("rump"), std::string::npos);
  EXPECT_NE(refusal({"fix", 0}, {"penalty"}, "x").find("penalty"), std::string::npos);
}

TEST_F(SceneEditing, ASceneThatCannotBeSetUpChangesNothing) {
  make_steps(*simulation_, 2);
  EXPECT_EQ(editor_->change({Kind::kSet, {"initial"}, {"stretch"}, Json{1.0, 1.0, 1.0}}), "");
  settle(*simulation_);
  simulation_->take_notices();
  editor_->update();
  const std::string undo = simulation_->undo_text();
  const Json before = editor_->scene();
  make_steps(*simulation_, 2);
  EXPECT_EQ(editor_->change({Kind::kSet, {"initial"}, {"displacement_array"}, "nothing"}), "");
  settle(*simulation_);
  const auto refusal = simulation_->take_refusal();
  ASSERT_TRUE(refusal);
  EXPECT_NE(refusal->find("displacement_array"), std::string::npos) << *refusal;
  EXPECT_FALSE(simulation_->take_refusal());
  editor_->update();
  EXPECT_EQ(editor_->scene(), before);
  EXPECT_EQ(simulation_->undo_text(), undo);
  EXPECT_EQ(simulation_->snapshot()->step, 2);
}

TEST_F(SceneEditing, ADistanceIsBetweenTheFirstAndTheLastOfTheSelectedVertices) {
  open(kScene);
  SceneChange add{Kind::kAdd, {"constraint"}};
  add.select = Json{{"vertices", {8, 9, 12, 13}}};
  make(add);
  ASSERT_EQ(entry_count(editor_->scene(), "constraint"), 1U);
  EXPECT_EQ(editor_->scene()["constraint"][0]["vertices"], (Json{8, 13}));
}

TEST_F(SceneEditing, EntriesOfEveryListAreAddedDuplicatedSwitchedAndDeleted) {
  const std::vector<OutlineGroup> groups = editor_->outline();
  for (const OutlineGroup& group : groups) {
    if (!group.is_list) continue;
    open(kScene);
    const std::string& section = group.section;
    const std::size_t before = entry_count(editor_->scene(), section);
    SceneChange add{Kind::kAdd, {section}};
    if (section == "traction" || section == "pressure") add.select = Json{{"surface", true}};
    // A rigid handle for instance needs several vertices, a distance two.
    if (section == "constraint") add.select = Json{{"vertices", {1, 2}}};
    SCOPED_TRACE(section);
    make(add);
    ASSERT_EQ(entry_count(editor_->scene(), section), before + 1);
    // Named selections are in the order of their names, and "selection_1" is before "tip".
    const std::size_t added_at = section == kSelections ? 0 : before;
    for (const Field& field : editor_->fields({section, added_at})) {
      EXPECT_TRUE(!field.is_needed || !field.value.is_null()) << field.title;
    }
    if (section != "fix") {  // a vertex is held by one of them
      EXPECT_EQ(editor_->duplicate({section, added_at}), "");
      wait();
      ASSERT_EQ(entry_count(editor_->scene(), section), before + 2);
      make({Kind::kRemove, {section, added_at + 1}});
    }
    const Json added = value({section, added_at}, {});
    EXPECT_EQ(editor_->switch_off({section, added_at}), "");
    wait();
    ASSERT_EQ(entry_count(editor_->scene(), section), before);
    ASSERT_EQ(editor_->off().size(), 1U);
    EXPECT_TRUE(editor_->is_off(editor_->off().front()));
    EXPECT_EQ(editor_->switch_on(0), "");
    wait();
    ASSERT_EQ(entry_count(editor_->scene(), section), before + 1);
    EXPECT_EQ(value({section, added_at}, {}), added);
    EXPECT_FALSE(editor_->is_off(editor_->off().front()));
    expect_same_when_saved(3);
    EXPECT_EQ(editor_->remove({section, added_at}), "");
    wait();
    EXPECT_EQ(entry_count(editor_->scene(), section), before);
    EXPECT_TRUE(editor_->off_now().empty()) << "it is deleted, not off";
    undo(*simulation_);
    editor_->update();
    EXPECT_EQ(entry_count(editor_->scene(), section), before + 1);
  }
}

TEST_F(SceneEditing, WhatIsSelectedIsEnoughForANewEntryOfEveryList) {
  const Json tip = ids_from(0.35);
  const Json pair{tip[0], tip[1]};
  for (const Json& ids : {Json(), Json::array({tip[0]}), pair, tip, ids_from(0.25)}) {
    const Json selected = ids.is_null() ? Json() : Json{{"vertices", ids}};
    const std::vector<OutlineGroup> groups = editor_->outline();
    for (const OutlineGroup& group : groups) {
      if (!group.is_list) continue;
      open(kScene);
      SCOPED_TRACE(group.section + " " + ids.dump());
      SceneChange add{Kind::kAdd, {group.section}};
      add.select = editor_->usual_selection(group.section, selected);
      const std::size_t before = entry_count(editor_->scene(), group.section);
      make(add);
      EXPECT_EQ(entry_count(editor_->scene(), group.section), before + 1);
    }
  }
}

TEST_F(SceneEditing, EventsFollowTheNumbersOfEntries) {
  const EntryPlace event{"event", 0};
  make({Kind::kRemove, {"force", 0}});
  EXPECT_EQ(simulation_->scene().force.size(), 1U);
  EXPECT_EQ(value(event, {"set"}).begin().key(), "force.0.vector");
  EXPECT_EQ(simulation_->undo_text(), "Set up again: Force 0 deleted");
  EXPECT_EQ(
      editor_->change({Kind::kRemove, {"force", 0}}),
      "This entry (force 0) is changed by the event at 0.01 s: change or delete the event first.");
  undo(*simulation_);
  editor_->update();
  EXPECT_EQ(value(event, {"set"}).begin().key(), "force.1.vector");
  expect_same_when_saved(20);
}

TEST_F(SceneEditing, TheUndoOfAnAddedLoadLeavesNothing) {
  const auto saved = [this] { return scene_text(simulation_->recorded_scene(), "/tmp"); };
  for (const char* section : {"force", "moment", "traction", "pressure", "body_force"}) {
    SCOPED_TRACE(section);
    open(kScene);
    const std::string before = saved();
    const Json scene = editor_->scene();
    SceneChange add{Kind::kAdd, {section}};
    add.select = Json{{"vertices", ids_from(0.25)}};
    make(add);
    const Json added = editor_->scene();
    set({section, entry_count(scene, section)}, {"until"}, 0.015);
    for (int i = 0; i < 2; ++i) undo(*simulation_);
    editor_->update();
    EXPECT_EQ(editor_->scene(), scene);
    EXPECT_EQ(saved(), before);
    redo(*simulation_);
    editor_->update();
    EXPECT_EQ(editor_->scene(), added);
    expect_same_when_saved(3);
    // After steps the saved scene has what the load has done. The tree does not have it any more.
    undo(*simulation_);
    editor_->update();
    EXPECT_EQ(editor_->scene(), scene);
    make_steps(*simulation_, 2);
    expect_same_when_saved(0);
    redo(*simulation_);
    editor_->update();
    EXPECT_EQ(editor_->scene(), added);
    make_steps(*simulation_, 2);
    undo(*simulation_);
    editor_->update();
    EXPECT_EQ(editor_->scene(), scene);
    // Neither has a run that goes on from an earlier state, or is set up again.
    make(add);
    EXPECT_EQ(editor_->scene(), added);
    undo(*simulation_);
    make_steps(*simulation_, 2);
    for (const double time : {0.005, 0.001}) {
      simulation_->show_at(time);
      simulation_->continue_here();
      settle(*simulation_);
      editor_->update();
      EXPECT_EQ(editor_->scene(), scene);
    }
    expect_same_when_saved(3);
    set({"time"}, {"end"}, 0.03);
    EXPECT_EQ(simulation_->scene().force.size(), 2U);
  }
}

TEST_F(SceneEditing, EventsThatChangeWhatIsDeletedAreNamedAndTakenOut) {
  open(std::string(kScene) + R"(
[[event]]
at = 0.015
set = { "fix.0.offset" = [0.0, 0.01, 0.0] }
[[event]]
at = 0.016
unfix = { select = "tip", fix = 0 }
set = { "damping.drag" = 1.0 }
)");
  EXPECT_EQ(editor_->events_that_change({"fix", 0}), "the event at 0.015 s, the event at 0.016 s");
  EXPECT_EQ(editor_->events_that_change({"force", 0}), "");
  make({Kind::kRemove, {"fix", 0}});
  EXPECT_EQ(entry_count(editor_->scene(), "fix"), 0U);
  // Anything else can be changed.
  set({"time"}, {"end"}, 0.03);
  ASSERT_EQ(simulation_->scene().event.size(), 2U);
  EXPECT_EQ(simulation_->scene().event[1].edits.size(), 1U);
  undo(*simulation_);
  undo(*simulation_);
  editor_->update();
  EXPECT_EQ(entry_count(editor_->scene(), "fix"), 1U);
  EXPECT_EQ(simulation_->scene().event.size(), 3U);
}

TEST_F(SceneEditing, AddedEntriesStayWhenTheSceneIsSetUpAgain) {
  SceneChange add{Kind::kAdd, {"force"}};
  add.value = Json{{"select", {{"all", true}}}, {"vector", {0.0, 0.1, 0.0}}};
  make(add);
  EXPECT_EQ(simulation_->undo_text(), "Force 2 added");
  set({"force", 2}, {"until"}, 0.015);
  make_steps(*simulation_, 2);
  set({"time"}, {"end"}, 0.03);
  EXPECT_EQ(simulation_->scene().force.size(), 3U);
  EXPECT_EQ(simulation_->scene().force[2].until, 0.015);
  EXPECT_EQ(simulation_->scene().time.end, 0.03);
  make({Kind::kRemove, {"force", 2}});
  EXPECT_EQ(simulation_->scene().force.size(), 2U);
  expect_same_when_saved(12);
}

TEST_F(SceneEditing, ReleasedAndRemovedEntriesStayAway) {
  SceneChange add{Kind::kAdd, {"constraint"}};
  add.value = Json{{"kind", "distance"}, {"vertices", {8, 12}}};
  make(add);
  set({"output"}, {"every"}, 2);
  EXPECT_EQ(simulation_->scene().constraint.size(), 1U);
  make({Kind::kRemove, {"constraint", 0}});
  make({Kind::kRemove, {"fix", 0}});
  EXPECT_EQ(entry_count(editor_->scene(), "fix"), 0U);
  EXPECT_EQ(entry_count(editor_->scene(), "constraint"), 0U);
  set({"output"}, {"every"}, 3);
  EXPECT_TRUE(simulation_->scene().constraint.empty());
  EXPECT_TRUE(simulation_->scene().fix.empty());
  expect_same_when_saved(3);
}

TEST_F(SceneEditing, NamesAreChangedWhereTheyAreUsed) {
  make({Kind::kRename, {"amplitude", 0}, {}, "slow"});
  EXPECT_EQ(simulation_->scene().force[0].amplitude, "slow");
  make({Kind::kRename, {"selection", 0}, {}, "end"});
  EXPECT_EQ(value({"force", 0}, {"select"}), "end");
  make({Kind::kAdd, {"amplitude"}});
  EXPECT_EQ(editor_->change({Kind::kRename, {"amplitude", 1}, {}, "slow"}),
            "The name \"slow\" is taken already.");
  EXPECT_NE(editor_->change({Kind::kRemove, {"amplitude", 0}}).find("slow"), std::string::npos)
      << "a force needs it";
}

TEST_F(SceneEditing, SelectionsChangeTheirKind) {
  for (const SceneKey& key : find_section("select")->keys) {
    const std::string kind = key.info.name;
    if (kind == "group" || kind == "faces") continue;
    set({"force", 1}, {"select"}, selection_of_kind(kind, Json{{"vertices", {3, 4}}}));
    EXPECT_EQ(value({"force", 1}, {"select"}).begin().key(), kind);
    bool is_field = false;
    for (const Field& field : editor_->fields({"force", 1})) {
      if (field.kind != FieldKind::kSelection) continue;
      ASSERT_EQ(field.fields.size(), 1U);
      is_field = field.fields.front().path.back() == kind;
    }
    EXPECT_TRUE(is_field) << kind;
  }
  set({"force", 1}, {"select"}, selection_of_kind("plane", Json()));
  set({"force", 1}, {"select", "plane", "at"}, 0.4);
  EXPECT_EQ(value({"force", 1}, {"select", "plane", "at"}), 0.4);
  set({"selection", 0}, {"plane", "at"}, 0.0);
  EXPECT_EQ(value({"selection", 0}, {"plane", "at"}), 0.0);
}

TEST_F(SceneEditing, TablesOfAListAreAddedAndTakenOut) {
  set({"initial"}, {"momentum", "0"}, Json::object());
  EXPECT_EQ(simulation_->scene().initial.momentum.size(), 1U);
  set({"initial"}, {"momentum", "0", "value"}, Json{0.0, 0.1, 0.0});
  EXPECT_EQ(simulation_->scene().initial.momentum[0].value.y(), 0.1);
  set({"initial"}, {"momentum", "0"}, Json());
  EXPECT_TRUE(simulation_->scene().initial.momentum.empty());
}

TEST_F(SceneEditing, EverySceneOfTheProjectIsATree) {
  int count = 0;
  for (const auto& file : std::filesystem::directory_iterator(TETRACTION_SCENES)) {
    if (file.path().extension() != ".toml") continue;
    SCOPED_TRACE(file.path().string());
    const Scene scene = read_scene(file.path().string());
    const Json json = scene_json(scene);
    const Scene again = scene_of_json(json, scene);
    EXPECT_EQ(scene_json(again), json);
    for (const OutlineGroup& group : outline(json)) {
      for (const OutlineEntry& entry : group.entries) {
        EXPECT_FALSE(fields_of(json, entry.place).empty()) << group.section;
      }
    }
    ++count;
  }
  EXPECT_GT(count, 5);
}

// A new name changes nothing of the run: it goes on, and edits and their events can use the name.
TEST_F(SceneEditing, ASelectionGetsANameInTheRunningSession) {
  make_steps(*simulation_, 3);
  const std::size_t edits = simulation_->edit_count();
  SceneChange add = addition_to("selection");
  add.path = {"corner"};
  add.value = {{"vertices", {1, 2}}};
  EXPECT_EQ(editor_->sets_up_again(add), false);
  make(add);
  EXPECT_EQ(simulation_->peek()->step, 3);
  EXPECT_EQ(value({"selection", 0}, {}), add.value);
  EXPECT_EQ(simulation_->undo_text(), "Named selection added");
  EXPECT_TRUE(simulation_->edited_since(edits));
  set({"force", 1}, {"select"}, "corner");
  EXPECT_EQ(simulation_->peek()->step, 3);
  make_steps(*simulation_, 2);
  undo(*simulation_);
  undo(*simulation_);
  wait();
  EXPECT_EQ(editor_->scene().at("selection").size(), 1U);
  EXPECT_EQ(simulation_->redo_text(), "Named selection added");
  // The event that used the name is still in the recording, so that no other selection may get it.
  SceneChange other = add;
  other.value = {{"vertices", {3}}};
  EXPECT_EQ(editor_->change(other), "");
  settle(*simulation_);
  const auto refusal = simulation_->take_refusal();
  ASSERT_TRUE(refusal);
  EXPECT_NE(refusal->find("choose another"), std::string::npos) << *refusal;
  redo(*simulation_);
  wait();
  EXPECT_EQ(value({"selection", 0}, {}), add.value);
  expect_same_when_saved(4);
}

TEST_F(SceneEditing, AnUndoneNameIsNotSavedUnlessTheRecordingNeedsIt) {
  const auto saved = [this](const std::string& name) {
    const std::vector<NamedSelection> all = simulation_->recorded_scene().selection;
    return std::ranges::find(all, name, &NamedSelection::name) != all.end();
  };
  SceneChange add = addition_to("selection");
  add.path = {"corner"};
  add.value = {{"vertices", {1, 2}}};
  make(add);
  EXPECT_TRUE(saved("corner"));
  undo(*simulation_);
  wait();
  EXPECT_FALSE(saved("corner"));
  EXPECT_TRUE(saved("tip"));
  redo(*simulation_);
  wait();
  EXPECT_TRUE(saved("corner"));
  // An edit that stays in the recording, as part of another selection.
  set({"force", 1}, {"select"}, {{"not", "corner"}});
  make_steps(*simulation_, 1);
  undo(*simulation_);
  undo(*simulation_);
  wait();
  EXPECT_TRUE(saved("corner"));
  // Another selection may have the name of one that nothing needs.
  add.path = {"side"};
  make(add);
  undo(*simulation_);
  wait();
  add.value = {{"vertices", {3}}};
  make(add);
  EXPECT_TRUE(saved("side"));
  expect_same_when_saved(2);
}

TEST_F(SceneEditing, ANameStaysAtARestartAndGoesWithAReload) {
  make_steps(*simulation_, 2);
  SceneChange add = addition_to("selection");
  add.path = {"corner"};
  make(add);
  restart(*simulation_);
  wait();
  EXPECT_EQ(editor_->scene().at("selection").size(), 2U);
  EXPECT_TRUE(simulation_->edited_since(0)) << "it is not saved yet";
  simulation_->reset();
  wait();
  EXPECT_EQ(editor_->scene().at("selection").size(), 1U);
  EXPECT_FALSE(simulation_->edited_since(0));
}

}  // namespace
}  // namespace tetraction::viewer
