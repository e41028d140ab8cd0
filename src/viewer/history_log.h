// The numbers of all steps, of bounded size.
#pragma once

#include <vector>

#include "snapshot.h"

namespace tetraction::viewer {

/// Rows in the order of their steps. When there are `capacity` of them, every second one goes, and
/// from then on only every second step of before is kept: a run may go on for days.
class HistoryLog {
 public:
  explicit HistoryLog(std::size_t capacity = 1U << 20U) : capacity_(capacity) {}

  void add(const HistoryRow& row);
  /// Forgets everything.
  void clear();
  /// Forgets the rows after a step.
  void go_back_to(Index step);

  const std::vector<HistoryRow>& rows() const { return rows_; }
  /// One more for each time that rows were taken out.
  std::size_t generation() const { return generation_; }

 private:
  std::size_t capacity_;
  Index stride_ = 1;
  std::size_t generation_ = 0;
  std::vector<HistoryRow> rows_;
};

/// The row of a session's present state.
HistoryRow history_row(const Session& session);

}  // namespace tetraction::viewer
