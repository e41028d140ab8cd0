#include "event_edits.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <type_traits>

#include "edit_check.h"
#include "tetraction/core/error.h"
#include "tetraction/simulation/setting_keys.h"

namespace tetraction::viewer {
namespace {

// The keys of a section that an event sets or unsets. No value if the event does not say which.
std::optional<std::set<std::string>> named_keys(const EventSettings& event,
                                                const std::string& section) {
  if (event.echo.empty()) return std::nullopt;
  const auto echo = nlohmann::json::parse(event.echo, nullptr, false);
  if (!echo.is_object() || !(echo.contains("set") || echo.contains("unset"))) return std::nullopt;
  std::set<std::string> names;
  const auto add = [&](const std::string& key) {
    if (key.starts_with(section + ".")) names.insert(key.substr(section.size() + 1));
  };
  if (echo.contains("set")) {
    for (const auto& [key, value] : echo.at("set").items()) add(key);
  }
  if (echo.contains("unset")) {
    for (const auto& key : echo.at("unset")) add(key.get<std::string>());
  }
  return names;
}

// Copies the value of a key. Returns false for a key whose value is not in one member of its own.
template <class Settings>
bool copy_value(const KeyValue<Settings>& value, const Settings& from, Settings& to) {
  const auto copy = [&](const auto& place) {
    using Place = std::decay_t<decltype(place)>;
    if constexpr (std::is_member_pointer_v<Place>) {
      to.*place = from.*place;
      return true;
    } else if constexpr (std::is_same_v<Place, NumberOrAuto<Settings>>) {
      to.*place.number = from.*place.number;
      to.*place.automatic = from.*place.automatic;
      return true;
    } else if constexpr (std::is_same_v<Place, NumberOrArray<Settings>>) {
      std::visit([&](auto at) { to.*at = from.*at; }, place.member);
      (to.*place.arrays).erase(place.name);
      if (const std::string array = place.array(from); !array.empty()) place.set(to, array);
      return true;
    } else if constexpr (std::is_same_v<Place, Choice<Settings>>) {
      const std::string name = place.get(from);
      if (!name.empty()) place.set(to, name);
      return !name.empty();
    } else {
      return false;
    }
  };
  return std::visit(copy, value);
}

// `present` with the values of the named keys of `wanted`. No value if a name is not that of a key with a
// value in one member.
template <class Settings>
std::optional<Settings> merged(const Settings& wanted, const Settings& present,
                               const std::set<std::string>& names) {
  Settings result = present;
  std::size_t copied = 0;
  for (const Key<Settings>& key : section_of<Settings>().keys) {
    if (names.count(key.info.name) > 0 && copy_value(key.value, wanted, result)) ++copied;
  }
  return copied == names.size() ? std::optional(result) : std::nullopt;
}

struct Merge {
  const EventSettings& event;
  const Settings& present;

  template <class Part>
  void part(const char* section, Part& wanted, const Part& now) const {
    const auto names = named_keys(event, section);
    if (!names) return;
    if (const std::optional<Part> both = merged(wanted, now, *names)) wanted = *both;
  }

  void operator()(SetTime& edit) const { part("time", edit.time, present.time); }
  void operator()(SetSolver& edit) const { part("solver", edit.solver, present.solver); }
  void operator()(SetDamping& edit) const { part("damping", edit.damping, present.damping); }
  void operator()(SetEnvironment& edit) const {
    part("environment", edit.environment, present.environment);
  }
  void operator()(SetMaterial& edit) const {
    const auto region = static_cast<std::size_t>(edit.region);
    if (region >= present.materials.size() || present.materials[region].custom) return;
    const std::string section =
        region == 0 ? "material" : fmt::format("material_region.{}", region - 1);
    part(section.c_str(), edit.material, present.materials[region]);
    check_material(edit.material);  // throws if the named parameters do not go with the others
  }
  template <class Other>
  void operator()(Other&) const {}
};

}  // namespace

Edit with_present_settings(const Edit& edit, const EventSettings& event, const Settings& present) {
  Edit result = edit;
  try {
    std::visit(Merge{event, present}, result);
    Edit checked = result;
    check_edit(checked);
    return result;
  } catch (const InputError&) {
    return edit;
  }
}

}  // namespace tetraction::viewer
