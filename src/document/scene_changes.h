// Changes of a scene as a file has it.
#pragma once

#include <string>
#include <vector>

#include "scene_tables.h"

namespace tetraction {

/// Sets a value, adds, removes or renames an entry.
struct SceneChange {
  enum class Kind { kSet, kAdd, kRemove, kRename } kind = Kind::kSet;
  EntryPlace place;
  /// Of kSet: the keys, and numbers in lists of tables, that lead to the value. Empty: the whole table,
  /// or what it has of the section beside it. Of kAdd: the name of a selection.
  std::vector<std::string> path{};
  /// Of kSet: the value; null takes it out, and an empty table gets what it must have. Of kAdd: the
  /// table, or null for a usual one. Of kRename: the name.
  Json value{};
  /// What new selections are, unless they are given.
  Json select = Json{{"all", true}};
};

/// The change that adds an entry to a list.
SceneChange addition_to(const std::string& section);

struct ChangedScene {
  Json json;
  Scene scene;
};

/// The scene after a change. What the change needs besides is done, too: a value that it replaces is taken out, values
/// that must be given are added, and events and references follow numbers and names. `base`: see scene_of_json(). Throws
/// InputError with the reason if no scene can be made of the change.
ChangedScene changed_scene(const Json& json, const Scene& base, const SceneChange& change);

/// Renumbers the entries from a number on in the events of a scene. Throws InputError if `by` is −1 and an event changes
/// the entry `from`.
void renumber_events(Json& scene, const std::string& section, std::size_t from, int by);
/// The same for an entry that does not exist any more, without an exception: what events change of it is taken out. An
/// event that changes nothing else becomes null, and changed_scene() leaves it out.
void drop_from_events(Json& scene, const EntryPlace& place);
/// "the event at 0.5 s, the event at 1 s". Empty if no event changes the entry.
std::string events_that_change(const Json& scene, const EntryPlace& place);

/// The name of an entry: the key of a named selection, or the value of its key `name`. Empty if it has none.
std::string name_of_entry(const Json& scene, const EntryPlace& place);
/// Whether such entries have names.
bool has_names(const std::string& section);

}  // namespace tetraction
