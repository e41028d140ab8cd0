// The kinds of values that a key can have, and the classes from which sections are written down.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <type_traits>
#include <utility>
#include <variant>

#include "setting_keys.h"
#include "tetraction/dynamics/steppers/integrator.h"

namespace tetraction {

template <>
struct EnumNames<Integrator> {
  inline static const std::vector<const char*> names = integrator_names();
};

/// The description of the values of one C++ type: the name of the type in the documents, the
/// value in files, and its check. The specialisations are in setting_values.cc.
template <class T>
struct ValueKind {
  static std::string type();
  static Json json(const T& value);
  static void read(const Json& node, const NumberRange& range, const Refusal& refuse, T& value);
  static void check(const T& value, const NumberRange& range, const std::string& name);
};

template <class T>
struct ValueKind<std::optional<T>> {
  static std::string type() { return ValueKind<T>::type(); }
  static Json json(const std::optional<T>& value) {
    return value ? ValueKind<T>::json(*value) : Json();
  }
  static void read(const Json& node, const NumberRange& range, const Refusal& refuse,
                   std::optional<T>& value) {
    T given{};
    ValueKind<T>::read(node, range, refuse, given);
    value = given;
  }
  static void check(const std::optional<T>& value, const NumberRange& range,
                    const std::string& name) {
    if (value) ValueKind<T>::check(*value, range, name);
  }
};

/// Reads one of the names.
std::string read_name(const Json& node, const Refusal& refuse,
                      const std::vector<const char*>& names);

/// A program's own environment has no name in files.
template <NamedEnum Enum>
std::vector<const char*> names_in_files() {
  std::vector<const char*> names = names_of<Enum>();
  if constexpr (std::is_same_v<Enum, EnvironmentKind>) names.pop_back();
  return names;
}

template <NamedEnum Enum>
struct ValueKind<Enum> {
  static std::string type() { return "text"; }
  static Json json(Enum value) { return name_of(value); }
  static void read(const Json& node, const NumberRange&, const Refusal& refuse, Enum& value) {
    value = *find_named<Enum>(read_name(node, refuse, names_in_files<Enum>()));
  }
  static void check(Enum, const NumberRange&, const std::string&) {}
};

/// Refuses a text that is not "auto", for NumberOrAuto.
[[noreturn]] void refuse_word(const std::string& word, const NumberRange& range,
                              const Refusal& refuse);
/// For NumberOrArray: the name of its type, a list of 1 to `most` entries, the name in an entry
/// { array = "…" }, and an entry that is a number.
std::string list_type(int most, bool takes_number);
void check_list(const Json& node, int most, const Refusal& refuse);
std::string array_of(const Json& entry, const Refusal& refuse);
double entry_of(const Json& entry, const NumberRange& range, const Refusal& refuse);
/// Throws InputError if a VectorOrField has both a file and a formula.
void check_field(const FieldSettings& field, const std::string& name);

/// The names that a key with a unit of length may have: those of length_units().
std::vector<const char*> length_unit_names();

/// The value of one member.
template <class S, class T>
class MemberValue : public SettingValue {
 public:
  explicit MemberValue(T S::*member) : member_(member) {}
  std::string type() const override { return ValueKind<T>::type(); }
  Json json(const void* settings) const override { return ValueKind<T>::json(get(settings)); }
  void read(const Json& node, const NumberRange& range, const Refusal& refuse,
            void* settings) const override {
    ValueKind<T>::read(node, range, refuse, static_cast<S*>(settings)->*member_);
  }
  void check(const void* settings, const NumberRange& range,
             const std::string& name) const override {
    ValueKind<T>::check(get(settings), range, name);
  }
  bool copy(const void* from, void* to) const override {
    static_cast<S*>(to)->*member_ = get(from);
    return true;
  }
  std::vector<const char*> names() const override {
    if constexpr (NamedEnum<T>) return names_in_files<T>();
    return {};
  }
  const void* member(const void* settings) const override { return &get(settings); }

 private:
  const T& get(const void* settings) const { return static_cast<const S*>(settings)->*member_; }
  T S::*member_;
};

/// A base of values that belong to settings of the type S.
template <class S>
class ValueOf : public SettingValue {
 protected:
  static const S& of(const void* settings) { return *static_cast<const S*>(settings); }
  static S& of(void* settings) { return *static_cast<S*>(settings); }
};

/// A text that must be one of several names. An empty text stands for an absent value.
template <class S>
class Choice : public ValueOf<S> {
 public:
  Choice(std::vector<const char*> names, std::function<std::string(const S&)> get,
         std::function<void(S&, const std::string&)> set)
      : names_(std::move(names)), get_(std::move(get)), set_(std::move(set)) {}
  Choice(std::vector<const char*> names, std::string S::*member)
      : Choice(std::move(names), std::mem_fn(member),
               [member](S& s, const std::string& name) { s.*member = name; }) {}
  std::string type() const override { return "text"; }
  Json json(const void* settings) const override {
    const std::string name = get_(this->of(settings));
    return name.empty() ? Json() : Json(name);
  }
  void read(const Json& node, const NumberRange&, const Refusal& refuse,
            void* settings) const override {
    set_(this->of(settings), read_name(node, refuse, names_));
  }
  bool copy(const void* from, void* to) const override {
    const std::string name = get_(this->of(from));
    if (!name.empty()) set_(this->of(to), name);
    return !name.empty();
  }
  std::vector<const char*> names() const override { return names_; }

