// [[event]]
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <tuple>
#include <type_traits>
#include <utility>

#include "scene_sections.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

// The parts of a scene that a changed key belongs to.
struct ChangedSection {
  std::string name;
  std::optional<std::size_t> index;
  bool operator<(const ChangedSection& other) const {
    return std::tie(name, index) < std::tie(other.name, other.index);
  }
};

// The parts of a scene that an event can change.
NameList changeable_parts() {
  NameList names;
  for (const ScenePart& part : scene_parts()) {
    if (part.may_change) names.emplace_back(part.section->name);
  }
  return names;
}

// Null if there is none of that name.
const ScenePart* find_part(std::string_view name) {
  for (const ScenePart& part : scene_parts()) {
    if (name == part.section->name) return &part;
  }
  return nullptr;
}

// `refuse` throws an error about the key.
ChangedSection changed_section(std::string_view key,
                               const std::function<void(const std::string&)>& refuse) {
  ChangedSection section;
  if (key.find(' ') != std::string_view::npos) {
    refuse("contains a space: a key is made of names with dots between them, like time.step.");
  }
  const auto dot = key.find('.');
  section.name = key.substr(0, dot);
  const ScenePart* part = find_part(section.name);
  if (section.name == "selection" || (part != nullptr && !part->may_change)) {
    refuse(section.name == "initial" ? "cannot change during a run; for momenta use the event's "
                                       "momentum = { select = { ... }, value = [...] }."
                                     : "cannot change during a run.");
  }
  if (part == nullptr) {
    refuse(
        fmt::format("is not a key that can change: {}", advice(section.name, changeable_parts())));
  }
  if (key.ends_with(".density") || key.find(".density.") != std::string_view::npos) {
    refuse(
        "cannot change during a run: mass would appear from nowhere, and momentum and energy with "
        "it. Set the density before the start.");
  }
  if (section.name == "material_region" && key.find(".select") != std::string_view::npos) {
    refuse(
        "cannot change during a run: the masses of the vertices would change. Give the parts that "
        "are to change regions of their own.");
  }
  if (part->is_list) {
    const auto end = key.find('.', dot == std::string_view::npos ? key.size() : dot + 1);
    std::size_t index = 0;
    const char* first = key.data() + (dot == std::string_view::npos ? key.size() : dot + 1);
    const char* last = key.data() + (end == std::string_view::npos ? key.size() : end);
    const auto [stop, error] = std::from_chars(first, last, index);
    if (error != std::errc() || stop != last) {
      refuse(
          fmt::format("must have the number of the entry after \"{0}\", counted from 0: keys of "
                      "the first [[{0}]] begin with \"{0}.0.\".",
                      section.name));
    }
    section.index = index;
  }
  return section;
}

// The edit that replaces a section as a whole, if there is one.
std::optional<Edit> replacement(const std::string& name, const Scene& next) {
  std::optional<Edit> edit;
  const auto enter = [&]<class Section>(const Section& settings) {
    if (name == section_of<Section>().name) edit = SetSection<Section>{settings};
  };
  std::apply([&](auto... member) { (enter(next.*member), ...); }, ChangeableSections::members());
  return edit;
}

// The edit that changes a section from its state in `scene` to its state in `next`.
Edit edit_of(const ChangedSection& section, const Scene& scene, const Scene& next) {
  const std::size_t i = section.index.value_or(0);
  if (const auto edit = replacement(section.name, next)) return *edit;
  if (section.name == "material") return SetMaterial{0, next.material};
  if (section.name == "material_region") {
    return SetMaterial{static_cast<Index>(i) + 1, next.material_region[i].material};
  }
  const auto existing = [i](const auto& list) {
    return i < list.size() ? std::optional<std::size_t>(i) : std::nullopt;
  };
  if (const std::optional<LoadKind> kind = find_named<LoadKind>(section.name)) {
    return SetForce{existing(scene.list(*kind)), next.list(*kind)[i]};
  }
  if (section.name == "fix") return SetFix{existing(scene.fix), next.fix[i]};
  if (section.name == "obstacle") return SetObstacle{existing(scene.obstacle), next.obstacle[i]};
  return SetConstraint{existing(scene.constraint), next.constraint[i]};
}

