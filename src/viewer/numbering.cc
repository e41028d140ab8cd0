#include "numbering.h"

namespace tetraction::viewer {
namespace {

std::vector<std::optional<std::size_t>> initial_numbers(std::size_t count) {
  std::vector<std::optional<std::size_t>> numbers;
  for (std::size_t i = 0; i < count; ++i) numbers.emplace_back(i);
  return numbers;
}

std::optional<std::size_t> number_of_entry(const std::vector<std::optional<std::size_t>>& numbers,
                                           std::size_t number) {
  return number < numbers.size() ? numbers[number] : std::nullopt;
}

}  // namespace

Counts counts_of(const Session& session) {
  Counts counts{{}, session.fix_count(), session.constraints().size()};
  for (const LoadKind kind : values_of<LoadKind>())
    counts.of(kind) = session.loads().list(kind).size();
  return counts;
}

Numbering::Numbering(const Scene& scene)
    : fixes_(initial_numbers(scene.fix.size())),
      constraints_(initial_numbers(scene.constraint.size())) {
  for (const LoadKind kind : values_of<LoadKind>()) {
    numbers_of(kind) = initial_numbers(scene.list(kind).size());
  }
}

std::optional<Edit> Numbering::translated(const Edit& edit) const {
  Edit result = edit;
  // Replaces `number`. Returns false if the entry does not exist.
  const auto translate = [](const auto& numbers, std::optional<std::size_t>& number) {
    if (!number) return true;
    number = number_of_entry(numbers, *number);
    return number.has_value();
  };
  bool known = true;
  if (auto* set = std::get_if<SetForce>(&result)) {
    known = translate(numbers_of(set->entry.kind), set->index);
  }
  if (auto* fix = std::get_if<SetFix>(&result)) known = translate(fixes_, fix->index);
  if (auto* unfix = std::get_if<Unfix>(&result)) known = translate(fixes_, unfix->fix);
  if (auto* set = std::get_if<SetConstraint>(&result)) known = translate(constraints_, set->index);
  if (auto* removed = std::get_if<RemoveConstraint>(&result)) {
    std::optional<std::size_t> number = removed->index;
    known = translate(constraints_, number);
    removed->index = number.value_or(0);
  }
  return known ? std::optional(result) : std::nullopt;
}

void Numbering::record_edit(const Edit& edit, const Counts& counts, bool refused) {
  const auto add = [refused](auto& numbers, std::size_t count) {
    numbers.push_back(refused ? std::nullopt : std::optional(count));
  };
  if (const auto* set = std::get_if<SetForce>(&edit); set != nullptr && !set->index) {
    add(numbers_of(set->entry.kind), counts.of(set->entry.kind));
  }
  if (const auto* fix = std::get_if<SetFix>(&edit); fix != nullptr && !fix->index) {
    add(fixes_, counts.fixes);
  }
  if (const auto* set = std::get_if<SetConstraint>(&edit); set != nullptr && !set->index) {
    add(constraints_, counts.constraints);
  }
}

}  // namespace tetraction::viewer
