#include "history_log.h"

#include <algorithm>
#include <utility>

#include "tetraction/simulation/probe.h"

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

void HistoryLog::replace_by(HistoryLog other) {
  other.generation_ = std::max(generation_, other.generation_) + 1;
  *this = std::move(other);
}

void HistoryLog::go_back_to(Index step) {
  const auto after = std::find_if(rows_.begin(), rows_.end(),
                                  [step](const HistoryRow& row) { return row.step > step; });
  if (after == rows_.end()) return;
  rows_.erase(after, rows_.end());
  ++generation_;
}

HistoryRow history_row(const Session& session) {
  const Balance& balance = session.balance();
  const Energies& energies = balance.energies();
  HistoryRow row;
  row.step = session.step_number();
  row.time = session.time();
  row.kinetic = energies.kinetic();
  row.elastic = energies.elastic();
  row.environment = energies.environment();
  row.total = energies.total();
  row.external_work = balance.external_work();
  row.constraint_work = balance.constraint_work();
  row.dissipated_energy = balance.dissipated_energy();
  row.edit_work = balance.edit_work();
  row.energy_error = balance.energy_error();
  row.linear_momentum = balance.momenta().linear;
  row.angular_momentum = balance.momenta().angular;
  row.iterations = session.last_iterations();
  row.probes.resize(session.probes().value_count());
  session.probes().evaluate(session, row.probes.data());
  return row;
}

}  // namespace tetraction::viewer
