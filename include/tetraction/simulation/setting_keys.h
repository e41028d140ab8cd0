// The keys of a scene's sections, in one table for each settings struct: name, unit, range,
// meaning. The scene's reader, writer and echo, the checks of edits, the fields of the window and
// the tables of docs/scene.md are all made from these tables. Default values are those of the
// structs themselves.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "tetraction/core/number_range.h"
#include "tetraction/simulation/scene.h"

namespace tetraction {

/// When the scene writer writes a key.
enum class Written { kAlways, kUnlessDefault };

/// The description of a key, which does not depend on the type of its value.
struct KeyInfo {
  const char* name = "";
  const char* title = "";    ///< its name in the window: "Mass damping"
  const char* unit = "";     ///< "m/s²"
  const char* per = "";      ///< completes the unit in a scene file: "on each vertex"
  const char* help = "";     ///< meaning, in Markdown, without range and default
  NumberRange range = {};    ///< allowed numbers, also for each entry of a list
  const char* needed = "";   ///< if the key is required: what to give; otherwise empty
  const char* absent = "–";  ///< the default in words, if the struct holds no value
  Written in_file = Written::kAlways;
  Written in_echo = Written::kAlways;
};

/// A text that must be one of several names. An empty text stands for an absent value.
template <class Settings>
struct Choice {
  std::vector<const char*> names;
  std::vector<const char*> later;  ///< names reserved for later versions, with their own message
  std::string (*get)(const Settings&);
  void (*set)(Settings&, const std::string&);
};

/// A number, or the word "auto" if the other member is true.
template <class Settings>
struct NumberOrAuto {
  double Settings::*number;
  bool Settings::*automatic;
};

/// Three numbers for the whole body, or a vector for each vertex from a file or from formulas.
template <class Settings>
struct VectorOrField {
  Vector3 Settings::*vector;
  FieldSettings Settings::*field;
};

/// A number for the whole body, or the name of a cell array of the mesh file with a number for each
/// tetrahedron.
template <class Settings>
struct NumberOrArray {
  const char* name;  ///< of the key
  std::variant<double Settings::*, std::optional<double> Settings::*> member;
  std::map<std::string, std::string> Settings::*arrays;

  /// The number. No value if there is none or if an array gives it.
  std::optional<double> number(const Settings& settings) const {
    if (!array(settings).empty()) return std::nullopt;
    return std::visit([&](auto at) -> std::optional<double> { return settings.*at; }, member);
  }
  /// The name of the array; empty if there is none.
  std::string array(const Settings& settings) const {
    const auto found = (settings.*arrays).find(name);
    return found == (settings.*arrays).end() ? std::string() : found->second;
  }
  void set(Settings& settings, double value) const {
    (settings.*arrays).erase(name);
    std::visit([&](auto at) { settings.*at = value; }, member);
  }
  void set(Settings& settings, const std::string& array_name) const {
    (settings.*arrays)[name] = array_name;
    if (const auto* at = std::get_if<std::optional<double> Settings::*>(&member)) {
      (settings.**at).reset();
    }
  }
};

/// A key whose value has a structure of its own, or a type that depends on other keys. Reader and
/// writer have special code for it.
struct ByHand {
  const char* type;  ///< in Markdown
};

/// The member that holds the value of a key.
template <class S>
using KeyValue =
    std::variant<int S::*, double S::*, std::optional<double> S::*, Vector3 S::*,
                 std::optional<Vector3> S::*, std::array<bool, 3> S::*, std::string S::*,
                 std::array<std::int64_t, 2> S::*, std::vector<std::int64_t> S::*,
                 std::vector<Vector3> S::*, std::vector<std::string> S::*, bool S::*, Choice<S>,
                 NumberOrAuto<S>, NumberOrArray<S>, VectorOrField<S>, ByHand>;

/// One key of a section.
template <class Settings>
struct Key {
  KeyInfo info;
  KeyValue<Settings> value;
  /// Whether the key has a meaning with the other settings. Null: always.
  bool (*used)(const Settings&) = nullptr;
  /// The unit, if it depends on the other settings.
  const char* (*unit)(const Settings&) = nullptr;

