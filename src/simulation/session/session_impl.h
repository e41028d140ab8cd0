// The parts of a Session.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/scope_exit.h"
#include "equilibrium_run.h"
#include "inversion_watch.h"
#include "simulation/scene/body_constraints.h"
#include "simulation/stepping/run_data.h"
#include "simulation/stepping/step_strategy.h"
#include "tetraction/simulation/probe.h"
#include "tetraction/simulation/session.h"
#include "tetraction/simulation/step_failure.h"

namespace tetraction {

struct Diagnosis;

struct Session::Impl {
  RunData run;
  std::unique_ptr<StepStrategy> strategy;       // of a motion; that of the present settings
  std::unique_ptr<EquilibriumRun> equilibrium;  // null for a motion
  InversionWatch inversions;
  std::vector<SharedDistance> shared;  // of settings.constraints
  std::unique_ptr<const ProbeSet> probes;
  std::optional<StepFailure> failed_step;  // the one of the message
  std::optional<BodyIdentity> body;        // made when the first checkpoint needs it

  // The last good state since the last edit, if good states are kept.
  struct GoodState {
    State state;
    BalanceSums balance;
    StepPlan plan;
  };
  bool keeps_good_states = false;
  GoodState good;

  // The beginning of the calls of observers that are being made.
  std::optional<PhaseTimer::Clock::time_point> observed_since;
  /// Measures the time of observers as long as the result lives. They can ask for it meanwhile.
  auto time_observers() {
    observed_since = PhaseTimer::Clock::now();
    return ScopeExit([this] {
      run.times.output += observed_seconds();
      observed_since.reset();
    });
  }
  /// Time since the observers are being called, s; 0 if they are not.
  double observed_seconds() const {
    if (!observed_since) return 0.0;
    return std::chrono::duration<double>(PhaseTimer::Clock::now() - *observed_since).count();
  }

  /// Sets a motion up at the state in which the scene begins. Throws InputError.
  void begin_motion();
  /// Makes the events that are due, and one step with all that belongs to it. Returns false when the
  /// run is over.
  bool step();
  /// Ends a run that has come to its end time.
  void finish();
  /// Ends a run in which a step failed.
  void fail(Diagnosis diagnosis);
  /// Ends a run whose step ended with the exception that is being handled.
  void fail_with_exception();
  /// Throws InputError if the session computes an equilibrium, which has none of `what`.
  void require_motion(const char* what) const;
  void apply(const Edit& edit, double at, const std::string& what);
  /// Makes the events that are due. Returns false if one of them could not be made.
  bool apply_events();
  void keep_state();
  /// The identity of the body, computed once.
  const BodyIdentity& identity();
};

}  // namespace tetraction
