// The keys of a scene's sections, each described once: name, unit, range, meaning, and the value in
// the settings. The scene's reader, writer and echo, the checks of edits, the fields of the window,
// the Python classes and the tables of docs/scene.md are all made from these descriptions. Default
// values are those of the structs themselves.
#pragma once

#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <string_view>
#include <typeindex>
#include <vector>

#include "tetraction/core/number_range.h"
#include "tetraction/simulation/scene.h"

namespace tetraction {

/// A value of a file. The keys of an object are in their order. A date, which no key takes, is
/// binary.
using Json = nlohmann::ordered_json;

/// When the scene writer writes a key.
enum class Written { kAlways, kUnlessDefault };

/// The description of a key, which does not depend on the type of its value.
struct KeyInfo {
  const char* name = "";
  const char* title = "";    ///< its name in the window: "Mass damping"
  const char* unit = "";     ///< "m/s²"
  const char* per = "";      ///< completes the unit in a scene file: "on each vertex"
  const char* help = "";     ///< meaning, in Markdown, without range and default
  NumberRange range = {};    ///< allowed numbers, also for each entry of a list
  double usual = 0.0;        ///< end of the usual range from 0, for a slider of the window; 0: none
  const char* needed = "";   ///< if the key is required: what to give; otherwise empty
  const char* absent = "–";  ///< the default in words, if the struct holds no value
  Written in_file = Written::kAlways;
  Written in_echo = Written::kAlways;
};

class MechanicalSystem;
struct SceneSection;

/// The range of counts.
inline constexpr NumberRange kAtLeastOne{.least = 1.0};

/// Refuses the value of a key with an InputError, whose message begins with place and key.
struct Refusal {
  std::function<std::string()> where;
  [[noreturn]] void operator()(const std::string& message) const;
};

/// Whether the table that is being read has a key.
using HasKey = std::function<bool(const char* key)>;

/// Reads a table of a file into settings that the section describes.
using TableReader = std::function<void(const SceneSection& section, void* settings)>;

/// The value of a key within the settings of its section: how it is read, written and checked. Each
/// kind of value is one class (setting_values.h). The pointers are to settings of that section.
class SettingValue {
 public:
  /// How the value stands in a file: as a number, text or list; as a table of its own; as either;
  /// as a list of tables; as a selection; or as something that other code reads and writes.
  enum class Form { kPlain, kTable, kPlainOrTable, kTables, kSelection, kOther };

  virtual ~SettingValue() = default;
  virtual Form form() const { return Form::kPlain; }
  /// Its type for the documents, in Markdown.
  virtual std::string type() const = 0;
  /// The value. Null if there is none.
  virtual Json json(const void* settings) const = 0;
  /// Takes the value of a file, of kPlain.
  virtual void read(const Json& node, const NumberRange& range, const Refusal& refuse,
                    void* settings) const;
  /// Takes a table of a file, or an entry of kTables.
  virtual void read_table(const TableReader& read, void* settings) const;
  virtual Selection* selection(void* settings) const;
  /// Throws InputError, which begins with the name, for a value that read() would refuse.
  virtual void check(const void* settings, const NumberRange& range, const std::string& name) const;
  /// Copies the value from settings to others. False, and no copy, if it is not in members of its
  /// own or there is none.
  virtual bool copy(const void* from, void* to) const;
  /// The names that it may have. Empty if it is not one of several names.
  virtual std::vector<const char*> names() const { return {}; }
  /// A word that can stand in place of a number. Empty if there is none.
  virtual const char* word() const { return ""; }
  /// The address of the member that holds the value. Null if there is no such member.
  virtual const void* member(const void* settings) const;
};

/// One key of a section.
struct SceneKey {
  KeyInfo info;
  std::shared_ptr<const SettingValue> value;
  /// Whether the key has a meaning with the other settings. Null: always.
  std::function<bool(const void*)> used;
  /// The unit, if it depends on the other settings.
  std::function<const char*(const void*)> unit;
  /// If the key is required with some settings only: what to give, or an empty text.
  std::function<std::string(const void*, const HasKey& has)> needed;
  /// Whether the key is written at all. Null: always.
  std::function<bool(const void*)> written;

