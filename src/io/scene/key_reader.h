// Reads the tables of a scene as the descriptions of their keys say.
#pragma once

#include "io/toml/toml_table.h"

namespace tetraction {

/// The names that the table of a section may have.
TableKeys table_keys(const SceneSection& section);

/// Reads all keys into the settings of the section, and checks the rules between them. Absent keys
/// leave the settings unchanged. Throws InputError.
void read_settings(const TomlTable& table, const SceneSection& section, void* settings);
template <class Settings>
void read_settings(const TomlTable& table, Settings& settings) {
  read_settings(table, section_of<Settings>(), &settings);
}

/// Reads the value under a key that is present, unless it is one that other code reads.
void read_value(const TomlTable& table, const SceneKey& key, void* settings);

/// The selection in the table under a key that contains the kind of selection directly.
Selection read_selection(const TomlTable& parent, std::string_view key, const TomlTable& table);
/// The selection under a key: exactly one kind of selection, or the name of another.
Selection read_selection(const TomlTable& parent, std::string_view key = "select");
/// [selection.NAME], in the order of the names.
std::vector<NamedSelection> read_named_selections(const TomlTable& root);

}  // namespace tetraction
