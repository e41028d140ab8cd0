#include "equilibrium_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "failure_place.h"
#include "obstacle_notes.h"
#include "run_warnings.h"
#include "simulation/facts/obstacle_checks.h"
#include "simulation/scene/initial_state.h"
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

EquilibriumRun::EquilibriumRun(RunData& run, double largest_increment, bool examines_stability)
    : run_(run) {
  MechanicalSystem& system = *run.system;
  RunSettings& settings = run.settings;
  // A load step is an implicit step of length 1 at most in the load factor, which ends at 1.
  settings.time = {Integrator::kBackwardEuler, 1.0, false, 1.0};
  use_consistent_weights(run.scene, system);
  set_constraints_of_equilibrium(run.scene, system, settings.constraints);
  refuse_friction(run.scene);
  refuse_free_motions(system, 0.0);
  std::unique_ptr<StaticStepper> stepper = make_static_stepper(system, settings.solver, 0.0);
  loading_ = std::make_unique<LoadStepping>(*stepper, largest_increment, examines_stability);
  problem_ = &stepper->problem();
  run.memory.stepper = std::move(stepper);
  run.states.set(system.rest_state());
  run.balance = std::make_unique<Balance>(system, run.state());
  enter(run.state());
  set_time_step(run, loading_->increment());
}

void EquilibriumRun::warn() {
  warn_of_materials(run_);
  warn_of_loads(run_);
  if (!run_.scene.event.empty()) {
    run_.progress.warnings.push_back(
        fmt::format("the equilibrium is that of the scene at t = 0: its {} [[event]] {} not made",
                    run_.scene.event.size(), run_.scene.event.size() == 1 ? "is" : "are"));
  }
  for (const FixSettings& fix : run_.scene.fix) {
    if (!fix.velocity.isZero(0.0)) run_.progress.warnings.push_back(resting_warning(fix.where));
  }
  for (const ConstraintSettings& constraint : run_.scene.constraint) {
    const bool moves = !constraint.velocity.value_or(Vector3::Zero()).isZero(0.0) ||
                       !constraint.angular_velocity.value_or(Vector3::Zero()).isZero(0.0);
    if (moves) run_.progress.warnings.push_back(resting_warning(constraint.where));
  }
  for (const ObstacleSettings& obstacle : run_.scene.obstacle) {
    const bool moves = !obstacle.velocity.isZero(0.0) || !obstacle.angular_velocity.isZero(0.0);
    if (moves) run_.progress.warnings.push_back(resting_warning(obstacle.where));
  }
  if (!loading_->path().is_examined) {
    run_.progress.warnings.emplace_back(
        "the equilibria are not examined for small motions that grow, as a pressure on a surface "
        "with a free rim can feed them");
  }
  warn_of_blas(run_);
}

void EquilibriumRun::enter(const State& at) {
  BalanceSums sums = run_.balance->sums();
  problem_->energies(at.time, at.position, sums.energies);
  if (at.step == 0) sums.initial_energies = sums.energies;
  run_.balance->restore(std::move(sums));
  run_.progress.external_force = problem_->applied_force(at.time, at.position);
  set_obstacle_forces(run_, at);
}

StepFailure EquilibriumRun::fail(const StepOutcome& outcome) {
  StepFailure now;
  now.step = run_.state().step + 1;
  now.time = run_.state().time;
  now.time_step = loading_->increment();
  now.what = loading_->message(outcome);
  locate(run_, outcome.element, now);
  const double end = std::min(1.0, now.time + now.time_step);
  Vector prescribed = run_.state().position;
  problem_->prescribe(end, prescribed);
  if (const auto note = obstacle_note(*run_.system, run_.state(), end, prescribed, {}, true)) {
    now.what += ". " + note->what;
    now.remedy = note->remedy;
    run_.progress.message = now.what + ". " + now.remedy;
    run_.progress.status = RunStatus::kNotConverged;
    return now;
  }
  run_.progress.message = now.what + ". Look" + place_of(*run_.system, now) + " first";
  run_.progress.status = RunStatus::kNotConverged;
  return now;
}

bool EquilibriumRun::step(InversionWatch& inversions, std::optional<StepFailure>& failure) {
  RunProgress& progress = run_.progress;
  const std::vector<LimitPoint>& limits = loading_->path().limit_points;
  const std::size_t known = limits.size();
  const std::string last = known > 0 ? limit_text(limits.back()) : "";
  StepOutcome outcome;
  // The time of examinations must not be counted twice.
  const auto enter_examination = [this, before = loading_->examination_seconds()] {
    const double taken = loading_->examination_seconds() - before;
    run_.times.stability += taken;
    run_.times.stepping -= taken;
  };
  try {
    std::optional<Interruptible> interruptible;
    for (const StopRequest* request : run_.stop_requests) {
      const auto* with_flag = dynamic_cast<const StopFlag*>(request);
      if (!interruptible && with_flag != nullptr) interruptible.emplace(with_flag->stop_flag());
    }
    outcome = loading_->advance(run_.state(), run_.states.other());
  } catch (const Interrupted&) {
    if (is_cancelled_within_step(run_)) return false;
    throw;
  }
  enter_examination();
  count_iterations(progress, outcome.minimizer);
  if (!outcome.ok()) {
    failure = fail(outcome);
    return false;
  }
  if (known > 0) {  // the last limit point may have become wider
    std::replace(progress.warnings.begin(), progress.warnings.end(), last,
                 limit_text(limits[known - 1]));
  }
  for (std::size_t i = known; i < limits.size(); ++i) {
    progress.warnings.push_back(limit_text(limits[i]));
  }
  const double length = run_.states.other().time - run_.state().time;
  enter(run_.states.other());
  run_.reactions = run_.memory.stepper->reactions();
  run_.states.switch_to_other();
  enter_length(progress, length, false);
  set_time_step(run_, std::min(loading_->increment(), std::max(length, 1.0 - run_.state().time)));
  inversions.update(run_, nullptr);
  if (run_.state().time >= 1.0) {
    progress.status = RunStatus::kFinished;
    if (loading_->path().loss) progress.warnings.push_back(loss_text(*loading_->path().loss));
    add_warning(progress, inverted_corner_warning(*run_.system, run_.state().position));
    add_warning(progress, round_off_text(loading_->path()));
  }
  return true;
}

}  // namespace tetraction
