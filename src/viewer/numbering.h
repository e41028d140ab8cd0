// Translates the numbers of forces, fixes and constraints in a scene's events. Edits by hand may
// have added entries in between, so that the numbers have shifted.
#pragma once

#include <optional>
#include <vector>

#include "tetraction/simulation/session.h"

namespace tetraction::viewer {

/// The number of entries of each kind that a body has.
struct Counts {
  std::size_t forces = 0;
  std::size_t fixes = 0;
  std::size_t constraints = 0;
};

Counts counts_of(const Session& session);

/// Maps the numbers in a scene's events to the true numbers of the entries.
class Numbering {
 public:
  explicit Numbering(const Scene& scene);

  /// The edit of an event with the true numbers. Nothing if the edit changes an entry that does not
  /// exist because the edit that would have added it was refused.
  std::optional<Edit> translated(const Edit& edit) const;
  /// Records that the (untranslated) edit was made, or `refused`. The counts are those of the body
  /// before the edit.
  void enter(const Edit& edit, const Counts& counts, bool refused);

 private:
  using Places = std::vector<std::optional<std::size_t>>;
  Places forces_;
  Places fixes_;
  Places constraints_;
};

}  // namespace tetraction::viewer
