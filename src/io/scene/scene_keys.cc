#include "scene_keys.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>
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

std::string toml_key(const std::string& name) {
  const bool is_bare = !name.empty() && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-';
  });
  return is_bare ? name : toml_text(name);
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

std::string toml_list(const std::array<std::string, 3>& texts) {
  return list_text(texts, toml_text);
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

SceneKeys keys_of(const ForceSettings& load) {
  SceneKeys keys = visit_load(
      load, []<class Settings>(const Settings& settings) { return keys_of<Settings>(settings); });
  if (load.total || load.acceleration) {
    std::erase_if(keys, [](const SceneKey& key) { return key.name == "vector"; });
  }
  return keys;
}

SceneKeys keys_of(const AmplitudeSettings& amplitude) {
  SceneKeys keys = keys_of<AmplitudeSettings>(amplitude);
  std::string value;
  switch (amplitude.kind) {
    case AmplitudeKind::kPoints:
      value = list_text(amplitude.points, [](const std::pair<double, double>& point) {
        return fmt::format("[{}, {}]", toml_number(point.first), toml_number(point.second));
      });
      break;
    case AmplitudeKind::kFile:
      value = toml_text(std::filesystem::absolute(amplitude.file).lexically_normal().string());
      break;
    case AmplitudeKind::kSine:
      value = inline_table({{"frequency", toml_number(amplitude.frequency)},
                            {"phase", toml_number(amplitude.phase)},
                            {"offset", toml_number(amplitude.offset)}});
      break;
    case AmplitudeKind::kSmoothStep:
      value = inline_table(
          {{"from", toml_number(amplitude.from)}, {"until", toml_number(amplitude.until)}});
      break;
  }
  keys.push_back({to_string(amplitude.kind), value});
  return keys;
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

namespace {

// A kind of selection and its value: keys if it is a table, otherwise a text.
struct KindAndValue {
  std::string kind;
  std::string value;
  SceneKeys keys{};
};

struct SelectionText {
  KindAndValue operator()(const SelectVertices& s) const { return {"vertices", toml_list(s.ids)}; }
  KindAndValue operator()(const SelectPlane& s) const { return {"plane", "", keys_of(s)}; }
  KindAndValue operator()(const SelectBox& s) const { return {"box", "", keys_of(s)}; }
  KindAndValue operator()(const SelectSphere& s) const { return {"sphere", "", keys_of(s)}; }
  KindAndValue operator()(const SelectNearest& s) const { return {"nearest", toml_list(s.point)}; }
  KindAndValue operator()(const SelectGroup& s) const { return {"group", toml_text(s.name)}; }
  KindAndValue operator()(const SelectSurface&) const { return {"surface", "true"}; }
  KindAndValue operator()(const SelectAll&) const { return {"all", "true"}; }
  KindAndValue operator()(const SelectFaces& s) const { return {"faces", "", keys_of(s)}; }
  KindAndValue operator()(const SelectSet& s) const {
    const auto text = [](const SelectionPart& part) { return inline_selection(part.selection); };
    const bool is_not = s.operation == SetOperation::kNot;
    return {to_string(s.operation), is_not ? text(s.of.at(0)) : list_text(s.of, text)};
  }
  // Where a table is needed: the union of that selection alone.
  KindAndValue operator()(const SelectNamed& s) const {
    return {to_string(SetOperation::kAnyOf), fmt::format("[{}]", toml_text(s.name))};
  }
};

}  // namespace

SceneKeys selection_keys(const Selection& selection) {
  const KindAndValue text = std::visit(SelectionText{}, selection);
  if (text.keys.empty()) return {{text.kind, text.value}};
  SceneKeys keys;
  for (const SceneKey& key : text.keys) {
    keys.push_back({fmt::format("{}.{}", text.kind, key.name), key.value});
  }
  return keys;
}

SceneKeys selection_keys(const std::string& key, const Selection& selection) {
  if (std::holds_alternative<SelectNamed>(selection)) return {{key, inline_selection(selection)}};
  if (const auto* set = std::get_if<SelectSet>(&selection);
      set != nullptr && set->operation == SetOperation::kNot) {
    return selection_keys(key + ".not", set->of.at(0).selection);
  }
  SceneKeys keys = selection_keys(selection);
  for (SceneKey& own : keys) own.name = fmt::format("{}.{}", key, own.name);
  return keys;
}

std::string inline_selection(const Selection& selection) {
  if (const auto* named = std::get_if<SelectNamed>(&selection)) return toml_text(named->name);
  const KindAndValue text = std::visit(SelectionText{}, selection);
  return inline_table({{text.kind, text.keys.empty() ? text.value : inline_table(text.keys)}});
}

std::string inline_table(const SceneKeys& keys, const Selection* select) {
  std::string text = select != nullptr ? "select = " + inline_selection(*select) : std::string();
  for (const SceneKey& key : keys) {
    text += fmt::format("{}{} = {}", text.empty() ? "" : ", ", key.name, key.value);
  }
  return "{ " + text + " }";
}

}  // namespace tetraction