 private:
  std::vector<const char*> names_;
  std::function<std::string(const S&)> get_;
  std::function<void(S&, const std::string&)> set_;
};

/// A number, or the word "auto" if the other member is true.
template <class S>
class NumberOrAuto : public ValueOf<S> {
 public:
  NumberOrAuto(double S::*number, bool S::*automatic) : number_(number), automatic_(automatic) {}
  std::string type() const override { return "number"; }
  Json json(const void* settings) const override {
    const S& s = this->of(settings);
    return s.*automatic_ ? Json("auto") : Json(s.*number_);
  }
  void read(const Json& node, const NumberRange& range, const Refusal& refuse,
            void* settings) const override {
    S& s = this->of(settings);
    s.*automatic_ = node.is_string();
    if (!node.is_string()) return ValueKind<double>::read(node, range, refuse, s.*number_);
    std::string word;
    ValueKind<std::string>::read(node, range, refuse, word);
    if (word != "auto") refuse_word(word, range, refuse);
  }
  void check(const void* settings, const NumberRange& range,
             const std::string& name) const override {
    const S& s = this->of(settings);
    if (!(s.*automatic_)) ValueKind<double>::check(s.*number_, range, name);
  }
  const char* word() const override { return "auto"; }
  const void* member(const void* settings) const override { return &(this->of(settings).*number_); }
  bool copy(const void* from, void* to) const override {
    this->of(to).*number_ = this->of(from).*number_;
    this->of(to).*automatic_ = this->of(from).*automatic_;
    return true;
  }

 private:
  double S::*number_;
  bool S::*automatic_;
};

/// Three numbers for the whole body, or a vector for each vertex from a file or from formulas.
template <class S>
class VectorOrField : public ValueOf<S> {
 public:
  VectorOrField(Vector3 S::*vector, FieldSettings S::*field) : vector_(vector), field_(field) {}
  SettingValue::Form form() const override { return SettingValue::Form::kPlainOrTable; }
  std::string type() const override { return "three numbers or a table"; }
  Json json(const void* settings) const override {
    const S& s = this->of(settings);
    if ((s.*field_).empty()) return ValueKind<Vector3>::json(s.*vector_);
    return settings_json(section_of<FieldSettings>(), &(s.*field_));
  }
  void read(const Json& node, const NumberRange& range, const Refusal& refuse,
            void* settings) const override {
    ValueKind<Vector3>::read(node, range, refuse, this->of(settings).*vector_);
  }
  void read_table(const TableReader& read, void* settings) const override {
    FieldSettings field;
    read(section_of<FieldSettings>(), &field);
    this->of(settings).*field_ = field;
  }
  void check(const void* settings, const NumberRange& range,
             const std::string& name) const override {
    const S& s = this->of(settings);
    if ((s.*field_).empty()) return ValueKind<Vector3>::check(s.*vector_, range, name);
    check_field(s.*field_, name);
  }
  const void* member(const void* settings) const override { return &(this->of(settings).*vector_); }

 private:
  Vector3 S::*vector_;
  FieldSettings S::*field_;
};

/// A table of its own. `get` returns null if the settings have none; `make` adds one. Both return
/// settings of the inner section.
template <class S>
class TableValue : public ValueOf<S> {
 public:
  TableValue(const SceneSection& (*section)(), const void* (*get)(const S&), void* (*make)(S&))
      : section_(section), get_(get), make_(make) {}
  SettingValue::Form form() const override { return SettingValue::Form::kTable; }
  std::string type() const override { return "table"; }
  Json json(const void* settings) const override {
    const void* inner = get_(this->of(settings));
    return inner != nullptr ? settings_json(section_(), inner) : Json();
  }
  void read_table(const TableReader& read, void* settings) const override {
    read(section_(), make_(this->of(settings)));
  }
  void check(const void* settings, const NumberRange&, const std::string&) const override {
    if (const void* inner = get_(this->of(settings))) check_settings(section_(), inner);
  }

 private:
  const SceneSection& (*section_)();
  const void* (*get_)(const S&);
  void* (*make_)(S&);
};

/// A list of tables.
template <class S, class Entry>
class TablesValue : public ValueOf<S> {
 public:
  explicit TablesValue(std::vector<Entry> S::*list) : list_(list) {}
  SettingValue::Form form() const override { return SettingValue::Form::kTables; }
  std::string type() const override { return "tables"; }
  Json json(const void* settings) const override {
    Json list;
    for (const Entry& entry : this->of(settings).*list_) {
      list.push_back(settings_json(section_of<Entry>(), &entry));
    }
    return list;
  }
  void read_table(const TableReader& read, void* settings) const override {
    read(section_of<Entry>(), &(this->of(settings).*list_).emplace_back());
  }