// The number of an entry of a list that has `count` entries at that time.
std::size_t read_number(const TomlTable& table, std::string_view key, std::size_t count,
                        const char* list) {
  int number = 0;
  table.read(key, number, {.least = 0.0});
  if (static_cast<std::size_t>(number) >= count) {
    const std::string known = count == 0 ? fmt::format("there is no {}", list)
                              : count == 1
                                  ? fmt::format("the only {} has the number 0", list)
                                  : fmt::format("the numbers of {} are 0 to {}", list, count - 1);
    table.refuse(key, fmt::format("= {}, but at that time {}.", number, known));
  }
  return static_cast<std::size_t>(number);
}

std::vector<TomlTable> entries_of(const TomlTable& event, const SceneSection& section) {
  return event.one_or_more_tables(event_key(section), table_keys(section));
}

// Reads the edits of an event that change the state, in the order of their kinds.
template <class... Kinds>
void read_state_changes(const TomlTable& event, std::vector<Edit>& edits,
                        std::type_identity<std::variant<Kinds...>>) {
  const auto read = [&]<class Kind>(std::type_identity<Kind>) {
    if constexpr (kChangesState<Kind>) {
      for (const TomlTable& entry : entries_of(event, section_of<decltype(Kind::change)>())) {
        Kind edit;
        read_settings(entry, edit.change);
        edits.emplace_back(std::move(edit));
      }
    }
  };
  (read(std::type_identity<Kinds>()), ...);
}

Unfix read_unfix(const TomlTable& event, std::size_t fix_count) {
  NameList keys = table_keys(section_of<Selection>()).valid;
  keys.emplace_back("select");
  keys.emplace_back("fix");
  const TomlTable table = event.table("unfix", {keys});
  Unfix unfix;
  unfix.where = table.where();
  if (table.has("fix")) unfix.fix = read_number(table, "fix", fix_count, "[[fix]]");
  if (!table.has("select")) {
    unfix.select = read_selection(event, "unfix", table);
    return unfix;
  }
  if (table.node().size() > (unfix.fix ? 2U : 1U)) {
    table.refuse(
        "select",
        "is one key too many: vertices are selected in two ways. Leave one of the two out.");
  }
  unfix.select = read_selection(table, "select");
  return unfix;
}

// Applies the changes, clears their list, and reads the scene with all changes so far. An error may
// be in a part of the scene that the event did not change. Therefore messages always name the
// event.
Scene read_changed(TomlDocument& document, std::vector<TomlDocument::Change>& changes,
                   const SectionReader& read_sections, const std::string& event,
                   const std::set<std::string>& own_places) {
  try {
    for (const TomlDocument::Change& change : changes) document.apply(change);
    changes.clear();
    return read_sections(document);
  } catch (const InputError& error) {
    std::string message = error.what();
    // The message names the place from where a value comes. An earlier event whose values were good
    // until now is not to blame.
    const auto event_text = message.find("event at ");
    if (event_text != std::string::npos) {
      const auto end = message.find(": ", event_text);
      if (end == std::string::npos || own_places.count(message.substr(0, end)) > 0) throw;
      message.erase(0, end + 2);
    }
    throw InputError(event + ": " + message);
  }
}

}  // namespace

