// The checks of settings that do not come from a scene file.
#include <fmt/format.h>

#include "tetraction/core/error.h"
#include "tetraction/simulation/setting_keys.h"

namespace tetraction {
namespace {

// Refuses a value of one key. Every kind of value has its own function.
template <class S>
struct ValueCheck {
  const S& settings;
  const KeyInfo& key;
  std::string name;

  void number(double value, const char* verb) const {
    const std::string refusal = key.range.refusal(value);
    if (!refusal.empty()) throw InputError(fmt::format("{} {} {}{}", name, verb, value, refusal));
  }
  void vector(const Vector3& value) const {
    for (const double entry : value) number(entry, "holds");
  }

  void operator()(int S::*member) const { number(settings.*member, "="); }
  void operator()(double S::*member) const { number(settings.*member, "="); }
  void operator()(std::optional<double> S::*member) const {
    if (settings.*member) number(*(settings.*member), "=");
  }
  void operator()(Vector3 S::*member) const { vector(settings.*member); }
  void operator()(std::optional<Vector3> S::*member) const {
    if (settings.*member) vector(*(settings.*member));
  }
  void operator()(std::array<bool, 3> S::*member) const {
    const auto& components = settings.*member;
    if (!components[0] && !components[1] && !components[2]) {
      throw InputError(name + " must name at least one of x, y and z.");
    }
  }
  void operator()(std::string S::*) const {}
  void operator()(std::array<std::int64_t, 2> S::*member) const {
    if ((settings.*member)[0] == (settings.*member)[1]) {
      throw InputError(name + " must name two different vertices, like [3, 40].");
    }
  }
  void operator()(std::vector<std::int64_t> S::*) const {}
  void operator()(std::vector<Vector3> S::*member) const {
    for (const Vector3& entry : settings.*member) vector(entry);
  }
  void operator()(bool S::*) const {}
  void operator()(std::vector<std::string> S::*) const {}
  void operator()(const Choice<S>&) const {}
  void operator()(const NumberOrAuto<S>& value) const {
    if (!(settings.*value.automatic)) number(settings.*value.number, "=");
  }
  void operator()(const NumberOrArray<S>& value) const {
    if (const std::optional<double> given = value.number(settings)) number(*given, "=");
  }
  void operator()(const VectorOrField<S>& value) const {
    const FieldSettings& field = settings.*value.field;
    if (field.empty()) vector(settings.*value.vector);
    if (!field.file.empty() && !field.formula[0].empty()) {
      throw InputError(name + " has both a file and a formula; give one of them.");
    }
  }
  void operator()(const ByHand&) const {}
};

}  // namespace

template <class S>
void check_settings(const S& settings) {
  const Section<S>& section = section_of<S>();
  for (const Key<S>& key : section.keys) {
    if (!key.is_used(settings)) continue;
    std::visit(ValueCheck<S>{settings, key.info, fmt::format("{}.{}", section.name, key.info.name)},
               key.value);
  }
  for (const KeyRule<S>& rule : section.rules) {
    const std::string conflict = rule.conflict(settings);
    if (conflict.empty()) continue;
    throw InputError(rule.keys.empty()
                         ? fmt::format("{} {}", section.name, conflict)
                         : fmt::format("{}.{} {}", section.name, rule.keys.back(), conflict));
  }
}

template void check_settings(const MeshSettings&);
template void check_settings(const GeneratorSettings&);
template void check_settings(const MaterialSettings&);
template void check_settings(const MaterialRegionSettings&);
template void check_settings(const TimeSettings&);
template void check_settings(const SolverSettings&);
template void check_settings(const Damping&);
template void check_settings(const EnvironmentSettings&);
template void check_settings(const FixSettings&);
template void check_settings(const ConstraintSettings&);
template void check_settings(const ForceSettings&);
template void check_settings(const MomentSettings&);
template void check_settings(const TractionSettings&);
template void check_settings(const PressureSettings&);
template void check_settings(const BodyForceSettings&);
template void check_settings(const AmplitudeSettings&);
template void check_settings(const InitialSettings&);
template void check_settings(const MomentumSettings&);
template void check_settings(const EventSettings&);
template void check_settings(const ShiftSettings&);
template void check_settings(const OutputSettings&);
template void check_settings(const ProbeSettings&);
template void check_settings(const Selection&);
template void check_settings(const SelectPlane&);
template void check_settings(const SelectBox&);
template void check_settings(const SelectSphere&);
template void check_settings(const SelectFaces&);

}  // namespace tetraction
