#include "scene_changes.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string_view>
#include <utility>

#include "scene_json.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

// The number in "force.2.vector" of an entry of the section [[force]], and what follows it.
std::optional<std::pair<std::size_t, std::string>> number_in(const std::string& key,
                                                             const std::string& section) {
  if (!key.starts_with(section + ".")) return std::nullopt;
  std::size_t end = 0;
  const std::string rest = key.substr(section.size() + 1);
  while (end < rest.size() && rest[end] >= '0' && rest[end] <= '9') ++end;
  if (end == 0) return std::nullopt;
  return std::pair(static_cast<std::size_t>(std::stoul(rest.substr(0, end))), rest.substr(end));
}

// Changes the numbers from one on in an event. If that entry is taken away (`by` is −1), what the event changes of it is
// taken out.
struct Renumbering {
  const std::string& section;
  std::size_t from;
  int by;

  std::optional<std::size_t> operator()(std::size_t number) const {
    if (number == from && by < 0) return std::nullopt;
    return number < from ? number : number + static_cast<std::size_t>(by);
  }
  std::optional<std::string> key(const std::string& key) const {
    const auto found = number_in(key, section);
    if (!found) return key;
    const std::optional<std::size_t> number = (*this)(found->first);
    if (!number) return std::nullopt;
    return fmt::format("{}.{}{}", section, *number, found->second);
  }
  // Returns whether something was taken out.
  bool event(Json& event) const {
    if (event.is_null()) return false;
    Json result = Json::object();
    bool all = true;
    for (const auto& [name, value] : event.items()) {
      if (name == "set" || name == "unset") {
        Json kept = name == "set" ? Json::object() : Json::array();
        for (const auto& [own, part] : value.items()) {
          const auto renamed = key(name == "set" ? own : part.get<std::string>());
          all = all && renamed;
          if (!renamed) continue;
          if (name == "set") {
            kept[*renamed] = part;
          } else {
            kept.push_back(*renamed);
          }
        }
        if (!kept.empty()) result[name] = kept;
        continue;
      }
      const bool in_table = name == "un" + section && value.is_object() && value.contains(section);
      if (!in_table && name != "remove_" + section) {
        result[name] = value;
        continue;
      }
      const auto number = (*this)((in_table ? value[section] : value).get<std::size_t>());
      all = all && number;
      if (!number) continue;
      result[name] = value;
      (in_table ? result[name][section] : result[name]) = *number;
    }
    event = std::move(result);
    return !all;
  }
};

bool changes_nothing(const Json& event) {
  for (const auto& [name, value] : event.items()) {
    if (name != "at" && name != "note") return false;
  }
  return true;
}

// Replaces a name where tables refer to it. The names of selections stand where a key needs a selection.
void rename_references(Json& node, const std::string& key, const std::string& section,
                       const std::string& from, const std::string& to) {
  if (node.is_string()) {
    const std::string own = key.substr(key.rfind('.') + 1);
    const bool refers = section == kSelections
                            ? own == "select" || own == "not" || own == "any_of" || own == "all_of"
                            : own == section;
    if (refers && node == from) node = to;
  } else if (node.is_array()) {
    for (Json& entry : node) rename_references(entry, key, section, from, to);
  } else if (node.is_object()) {
    for (auto& [name, value] : node.items()) rename_references(value, name, section, from, to);
  }
}

std::string unused_name(const Json& scene, const std::string& section, const std::string& like) {
  const auto is_used = [&](const std::string& name) {
    for (std::size_t i = 0; i < entry_count(scene, section); ++i) {
      if (name_of_entry(scene, {section, i}) == name) return true;
    }
    return false;
  };
  if (like != section && !is_used(like)) return like;
  std::string stem = like;  // "ramp" of "ramp_2"
  while (!stem.empty() && stem.back() >= '0' && stem.back() <= '9') stem.pop_back();
  if (stem.size() < like.size() && !stem.empty() && stem.back() == '_') stem.pop_back();
  if (stem.empty()) stem = section;
  for (int number = 1;; ++number) {
    std::string name = fmt::format("{}_{}", stem, number);
    if (!is_used(name)) return name;
  }
}

class Changer {
 public:
  Changer(Json json, const Scene& base, const SceneChange& change)
      : json_(std::move(json)), base_(base), change_(change), place_(change.place) {}

  ChangedScene result() {
    switch (change_.kind) {
      case SceneChange::Kind::kSet:
        set();
        break;
      case SceneChange::Kind::kAdd:
        add();
        break;
      case SceneChange::Kind::kRemove:
        remove();
        break;
      case SceneChange::Kind::kRename:
        rename();
        break;
    }
    return read();
  }

