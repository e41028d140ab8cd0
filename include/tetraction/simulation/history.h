// The numbers that a run tells after each step, by name: the columns of history.csv.
#pragma once

#include <string>
#include <vector>

#include "tetraction/simulation/session.h"

namespace tetraction {

/// The columns of the history of a session: step, time, the terms of the balance, reactions, and what
/// its scene adds to them (docs/outputs.md has them all with their units). Which columns there are is
/// settled when the object is made, because an event may change the settings that they depend on.
class HistoryColumns {
 public:
  explicit HistoryColumns(const Session& session);

  const std::vector<std::string>& names() const { return names_; }
  /// The present values of the session, one for each name. The session must be the one of the
  /// constructor, or a session of the same scene.
  std::vector<double> values(const Session& session) const;

 private:
  bool has_inverted_ = false;
  bool has_repeated_ = false;
  std::vector<std::string> names_;
  std::vector<double StepControl::*> adaptation_values_;  // the last columns
};

}  // namespace tetraction
