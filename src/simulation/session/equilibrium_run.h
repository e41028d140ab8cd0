// A run that computes an equilibrium: its steps are load steps.
#pragma once

#include <memory>
#include <optional>

#include "inversion_watch.h"
#include "load_stepping.h"
#include "simulation/stepping/run_data.h"
#include "tetraction/simulation/step_failure.h"

namespace tetraction {

class EquilibriumRun {
 public:
  /// Sets the body of the run up at rest, without loads. Keeps a reference to the run. See Session for the
  /// other arguments, and for errors.
  EquilibriumRun(RunData& run, double largest_increment, bool examines_stability);

  /// Adds the warnings that can be given before the first load step.
  void warn();
  /// Makes one load step. Returns false if there is none, with `failure` unless it was cancelled.
  bool step(InversionWatch& inversions, std::optional<StepFailure>& failure);
  const LoadPath& path() const { return loading_->path(); }
  /// See Session::constraint_error().
  double constraint_error(const State& at) const {
    return problem_->constraint_error(at.time, at.position);
  }

 private:
  // Enters the energies and the loads of an equilibrium.
  void enter(const State& at);
  // Ends the run with a message of the load path.
  StepFailure fail(const StepOutcome& outcome);

  RunData& run_;
  std::unique_ptr<LoadStepping> loading_;
  const StaticProblem* problem_ = nullptr;  // of the stepper of the run
};

}  // namespace tetraction
