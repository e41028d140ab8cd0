// time.adapt = "energy": every step has the size that keeps the discrete energy.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "adaptations.h"
#include "tetraction/dynamics/body_sums.h"

namespace tetraction {
namespace {

// The discrete energy is kept to this share of the solver's tolerance, relative to the energy that
// entered, but not to less than what the solver's round-off makes of it.
constexpr double kEnergyShare = 0.1;
constexpr double kLeastEnergyTolerance = 1e-10;
// Neighbouring steps that keep the discrete energy differ by this factor at most.
constexpr double kLargestChange = 2.0;

// Calls use(term) for the potentials that are not among the stored energies.
void for_each_driven_potential(const MechanicalSystem& system, const auto& use) {
  for (const ForceTerm* term : system.force_terms()) {
    if (term->has_potential() && term->account() != EnergyAccount::kStored) use(*term);
  }
}

class StepsByEnergy final : public AdaptiveSteps {
 public:
  explicit StepsByEnergy(RunData& run) : AdaptiveSteps(run) {}

  StepOutcome advance() override;
  std::string advice(double /*limit*/) const override {
    return fmt::format(
        "The step is {:.4g} s, as time.adapt = \"energy\" chose it. Take a smaller time.step or "
        "time.max_step, or time.adapt = \"error\"{}, and check the loads.",
        run_.progress.plan.time_step, other_rule());
  }
  std::string energy_warning(double share) const override {
    return unresolved_warning(share, "time.step, which is the first one");
  }

