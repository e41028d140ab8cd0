// A TOML file with KEY=VALUE overrides, which stores the origin of each value.
#pragma once

#include <toml++/toml.h>

#include <string>
#include <string_view>
#include <vector>

namespace tetraction {

/// The tree of a TOML file and the places of its values, "FILE:LINE:COLUMN" or, for a value that an
/// override brought in, "--set KEY=VALUE".
class TomlDocument {
 public:
  /// Throws FileError if the file cannot be read, InputError for syntax errors and overrides that
  /// are malformed or do not fit the tree.
  TomlDocument(const std::string& path, const std::vector<std::string>& overrides);
  /// The same for a text; messages name it `path`.
  TomlDocument(const std::string& path, std::string text,
               const std::vector<std::string>& overrides);

  /// A value put under a dotted key, and where it comes from.
  struct Change {
    std::string key;
    std::string value;    ///< TOML text
    std::string source;   ///< what messages about the value begin with
    bool remove = false;  ///< takes the key out instead
  };
  /// A copy of the document, which can be changed by itself.
  TomlDocument copy() const { return {path_, text_, changes_}; }
  /// Inserts or removes a value. Throws InputError if it does not fit the tree.
  void apply(const Change& change);

  const toml::table& root() const { return root_; }
  /// The place of a table or a value.
  std::string place_of(const toml::node& node) const;
  /// The place of a key of a table: the key itself, which stands left of its value.
  std::string place_of(const toml::table& table, std::string_view key) const;
  /// Whether an override brought in the value.
  bool is_override(const toml::node& node) const;

 private:
  TomlDocument(std::string path, std::string text, const std::vector<Change>& changes);
  std::string place_of(const toml::source_region& source) const;
  void remove(const std::vector<std::string>& segments, const std::string& source);

  std::string path_;
  std::string text_;  // toml++ forgets places in a copy: a copy is read again
  std::vector<Change> changes_;
  toml::table root_;
};

/// "a string", "a number", "a table", …: what a value is, for messages.
std::string_view kind_of(const toml::node& node);

}  // namespace tetraction
