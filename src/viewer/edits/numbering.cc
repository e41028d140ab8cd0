#include "numbering.h"

#include <algorithm>
#include <type_traits>
#include <variant>

namespace tetraction::viewer {
namespace {

ForEachList<std::size_t> counts_with(const LoadLists& loads, std::size_t fixes,
                                     std::size_t constraints, std::size_t obstacles) {
  ForEachList<std::size_t> counts{};
  for (const LoadKind kind : values_of<LoadKind>()) {
    counts[static_cast<std::size_t>(kind)] = loads.list(kind).size();
  }
  counts[list_of(FixSettings())] = fixes;
  counts[list_of(ConstraintSettings())] = constraints;
  counts[list_of(ObstacleSettings())] = obstacles;
  return counts;
}

}  // namespace

std::optional<EditedEntry> edited_entry(const Edit& edit) {
  return std::visit(
      []<class Kind>(const Kind& kind) -> std::optional<EditedEntry> {
        if constexpr (kSetsEntry<Kind>) {
          return EditedEntry{list_of(kind.entry), kind.index, !kind.index};
        } else if constexpr (std::is_same_v<Kind, Unfix>) {
          return EditedEntry{list_of(FixSettings()), kind.fix};
        } else if constexpr (std::is_same_v<Kind, RemoveConstraint>) {
          return EditedEntry{list_of(ConstraintSettings()), kind.index};
        } else if constexpr (std::is_same_v<Kind, RemoveObstacle>) {
          return EditedEntry{list_of(ObstacleSettings()), kind.index};
        } else {
          return std::nullopt;
        }
      },
      edit);
}

void set_index(Edit& edit, std::size_t index) {
  std::visit(
      [index]<class Kind>(Kind& kind) {
        if constexpr (kSetsEntry<Kind> || std::is_same_v<Kind, RemoveConstraint> ||
                      std::is_same_v<Kind, RemoveObstacle>) {
          kind.index = index;
        } else if constexpr (std::is_same_v<Kind, Unfix>) {
          kind.fix = index;
        }
      },
      edit);
}

ForEachList<std::size_t> counts_of(const Session& session) {
  return counts_with(session.loads(), session.fix_count(), session.constraints().size(),
                     session.settings().obstacles.size());
}

EntryNumbers present_entries(const Session& session) {
  EntryNumbers present;
  const ForEachList<std::size_t> counts = counts_of(session);
  const BodyConstraints& constraints = session.settings().constraints;
  const auto acts = [&](std::size_t list, std::size_t i) {
    if (list == list_of(FixSettings())) return !constraints.fixes[i].vertices.empty();
    if (list == list_of(ConstraintSettings())) return constraints.other_settings[i].has_value();
    if (list == list_of(ObstacleSettings())) return !session.settings().obstacles[i].removed;
    return true;
  };
  for (std::size_t list = 0; list < kEntryLists; ++list) {
    for (std::size_t i = 0; i < counts[list]; ++i) {
      if (acts(list, i)) present[list].push_back(i);
    }
  }
  return present;
}

bool has(const EntryNumbers& numbers, std::size_t list, std::size_t index) {
  return std::ranges::binary_search(numbers[list], index);
}

Numbering::Numbering(const Scene& scene) {
  const auto counts =
      counts_with(scene, scene.fix.size(), scene.constraint.size(), scene.obstacle.size());
  for (std::size_t list = 0; list < kEntryLists; ++list) {
    for (std::size_t i = 0; i < counts[list]; ++i) numbers_[list].emplace_back(i);
  }
}

std::optional<Edit> Numbering::translated(const Edit& edit) const {
  const std::optional<EditedEntry> entry = edited_entry(edit);
  if (!entry || !entry->index) return edit;
  const auto& numbers = numbers_[entry->list];
  if (*entry->index >= numbers.size() || !numbers[*entry->index]) return std::nullopt;
  Edit result = edit;
  set_index(result, *numbers[*entry->index]);
  return result;
}

void Numbering::record_edit(const Edit& edit, const ForEachList<std::size_t>& counts,
                            bool refused) {
  const std::optional<EditedEntry> entry = edited_entry(edit);
  if (!entry || !entry->adds) return;
  numbers_[entry->list].push_back(refused ? std::nullopt : std::optional(counts[entry->list]));
}

}  // namespace tetraction::viewer
