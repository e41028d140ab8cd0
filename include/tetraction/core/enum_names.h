// Enumerations whose values have names in files, each with one table.
#pragma once

#include <cstddef>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace tetraction {

/// The names of an enumeration that counts from 0. A specialisation beside the enumeration has
/// - `names`, an array of the names in the order of the enumeration,
/// - for from_string(), `noun`, which completes "is not" in its message: "a linear solver".
template <class Enum>
struct EnumNames;

template <class Enum>
concept NamedEnum = std::is_enum_v<Enum> && requires {
  std::size(EnumNames<Enum>::names);
};

/// Throws InputError: "NAME" is not a NOUN; there are A, B.
[[noreturn]] void refuse_name(const std::string& name, const char* noun,
                              const std::vector<const char*>& known);

/// "unknown" for a number that is not a value of the enumeration.
template <NamedEnum Enum>
const char* name_of(Enum value) {
  const auto i = static_cast<std::size_t>(value);
  return i < std::size(EnumNames<Enum>::names) ? EnumNames<Enum>::names[i] : "unknown";
}

template <NamedEnum Enum>
std::string to_string(Enum value) {
  return name_of(value);
}

/// All names, in the order of the enumeration.
template <NamedEnum Enum>
std::vector<const char*> names_of() {
  return {std::begin(EnumNames<Enum>::names), std::end(EnumNames<Enum>::names)};
}

/// All values, in the order of the enumeration.
template <NamedEnum Enum>
const std::vector<Enum>& values_of() {
  static const std::vector<Enum> values = [] {
    std::vector<Enum> all;
    for (std::size_t i = 0; i < std::size(EnumNames<Enum>::names); ++i) {
      all.push_back(static_cast<Enum>(i));
    }
    return all;
  }();
  return values;
}

/// The value with that name. No value if there is none.
template <NamedEnum Enum>
std::optional<Enum> find_named(std::string_view name) {
  for (std::size_t i = 0; i < std::size(EnumNames<Enum>::names); ++i) {
    if (name == EnumNames<Enum>::names[i]) return static_cast<Enum>(i);
  }
  return std::nullopt;
}

/// Inverse of to_string(); throws InputError listing the valid names.
template <NamedEnum Enum>
Enum from_string(const std::string& name) {
  if (const std::optional<Enum> value = find_named<Enum>(name)) return *value;
  refuse_name(name, EnumNames<Enum>::noun, names_of<Enum>());
}

}  // namespace tetraction
