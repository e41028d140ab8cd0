// The value of a key as TOML text.
#pragma once

#include <cmath>
#include <string>

#include "scene_keys.h"
#include "tetraction/simulation/setting_keys.h"

namespace tetraction {

/// The value of one key as TOML text, or an empty text if there is none. Every kind has its own
/// function.
template <class S>
struct ValueText {
  const S& settings;

  std::string operator()(int S::*member) const { return std::to_string(settings.*member); }
  std::string operator()(double S::*member) const {
    const double value = settings.*member;
    return std::isfinite(value) ? toml_number(value) : "";
  }
  std::string operator()(std::optional<double> S::*member) const {
    return settings.*member ? toml_number(*(settings.*member)) : "";
  }
  std::string operator()(Vector3 S::*member) const { return toml_list(settings.*member); }
  std::string operator()(std::optional<Vector3> S::*member) const {
    return settings.*member ? toml_list(*(settings.*member)) : "";
  }
  std::string operator()(std::array<bool, 3> S::*member) const {
    return toml_text(letters_of(settings.*member));
  }
  std::string operator()(std::string S::*member) const {
    return (settings.*member).empty() ? "" : toml_text(settings.*member);
  }
  std::string operator()(std::array<std::int64_t, 2> S::*member) const {
    const auto& pair = settings.*member;
    return toml_list(std::vector<std::int64_t>(pair.begin(), pair.end()));
  }
  std::string operator()(std::vector<std::int64_t> S::*member) const {
    return toml_list(settings.*member);
  }
  std::string operator()(std::vector<Vector3> S::*member) const {
    return (settings.*member).empty() ? "" : toml_list(settings.*member);
  }
  std::string operator()(bool S::*member) const { return settings.*member ? "true" : "false"; }
  std::string operator()(std::vector<std::string> S::*member) const {
    return (settings.*member).empty() ? "" : toml_list(settings.*member);
  }
  std::string operator()(const Choice<S>& choice) const {
    const std::string name = choice.get(settings);
    return name.empty() ? "" : toml_text(name);
  }
  std::string operator()(const NumberOrAuto<S>& value) const {
    return settings.*value.automatic ? toml_text("auto") : toml_number(settings.*value.number);
  }
  std::string operator()(const NumberOrArray<S>& value) const {
    const std::string array = value.array(settings);
    if (!array.empty()) return inline_table({{"array", toml_text(array), ""}});
    const std::optional<double> number = value.number(settings);
    return number ? toml_number(*number) : "";
  }
  std::string operator()(const VectorOrField<S>& value) const {
    const FieldSettings& field = settings.*value.field;
    if (field.empty()) return toml_list(settings.*value.vector);
    if (!field.file.empty()) return inline_table({{"file", toml_text(field.file)}});
    return inline_table({{"formula", toml_list(field.formula)}});
  }
  std::string operator()(const ByHand&) const { return {}; }
};

}  // namespace tetraction
