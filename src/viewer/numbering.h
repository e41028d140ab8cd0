// Numbers of forces, fixes and constraints: those that a scene's events mean, when edits by hand have
// added others in between.
#pragma once

#include <optional>
#include <vector>

#include "tetraction/simulation/session.h"

namespace tetraction::viewer {

/// How many of each a body has.
struct Counts {
  std::size_t forces = 0;
  std::size_t fixes = 0;
  std::size_t constraints = 0;
};

Counts counts_of(const Session& session);

/// Where the entries that a scene's events know by their numbers really are.
class Numbering {
 public:
  explicit Numbering(const Scene& scene);

  /// The edit of an event with the true numbers. Nothing if it changes an entry that was never
  /// added, because that edit had been refused.
  std::optional<Edit> translated(const Edit& edit) const;
  /// Enters that the (untranslated) edit was made, or `refused`, on a body of these counts before it.
  void enter(const Edit& edit, const Counts& counts, bool refused);

 private:
  using Places = std::vector<std::optional<std::size_t>>;
  Places forces_;
  Places fixes_;
  Places constraints_;
};

}  // namespace tetraction::viewer
