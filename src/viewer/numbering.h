// Translates the indices of loads, fixes and constraints in the events of a scene. The user may have
// added entries, so that entries of later events have other indices than in the scene.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "tetraction/simulation/session.h"

namespace tetraction::viewer {

/// The number of entries of each kind that a body has.
struct Counts {
  std::array<std::size_t, 5> loads{};  ///< of each kind of load

  std::size_t& of(LoadKind kind) { return loads[static_cast<std::size_t>(kind)]; }
  std::size_t of(LoadKind kind) const { return loads[static_cast<std::size_t>(kind)]; }
  std::size_t fixes = 0;
  std::size_t constraints = 0;
};

Counts counts_of(const Session& session);

/// Maps the indices in a scene's events to the actual indices of the entries.
class Numbering {
 public:
  explicit Numbering(const Scene& scene);

  /// The edit of an event with the actual indices. No value if the edit changes an entry that does not
  /// exist because the edit that should have added it was refused.
  std::optional<Edit> translated(const Edit& edit) const;
  /// Must be called for every edit of an event, with the untranslated indices, after it was made or
  /// `refused`. The counts are those before the edit.
  void record_edit(const Edit& edit, const Counts& counts, bool refused);

 private:
  using EntryNumbers = std::vector<std::optional<std::size_t>>;
  EntryNumbers& numbers_of(LoadKind kind) { return loads_[static_cast<std::size_t>(kind)]; }
  const EntryNumbers& numbers_of(LoadKind kind) const {
    return loads_[static_cast<std::size_t>(kind)];
  }

  std::array<EntryNumbers, 5> loads_;  // of each kind of load
  EntryNumbers fixes_;
  EntryNumbers constraints_;
};

}  // namespace tetraction::viewer
