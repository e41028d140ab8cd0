// Earlier states of a run, from which it can go on.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "tetraction/dynamics/balance.h"
#include "tetraction/dynamics/state.h"
#include "tetraction/simulation/run_settings.h"
#include "viewer/edits/numbering.h"

namespace tetraction::viewer {

/// What holds from one edit to the next.
struct KeptSettings {
  RunSettings settings;
  std::vector<std::uint8_t> fixed;  ///< prescribed_vertices()
  std::size_t edits = 0;            ///< of the session
  std::size_t recorded = 0;         ///< entries of the recording
  std::size_t events_made = 0;
  Numbering numbering;
  double end = 0.0;             ///< time.end of the scene or of its events so far, s
  EntryNumbers undone_loads{};  ///< of the EditHistory
};

/// A state with all that a run needs to go on from it. Only the state takes much memory; the settings
/// are shared.
struct KeptState {
  State state;
  BalanceSums balance;
  double time_step = 0.0;  ///< s
  std::shared_ptr<const KeptSettings> settings;
};

/// Kept states in the order of their steps. If they take more memory than allowed, every second one is
/// removed, and from then on only half as many steps are kept. They therefore cover the whole run.
class KeptStates {
 public:
  static constexpr std::size_t kBudget = 300'000'000;  ///< bytes
  explicit KeptStates(std::size_t budget = kBudget) : budget_(budget) {}

  /// Whether the state of this step is to be kept.
  bool wants(Index step) const { return step % stride_ == 0; }
  void add(std::shared_ptr<const KeptState> state);
  /// Removes the states after a step.
  void go_back_to(Index step);
  /// The one nearest to a time, s. Null if there is none.
  std::shared_ptr<const KeptState> nearest(double time) const;
  /// Their times, s, in ascending order.
  std::vector<double> times() const;
  std::size_t size() const { return states_.size(); }
  std::size_t budget() const { return budget_; }
  /// An estimate of the memory that they take.
  std::size_t bytes() const { return bytes_; }

 private:
  void count();

  std::size_t budget_;
  std::size_t bytes_ = 0;
  Index stride_ = 1;
  std::vector<std::shared_ptr<const KeptState>> states_;
};

}  // namespace tetraction::viewer
