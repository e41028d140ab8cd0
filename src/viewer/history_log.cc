#include "history_log.h"

#include <algorithm>

namespace tetraction::viewer {

void HistoryLog::add(const HistoryRow& row) {
  if (row.step % stride_ != 0) return;
  rows_.push_back(row);
  if (rows_.size() < capacity_) return;
  stride_ *= 2;
  std::erase_if(rows_, [this](const HistoryRow& old) { return old.step % stride_ != 0; });
  ++generation_;
}

void HistoryLog::clear() {
  rows_.clear();
  stride_ = 1;
  ++generation_;
}

void HistoryLog::go_back_to(Index step) {
  const auto after = std::find_if(rows_.begin(), rows_.end(),
                                  [step](const HistoryRow& row) { return row.step > step; });
  if (after == rows_.end()) return;
  rows_.erase(after, rows_.end());
  ++generation_;
}

HistoryRow history_row(const Session& session) {
  const State& state = session.state();
  const Books& books = session.books();
  const Energies& energies = books.energies();
  HistoryRow row;
  row.step = state.step;
  row.time = state.time;
  row.kinetic = energies.kinetic();
  row.elastic = energies.elastic();
  row.environment = energies.environment();
  row.total = energies.total();
  row.external_work = books.external_work();
  row.constraint_work = books.constraint_work();
  row.dissipated_energy = books.dissipated_energy();
  row.edit_work = books.edit_work();
  row.energy_error = books.energy_error();
  row.linear_momentum = books.momenta().linear;
  row.angular_momentum = books.momenta().angular;
  row.iterations = session.last_iterations();
  return row;
}

}  // namespace tetraction::viewer
