// The lists of loads, fixes, constraints and obstacles, to which edits add entries. The user may have added some,
// so that entries of later events have other numbers than in the scene.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "tetraction/simulation/session.h"

namespace tetraction::viewer {

inline constexpr std::size_t kLoadKinds = EnumNames<LoadKind>::names.size();
/// The loads of each kind, the fixes, the constraints, and the obstacles.
inline constexpr std::size_t kEntryLists = kLoadKinds + 3;
template <class Value>
using ForEachList = std::array<Value, kEntryLists>;

/// The number of a list.
inline std::size_t list_of(const ForceSettings& load) {
  return static_cast<std::size_t>(load.kind);
}
inline std::size_t list_of(const FixSettings&) {
  return kLoadKinds;
}
inline std::size_t list_of(const ConstraintSettings&) {
  return kLoadKinds + 1;
}
inline std::size_t list_of(const ObstacleSettings&) {
  return kLoadKinds + 2;
}

/// The list that an edit changes, and the entry.
struct EditedEntry {
  std::size_t list = 0;
  std::optional<std::size_t> index;  ///< none if the edit adds one, or is for all of them
  bool adds = false;
};
/// No value if the edit changes no entry of a list.
std::optional<EditedEntry> edited_entry(const Edit& edit);
/// Sets the number of the entry that an edit changes.
void set_index(Edit& edit, std::size_t index);

/// The number of entries that a body has.
ForEachList<std::size_t> counts_of(const Session& session);

/// Numbers of entries.
using EntryNumbers = ForEachList<std::vector<std::size_t>>;
/// The entries that act: all loads, fixes that hold vertices, constraints and obstacles that are not removed.
EntryNumbers present_entries(const Session& session);
bool has(const EntryNumbers& numbers, std::size_t list, std::size_t index);

/// Maps the indices in a scene's events to the actual indices of the entries.
class Numbering {
 public:
  explicit Numbering(const Scene& scene);

  /// The edit of an event with the actual indices. No value if the edit changes an entry that does not
  /// exist because the edit that should have added it was refused.
  std::optional<Edit> translated(const Edit& edit) const;
  /// Must be called for every edit of an event, with the untranslated indices, after it was made or
  /// `refused`. The counts are those before the edit.
  void record_edit(const Edit& edit, const ForEachList<std::size_t>& counts, bool refused);

 private:
  // No value for an entry whose edit was refused.
  ForEachList<std::vector<std::optional<std::size_t>>> numbers_;
};

}  // namespace tetraction::viewer