 private:
  // A step of the rule with its discrete energy, J, and half of the work that is no potential's, J.
  struct Trial {
    StepOutcome outcome;
    double energy = 0.0;
    double half_work = 0.0;
    double magnitude = 0.0;  // sum of the magnitudes of all energies
  };
  Trial try_step(const StepSpan& span);
  // The energy of a state with all potentials, J. `magnitude`: the sum of their magnitudes. NaN
  // where it is not defined.
  double full_energy(const State& at, double& magnitude) const;
};

double StepsByEnergy::full_energy(const State& at, double& magnitude) const {
  const MechanicalSystem& system = *run_.system;
  Energies energies = run_.balance->energies();
  if (!evaluate_energies(system, at, energies).ok())
    return std::numeric_limits<double>::quiet_NaN();
  double energy = energies.total();
  magnitude = 0.0;
  for (const Energies::Entry& entry : energies.entries()) magnitude += std::abs(entry.value);
  const ForcePoint point = system.force_point(at.position, at.time);
  for_each_driven_potential(system, [&](const ForceTerm& term) {
    const double value = sum_over_parts(system.part(), term.energy(point));
    energy += value;
    magnitude += std::abs(value);
  });
  return energy;
}

// The discrete energy of the midpoint rule is −∂L_d/∂h of its discrete Lagrangian L_d = h L(½(q_k +
// q_{k+1}), v): kinetic energy of v and the potentials in the middle.
StepsByEnergy::Trial StepsByEnergy::try_step(const StepSpan& span) {
  Trial trial;
  const MechanicalSystem& system = *run_.system;
  const State& from = run_.state();
  State& to = run_.states.other();
  State& middle = run_.work.middle;
  trial.outcome = run_.memory.stepper->advance(from, to, span.length, span.end);
  count_iterations(run_.progress, trial.outcome.minimizer);
  if (!trial.outcome.ok()) return trial;
  middle.time = from.time + 0.5 * span.length;
  middle.position = 0.5 * (from.position + to.position);
  middle.velocity = to.velocity;
  system.momentum_of(to.velocity, middle.momentum);
  trial.energy = full_energy(middle, trial.magnitude);
  double work =
      trial.outcome.external_work + trial.outcome.constraint_work - trial.outcome.dissipated_energy;
  const ForcePoint start = system.force_point(from.position, from.time);
  const ForcePoint end = system.force_point(to.position, to.time);
  for_each_driven_potential(system, [&](const ForceTerm& term) {
    // It is part of the discrete energy.
    work += sum_over_parts(system.part(), term.energy_change(start, end));
  });
  trial.half_work = 0.5 * work;
  return trial;
}

StepOutcome StepsByEnergy::advance() {
  RunProgress& progress = run_.progress;
  StepControl& control = progress.control;
  Stepper& stepper = *run_.memory.stepper;
  AdaptiveStepMemory& memory = progress.plan.adaptive;
  const StepBounds limits = bounds();
  const double landing = next_landing();
  const double begin = run_.state().time;
  const double present = std::clamp(progress.plan.time_step, limits.least, limits.most);
  const IterationCount iterations(progress);
  const bool keeps = memory.has_energy;
  const double kept = memory.energy + memory.half_work;
  double magnitude = 0.0;
  const double at_zero = keeps ? full_energy(run_.state(), magnitude) - kept : 0.0;
  const double tolerance =
      std::max(kLeastEnergyTolerance, kEnergyShare * run_.settings.solver.tolerance) /
          relative_energy(run_, 1.0) +
      16.0 * std::numeric_limits<double>::epsilon() * magnitude;

  Trial last;
  double last_length = 0.0;
  bool present_fails = false;
  const auto make_trial = [&](const StepSpan& span) {
    if (last_length > 0.0) {
      if (progress.status == RunStatus::kCancelled || is_cancelled_within_step(run_)) return false;
      stepper.reset();
    }
    last = try_step(span);
    last_length = span.length;
    if (last.outcome.ok() && std::isfinite(last.energy)) return true;
    present_fails = present_fails || span.length == present;
    ++control.rejected;
    ++control.failed;
    ++control.last_rejected;
    return false;
  };
  const auto residual = [&](double length) -> std::optional<double> {
    if (!make_trial({length, begin + length})) return std::nullopt;
    return keeps ? last.energy - kept - last.half_work : 0.0;
  };
  const auto give_up = [&] {
    stepper.reset();
    set_time_step(run_, last_length);
    iterations.report();
    if (last.outcome.ok()) last.outcome.status = StepStatus::kInverted;  // no discrete energy
    return std::move(last.outcome);
  };
  const StepBounds range{std::max(limits.least, present / kLargestChange),
                         std::min(limits.most, present * kLargestChange)};
  StepRoot root = find_step(residual, present, at_zero, range, tolerance);
  if (root.step == 0.0 && range.least > limits.least && progress.status == RunStatus::kRunning) {
    root = find_step(residual, range.least, at_zero, {limits.least, range.least}, tolerance);
  }

  if (progress.status == RunStatus::kCancelled) return std::move(last.outcome);
  if (root.step == 0.0) return give_up();

  // The least residual would lead to ever smaller steps: see docs/theory.md.
  const double chosen = root.found || present_fails ? root.step : present;
  StepSpan span = span_of(chosen, landing);
  const bool is_cut = span.end > landing;
  if (is_cut) span = span_to(landing);
  // The last trial is that of a solution, unless its end is not exactly the landing.
  const bool is_made = last_length == span.length && span.end == begin + span.length;
  if (!is_made && !make_trial(span)) {
    return progress.status == RunStatus::kCancelled ? std::move(last.outcome) : give_up();
  }
  const State& from = run_.state();
  run_.system->applied_force(from.position, from.time, span.length, run_.work.external_force);
  run_.balance->enter(run_.states.other(), last.outcome);
  accept_step(run_);
  iterations.report();
  enter_length(progress, span.length, is_cut);
  if (keeps && !root.found && !is_cut) ++control.without_solution;
  // A step that was cut has another discrete energy; it must not become the one to keep.
  if (keeps || !is_cut) {
    memory.energy = keeps ? kept + last.half_work : last.energy;
    memory.half_work = last.half_work;
    memory.has_energy = true;
  }
  control.discrete_energy = last.energy;
  control.energy_residual = memory.has_energy ? last.energy - memory.energy : 0.0;
  set_time_step(run_, chosen);
  return std::move(last.outcome);
}

std::string energy_report(const StepControl& control, const TimeSettings& /*time*/) {
  return fmt::format(
      "the discrete energy is kept, but for {} steps without a solution; {} attempts failed. "
      "energy_error is the one between the ends of steps, which stays bounded but is not zero",
      control.without_solution, control.failed);
}

std::string energy_steps_warning(const StepControl& control, const TimeSettings& /*time*/,
                                 Index step) {
  if (control.without_solution == 0) return {};
  return fmt::format(
      "in {} of {} steps no size between the bounds keeps the discrete energy: the size of the "
      "step before was taken. history.csv has what is missing in the column energy_residual.",
      control.without_solution, step);
}

}  // namespace

Adaptation adaptation_by_energy() {
  const auto make = [](RunData& run) -> std::unique_ptr<StepStrategy> {
    return std::make_unique<StepsByEnergy>(run);
  };
  return {StepAdaptation::kEnergy,
          make,
          0.1,
          10.0,
          {{"discrete_energy", &StepControl::discrete_energy},
           {"energy_residual", &StepControl::energy_residual}},
          energy_report,
          energy_steps_warning};
}

}  // namespace tetraction
