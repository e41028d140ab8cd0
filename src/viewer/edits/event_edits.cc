#include "event_edits.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <string>

#include "simulation/scene/setting_keys.h"
#include "tetraction/core/error.h"

namespace tetraction::viewer {
namespace {

// The keys of a section that an event sets or unsets. No value if the event does not say which.
std::optional<std::set<std::string>> named_keys(const EventSettings& event,
                                                const std::string& section) {
  if (event.changed_keys.empty()) return std::nullopt;
  std::set<std::string> names;
  for (const std::string& key : event.changed_keys) {
    if (key.starts_with(section + ".")) names.insert(key.substr(section.size() + 1));
  }
  return names;
}

// `present` with the values of the named keys of `wanted`. No value if a name is not that of a key
// whose value can be copied by itself.
template <class Settings>
std::optional<Settings> merged(const Settings& wanted, const Settings& present,
                               const std::set<std::string>& names) {
  Settings result = present;
  for (const std::string& name : names) {
    // The entry of a list, such as "mu.0", is copied with the list.
    const SceneKey* key = section_of<Settings>().find(name.substr(0, name.find('.')));
    if (key == nullptr || !key->value->copy(&wanted, &result)) return std::nullopt;
  }
  return result;
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

  template <class Section>
  void operator()(SetSection<Section>& edit) const {
    part(section_of<Section>().name, edit.settings, present.section<Section>());
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

struct Check {
  void operator()(SetMaterial&) const {}  // make_material() checks the values
  void operator()(SetTime& edit) const {
    TimeSettings time = edit.settings;
    if (std::isinf(time.end)) time.end = TimeSettings{}.end;  // runs in a window have no end
    check_settings(time);
  }
  void operator()(SetEnvironment& edit) const {
    check_settings(edit.settings);
    edit.settings.direction = unit_direction(edit.settings.direction);
  }
  template <class Section>
  void operator()(SetSection<Section>& edit) const {
    check_settings(edit.settings);
  }
  template <class Entry>
  void operator()(SetEntry<Entry>& edit) const {
    check_selection(edit.entry.select);
    check_settings(edit.entry);
  }
  void operator()(Unfix& edit) const { check_selection(edit.select); }
  void operator()(RemoveConstraint&) const {}
  void operator()(RemoveObstacle&) const {}
  template <class Change>
  void operator()(ChangeState<Change>& edit) const {
    if constexpr (requires { edit.change.select; }) check_selection(edit.change.select);
    check_settings(edit.change);
  }
};

}  // namespace

void check_edit(Edit& edit) {
  std::visit(Check{}, edit);
}

bool changes_what_was_removed(const Edit& edit, const Edit& translated, const EntryNumbers& present,
                              std::span<const EventSettings> earlier) {
  const std::optional<EditedEntry> wanted = edited_entry(translated);
  const bool sets =
      std::visit([]<class Kind>(const Kind&) { return kSetsEntry<Kind>; }, translated);
  if (!sets || !wanted || !wanted->index || has(present, wanted->list, *wanted->index)) {
    return false;
  }
  const std::size_t number = *edited_entry(edit)->index;
  const auto removes = [&](const Edit& other) {
    const std::optional<EditedEntry> entry = edited_entry(other);
    const bool is_removal = std::holds_alternative<Unfix>(other) ||
                            std::holds_alternative<RemoveConstraint>(other) ||
                            std::holds_alternative<RemoveObstacle>(other);
    return is_removal && entry->list == wanted->list && entry->index.value_or(number) == number;
  };
  return std::ranges::none_of(earlier, [&](const EventSettings& event) {
    return std::ranges::any_of(event.edits, removes);
  });
}

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
