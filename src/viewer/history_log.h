// The history of a run in a table of bounded size.
#pragma once

#include <vector>

#include "snapshot.h"

namespace tetraction::viewer {

/// Rows in the order of their steps. When there are `capacity` rows, every second row is removed, and
/// from then on only half as many steps are stored. The size is therefore bounded in runs of any
/// length.
class HistoryLog {
 public:
  explicit HistoryLog(std::size_t capacity = 1U << 20U) : capacity_(capacity) {}

  void add(const HistoryRow& row);
  /// Removes all rows.
  void clear();
  /// Takes the rows of another log, for instance those before a restart.
  void replace_by(HistoryLog other);
  /// Removes the rows after a step.
  void go_back_to(Index step);

  const std::vector<HistoryRow>& rows() const { return rows_; }
  /// A counter that increases each time rows are removed.
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