 private:
  const SceneSection& section() const { return section_of_entries(place_.section); }
  std::span<const std::string> table_path() const {
    return std::span(change_.path).first(change_.path.size() - 1);
  }

  void set() {
    if (table_of(json_, place_).is_null()) {
      throw InputError(
          "This event changes only what was deleted. Delete it, or undo the deletion.");
    }
    if (change_.path.empty()) return set_table();
    visit_table(section(), table_of(json_, place_), outer_path(),
                [&](const SceneSection& own, void*, Json& table) { set_in(own, table); });
    complete();
  }

  // Replaces all values, or those of the section beside it.
  void set_table() {
    Json& table = table_of(json_, place_);
    if (section().beside) {
      for (const SceneKey& key : section().beside().keys) table.erase(key.info.name);
      table.update(change_.value);
    } else {
      table = change_.value;
    }
  }

  // The path to the table that has the value, or the list of tables that it is in.
  std::span<const std::string> outer_path() const {
    std::span<const std::string> path = table_path();
    if (is_number(change_.path.back())) path = path.first(path.size() - 1);
    return path;
  }
  static bool is_number(const std::string& text) {
    return !text.empty() && text.find_first_not_of("0123456789") == std::string::npos;
  }

  void set_in(const SceneSection& own, Json& table) {
    const std::string& last = change_.path.back();
    if (is_number(last)) {
      Json& list = table[change_.path[change_.path.size() - 2]];
      const std::size_t number = std::stoul(last);
      if (change_.value.is_null()) {
        list.erase(number);
        if (list.empty()) table.erase(change_.path[change_.path.size() - 2]);
      } else if (number < list.size()) {
        list[number] = change_.value;
      } else {
        list.push_back(change_.value);
      }
      return;
    }
    // A selection is of one kind.
    if (&own == find_section("select")) table = Json::object();
    if (change_.value.is_null()) {
      table.erase(last);
    } else {
      table[last] = change_.value;
    }
  }

  // Adds what the table of the value and the value itself need.
  void complete() {
    Json& table = table_of(json_, place_);
    complete_table(section(), table, outer_path(), change_.path.back(), change_.select);
    if (change_.value.is_object())
      complete_table(section(), table, change_.path, {}, change_.select);
  }

  void add() {
    if (change_.place.section == kSelections) {
      const Json value = change_.value.is_null() ? change_.select : change_.value;
      const std::string like = change_.path.empty() ? kSelections : change_.path.front();
      json_[kSelections][unused_name(json_, kSelections, like)] = value;
      return;
    }
    const std::string& name = place_.section;
    place_.index = entry_count(json_, name);
    Json table = change_.value;
    if (table.is_null()) table = usual_entry();
    if (has_names(name)) {
      table["name"] = unused_name(json_, name, table.value("name", name));
    }
    renumber_events(json_, name, place_.index, 1);
    json_[name].push_back(table);
    complete_table(section(), json_[name].back(), {}, {}, change_.select);
  }

  Json usual_entry() const {
    Json table = Json::object();
    // A region begins as the material of the body, for instance.
    if (section().beside) table = json_.value(section().beside().name, Json::object());
    if (section().type == typeid(EventSettings)) {
      const auto time = json_.find("time");
      const double end = time == json_.end() ? 0.0 : time->value("end", 0.0);
      table["at"] = 0.5 * end;
      table["set"] = {{"damping.drag", json_.value("damping", Json::object()).value("drag", 0.0)}};
    }
    return table;
  }

  void remove() {
    Json& entries = json_.at(place_.section);
    if (place_.section == kSelections) {
      entries.erase(std::next(entries.begin(), static_cast<std::ptrdiff_t>(place_.index)));
    } else {
      entries.erase(place_.index);
      renumber_events(json_, place_.section, place_.index, -1);
    }
    if (entries.empty()) json_.erase(place_.section);
  }

  void rename() {
    const std::string from = name_of_entry(json_, place_);
    const auto to = change_.value.get<std::string>();
    if (to.empty()) throw InputError("A name must not be empty.");
    for (std::size_t i = 0; i < entry_count(json_, place_.section); ++i) {
      if (i != place_.index && name_of_entry(json_, {place_.section, i}) == to) {
        throw InputError(fmt::format("The name \"{}\" is taken already.", to));
      }
    }
    if (place_.section == kSelections) {
      Json renamed = Json::object();
      for (const auto& [name, value] : json_[kSelections].items()) {
        renamed[name == from ? to : name] = value;
      }
      json_[kSelections] = renamed;
    } else {
      table_of(json_, place_)["name"] = to;
    }
    rename_references(json_, "", place_.section, from, to);
  }

