#include "recording.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "event_edits.h"

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

}  // namespace

Recording::Recording(Scene scene) : start_(std::move(scene)), numbering_(start_) {}

void Recording::begin(const Scene& scene) {
  const std::lock_guard lock(mutex_);
  start_ = scene;
  entries_.clear();
  step_ = 0;
  time_ = 0.0;
  events_made_ = 0;
  numbering_ = Numbering(start_);
}

void Recording::add(const Session& session, const Edit& edit, const std::string& note) {
  const std::lock_guard lock(mutex_);
  entries_.push_back({session.step_number(), session.time(), session.time_step(), edit, note});
  counts_ = counts_of(session);
}

void Recording::move_to(const Session& session) {
  const std::lock_guard lock(mutex_);
  step_ = session.step_number();
  time_ = session.time();
  counts_ = counts_of(session);
  if (entries_.empty()) first_time_step_ = session.time_step();
}

void Recording::set_events_made(std::size_t count, const Numbering& numbering) {
  const std::lock_guard lock(mutex_);
  events_made_ = count;
  numbering_ = numbering;
}

Scene Recording::scene() const {
  const std::lock_guard lock(mutex_);
  Scene scene = start_;
  scene.event.clear();
  for (const Entry& entry : entries_) {
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
  if (step_ == 0) {
    for (std::size_t i = 0; i < entries_.size(); ++i) {
      if (auto* set = std::get_if<SetTime>(&scene.event[i].edits.front())) set->settings.end = *end;
    }
    return;
  }
  double time_step = first_time_step_;
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    auto* set = std::get_if<SetTime>(&scene.event[i].edits.front());
    if (set == nullptr) continue;
    if (entries_[i].step == step_) {  // no step was made after this edit
      set->settings.end = time_ + entries_[i].time_step;
      continue;
    }
    *end = time_ + time_step;
    end = &set->settings.end;
    time_step = entries_[i].time_step;
  }
  *end = time_;
}

// The settings of the sections after all edits so far.
Settings Recording::present_settings() const {
  Settings present;
  static_cast<ChangeableSections&>(present) = start_;
  present.materials.push_back(start_.material);
  for (const MaterialRegionSettings& region : start_.material_region) {
    present.materials.push_back(region.material);
  }
  for (const Entry& entry : entries_) std::visit(ApplyToSections{present}, entry.edit);
  return present;
}

void Recording::add_events_to_come(Scene& scene) const {
  Numbering numbering = numbering_;
  ForEachList<std::size_t> counts = counts_;
  Settings present = present_settings();
  for (std::size_t i = events_made_; i < start_.event.size(); ++i) {
    EventSettings event = start_.event[i];
    event.at = std::max(event.at, scene.event.empty() ? event.at : scene.event.back().at);
    event.edits.clear();
    for (const Edit& edit : start_.event[i].edits) {
      std::optional<Edit> translated = numbering.translated(edit);
      if (translated && !entries_.empty()) {
        translated = with_present_settings(*translated, start_.event[i], present);
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
