// The kind of value that parameters of materials have.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <variant>

#include "setting_values.h"

namespace tetraction {

/// The table { array = "…" }.
struct ArrayName {
  std::string name;
};

/// A number for the whole body, or the name of a cell array of the mesh file with a number for each
/// tetrahedron; or a list of such values, whose entries have the names "mu.0", "mu.1", ….
template <class S>
class NumberOrArray : public ValueOf<S> {
 public:
  using Numbers = std::map<std::string, double>;
  using Member = std::variant<double S::*, std::optional<double> S::*, Numbers S::*>;
  /// A list of 1 to `most` entries; 0: the key takes no list.
  struct List {
    int most = 0;
    NumberRange range = {};    ///< of an entry
    bool takes_number = true;  ///< false if the key takes a list only
  };

  /// `name` is that of the key.
  NumberOrArray(std::string name, Member member, std::map<std::string, std::string> S::*arrays,
                List list = {})
      : name_(std::move(name)), member_(member), arrays_(arrays), list_(list) {}
  SettingValue::Form form() const override { return SettingValue::Form::kPlainOrTable; }
  std::string type() const override { return list_type(list_.most, list_.takes_number); }
  Json json(const void* settings) const override {
    const S& s = this->of(settings);
    if (const int count = entry_count(s); count > 0) {
      Json list = Json::array();
      for (int i = 0; i < count; ++i) list.push_back(entry(i).json(settings));
      return list;
    }
    if (const auto array = (s.*arrays_).find(name_); array != (s.*arrays_).end()) {
      return {{"array", array->second}};
    }
    return ValueKind<std::optional<double>>::json(number(s));
  }
  void read(const Json& node, const NumberRange& range, const Refusal& refuse,
            void* settings) const override {
    S& s = this->of(settings);
    if (list_.most == 0 || (list_.takes_number && !node.is_array())) {
      double number = 0.0;
      ValueKind<double>::read(node, range, refuse, number);
      return set(s, number);
    }
    check_list(node, list_.most, refuse);
    for (int i = 0; i < static_cast<int>(node.size()); ++i) {
      const Json& given = node[static_cast<std::size_t>(i)];
      if (given.is_object()) {
        entry(i).set(s, array_of(given, refuse));
      } else {
        entry(i).set(s, entry_of(given, list_.range, refuse));
      }
    }
  }
  void read_table(const TableReader& read, void* settings) const override {
    ArrayName array;
    read(section_of<ArrayName>(), &array);
    set(this->of(settings), array.name);
  }
  void check(const void* settings, const NumberRange& range,
             const std::string& name) const override {
    const S& s = this->of(settings);
    ValueKind<std::optional<double>>::check(number(s), range, name);
    for (int i = 0; i < entry_count(s); ++i) {
      entry(i).check(settings, list_.range, name + "." + std::to_string(i));
    }
  }
  bool copy(const void* from, void* to) const override {
    const S& given = this->of(from);
    S& s = this->of(to);
    clear(s);
    if (const std::optional<double> value = number(given)) set(s, *value);
    const auto array = (given.*arrays_).find(name_);
    if (array != (given.*arrays_).end()) set(s, array->second);
    for (int i = 0; i < entry_count(given); ++i) entry(i).copy(from, to);
    return true;
  }
  const void* member(const void* settings) const override {
    return std::visit([&](auto at) -> const void* { return &(this->of(settings).*at); }, member_);
  }

 private:
  NumberOrArray entry(int i) const { return {name_ + "." + std::to_string(i), member_, arrays_}; }
  int entry_count(const S& s) const {
    int count = 0;
    while (count < list_.most && entry(count).is_given(s)) ++count;
    return count;
  }
  bool is_given(const S& s) const { return (s.*arrays_).count(name_) > 0 || number(s).has_value(); }
  /// No value if there is none or if an array gives it.
  std::optional<double> number(const S& s) const {
    if ((s.*arrays_).count(name_) > 0) return std::nullopt;
    if (const auto* at = std::get_if<Numbers S::*>(&member_)) {
      const auto found = (s.**at).find(name_);
      return found == (s.**at).end() ? std::nullopt : std::optional(found->second);
    }
    if (const auto* at = std::get_if<double S::*>(&member_)) return s.**at;
    return s.*std::get<std::optional<double> S::*>(member_);
  }
  void set(S& s, double value) const {
    (s.*arrays_).erase(name_);
    if (const auto* at = std::get_if<Numbers S::*>(&member_)) {
      (s.**at)[name_] = value;
    } else if (const auto* plain = std::get_if<double S::*>(&member_)) {
      s.** plain = value;
    } else {
      s.*std::get<std::optional<double> S::*>(member_) = value;
    }
  }
  void set(S& s, const std::string& array) const {
    clear(s);
    (s.*arrays_)[name_] = array;
  }
  /// Takes the value away, with all entries of a list. A number that cannot be absent stays.
  void clear(S& s) const {
    (s.*arrays_).erase(name_);
    if (const auto* at = std::get_if<std::optional<double> S::*>(&member_)) (s.**at).reset();
    if (const auto* at = std::get_if<Numbers S::*>(&member_)) (s.**at).erase(name_);
    for (int i = 0; i < list_.most; ++i) entry(i).clear(s);
  }

  std::string name_;
  Member member_;
  std::map<std::string, std::string> S::*arrays_;
  List list_;
};

}  // namespace tetraction
