#include "scene_editor.h"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <tuple>
#include <utility>

#include "document/scene_json.h"
#include "tetraction/core/error.h"
#include "tetraction/mesh/selection.h"
#include "usual_obstacle.h"

namespace tetraction::viewer {
namespace {

// The list of an edit's entries, if a section has one.
std::optional<std::size_t> edited_list(const std::string& section) {
  for (const LoadKind kind : values_of<LoadKind>()) {
    if (section == name_of(kind)) return static_cast<std::size_t>(kind);
  }
  if (section == section_of<FixSettings>().name) return list_of(FixSettings());
  if (section == section_of<ConstraintSettings>().name) return list_of(ConstraintSettings());
  if (section == section_of<ObstacleSettings>().name) return list_of(ObstacleSettings());
  return std::nullopt;
}

Json json_of(const SceneSection& section, const void* settings) {
  const Json all = settings_json(section, settings);
  Json given = Json::object();
  for (const auto& [key, value] : all.items()) {
    if (!value.is_null()) given[key] = value;
  }
  return given;
}

// A scene of the window may be without an end, which a file must have.
Json json_of_scene(Scene scene) {
  const bool is_endless = std::isinf(scene.time.end);
  if (is_endless) scene.time.end = TimeSettings{}.end;
  Json json = scene_json(scene);
  if (is_endless) json["time"].erase("end");
  return json;
}

// The scene with the present settings. The numbers are those of the session for the entries of its lists.
Scene present_scene(const Scene& start, const Settings& settings) {
  Scene scene = start;
  const double end = scene.time.end;  // runs in the window have none
  static_cast<ChangeableSections&>(scene) = settings;
  scene.time.end = end;
  scene.material = settings.materials.front();
  for (std::size_t i = 1; i < settings.materials.size(); ++i) {
    scene.material_region.at(i - 1).material = settings.materials[i];
  }
  const auto take = [&](auto& entries, const auto& all, std::size_t list) {
    entries.clear();
    for (const std::size_t number : settings.present[list]) entries.push_back(all[number]);
  };
  for (const LoadKind kind : values_of<LoadKind>()) {
    take(scene.list(kind), settings.loads.list(kind), static_cast<std::size_t>(kind));
  }
  take(scene.fix, settings.fixes, list_of(FixSettings()));
  scene.constraint.clear();
  for (const std::optional<ConstraintSettings>& constraint : settings.constraints) {
    if (constraint) scene.constraint.push_back(*constraint);
  }
  scene.obstacle.clear();
  for (const BodyObstacle& obstacle : settings.obstacles) {
    if (!obstacle.removed) scene.obstacle.push_back(obstacle.settings);
  }
  return scene;
}

// The numbers in the session of the entries of present_scene().
std::size_t number_of_entry(const Settings& settings, std::size_t list, std::size_t index) {
  const std::vector<std::size_t>& present = settings.present[list];
  return index < present.size() ? present[index] : kNewest;
}

// The scene with the edits, with numbers in its events that fit.
Json edited_json(const EditedScene& edited) {
  Json json = json_of_scene(edited.scene);
  const auto each_list = [](const auto& work) {
    for (const LoadKind kind : values_of<LoadKind>()) {
      work(std::string(name_of(kind)), static_cast<std::size_t>(kind));
    }
    work(std::string(section_of<FixSettings>().name), list_of(FixSettings()));
    work(std::string(section_of<ConstraintSettings>().name), list_of(ConstraintSettings()));
    work(std::string(section_of<ObstacleSettings>().name), list_of(ObstacleSettings()));
  };
  each_list([&](const std::string& section, std::size_t list) {
    const auto added = static_cast<int>(edited.numbers[list].size() - edited.counts[list]);
    if (added > 0) renumber_events(json, section, edited.counts[list], added);
    std::vector<std::size_t> removed = edited.removed[list];
    std::sort(removed.rbegin(), removed.rend());
    for (const std::size_t place : removed) {
      json[section].erase(place);
      drop_from_events(json, {section, place});
      if (json[section].empty()) json.erase(section);
    }
  });
  return json;
}

// The usual strength of attraction causes a visible but moderate motion, and the softening bounds the force at the
// origin.
Json usual_attraction(const EnvironmentSettings& present) {
  EnvironmentSettings next = present;
  next.kind = EnvironmentKind::kAttraction;
  next.strength = 0.5;
  next.softening = 0.3;
  return json_of(section_of<EnvironmentSettings>(), &next);
}

// The run goes on with a new named selection, which nothing uses yet.
bool adds_selection(const SceneChange& change) {
  return change.kind == SceneChange::Kind::kAdd && change.place.section == kSelections;
}

}  // namespace

Scene scene_with_edits(const Simulation& simulation) {
  const EditedScene edited = simulation.edited_scene();
  return scene_of_json(edited_json(edited), edited.scene);
}

SceneEditor::SceneEditor(Simulation& simulation, std::vector<OffEntry> off)
    : simulation_(simulation), off_(std::move(off)) {
  update();
}

std::vector<Field> SceneEditor::fields(const EntryPlace& place) const {
  std::vector<Field> fields = fields_of(scene_, place);
  for (Field& field : fields) {
    const bool is_end = place.section == section_of<TimeSettings>().name && field.name() == "end";
    if (is_end && std::isinf(present_.time.end)) field.standard = Json();  // there is none
  }
  return fields;
}

Json SceneEditor::usual_selection(const std::string& section, const Json& selected) const {
  const Json all{{"all", true}};
  if (selected.is_null()) {
    const TetMesh& mesh = simulation_.mesh();
    const bool is_constraint = section == section_of<ConstraintSettings>().name;
    return is_constraint ? Json{{"vertices", {mesh.vertex_id(0), mesh.vertex_id(1)}}} : all;
  }
  const bool is_on_surface =
      section == name_of(LoadKind::kTraction) || section == name_of(LoadKind::kPressure);
  const bool is_in_volume = section == name_of(LoadKind::kBodyForce) ||
                            section == section_of<MaterialRegionSettings>().name;
  const SelectVertices vertices{selected["vertices"].get<std::vector<std::int64_t>>()};
  try {
    if (is_on_surface) select_triangles(simulation_.mesh(), vertices);
    if (is_in_volume) select_tetrahedra(simulation_.mesh(), vertices);
  } catch (const InputError&) {
    return is_on_surface ? Json{{"surface", true}} : all;
  }
  return selected;
}

bool SceneEditor::update() {
  if (shown_ == simulation_.settings_number() && units_ == unit_system()) return false;
  Present now = simulation_.present();
  shown_ = now.number;
  settings_ = std::move(now.settings);
  const Scene& start = *now.start;
  present_ = present_scene(start, settings_);
  try {
    present_.event.clear();
    scene_ = json_of_scene(present_);
    if (!start.event.empty()) scene_["event"] = json_of_scene(start)["event"];
  } catch (const InputError&) {
    scene_ = Json();
  }
  units_ = unit_system();
  outline_ = outline_in_units(scene_);
  return true;
}

// Another model gets parameters with the same moduli at small strains.
SceneChange SceneEditor::with_model(const SceneChange& change) const {
  const SceneSection& section = section_of_entries(change.place.section);
  if (section.type == typeid(ObstacleSettings)) {
    return with_usual_shape(change, scene_, simulation_.mesh());
  }
  if (section.type == typeid(EnvironmentSettings) && change.value == "attraction" &&
      present_.environment.kind != EnvironmentKind::kAttraction) {
    return {SceneChange::Kind::kSet, change.place, {}, usual_attraction(present_.environment)};
  }
  const bool is_region = section.beside && &section.beside() == &section_of<MaterialSettings>();
  if (change.kind != SceneChange::Kind::kSet || change.path != std::vector<std::string>{"model"} ||
      !(is_region || section.type == typeid(MaterialSettings)) || !change.value.is_string()) {
    return change;
  }
  const MaterialChoice* choice = find_material(change.value.get<std::string>());
  const std::size_t region = is_region ? change.place.index + 1 : 0;
  if (choice == nullptr || region >= settings_.materials.size()) return change;
  MaterialSettings material;
  material.model = choice->name;
  material.density = settings_.materials[region].density;
  const MaterialSettings& before = settings_.materials[region];
  const auto has = [&](const MaterialParameter& parameter) {
    return before.arrays.contains(parameter.name);
  };
  const bool keeps_young = (before.youngs_modulus || has(kYoungsModulus)) &&
                           (before.poissons_ratio || has(kPoissonsRatio)) &&
                           std::string_view(choice->instead.front().name) == kYoungsModulus.name;
  choice->set_like(material, settings_.moduli[region].least);
  if (has(kDensity)) material.arrays[kDensity.name] = before.arrays.at(kDensity.name);
  if (keeps_young) {
    MaterialSettings by_young;
    by_young.model = material.model;
    by_young.density = material.density;
    by_young.youngs_modulus = before.youngs_modulus;
    by_young.poissons_ratio = before.poissons_ratio;
    for (const MaterialParameter& parameter : {kYoungsModulus, kPoissonsRatio, kDensity}) {
      if (has(parameter)) by_young.arrays[parameter.name] = before.arrays.at(parameter.name);
    }
    for (const MaterialParameter& beside : choice->beside_young) {
      const auto usual = number_of(material, beside.name);
      const auto kept = number_of(before, beside.name);
      if (kept || usual) set_number(by_young, beside.name, kept ? *kept : *usual);
    }
    try {
      check_material(by_young);
      material = by_young;
    } catch (const InputError&) {
      // The model is given by its own parameters.
    }
  }
  SceneChange whole = change;
  whole.path.clear();
  whole.value = json_of(section_of<MaterialSettings>(), &material);
  return whole;
}

// The edit that a change of the present scene is. No value if there is no such edit.
std::optional<Edit> SceneEditor::edit_of(const SceneChange& change) const {
  const std::string& section = change.place.section;
  Json json = scene_;
  json.erase("event");
  const Json before = json;
  const std::optional<std::size_t> list = edited_list(section);
  // A run whose scene has no obstacles knows no contact.
  if (list == list_of(ObstacleSettings()) && settings_.obstacles.empty()) return std::nullopt;
  if (change.kind == SceneChange::Kind::kRemove) {
    if (!list) return std::nullopt;
    const std::size_t number = number_of_entry(settings_, *list, change.place.index);
    if (*list == list_of(FixSettings())) {
      return Unfix{SelectAll{}, {}, number};
    }
    if (*list == list_of(ConstraintSettings())) return RemoveConstraint{number};
    if (*list == list_of(ObstacleSettings())) return RemoveObstacle{number};
    return std::nullopt;
  }
  const Scene after = changed_scene(json, present_, change).scene;
  if (list && change.kind != SceneChange::Kind::kRename) {
    std::optional<std::size_t> number;
    std::size_t index = entry_count(before, section);
    if (change.kind == SceneChange::Kind::kSet) {
      index = change.place.index;
      number = number_of_entry(settings_, *list, index);
    }
    if (*list == list_of(FixSettings())) return SetFix{number, after.fix.at(index)};
    if (*list == list_of(ConstraintSettings())) {
      return SetConstraint{number, after.constraint.at(index)};
    }
    if (*list == list_of(ObstacleSettings())) return SetObstacle{number, after.obstacle.at(index)};
    return SetForce{number, after.list(static_cast<LoadKind>(*list)).at(index)};
  }
  if (change.kind != SceneChange::Kind::kSet) return std::nullopt;
  const auto material_edit = [&](Index region, const MaterialSettings& was,
                                 const MaterialSettings& is) -> std::optional<Edit> {
    const auto array = [](const MaterialSettings& m) {
      const auto found = m.arrays.find(kDensity.name);
      return found == m.arrays.end() ? std::string() : found->second;
    };
    if (was.density != is.density || array(was) != array(is)) return std::nullopt;
    return SetMaterial{region, is};
  };
  if (section == section_of<MaterialSettings>().name) {
    return material_edit(0, present_.material, after.material);
  }
  if (section == section_of<MaterialRegionSettings>().name) {
    if (!change.path.empty() && change.path.front() == "select") return std::nullopt;
    const std::size_t i = change.place.index;
    return material_edit(static_cast<Index>(i) + 1, present_.material_region.at(i).material,
                         after.material_region.at(i).material);
  }
  std::optional<Edit> edit;
  const auto try_section = [&]<class Section>(Section ChangeableSections::*member) {
    if (section != section_of<Section>().name) return;
    SetSection<Section> set{after.*member};
    if constexpr (std::is_same_v<Section, TimeSettings>) {
      if (change.path == std::vector<std::string>{"end"}) return;
      set.settings.end = settings_.time.end;  // runs in the window have none
    }
    edit = set;
  };
  std::apply([&](auto... member) { (try_section(member), ...); }, ChangeableSections::members());
  return edit;
}

SceneChange SceneEditor::in_edited_scene(const SceneChange& change,
                                         const EditedScene& edited) const {
  SceneChange result = change;
  const std::optional<std::size_t> list = edited_list(change.place.section);
  if (!list || change.kind == SceneChange::Kind::kAdd) return result;
  const std::size_t number = number_of_entry(settings_, *list, change.place.index);
  const std::vector<std::size_t>& numbers = edited.numbers[*list];
  const auto found = std::find(numbers.begin(), numbers.end(), number);
  if (found == numbers.end()) {
    throw InputError("An event of the scene has added this entry: change the event.");
  }
  const auto place = static_cast<std::size_t>(found - numbers.begin());
  // Those that are removed are no longer in the scene.
  const std::vector<std::size_t>& removed = edited.removed[*list];
  result.place.index = place - static_cast<std::size_t>(
                                   std::count_if(removed.begin(), removed.end(),
                                                 [&](std::size_t other) { return other < place; }));
  return result;
}

SceneEditor::Prepared SceneEditor::prepare(const SceneChange& change) const {
  if (scene_.is_null()) throw InputError("A scene file cannot hold this scene.");
  const SceneChange whole = with_model(change);
  if (std::optional<Edit> edit = edit_of(whole)) return {std::move(edit), {}, {}};
  const EditedScene edited = simulation_.edited_scene();
  ChangedScene changed =
      changed_scene(edited_json(edited), edited.scene, in_edited_scene(whole, edited));
  if (!changed.json["time"].contains("end")) changed.scene.time.end = edited.scene.time.end;
  if (adds_selection(change)) {
    for (const NamedSelection& named : changed.scene.selection) {
      const auto& before = edited.scene.selection;
      const bool is_new =
          std::ranges::find(before, named.name, &NamedSelection::name) == before.end();
      if (is_new) return {{}, named, {}};
    }
  }
  return {{}, {}, std::move(changed.scene)};
}

std::string SceneEditor::change(const SceneChange& change, bool continues_previous) {
  if (scene_.is_null()) return "A scene file cannot hold this scene.";
  return change_as(change, description_of(change, scene_), continues_previous);
}

std::string SceneEditor::change_as(const SceneChange& change, const std::string& what,
                                   bool continues_previous) {
  if (simulation_.is_setting_up()) return "The run is being set up again. Please wait.";
  try {
    Prepared prepared = prepare(change);
    if (prepared.edit) {
      simulation_.edit(std::move(*prepared.edit), what, continues_previous);
    } else if (prepared.named) {
      simulation_.add_selection(std::move(*prepared.named), what);
    } else {
      simulation_.set_up(std::move(prepared.scene), what);
    }
    return {};
  } catch (const Error& error) {
    return error.what();
  }
}

std::optional<bool> SceneEditor::sets_up_again(const SceneChange& change) const {
  try {
    return !adds_selection(change) && !edit_of(with_model(change));
  } catch (const Error&) {
    return std::nullopt;
  }
}

std::string SceneEditor::duplicate(const EntryPlace& place) {
  SceneChange add = addition_to(place.section);
  Json tables = scene_;
  add.value = table_of(tables, place);
  return change(std::move(add));
}

std::string SceneEditor::events_that_change(const EntryPlace& place) const {
  EntryPlace at_start = place;
  if (const std::optional<std::size_t> list = edited_list(place.section)) {
    at_start.index = number_of_entry(settings_, *list, place.index);
  }
  return tetraction::events_that_change(scene_, at_start);
}

std::string SceneEditor::remove(const EntryPlace& place) {
  Json tables = scene_;
  const Json table = table_of(tables, place);
  std::string refusal = change({SceneChange::Kind::kRemove, place});
  // It may have been off before. Now it is not there at all.
  if (refusal.empty()) {
    std::erase_if(off_, [&](const OffEntry& entry) {
      return entry.section == place.section && entry.table == table;
    });
  }
  return refusal;
}

std::string SceneEditor::switch_off(const EntryPlace& place) {
  Json tables = scene_;
  OffEntry entry{place.section, {}, table_of(tables, place)};
  entry.label =
      place.section == kSelections ? name_of_entry(scene_, place) : text_of_entry(entry.table);
  const SceneChange removal{SceneChange::Kind::kRemove, place};
  std::string what = description_of(removal, scene_);
  const std::string deleted = "deleted";
  what.replace(what.size() - deleted.size(), deleted.size(), "switched off");
  std::string refusal = change_as(removal, what);
  if (refusal.empty()) off_.push_back(std::move(entry));
  return refusal;
}

std::string SceneEditor::switch_on(std::size_t off) {
  SceneChange add = addition_to(off_.at(off).section);
  add.value = off_[off].table;
  if (add.place.section == kSelections) add.path = {off_[off].label};
  return change(std::move(add));
}

void SceneEditor::forget(std::size_t off) {
  off_.erase(off_.begin() + static_cast<std::ptrdiff_t>(off));
}

std::vector<OffEntry> SceneEditor::off_now() const {
  std::vector<OffEntry> now;
  for (const OffEntry& entry : off_) {
    if (is_off(entry)) now.push_back(entry);
  }
  return now;
}

bool SceneEditor::is_off(const OffEntry& entry) const {
  Json tables = scene_;
  for (std::size_t i = 0; i < entry_count(scene_, entry.section); ++i) {
    if (table_of(tables, {entry.section, i}) == entry.table) return false;
  }
  return true;
}

}  // namespace tetraction::viewer
