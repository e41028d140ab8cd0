#include "tetraction/simulation/event_settings.h"

#include <fmt/format.h>

#include <optional>
#include <utility>
#include <variant>

#include "body_constraints.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

[[noreturn]] void refuse() {
  throw InputError("An event of the scene changes something that does not exist.");
}

// Replaces the entry with that number, or adds one.
template <class List, class Entry>
void set_entry(List& list, std::optional<std::size_t> index, const Entry& entry) {
  if (!index) {
    list.emplace_back(entry);
    return;
  }
  if (*index >= list.size()) refuse();
  list[*index] = entry;
}

// The effect of the edits of session_edits.cc on the settings alone.
struct SettingsEditor {
  RunSettings& settings;
  BodyConstraints& constraints = settings.constraints;

  void operator()(const SetMaterial& edit) {
    if (edit.region < 0 || edit.region >= static_cast<Index>(settings.materials.size())) refuse();
    settings.materials[static_cast<std::size_t>(edit.region)] = edit.material;
  }
  template <class Section>
  void operator()(const SetSection<Section>& edit) {
    settings.section<Section>() = edit.settings;
  }
  void operator()(const SetForce& edit) {
    set_entry(settings.loads.list(edit.entry.kind), edit.index, edit.entry);
  }
  void operator()(const SetFix& edit) {
    set_entry(constraints.fix_settings, edit.index, edit.entry);
  }
  void operator()(const SetConstraint& edit) {
    set_entry(constraints.other_settings, edit.index, edit.entry);
  }
  void operator()(const RemoveConstraint& edit) {
    if (edit.index >= constraints.other_settings.size()) refuse();
    constraints.other_settings[edit.index].reset();
  }
  void operator()(const SetObstacle& edit) {
    set_entry(settings.obstacles, edit.index, BodyObstacle{edit.entry});
  }
  void operator()(const RemoveObstacle& edit) {
    if (edit.index >= settings.obstacles.size()) refuse();
    settings.obstacles[edit.index].removed = true;
  }
  // They change the state, or the objects of constraints.
  void operator()(const Unfix&) {}
  template <class Change>
  void operator()(const ChangeState<Change>&) {}
};

// Whether the object is one that make_constraint() makes of such settings.
bool fits(const ConstraintObject& object, const std::optional<ConstraintSettings>& settings) {
  if (!settings) {
    const auto* removed = std::get_if<PrescribedVertices>(&object);
    return removed != nullptr && removed->vertices.empty();
  }
  switch (settings->kind) {
    case ConstraintKind::kDistance:
      return std::holds_alternative<FixedDistance>(object);
    case ConstraintKind::kPlane:
    case ConstraintKind::kLine:
      return std::holds_alternative<GuidedVertices>(object);
    case ConstraintKind::kRigid:
      break;
  }
  return settings->is_driven() ? std::holds_alternative<PrescribedVertices>(object)
                               : std::holds_alternative<RigidHandle>(object);
}

}  // namespace

RunSettings initial_settings(const Scene& scene) {
  RunSettings settings;
  static_cast<ChangeableSections&>(settings) = scene;
  settings.materials.push_back(scene.material);
  for (const MaterialRegionSettings& region : scene.material_region) {
    settings.materials.push_back(region.material);
  }
  settings.loads = scene;
  for (const ObstacleSettings& obstacle : scene.obstacle) {
    settings.obstacles.push_back({obstacle});
  }
  return settings;
}

RunSettings settings_after_events(const Scene& scene, std::size_t event_count) {
  RunSettings settings = initial_settings(scene);
  settings.constraints.fix_settings = scene.fix;
  for (const ConstraintSettings& constraint : scene.constraint) {
    settings.constraints.other_settings.emplace_back(constraint);
  }
  if (event_count > scene.event.size()) {
    throw InputError(
        fmt::format("{} events were made, and the scene has {}.", event_count, scene.event.size()));
  }
  for (std::size_t i = 0; i < event_count; ++i) {
    for (const Edit& edit : scene.event[i].edits) std::visit(SettingsEditor{settings}, edit);
  }
  return settings;
}

void complete_constraints(const Scene& scene, RunSettings& settings) {
  BodyConstraints& constraints = settings.constraints;
  const auto require = [](bool fits) {
    if (!fits) {
      throw InputError("The [[fix]] and [[constraint]] of the run are not those of the scene.");
    }
  };
  require(constraints.fixes.size() == constraints.fix_settings.size() &&
          constraints.others.size() == constraints.other_settings.size());
  for (std::size_t i = 0; i < constraints.fixes.size(); ++i) {
    const FixSettings& fix = constraints.fix_settings[i];
    PrescribedVertices& held = constraints.fixes[i];
    held.name = fix.where;
    held.motion.offset_amplitude = find_amplitude(scene.amplitude, fix.amplitude, fix.where);
  }
  for (std::size_t i = 0; i < constraints.others.size(); ++i) {
    ConstraintObject& object = constraints.others[i];
    std::optional<ConstraintSettings>& constraint = constraints.other_settings[i];
    require(fits(object, constraint));
    if (!constraint) continue;
    std::visit([&](auto& o) { o.name = constraint->where; }, object);
    if (auto* driven = std::get_if<PrescribedVertices>(&object)) {
      driven->motion.velocity_amplitude =
          find_amplitude(scene.amplitude, constraint->amplitude, constraint->where);
    }
    constraint = with_length(*std::move(constraint), object);
  }
}

}  // namespace tetraction
