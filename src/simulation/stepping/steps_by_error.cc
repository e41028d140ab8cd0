// time.adapt = "error": the error of a step is estimated from its comparison with two halves.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "adaptations.h"
#include "automatic_step.h"
#include "mesh/bounding_box.h"

namespace tetraction {
namespace {

// The largest distance between the positions of a vertex, m.
double largest_distance(const MeshPart* part, const Vector& a, const Vector& b) {
  const double square = (a - b).reshaped(3, a.size() / 3).colwise().squaredNorm().maxCoeff();
  return std::sqrt(largest_of_parts(part, square));
}

class StepsByError final : public AdaptiveSteps {
 public:
  explicit StepsByError(RunData& run) : AdaptiveSteps(run) {}

  StepOutcome advance() override;
  std::string advice(double /*limit*/) const override {
    return fmt::format(
        "time.adapt made the steps smaller, down to {:.4g} s, which did not help. Check loads, "
        "materials and prescribed motion, or make time.min_step smaller{}.",
        run_.progress.plan.time_step, other_rule());
  }
  std::string energy_warning(double share) const override {
    return unresolved_warning(share, "time.tolerance");
  }

 private:
  // Two halves of a step, and the error of their result relative to the body's diagonal.
  struct Halves {
    StepOutcome first;
    StepOutcome second;  // of the whole step if that one failed
    double error = 0.0;
    Reactions reactions;
  };
  Halves try_halves(const StepSpan& span);
  void accept_halves(const Halves& halves, const StepSpan& span);

  double rest_diagonal_ =
      0.0;  // of the box around the body at rest, m; made when it is first needed
};

StepsByError::Halves StepsByError::try_halves(const StepSpan& span) {
  Halves halves;
  StepWork& work = run_.work;
  Stepper& stepper = *run_.memory.stepper;
  std::unique_ptr<Stepper>& whole_stepper = run_.memory.whole_stepper;
  const auto advance = [&](Stepper& rule, const State& from, State& to, double length, double end) {
    StepOutcome outcome = rule.advance(from, to, length, end);
    count_iterations(run_.progress, outcome.minimizer);
    return outcome;
  };
  if (!whole_stepper) {
    whole_stepper = make_stepper(time().integrator, run_.settings.solver, *run_.system);
  }
  // Its last step, if any, led to another state.
  whole_stepper->reset();
  const State& from = run_.state();
  State& to = run_.states.other();
  halves.second = advance(*whole_stepper, from, work.whole, span.length, span.end);
  if (!halves.second.ok()) return halves;
  const double half = 0.5 * span.length;
  halves.second = halves.first = advance(stepper, from, work.middle, half, from.time + half);
  if (!halves.first.ok()) return halves;
  halves.reactions.add(stepper.reactions(), 0.5, half);
  halves.second = advance(stepper, work.middle, to, half, span.end);
  if (!halves.second.ok()) return halves;
  halves.reactions.add(stepper.reactions(), 0.5, 0.0);
  if (rest_diagonal_ == 0.0) rest_diagonal_ = bounding_box(run_.system->mesh()).diagonal();
  const int order_of_rule = order(time().integrator);
  halves.error = largest_distance(run_.system->part(), to.position, work.whole.position) /
                 ((std::ldexp(1.0, order_of_rule) - 1.0) * rest_diagonal_);
  return halves;
}

void StepsByError::accept_halves(const Halves& halves, const StepSpan& span) {
  const State& from = run_.state();
  State& to = run_.states.other();
  run_.system->applied_force(from.position, from.time, span.length, run_.work.external_force);
  auto guard = balance_guard(*run_.balance);
  run_.balance->enter(run_.work.middle, halves.first);
  run_.balance->enter(to, halves.second);
  guard.release();
  to.step = from.step + 1;
  run_.memory.stepper->set_reactions(halves.reactions);
  accept_step(run_);
  if (follows_limit(time())) {
    AutomaticStep(run_.progress.plan.automatic)
        .watch_elastic(halves.second.elastic_energy, run_.state().step);
  }
  run_.progress.control.last_substeps = 2;
  run_.progress.control.last_error = halves.error;
}

StepOutcome StepsByError::advance() {
  StepControl& control = run_.progress.control;
  StepController controller(run_.progress.plan.adaptive, order(time().integrator));
  const StepBounds range = bounds();
  const double landing = next_landing();
  const IterationCount iterations(run_.progress);
  const auto error_of = [&](const Halves& halves) {
    return halves.second.ok() ? halves.error / time().tolerance
                              : std::numeric_limits<double>::infinity();
  };
  const auto is_acceptable = [&](const Halves& halves, const StepSpan& span) {
    return halves.second.ok() && (error_of(halves) <= 1.0 || span.length <= range.least);
  };
  double length = std::clamp(run_.progress.plan.time_step, range.least, range.most);
  for (;;) {
    StepSpan span = span_of(length, landing);
    Halves halves = try_halves(span);
    const bool is_rejected = !is_acceptable(halves, span) && span.length > range.least;
    if (is_rejected && is_cancelled_within_step(run_)) return std::move(halves.second);
    bool is_cut = false;
    // A step is cut only after the full one was accepted. Rejections are then the same whether an
    // edit is made between two steps or at a time on which the steps land.
    if (is_acceptable(halves, span) && span.end > landing) {
      is_cut = true;
      span = span_to(landing);
      run_.memory.stepper->reset();
      halves = try_halves(span);
    }
    const double error = error_of(halves);
    if (is_acceptable(halves, span)) {
      if (error > 1.0) ++control.above_tolerance;
      accept_halves(halves, span);
      iterations.report();
      enter_length(run_.progress, span.length, is_cut);
      if (!is_cut) {
        length *= controller.after_success(error, control.last_rejected > 0);
      }
      set_time_step(run_, std::clamp(length, range.least, range.most));
      return std::move(halves.second);
    }
    ++control.rejected;
    ++control.last_rejected;
    if (!halves.second.ok()) ++control.failed;
    run_.memory.stepper->reset();
    if (span.length <= range.least) {
      set_time_step(run_, span.length);
      iterations.report();
      return std::move(halves.second);
    }
    length = std::max(range.least, span.length * controller.after_rejection(error));
  }
}

std::string error_report(const StepControl& control, const TimeSettings& time) {
  return fmt::format(
      "errors of at most {:.3g} of the body's diagonal in a step; {} attempts rejected, {} of "
      "which failed. Momenta are conserved as with equal steps; the energy {}",
      time.tolerance, control.rejected, control.failed,
      is_variational(time.integrator) ? "may drift, because the size of the steps changes"
                                      : "is treated as in equal steps");
}

std::string error_steps_warning(const StepControl& control, const TimeSettings& time, Index step) {
  if (control.above_tolerance == 0) return {};
  return fmt::format(
      "{} of {} steps are less exact than time.tolerance = {:.3g}: smaller ones than time.min_step "
      "would be needed. history.csv has their errors in the column step_error.",
      control.above_tolerance, step, time.tolerance);
}

}  // namespace

Adaptation adaptation_by_error() {
  const auto make = [](RunData& run) -> std::unique_ptr<StepStrategy> {
    return std::make_unique<StepsByError>(run);
  };
  return {StepAdaptation::kError,
          make,
          1e-6,
          100.0,
          {{"step_error", &StepControl::last_error}},
          error_report,
          error_steps_warning};
}

}  // namespace tetraction
