// The tables of a scene as JSON (scene_json.h) beside the descriptions of their keys.
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "simulation/scene/setting_keys.h"

namespace tetraction {

/// An entry of a scene: its section, and its number in a list. Named selections and events are lists, too.
struct EntryPlace {
  std::string section;
  std::size_t index = 0;
  bool operator==(const EntryPlace&) const = default;
};

/// The name of the list of named selections.
inline constexpr const char* kSelections = "selection";

/// The description of the entries of a section, or of named selections.
const SceneSection& section_of_entries(const std::string& name);
/// Whether a scene has a list of such entries.
bool is_list(const std::string& section);
std::size_t entry_count(const Json& scene, const std::string& section);
/// The table of an entry, which must exist. That of the only entry of a section is made if it is absent.
Json& table_of(Json& scene, const EntryPlace& place);

/// A key with the settings that have it.
struct OwnedKey {
  const SceneSection* section;
  const SceneKey* key;
  void* settings;
};
/// All keys of a table, with those of SceneSection::beside, in the order of a file.
std::vector<OwnedKey> owned_keys(const SceneSection& section, void* settings);

/// Calls a function with settings of a section as a table gives them. Values that are not possible are left out. With a
/// path of keys and numbers, these are the inner table under it and its section. A number one above
/// those of a list adds a table. The function is not called if there is no such inner table.
using TableVisit = std::function<void(const SceneSection& section, void* settings, Json& table)>;
void visit_table(const SceneSection& section, Json& table, std::span<const std::string> path,
                 const TableVisit& visit);

/// Whether a value of a key is possible, as far as the key alone can say.
bool is_possible(const OwnedKey& key, const Json& value);

/// Takes keys out of the table under a path that have no meaning or a value that is not possible, and adds values for
/// those that must be given. The key `kept` stays as it is. `select` is what new selections are.
void complete_table(const SceneSection& section, Json& table, std::span<const std::string> path,
                    const std::string& kept, const Json& select);
/// A value for a key with the settings that it has. Null if none can be guessed.
Json usual_value(const OwnedKey& key, const Json& select);

/// A selection of a kind, such as "plane".
Json selection_of_kind(const std::string& kind, const Json& select);

}  // namespace tetraction
