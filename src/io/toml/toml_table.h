// Typed access to a table of a TOML document, with messages that say where, what and what to do.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/spelling.h"
#include "simulation/scene/setting_values.h"
#include "toml_document.h"
#include "toml_text.h"

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

  /// Values of one of the kinds of simulation/scene/setting_values.h.
  template <class T>
  void read(std::string_view key, T& target, const NumberRange& range = kFinite) const {
    if (has(key)) ValueKind<T>::read(json(key), range, refusal(key), target);
  }
  /// The value under a key that is present.
  Json json(std::string_view key) const { return to_json(*find(key)); }
  /// The function that refuses that value.
  Refusal refusal(std::string_view key) const;

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

  const TomlDocument* document_;
  const toml::table* table_;
  std::string name_;
};

}  // namespace tetraction