  bool is_used(const Settings& settings) const { return used == nullptr || used(settings); }
};

/// A condition that the keys of a section must satisfy together.
template <class Settings>
struct KeyRule {
  /// The keys of the condition. An empty list means the section as a whole. A message names the key
  /// that an override has set, otherwise the last one that is present.
  std::vector<const char*> keys;
  /// The text of the message after the key's name, such as "must not be zero.". Empty if the
  /// settings satisfy the condition.
  std::string (*conflict)(const Settings&);
};

/// A section of the scene file, with its keys in the order of reading and writing.
template <class Settings>
struct Section {
  const char* name;
  std::vector<Key<Settings>> keys;
  std::vector<KeyRule<Settings>> rules = {};
  /// Whether keys without a meaning (is_used()) are refused. The first key is then a `kind`.
  bool refuses_unused = false;
};

// Settings of one kind of load each, so that each kind has its own table.
struct MomentSettings : ForceSettings {
  MomentSettings() { kind = LoadKind::kMoment; }
};
struct TractionSettings : ForceSettings {
  TractionSettings() { kind = LoadKind::kTraction; }
};
struct PressureSettings : ForceSettings {
  PressureSettings() { kind = LoadKind::kPressure; }
};
struct BodyForceSettings : ForceSettings {
  BodyForceSettings() { kind = LoadKind::kBodyForce; }
};

/// Calls `visit` with the load as settings of its kind, which have a table, and returns the result.
template <class Visit>
decltype(auto) visit_load(const ForceSettings& load, const Visit& visit) {
  const auto as = [&load]<class Settings>(Settings settings) {
    static_cast<ForceSettings&>(settings) = load;
    return settings;
  };
  switch (load.kind) {
    case LoadKind::kMoment:
      return visit(as(MomentSettings{}));
    case LoadKind::kTraction:
      return visit(as(TractionSettings{}));
    case LoadKind::kPressure:
      return visit(as(PressureSettings{}));
    case LoadKind::kBodyForce:
      return visit(as(BodyForceSettings{}));
    case LoadKind::kForce:
      break;
  }
  return visit(load);
}

/// The table of a settings struct. There is one for each of the types below.
template <class Settings>
const Section<Settings>& section_of();

template <>
const Section<MeshSettings>& section_of();
template <>
const Section<GeneratorSettings>& section_of();
template <>
const Section<MaterialSettings>& section_of();
template <>
const Section<MaterialRegionSettings>& section_of();
template <>
const Section<TimeSettings>& section_of();
template <>
const Section<SolverSettings>& section_of();
template <>
const Section<Damping>& section_of();
template <>
const Section<EnvironmentSettings>& section_of();
template <>
const Section<FixSettings>& section_of();
template <>
const Section<ConstraintSettings>& section_of();
template <>
const Section<ForceSettings>& section_of();
template <>
const Section<MomentSettings>& section_of();
template <>
const Section<TractionSettings>& section_of();
template <>
const Section<PressureSettings>& section_of();
template <>
const Section<BodyForceSettings>& section_of();
template <>
const Section<AmplitudeSettings>& section_of();
template <>
const Section<InitialSettings>& section_of();
template <>
const Section<MomentumSettings>& section_of();
template <>
const Section<EventSettings>& section_of();
template <>
const Section<ShiftSettings>& section_of();
template <>
const Section<OutputSettings>& section_of();
template <>
const Section<ProbeSettings>& section_of();
template <>
const Section<Selection>& section_of();
template <>
const Section<SelectPlane>& section_of();
template <>
const Section<SelectBox>& section_of();
template <>
const Section<SelectSphere>& section_of();
template <>
const Section<SelectFaces>& section_of();

/// Calls `visit(section)` for every table, in the order of docs/scene.md.
template <class Visit>
void for_each_section(const Visit& visit) {
  visit(section_of<MeshSettings>());
  visit(section_of<GeneratorSettings>());
  visit(section_of<MaterialSettings>());
  visit(section_of<MaterialRegionSettings>());
  visit(section_of<TimeSettings>());
  visit(section_of<SolverSettings>());
  visit(section_of<EnvironmentSettings>());
  visit(section_of<Damping>());
  visit(section_of<FixSettings>());
  visit(section_of<ConstraintSettings>());
  visit(section_of<ForceSettings>());
  visit(section_of<MomentSettings>());
  visit(section_of<TractionSettings>());
  visit(section_of<PressureSettings>());
  visit(section_of<BodyForceSettings>());
  visit(section_of<AmplitudeSettings>());
  visit(section_of<InitialSettings>());
  visit(section_of<MomentumSettings>());
  visit(section_of<EventSettings>());
  visit(section_of<ShiftSettings>());
  visit(section_of<OutputSettings>());
  visit(section_of<ProbeSettings>());
  visit(section_of<Selection>());
  visit(section_of<SelectPlane>());
  visit(section_of<SelectBox>());
  visit(section_of<SelectSphere>());
  visit(section_of<SelectFaces>());
}

/// What there is to say of the key that a member holds: key_info(&Damping::drag).
template <class Settings, class Value>
const KeyInfo& key_info(Value Settings::*member) {
  for (const Key<Settings>& key : section_of<Settings>().keys) {
    if (const auto* held = std::get_if<Value Settings::*>(&key.value)) {
      if (*held == member) return key.info;
    }
    if constexpr (std::is_same_v<Value, double>) {
      const auto* either = std::get_if<NumberOrAuto<Settings>>(&key.value);
      if (either != nullptr && either->number == member) return key.info;
    }
  }
  static const KeyInfo none;
  return none;
}

/// Checks values and rules as the scene reader does. Throws InputError with the key, its value and
/// the allowed values. It is instantiated for all types above.
template <class Settings>
void check_settings(const Settings& settings);

}  // namespace tetraction