 private:
  std::vector<Entry> S::*list_;
};

/// A selection, which only the scene reader can read, because it may have the name of another.
template <class S>
class SelectionValue : public ValueOf<S> {
 public:
  explicit SelectionValue(Selection S::*member = &S::select) : member_(member) {}
  SettingValue::Form form() const override { return SettingValue::Form::kSelection; }
  std::string type() const override { return "[selection](#selections)"; }
  Json json(const void* settings) const override {
    return selection_json(this->of(settings).*member_);
  }
  Selection* selection(void* settings) const override { return &(this->of(settings).*member_); }

 private:
  Selection S::*member_;
};

/// A value with functions of its own, because its form depends on other keys.
template <class S>
class OwnValue : public ValueOf<S> {
 public:
  using Read = void (*)(const Json& node, const NumberRange& range, const Refusal& refuse, S&);
  /// `type` is in Markdown.
  OwnValue(const char* type, Json (*json_of)(const S&), Read read_from)
      : type_(type), json_(json_of), read_(read_from) {}
  std::string type() const override { return type_; }
  Json json(const void* settings) const override { return json_(this->of(settings)); }
  void read(const Json& node, const NumberRange& range, const Refusal& refuse,
            void* settings) const override {
    read_(node, range, refuse, this->of(settings));
  }

 private:
  const char* type_;
  Json (*json_)(const S&);
  Read read_;
};

/// A key that other code reads and writes. It is here for the documents.
template <class S>
class DocumentedValue : public ValueOf<S> {
 public:
  /// `type` is in Markdown.
  explicit DocumentedValue(const char* type) : type_(type) {}
  SettingValue::Form form() const override { return SettingValue::Form::kOther; }
  std::string type() const override { return type_; }
  Json json(const void*) const override { return {}; }

 private:
  const char* type_;
};

/// Functions of SceneKey that tell how a key depends on the other settings, or null.
template <class S>
struct KeyUse {
  bool (*used)(const S&) = nullptr;
  const char* (*unit)(const S&) = nullptr;
  std::string (*needed)(const S&, const HasKey& has) = nullptr;
  bool (*written)(const S&) = nullptr;
};

/// One key of a section for settings of the type S.
template <class S>
struct Key : SceneKey {
  template <class Value>
  Key(KeyInfo key, const Value& held, KeyUse<S> use = {}) {
    info = key;
    if constexpr (std::is_member_object_pointer_v<Value>) {
      using Member = MemberValue<S, std::remove_cvref_t<decltype(std::declval<S&>().*held)>>;
      value = std::make_shared<const Member>(held);
    } else {
      value = std::make_shared<const Value>(held);
    }
    if (use.used) used = [use](const void* s) { return use.used(of(s)); };
    if (use.unit) unit = [use](const void* s) { return use.unit(of(s)); };
    if (use.needed) {
      needed = [use](const void* s, const HasKey& has) { return use.needed(of(s), has); };
    }
    if (use.written) written = [use](const void* s) { return use.written(of(s)); };
  }
  template <class Value>
  Key(KeyInfo key, const Value& held, bool (*used_if)(const S&))
      : Key(key, held, KeyUse<S>{.used = used_if}) {}

 private:
  static const S& of(const void* settings) { return *static_cast<const S*>(settings); }
};

/// A rule for settings of the type S.
template <class S>
struct KeyRule : SectionRule {
  KeyRule(std::vector<const char*> of_keys, std::string (*conflict_of)(const S&)) {
    keys = std::move(of_keys);
    conflict = [conflict_of](const void* s) { return conflict_of(*static_cast<const S*>(s)); };
  }
};

/// A section for settings of the type S.
template <class S>
SceneSection make_section(const char* name, const std::vector<Key<S>>& keys,
                          const std::vector<KeyRule<S>>& rules = {}, bool refuses_unused = false,
                          const S& defaults = S{}) {
  SceneSection section{
      name,      {keys.begin(), keys.end()},         {rules.begin(), rules.end()}, refuses_unused,
      typeid(S), std::make_shared<const S>(defaults)};
  if constexpr (requires(S s) { s.where; }) {
    section.where = [](void* s) { return &static_cast<S*>(s)->where; };
  }
  return section;
}

/// The key `select`. It must be given, unless `needed` says otherwise.
template <class S>
Key<S> select_key(const char* help, bool (*used)(const S&) = nullptr) {
  return {{.name = "select", .help = help, .absent = "must be given"},
          SelectionValue<S>(),
          {.used = used, .needed = [](const S&, const HasKey&) -> std::string {
             return "say which vertices, for instance select = { all = true }.";
           }}};
}

}  // namespace tetraction
