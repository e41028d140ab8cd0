// A session that computes an equilibrium: its steps are load steps.
#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "session_impl.h"
#include "tetraction/core/error.h"
#include "tetraction/core/interruption.h"
#include "tetraction/simulation/scene_objects.h"
#include "tetraction/simulation/stop_flag.h"

namespace tetraction {

namespace {

std::string resting_warning(const std::string& where) {
  return fmt::format(
      "the equilibrium is that of the scene at t = 0: {} has not moved with its velocity yet. "
      "Prescribe a displacement with [[fix]] and offset, or let the body follow the motion with "
      "run and backward-euler",
      where);
}

}  // namespace

void Session::Impl::begin_equilibrium(double largest_increment, bool examines_stability) {
  // A load step is an implicit step of length 1 at most in the load factor, which ends at 1.
  settings.time = {Integrator::kBackwardEuler, 1.0, false, 1.0};
  use_consistent_weights(scene, *system);
  set_constraints_of_equilibrium(scene, *system, settings.constraints);
  shared = shared_distances(settings.constraints.others);
  refuse_free_motions(*system, 0.0);
  std::unique_ptr<StaticStepper> load_stepper = make_static_stepper(*system, settings.solver, 0.0);
  loading = std::make_unique<LoadStepping>(*load_stepper, largest_increment, examines_stability);
  equilibrium_problem = &load_stepper->problem();
  stepper = std::move(load_stepper);
  states.set(system->rest_state());
  balance = std::make_unique<Balance>(*system, state());
  enter_equilibrium(state());
  set_time_step(loading->increment());
  count_inverted(nullptr);
  warn_of_materials();
  warn_of_loads();
  if (!scene.event.empty()) {
    progress.warnings.push_back(
        fmt::format("the equilibrium is that of the scene at t = 0: its {} [[event]] {} not made",
                    scene.event.size(), scene.event.size() == 1 ? "is" : "are"));
  }
  for (const FixSettings& fix : scene.fix) {
    if (!fix.velocity.isZero(0.0)) progress.warnings.push_back(resting_warning(fix.where));
  }
  for (const ConstraintSettings& constraint : scene.constraint) {
    const bool moves = !constraint.velocity.value_or(Vector3::Zero()).isZero(0.0) ||
                       !constraint.angular_velocity.value_or(Vector3::Zero()).isZero(0.0);
    if (moves) progress.warnings.push_back(resting_warning(constraint.where));
  }
  if (!loading->path().is_examined) {
    progress.warnings.emplace_back(
        "the equilibria are not examined for small motions that grow, as a pressure on a surface "
        "with a free rim can feed them");
  }
  warn_of_blas();
}

// Sets the energies and the loads of an equilibrium.
void Session::Impl::enter_equilibrium(const State& at) {
  BalanceSums sums = balance->sums();
  equilibrium_problem->energies(at.time, at.position, sums.energies);
  if (at.step == 0) sums.initial_energies = sums.energies;
  balance->restore(std::move(sums));
  progress.external_force = equilibrium_problem->applied_force(at.time, at.position);
}

bool Session::Impl::load_step() {
  const std::vector<LimitPoint>& limits = loading->path().limit_points;
  const std::size_t known = limits.size();
  const std::string last = known > 0 ? limit_text(limits.back()) : "";
  StepOutcome outcome;
  // The time of examinations must not be counted twice.
  const auto enter_examination = [this, before = loading->examination_seconds()] {
    const double taken = loading->examination_seconds() - before;
    times.stability += taken;
    times.stepping -= taken;
  };
  try {
    std::optional<Interruptible> interruptible;
    for (const StopRequest* request : stop_requests) {
      const auto* with_flag = dynamic_cast<const StopFlag*>(request);
      if (!interruptible && with_flag != nullptr) interruptible.emplace(with_flag->stop_flag());
    }
    outcome = loading->advance(state(), states.other());
  } catch (const Interrupted&) {
    if (cancelled_within_step()) return false;
    throw;
  }
  enter_examination();
  count(outcome.minimizer);
  if (!outcome.ok()) {
    fail_load_step(outcome);
    return false;
  }
  if (known > 0) {  // the last limit point may have become wider
    std::replace(progress.warnings.begin(), progress.warnings.end(), last,
                 limit_text(limits[known - 1]));
  }
  for (std::size_t i = known; i < limits.size(); ++i) {
    progress.warnings.push_back(limit_text(limits[i]));
  }
  const double length = states.other().time - state().time;
  enter_equilibrium(states.other());
  reactions = stepper->reactions();
  states.switch_to_other();
  StepRange& steps = progress.steps;
  steps.last = length;
  steps.largest = std::max(steps.largest, length);
  steps.smallest = steps.smallest == 0.0 ? length : std::min(steps.smallest, length);
  set_time_step(std::min(loading->increment(), std::max(length, 1.0 - state().time)));
  count_inverted(nullptr);
  if (state().time >= 1.0) {
    progress.status = RunStatus::kFinished;
    if (loading->path().loss) progress.warnings.push_back(loss_text(*loading->path().loss));
    warn_of_inverted_corners();
    if (std::string text = round_off_text(loading->path()); !text.empty()) {
      progress.warnings.push_back(std::move(text));
    }
  }
  return true;
}

void Session::Impl::require_motion(const char* what) const {
  if (!loading) return;
  throw InputError(fmt::format("A session that computes an equilibrium has no {}.", what));
}

}  // namespace tetraction
