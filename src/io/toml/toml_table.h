// Typed access to a table of a TOML document, with messages that say where, what and what to do.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/spelling.h"
#include "tetraction/core/number_range.h"
#include "tetraction/core/types.h"
#include "toml_document.h"

namespace tetraction {

/// The keys that a table may have.
struct TableKeys {
  NameList valid;
  /// Known names that this version cannot honour yet: refused, but not as a spelling mistake.
  NameList later = {};
};

/// One table of a document. `read(key, target)` sets the target if the key is present and throws
/// InputError if its value is of a wrong type or out of range; an absent key leaves the default.
/// Keys are checked at construction, so that a misspelt key is reported as such and not as the
/// absence of the right one.
class TomlTable {
 public:
  /// `name` is the dotted path of the table, empty for the root.
  TomlTable(const TomlDocument& document, const toml::table& table, std::string name,
            const TableKeys& keys);

  bool has(std::string_view key) const { return table_->contains(key); }

  void read(std::string_view key, double& target, const NumberRange& range = kFinite) const;
  void read(std::string_view key, std::optional<double>& target,
            const NumberRange& range = kFinite) const;
  /// Whole numbers of at least `least`.
  void read(std::string_view key, int& target, int least) const;
  void read(std::string_view key, int& target, const NumberRange& range) const;
  /// Lists of three.
  void read(std::string_view key, Vector3& target, const NumberRange& range = kFinite) const;
  void read(std::string_view key, std::optional<Vector3>& target) const;
  void read(std::string_view key, std::array<int, 3>& target, int least) const;
  /// Lists of two.
  void read(std::string_view key, std::array<double, 2>& target,
            const NumberRange& range = kFinite) const;
  /// Two different whole numbers of at least 0.
  void read_pair(std::string_view key, std::array<std::int64_t, 2>& target) const;
  /// Which of x, y and z a text names, each once.
  void read_letters(std::string_view key, std::array<bool, 3>& target) const;
  /// A number in the range, or "auto", which leaves the number as it is.
  void read_or_auto(std::string_view key, double& target, bool& automatic,
                    const NumberRange& range) const;
  /// A list of one or more whole numbers of at least 0.
  void read(std::string_view key, std::vector<std::int64_t>& target) const;
  /// A list of one or more lists of three numbers.
  void read(std::string_view key, std::vector<Vector3>& target) const;
  /// A list of one or more lists of two numbers.
  void read(std::string_view key, std::vector<std::pair<double, double>>& target) const;
  /// A list of one or more texts.
  void read(std::string_view key, std::vector<std::string>& target) const;
  /// A text that is not empty.
  void read(std::string_view key, std::string& target) const;
  /// One of the valid names; `later` names are refused as belonging to later versions.
  void read(std::string_view key, std::string& target, const NameList& valid,
            const NameList& later = {}) const;
  void read(std::string_view key, bool& target) const;

  /// The table under a key that is present.
  TomlTable table(std::string_view key, const TableKeys& keys) const;
  /// The tables of a list of tables, [[key]]; none if the key is absent.
  std::vector<TomlTable> tables(std::string_view key, const TableKeys& keys) const;
  /// The tables under a key that holds one table or a list of them; none if it is absent.
  std::vector<TomlTable> one_or_more_tables(std::string_view key, const TableKeys& keys) const;
  /// The dotted path of the table.
  const std::string& name() const { return name_; }
  /// The table as toml++ has it.
  const toml::table& node() const { return *table_; }
  const TomlDocument& document() const { return *document_; }
  /// Whether the value under a key that is present is a string.
  bool is_string(std::string_view key) const { return table_->get(key)->is_string(); }
  bool is_override(std::string_view key) const {
    return has(key) && document_->is_override(*table_->get(key));
  }

  /// Throws InputError unless the key is present: "… is missing: " + remedy.
  void require(std::string_view key, std::string_view remedy) const;
  /// Throws InputError about a key: its place, its name, and the message.
  [[noreturn]] void refuse(std::string_view key, std::string_view message) const;
  /// Throws InputError about the whole table.
  [[noreturn]] void refuse_table(std::string_view message) const;
  /// Place and name of the table, or of a key of it: "scene.toml:3:1: time.step".
  std::string where() const;
  std::string where(std::string_view key) const;
  /// The place alone, of the table or of a key.
  std::string place() const { return document_->place_of(*table_); }
  std::string place(std::string_view key) const { return document_->place_of(*table_, key); }

 private:
  const toml::node* find(std::string_view key) const;
  std::string path_of(std::string_view key) const;
  double number_of(std::string_view key, const toml::node& node, const NumberRange& range,
                   bool in_list) const;
  std::int64_t integer_of(std::string_view key, const toml::node& node, std::int64_t least,
                          std::int64_t most, bool in_list) const;
  const toml::array& list_of(std::string_view key, const toml::node& node, std::size_t size,
                             std::string_view example) const;

  const TomlDocument* document_;
  const toml::table* table_;
  std::string name_;
};

}  // namespace tetraction
