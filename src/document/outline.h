// The tree of a scene and the fields of its entries, made from the tables of scene keys alone.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "scene_tables.h"
#include "tetraction/core/number_range.h"

namespace tetraction {

struct OutlineEntry {
  EntryPlace place;
  std::string label;
};

/// A section of the scene. One that is no list has one entry.
struct OutlineGroup {
  std::string section;
  std::string title;
  bool is_list = false;
  std::vector<OutlineEntry> entries;
};

/// What an entry of a list is called: by its name, its selection, its time or its kind. May be empty. `time_unit` is
/// the unit of the time in the table.
std::string text_of_entry(const Json& table, const std::string& time_unit = "s");

/// All sections that a scene can have, in the order of a file. `text` is what an entry of a section is called,
/// such as text_of_entry() of its table.
using EntryText = std::function<std::string(const std::string& section, const Json& table)>;
std::vector<OutlineGroup> outline(
    const Json& scene, const EntryText& text = [](const std::string&, const Json& table) {
      return text_of_entry(table);
    });
std::string title_of_section(const std::string& section);
/// The same of an entry, with its number in a list: "Body force 0".
std::string title_of_entry(const EntryPlace& place);

/// How a value is entered.
enum class FieldKind {
  kNumber,
  kWholeNumber,
  kVector,  ///< three numbers
  kChoice,  ///< one of Field::names
  kFlag,
  kText,
  kFile,
  kJson,      ///< anything else, as JSON text
  kTable,     ///< has fields
  kTables,    ///< has a field of kTable for each table
  kSelection  ///< has the fields of its kind
};

struct Field {
  FieldKind kind = FieldKind::kText;
  std::vector<std::string> path;  ///< of SceneChange
  std::string title;              ///< "Mass damping"
  std::string unit;               ///< with what completes it
  std::string help;
  NumberRange range{};
  double usual = 0.0;              ///< see KeyInfo::usual
  std::vector<std::string> names;  ///< of kChoice; an empty name stands for no value
  std::string word;                ///< that can stand in place of a number
  Json value;                      ///< null if the scene has none
  Json standard;                   ///< the default; null if there is none
  bool is_needed = false;
  bool takes_array = false;  ///< whether the name of a cell array can stand in place of a number
  bool takes_field = false;  ///< whether a table of kind `field` can stand in place of a vector
  std::vector<Field> fields;

  std::string name() const { return path.empty() ? std::string() : path.back(); }
  /// The value, or else the default.
  const Json& shown() const { return value.is_null() ? standard : value; }
};

/// The fields that have a meaning with the present values.
std::vector<Field> fields_of(const Json& scene, const EntryPlace& place);

/// "plane x = 0", "group clamp", "vertices 1, 2, … (40)".
std::string selection_text(const Json& select);

}  // namespace tetraction
