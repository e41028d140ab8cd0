#include "scene_keys.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <variant>

#include "key_text.h"
#include "tetraction/core/error.h"
#include "tetraction/simulation/setting_keys.h"

namespace tetraction {
namespace {

template <class Values, class Text>
std::string list_text(const Values& values, const Text& text) {
  std::string list = "[";
  for (const auto& value : values) list += (list.size() > 1 ? ", " : "") + text(value);
  return list + "]";
}

template <class S>
std::string unit_text(const Key<S>& key, const S& settings) {
  const char* unit = key.unit != nullptr ? key.unit(settings) : key.info.unit;
  return key.info.per[0] == '\0' ? unit : fmt::format("{} {}", unit, key.info.per);
}

// The keys of a kind of selection that is a table.
template <class Kind>
SceneKeys selection_keys(const char* name, const Kind& kind) {
  SceneKeys keys = keys_of<Kind>(kind);
  for (SceneKey& key : keys) key = {fmt::format("{}.{}", name, key.name), key.value};
  return keys;
}

}  // namespace

std::string toml_number(double value) {
  std::string text = fmt::format("{}", value);
  // "3" would be read as an integer, and "-0" would lose its sign.
  if (text.find_first_not_of("-0123456789") == std::string::npos) text += ".0";
  return text;
}

std::string toml_text(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      quoted += '\\';
      quoted += c;
    } else if (byte < 0x20 || byte == 0x7f) {
      quoted += fmt::format("\\u{:04x}", byte);
    } else {
      quoted += c;
    }
  }
  return quoted + "\"";
}

std::string toml_list(const Vector3& value) {
  return list_text(value, toml_number);
}

std::string toml_list(const std::vector<std::int64_t>& values) {
  return list_text(values, [](std::int64_t value) { return std::to_string(value); });
}

std::string toml_list(const std::vector<Vector3>& values) {
  return list_text(values, [](const Vector3& value) { return toml_list(value); });
}

std::string toml_list(const std::vector<std::string>& values) {
  return list_text(values, toml_text);
}

template <class S>
SceneKeys keys_of(const S& settings) {
  const Section<S>& section = section_of<S>();
  const S defaults{};
  SceneKeys keys;
  for (const Key<S>& key : section.keys) {
    if (section.refuses_unused && !key.is_used(settings)) continue;
    const std::string value = std::visit(ValueText<S>{settings}, key.value);
    if (value.empty()) continue;
    if (key.info.in_file == Written::kUnlessDefault &&
        value == std::visit(ValueText<S>{defaults}, key.value)) {
      continue;
    }
    keys.push_back(
        {key.info.name, value, value[0] == '"' ? std::string() : unit_text(key, settings)});
  }
  return keys;
}

template SceneKeys keys_of(const MeshSettings&);
template SceneKeys keys_of(const SolverSettings&);
template SceneKeys keys_of(const Damping&);
template SceneKeys keys_of(const OutputSettings&);
template SceneKeys keys_of(const ProbeSettings&);
template SceneKeys keys_of(const InitialSettings&);
template SceneKeys keys_of(const FixSettings&);
template SceneKeys keys_of(const ConstraintSettings&);
template SceneKeys keys_of(const ForceSettings&);
template SceneKeys keys_of(const MomentumSettings&);
template SceneKeys keys_of(const ShiftSettings&);

SceneKeys keys_of(const MaterialSettings& material) {
  if (material.custom) {
    throw InputError(fmt::format(
        "The material {} is a program's own: a scene file cannot name it. Take one of the models.",
        material_name(*material.custom)));
  }
  return keys_of<MaterialSettings>(material);
}

SceneKeys keys_of(const TimeSettings& time) {
  if (!std::isfinite(time.end)) {
    throw InputError("The run has no end, which a scene file must give: set time.end.");
  }
  return keys_of<TimeSettings>(time);
}

SceneKeys keys_of(const EnvironmentSettings& environment) {
  if (environment.kind == EnvironmentKind::kCustom) {
    throw InputError(
        "The environment is a program's own force field: a scene file cannot name it. Take none, "
        "gravity or attraction.");
  }
  return keys_of<EnvironmentSettings>(environment);
}

SceneKeys keys_of(const Selection& selection) {
  struct Visitor {
    SceneKeys operator()(const SelectVertices& s) const { return {{"vertices", toml_list(s.ids)}}; }
    SceneKeys operator()(const SelectPlane& s) const { return selection_keys("plane", s); }
    SceneKeys operator()(const SelectBox& s) const { return selection_keys("box", s); }
    SceneKeys operator()(const SelectSphere& s) const { return selection_keys("sphere", s); }
    SceneKeys operator()(const SelectNearest& s) const { return {{"nearest", toml_list(s.point)}}; }
    SceneKeys operator()(const SelectGroup& s) const { return {{"group", toml_text(s.name)}}; }
    SceneKeys operator()(const SelectSurface&) const { return {{"surface", "true"}}; }
    SceneKeys operator()(const SelectAll&) const { return {{"all", "true"}}; }
  };
  return std::visit(Visitor{}, selection);
}

std::string inline_selection(const Selection& selection) {
  const SceneKeys keys = keys_of(selection);
  const auto dot = keys.front().name.find('.');
  if (dot == std::string::npos) return inline_table(keys);
  SceneKeys inner = keys;
  for (SceneKey& key : inner) key.name.erase(0, dot + 1);
  return inline_table({{keys.front().name.substr(0, dot), inline_table(inner)}});
}

std::string inline_table(const SceneKeys& keys, const Selection* select) {
  std::string text = select != nullptr ? "select = " + inline_selection(*select) : std::string();
  for (const SceneKey& key : keys) {
    text += fmt::format("{}{} = {}", text.empty() ? "" : ", ", key.name, key.value);
  }
  return "{ " + text + " }";
}

}  // namespace tetraction