  ChangedScene read() {
    if (json_.contains("event")) {  // without those of drop_from_events()
      Json& events = json_["event"];
      events.erase(std::remove(events.begin(), events.end(), Json()), events.end());
      if (events.empty()) json_.erase("event");
    }
    try {
      return {json_, scene_of_json(json_, base_)};
    } catch (const InputError& error) {
      const bool may_add = change_.kind == SceneChange::Kind::kAdd && change_.value.is_null();
      if (std::optional<ChangedScene> other = may_add ? with_one_more() : with_one_less(error)) {
        return std::move(*other);
      }
      throw;
    }
  }

  std::optional<ChangedScene> attempt(const Json& json) const {
    try {
      return ChangedScene{json, scene_of_json(json, base_)};
    } catch (const Error&) {
      return std::nullopt;
    }
  }

  // An entry of which one key must be given and any will do, as for an amplitude.
  std::optional<ChangedScene> with_one_more() const {
    std::optional<ChangedScene> found;
    Json json = json_;
    if (place_.section == kSelections) return found;
    Json& table = table_of(json, place_);
    const Json without = table;
    visit_table(section(), table, {}, [&](const SceneSection& own, void* settings, Json&) {
      for (const OwnedKey& key : owned_keys(own, settings)) {
        if (found || without.contains(key.key->info.name)) continue;
        const Json value = usual_value(key, change_.select);
        if (value.is_null()) continue;
        table = without;
        table[key.key->info.name] = value;
        found = attempt(json);
      }
    });
    return found;
  }

  // The value stands in place of another one of the same table, as a total force does.
  std::optional<ChangedScene> with_one_less(const InputError& error) const {
    if (change_.kind != SceneChange::Kind::kSet || change_.value.is_null()) return std::nullopt;
    const std::string message = error.what();
    const auto says = [&](const char* words) { return message.find(words) != std::string::npos; };
    if (!says("one key too many") && !says("Leave one") && !says("both") &&
        !says("does not belong"))
      return std::nullopt;
    std::optional<ChangedScene> found;
    Json json = json_;
    visit_table(section(), table_of(json, place_), outer_path(),
                [&](const SceneSection&, void*, Json& table) {
                  const Json all = table;
                  for (const auto& [name, value] : all.items()) {
                    if (found || name == change_.path.back()) continue;
                    table = all;
                    table.erase(name);
                    found = attempt(json);
                  }
                });
    return found;
  }

  Json json_;
  const Scene& base_;
  const SceneChange& change_;
  EntryPlace place_;
};

}  // namespace

SceneChange addition_to(const std::string& section) {
  SceneChange add;
  add.kind = SceneChange::Kind::kAdd;
  add.place.section = section;
  return add;
}

ChangedScene changed_scene(const Json& json, const Scene& base, const SceneChange& change) {
  return Changer(json, base, change).result();
}

void renumber_events(Json& scene, const std::string& section, std::size_t from, int by) {
  const auto events = scene.find("event");
  if (events == scene.end() || section == "event") return;
  const std::string changing = by < 0 ? events_that_change(scene, {section, from}) : std::string();
  if (!changing.empty()) {
    throw InputError(
        fmt::format("This entry ({} {}) is changed by {}: change or delete the event first.",
                    section, from, changing));
  }
  for (Json& event : *events) Renumbering{section, from, by}.event(event);
}

void drop_from_events(Json& scene, const EntryPlace& place) {
  const auto events = scene.find("event");
  if (events == scene.end()) return;
  for (Json& event : *events) {
    if (Renumbering{place.section, place.index, -1}.event(event) && changes_nothing(event)) {
      event = Json();
    }
  }
}

std::string events_that_change(const Json& scene, const EntryPlace& place) {
  std::string times;
  const auto events = scene.find("event");
  if (events == scene.end() || place.section == "event") return times;
  for (Json event : *events) {
    if (!Renumbering{place.section, place.index, -1}.event(event)) continue;
    times +=
        fmt::format("{}the event at {:.6g} s", times.empty() ? "" : ", ", event.value("at", 0.0));
  }
  return times;
}

bool has_names(const std::string& section) {
  return section == kSelections || section_of_entries(section).find("name") != nullptr;
}

std::string name_of_entry(const Json& scene, const EntryPlace& place) {
  if (!has_names(place.section) || place.index >= entry_count(scene, place.section)) return {};
  const Json& entries = scene.at(place.section);
  if (place.section == kSelections) {
    return std::next(entries.begin(), static_cast<std::ptrdiff_t>(place.index)).key();
  }
  return entries.at(place.index).value("name", "");
}

}  // namespace tetraction