void read_events(const TomlDocument& document, const TomlTable& root,
                 const SectionReader& read_sections, const ObstacleReader& complete_obstacle,
                 Scene& scene) {
  struct Timed {
    EventSettings event;
    TomlTable table;
  };
  std::vector<Timed> timed;
  for (const TomlTable& table : root.tables("event", table_keys(section_of<EventSettings>()))) {
    EventSettings event;
    read_settings(table, event);
    timed.push_back({std::move(event), table});
  }
  std::stable_sort(timed.begin(), timed.end(),
                   [](const Timed& a, const Timed& b) { return a.event.at < b.event.at; });

  // Every event's `set` is read as a part of the whole scene at that time, so that errors are found
  // before the run begins. All changes go into one document, because a recorded session has
  // thousands of them.
  TomlDocument changed = document.copy();
  std::vector<TomlDocument::Change> changes;
  Scene now = scene;
  for (Timed& timed_event : timed) {
    const TomlTable& table = timed_event.table;
    EventSettings& event = timed_event.event;
    const double at = event.at;
    event.where = table.where();
    event.echo = to_json(table.node()).dump(-1, ' ', false, Json::error_handler_t::replace);
    std::set<ChangedSection> sections;
    std::set<std::string> own_places;
    std::string changed_at;
    if (table.has("unset")) {
      std::vector<std::string> keys;
      table.read("unset", keys);
      changed_at = fmt::format("{}: event at {} s", table.place("unset"), at);
      for (const std::string& key : keys) {
        sections.insert(changed_section(key, [&](const std::string& message) {
          table.refuse("unset", fmt::format("names {}, which {}", key, message));
        }));
        changes.push_back({key, {}, changed_at, true});
        event.changed_keys.push_back(key);
      }
    }
    if (table.has("set")) {
      const toml::table* values = table.node().get_as<toml::table>("set");
      if (values == nullptr) {
        table.refuse("set", "must be a table like { \"time.step\" = 1e-3 }.");
      }
      NameList keys;
      for (const auto& [key, value] : *values) keys.push_back(key.str());
      const TomlTable set = table.table("set", {keys});
      for (const auto& [key, value] : *values) {
        const std::string_view name = key.str();
        // Without quotes a key with dots is a table of the section.
        if (value.is_table() && name.find('.') == std::string_view::npos) {
          set.refuse(name, "is a table: put the whole key into quotes, like \"time.step\" = 1e-3.");
        }
        const ChangedSection section =
            changed_section(name, [&](const std::string& message) { set.refuse(name, message); });
        if (value.is_table() && section.index && std::ranges::count(name, '.') == 1) {
          set.refuse(
              name,
              fmt::format("is a table: give the single keys of the entry, like \"{}.KEY\" = VALUE.",
                          name));
        }
        if (section.name == "material_region" && *section.index >= now.material_region.size()) {
          set.refuse(key.str(),
                     fmt::format("names a [[material_region]] that does not exist: the scene has "
                                 "{} of them, counted from 0, and none can be added during a run.",
                                 now.material_region.size()));
        }
        sections.insert(section);
        event.changed_keys.emplace_back(name);
        changes.push_back({std::string(key.str()), toml_value(to_json(value)),
                           fmt::format("{}: event at {} s", set.place(key.str()), at)});
        own_places.insert(changes.back().source);
      }
      if (keys.empty()) keys.emplace_back();
      changed_at = fmt::format("{}: event at {} s", set.place(keys.front()), at);
    }
    if (!changed_at.empty()) {
      own_places.insert(changed_at);
      const Scene next = read_changed(changed, changes, read_sections, changed_at, own_places);
      for (const ChangedSection& section : sections)
        event.edits.push_back(edit_of(section, now, next));
      now = next;
    }
    if (table.has("unfix")) event.edits.emplace_back(read_unfix(table, now.fix.size()));
    if (table.has("remove_constraint")) {
      event.edits.emplace_back(RemoveConstraint{
          read_number(table, "remove_constraint", now.constraint.size(), "[[constraint]]")});
    }
    if (table.has("remove_obstacle")) {
      event.edits.emplace_back(RemoveObstacle{
          read_number(table, "remove_obstacle", now.obstacle.size(), "[[obstacle]]")});
    }
    // An added entry gets the next number of its list. Later events can change it by this number.
    const auto add_entries = [&](const SceneSection& section, auto& list, const auto& fresh) {
      for (const TomlTable& entry : entries_of(table, section)) {
        changes.push_back({fmt::format("{}.{}", section.name, list.size()),
                           toml_value(to_json(entry.node())),
                           fmt::format("{}: event at {} s", entry.place(), at)});
        list.push_back(fresh);
        read_settings(entry, section, &list.back());
        using Entry = std::remove_cvref_t<decltype(fresh)>;
        if constexpr (std::is_same_v<Entry, ObstacleSettings>) complete_obstacle(list.back());
        event.edits.emplace_back(SetEntry<Entry>{std::nullopt, list.back()});
      }
    };
    add_entries(section_of<FixSettings>(), now.fix, FixSettings());
    add_entries(section_of<ConstraintSettings>(), now.constraint, ConstraintSettings());
    add_entries(section_of<ObstacleSettings>(), now.obstacle, ObstacleSettings());
    for (const LoadKind kind : values_of<LoadKind>()) {
      ForceSettings load;
      load.kind = kind;
      add_entries(section_of(kind), now.list(kind), load);
    }
    read_state_changes(table, event.edits, std::type_identity<Edit>());
    if (event.edits.empty()) {
      table.refuse_table(
          "changes nothing: give set, unset, fix, unfix, constraint, remove_constraint, obstacle, "
          "remove_obstacle, a load such as force, momentum or shift.");
    }
    scene.event.push_back(std::move(event));
  }
}

}  // namespace tetraction
