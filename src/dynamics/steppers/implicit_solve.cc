// The solution of an implicit step: the first guess, and intermediate steps if prescribed vertices
// move far.
#include <algorithm>

#include "common_outcome.h"
#include "implicit_stepper.h"
#include "tetraction/dynamics/contact/contact.h"

namespace tetraction {

// Minimises Φ, or the outcome says why there is no minimiser.
bool ImplicitStepper::find(const State& from, double end_time, StepOutcome& outcome) {
  using Quality = FirstGuess::Quality;
  Quality guess = guess_.choose(*problem_, from);
  solve_.u().setZero(system_.dof_count());
  const bool led = guess != Quality::kGood;
  if (led && !lead_along(from, end_time, outcome)) {
    if (guess == Quality::kUndefined) return false;
    // Materials that are defined for inverted elements continue from a poor guess.
    forget_failure(outcome);
    problem_->prescribe_base(end_time);
    guess_.choose(*problem_, from);
    solve_.u().setZero();
  }
  if (solve_.minimize(from.position, outcome)) return true;
  // Without intermediate steps the minimisation of a body with moving targets may fail.
  if (led || !moving_) return false;
  StepOutcome again;
  again.minimizer.iterations = outcome.minimizer.iterations;
  again.minimizer.factorizations = outcome.minimizer.factorizations;
  again.minimizer.cg_iterations = outcome.minimizer.cg_iterations;
  problem_->set_constraint_force({});
  solve_.u().setZero(system_.dof_count());
  if (!lead_along(from, end_time, again) || !solve_.minimize(from.position, again)) return false;
  outcome = again;
  return true;
}

// Moves the prescribed components by a part of their displacement at a time. Each time the body follows by a
// harmonic extension, and Φ is minimised. So a motion by more than the size of an element in a step
// crushes or inverts no element.
bool ImplicitStepper::lead_along(const State& from, double end_time, StepOutcome& outcome) {
  constexpr double kLeastPart = 1.0 / 512;
  if (!moving_) {
    outcome.status = StepStatus::kNotConverged;
    const Contact* contact = system_.contact();
    outcome.message = contact != nullptr && contact->moves()
                          ? "an obstacle moves so far in this step that it would crush or invert "
                            "elements: take a "
                            "smaller step"
                          : "the elastic energy is not defined at the start of the step";
    return false;
  }
  if (system_.part() != nullptr) {
    outcome.status = StepStatus::kNotConverged;
    outcome.message =
        "prescribed vertices move so far in a step that several processes cannot lead them there "
        "yet";
    outcome.obstacle = StepObstacle::kPrescribedMotion;
    return false;
  }
  x_ = from.position;
  double done = 0.0;
  double part = 1.0;
  while (done < 1.0) {
    const double next = std::min(1.0, done + part);
    problem_->prescribe_base(next < 1.0 ? from.time + next * (end_time - from.time) : end_time);
    trial_ = x_;
    guess_.carry_along(*problem_, trial_);
    problem_->set_origin(trial_);
    solve_.u().setZero();
    double phi = 0.0;
    bool good = problem_->value(solve_.u(), phi).ok() && guess_.keeps_volumes(x_, trial_);
    if (good && next < 1.0) good = solve_.solve(outcome);
    if (good) {
      problem_->positions(solve_.u(), x_);
      done = next;
      part *= 2.0;
    } else {
      part *= 0.5;
    }
    if (part < kLeastPart) {
      outcome.status = StepStatus::kNotConverged;
      outcome.message =
          "what moves as prescribed would crush the elements beside it, however it is led there";
      outcome.obstacle = StepObstacle::kPrescribedMotion;
      return false;
    }
  }
  forget_failure(outcome);
  return true;
}

}  // namespace tetraction
