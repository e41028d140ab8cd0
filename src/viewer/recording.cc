#include "recording.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <span>
#include <utility>

#include "tetraction/core/error.h"
#include "viewer/edits/event_edits.h"

namespace tetraction::viewer {
namespace {

// Stores the settings of an edit of a section. Edits of other kinds have no effect.
struct ApplyToSections {
  Settings& settings;
  void operator()(const SetMaterial& edit) const {
    settings.materials.at(static_cast<std::size_t>(edit.region)) = edit.material;
  }
  template <class Section>
  void operator()(const SetSection<Section>& edit) const {
    settings.section<Section>() = edit.settings;
  }
  template <class Other>
  void operator()(const Other&) const {}
};

bool uses(const Selection& selection, const std::string& name) {
  const auto any = [&](const std::vector<SelectionPart>& parts) {
    return std::ranges::any_of(
        parts, [&](const SelectionPart& part) { return uses(part.selection, name); });
  };
  if (const auto* set = std::get_if<SelectSet>(&selection)) return any(set->of);
  const auto* named = std::get_if<SelectNamed>(&selection);
  return named != nullptr && (named->name == name || any(named->of));
}

// Whether an edit has a selection with this name.
bool uses(const Edit& edit, const std::string& name) {
  return std::visit(
      [&]<class Kind>(const Kind& kind) {
        if constexpr (requires { kind.entry.select; }) return uses(kind.entry.select, name);
        if constexpr (requires { kind.select; }) return uses(kind.select, name);
        if constexpr (requires { kind.change.select; }) return uses(kind.change.select, name);
        return false;
      },
      edit);
}

}  // namespace

Recording::Recording(const Scene& scene)
    : data_{.start = scene, .entries = {}, .numbering = Numbering(scene)} {}

Recording::Data Recording::data() const {
  const std::lock_guard lock(mutex_);
  return data_;
}

void Recording::restore(Data data) {
  const std::lock_guard lock(mutex_);
  data_ = std::move(data);
}

void Recording::begin(const Scene& scene) {
  const std::lock_guard lock(mutex_);
  data_ = {.start = scene, .entries = {}, .numbering = Numbering(scene)};
}

std::size_t Recording::entry_count() const {
  const std::lock_guard lock(mutex_);
  return data_.entries.size();
}

void Recording::add(const NamedSelection& named) {
  const std::lock_guard lock(mutex_);
  const auto known = std::ranges::find(data_.start.selection, named.name, &NamedSelection::name);
  if (known == data_.start.selection.end()) {
    data_.start.selection.push_back(named);
  } else if (!(known->select == named.select)) {
    throw InputError(fmt::format(
        "The name \"{}\" was used in this run already: choose another one.", named.name));
  }
}

void Recording::remove(const NamedSelection& named) {
  const std::lock_guard lock(mutex_);
  const bool is_needed = std::ranges::any_of(
      data_.entries, [&](const Entry& entry) { return uses(entry.edit, named.name); });
  if (is_needed) return;
  std::erase_if(data_.start.selection,
                [&](const NamedSelection& other) { return other.name == named.name; });
}

void Recording::add(const Session& session, const Edit& edit, const std::string& note,
                    bool by_user) {
  const std::lock_guard lock(mutex_);
  data_.entries.push_back(
      {session.step_number(), session.time(), session.time_step(), edit, note, by_user});
  data_.counts = counts_of(session);
  data_.present = present_entries(session);
}

void Recording::move_to(const Session& session) {
  const std::lock_guard lock(mutex_);
  data_.step = session.step_number();
  data_.time = session.time();
  data_.counts = counts_of(session);
  data_.present = present_entries(session);
  if (data_.entries.empty()) data_.first_time_step = session.time_step();
}

void Recording::set_events_made(std::size_t count, const Numbering& numbering) {
  const std::lock_guard lock(mutex_);
  data_.events_made = count;
  data_.numbering = numbering;
}

Scene Recording::scene() const {
  const std::lock_guard lock(mutex_);
  Scene scene = data_.start;
  // A scene file must have an end.
  if (std::isinf(scene.time.end)) scene.time.end = TimeSettings{}.end;
  scene.event.clear();
  for (const Entry& entry : data_.entries) {
    EventSettings event;
    event.at = entry.time;
    event.edits = {entry.edit};
    event.note = entry.note;
    event.echo = nlohmann::ordered_json{{"at", entry.time}, {"note", entry.note}}.dump(
        -1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
    scene.event.push_back(std::move(event));
  }
  set_ends(scene);
  add_events_to_come(scene);
  return scene;
}

// Sets time.end such that the replay ends at the present time. An edit of the time settings contains an
// end, too. It must not be before the edits that follow.
void Recording::set_ends(Scene& scene) const {
  double* end = &scene.time.end;
  if (data_.step == 0) {
    for (std::size_t i = 0; i < data_.entries.size(); ++i) {
      if (auto* set = std::get_if<SetTime>(&scene.event[i].edits.front())) set->settings.end = *end;
    }
    return;
  }
  double time_step = data_.first_time_step;
  for (std::size_t i = 0; i < data_.entries.size(); ++i) {
    auto* set = std::get_if<SetTime>(&scene.event[i].edits.front());
    if (set == nullptr) continue;
    if (data_.entries[i].step == data_.step) {  // no step was made after this edit
      set->settings.end = data_.time + data_.entries[i].time_step;
      continue;
    }
    *end = data_.time + time_step;
    end = &set->settings.end;
    time_step = data_.entries[i].time_step;
  }
  *end = data_.time;
}

// The settings of the sections after all edits so far.
Settings Recording::present_settings() const {
  Settings present;
  static_cast<ChangeableSections&>(present) = data_.start;
  present.materials.push_back(data_.start.material);
  for (const MaterialRegionSettings& region : data_.start.material_region) {
    present.materials.push_back(region.material);
  }
  for (const Entry& entry : data_.entries) std::visit(ApplyToSections{present}, entry.edit);
  return present;
}

void Recording::add_events_to_come(Scene& scene) const {
  Numbering numbering = data_.numbering;
  ForEachList<std::size_t> counts = data_.counts;
  Settings present = present_settings();
  for (std::size_t i = data_.events_made; i < data_.start.event.size(); ++i) {
    EventSettings event = data_.start.event[i];
    event.at = std::max(event.at, scene.event.empty() ? event.at : scene.event.back().at);
    event.edits.clear();
    for (const Edit& edit : data_.start.event[i].edits) {
      std::optional<Edit> translated = numbering.translated(edit);
      if (translated && changes_what_was_removed(edit, *translated, data_.present,
                                                 std::span(data_.start.event).first(i + 1))) {
        translated.reset();
      }
      if (translated && !data_.entries.empty()) {
        translated = with_present_settings(*translated, data_.start.event[i], present);
      }
      numbering.record_edit(edit, counts, false);
      const std::optional<EditedEntry> entry = edited_entry(edit);
      if (entry && entry->adds) ++counts[entry->list];
      if (translated) {
        std::visit(ApplyToSections{present}, *translated);
        event.edits.push_back(*translated);
      }
    }
    if (!event.edits.empty()) scene.event.push_back(std::move(event));
  }
}

}  // namespace tetraction::viewer