  bool is_used(const void* settings) const { return !used || used(settings); }
  bool is_written(const void* settings) const { return !written || written(settings); }
};

/// The conflict of two keys of which only one may be given. `why` follows "both given": ", and …" or ". A …".
std::string one_key_too_many(std::string_view first, std::string_view second,
                             std::string_view why = "");

/// A condition that the keys of a section must satisfy together.
struct SectionRule {
  /// The keys of the condition. An empty list means the section as a whole. A message names the key
  /// that an override has set, otherwise the last one that is present.
  std::vector<const char*> keys;
  /// The text of the message after the key's name, such as "must not be zero.". Empty if the
  /// settings satisfy the condition.
  std::function<std::string(const void*)> conflict;
};

/// A section of the scene file, with its keys in the order of reading and writing.
struct SceneSection {
  const char* name;
  std::vector<SceneKey> keys;
  std::vector<SectionRule> rules;
  /// Whether keys without a meaning (is_used()) are refused. The first key is then a `kind`.
  bool refuses_unused = false;
  std::type_index type;                  ///< of the settings
  std::shared_ptr<const void> defaults;  ///< settings that are default
  /// The member for the place in the scene. Null if the settings have none.
  std::function<std::string*(void*)> where = nullptr;
  /// Whether that place is the one of the only key, and not of the table.
  bool is_placed_at_key = false;
  /// Why a scene file cannot have the settings, which a program has made; empty if it can.
  std::function<std::string(const void*)> unwritable = nullptr;
  /// Lets the settings act on a body in place of those that it had of this section. Null if they do
  /// not act on it, or other code lets them. A force term that it sets must be there from the start,
  /// even if it does nothing yet, because the energies of a run stay the same ones. Throws InputError.
  std::function<void(const void*, MechanicalSystem&, const std::vector<AmplitudeSettings>&)>
      put_into = nullptr;
  /// The section whose keys stand in the same table, before the own ones, and its settings within those
  /// of this section. Null if there is none.
  const SceneSection& (*beside)() = nullptr;
  void* (*settings_beside)(void*) = nullptr;
  /// The key to give in a scene that lacks the section. Null if a scene may lack it.
  const char* needed = nullptr;

  /// Null if there is no such key.
  const SceneKey* find(std::string_view key) const;
};

/// The key of [[event]] with tables of a section: "momentum" for those of [[initial.momentum]].
const char* event_key(const SceneSection& section);

/// All sections and inner tables that have a table in the documents, in its order.
std::span<const SceneSection> documented_sections();
/// The section of that name, such as "fix" or "select.plane". Null if there is none.
const SceneSection* find_section(std::string_view name);
/// The section of settings of a type; of ForceSettings that of LoadKind::kForce.
const SceneSection& section_of(std::type_index type);
template <class Settings>
const SceneSection& section_of() {
  return section_of(std::type_index(typeid(Settings)));
}
const SceneSection& section_of(LoadKind kind);

/// A section and its settings in a scene.
struct ScenePart {
  const SceneSection* section;
  bool is_list = false;
  /// The settings of all entries of a list, or the only ones.
  std::function<std::vector<const void*>(const Scene&)> entries;
  /// A new entry of a list, or the only settings.
  std::function<void*(Scene&)> add;
  /// Whether edits may change it.
  bool may_change = true;
};
/// The parts of a scene in the order of summary.json, without events and named selections.
const std::vector<ScenePart>& scene_parts();

/// The default of a key of the scene, such as {"force", "0", "vector"}. Null if there is no such key or its settings
/// hold no value.
Json default_of(std::span<const std::string> key);

/// Lets all of these sections act on a body.
void put_sections(const ChangeableSections& sections, MechanicalSystem& system,
                  const std::vector<AmplitudeSettings>& amplitudes);

/// The description of the key that a member holds: key_info(&Damping::drag).
template <class Settings, class Value>
const KeyInfo& key_info(Value Settings::*member) {
  const SceneSection& section = section_of<Settings>();
  const auto* defaults = static_cast<const Settings*>(section.defaults.get());
  for (const SceneKey& key : section.keys) {
    if (key.value->member(defaults) == &(defaults->*member)) return key.info;
  }
  static const KeyInfo none;
  return none;
}

/// All keys of a section that have a meaning with the other settings, as summary.json has them.
Json settings_json(const SceneSection& section, const void* settings);
/// The selection as a table, or as a text for a named one.
Json selection_json(const Selection& selection);

/// Checks values and rules as the scene reader does. Throws InputError with the key, its value and
/// the allowed values.
void check_settings(const SceneSection& section, const void* settings);
/// The same for a selection with all its parts.
void check_selection(const Selection& selection);
template <class Settings>
void check_settings(const Settings& settings) {
  check_settings(section_of<Settings>(), &settings);
}
/// The same by the section of its kind.
void check_settings(const ForceSettings& load);

}  // namespace tetraction
