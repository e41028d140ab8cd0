#include "run_data.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "simulation/session/contact_point.h"
#include "step_count.h"
#include "tetraction/dynamics/contact/contact.h"

namespace tetraction {
namespace {

// A run counts as unstable once the energy error is this many times the energy that entered.
constexpr double kBlowUp = 10.0;
// If the remaining time is shorter than this share of a step, the step before it is made longer.
constexpr double kMergedAtEnd = 1e-6;

}  // namespace

double round_off_of_time(double t) {
  return 4.0 * std::numeric_limits<double>::epsilon() * std::abs(t);
}

void add_warning(RunProgress& progress, std::string warning) {
  if (!warning.empty()) progress.warnings.push_back(std::move(warning));
}

double relative_energy(const RunData& run, double energy) {
  // Because of the lower bound, round-off in a body at rest does not count.
  const MechanicalSystem& system = *run.system;
  double modulus = 0.0;
  for (const MaterialField& material : system.materials()) {
    modulus = std::max(modulus, material.lame_range().most_modulus);
  }
  modulus = largest_of_parts(system.part(), modulus);
  const double floor = 1e-12 * modulus * system.mesh().total_volume();
  return energy / std::max(run.balance->energy_scale(), floor);
}

bool has_blown_up(const RunData& run) {
  const double error = run.balance->energy_error();
  // The usual case without the loop over the mesh.
  if (error <= kBlowUp * run.balance->energy_scale()) return false;
  return !(relative_energy(run, error) <= kBlowUp);
}

Vector next_external_force(const RunData& run) {
  Vector force;
  if (run.analysis == Analysis::kEquilibrium) {
    force = run.progress.external_force;
  } else {
    const State& state = run.state();
    run.system->applied_force(state.position, state.time, run.progress.plan.time_step, force);
  }
  // It is empty where there are none.
  return force.size() > 0 ? force : Vector(Vector::Zero(run.system->dof_count()));
}

Index steps_to_end(const RunData& run, double step) {
  const double end = run.settings.time.end;
  const double left = end - run.state().time;
  if (std::isfinite(end) && left <= round_off_of_time(end)) return 0;
  const double count = std::ceil(std::min(left / step, kMostSteps) - kMergedAtEnd);
  return std::max<Index>(1, static_cast<Index>(count));
}

void set_time_step(RunData& run, double step) {
  StepPlan& plan = run.progress.plan;
  if (run.state().step > 0 && step != plan.time_step) ++run.progress.steps.changes;
  plan.time_step = step;
  plan.segment_time = run.state().time;
  plan.segment_step = run.state().step;
  plan.segment_count = steps_to_end(run, step);
}

void enter_length(RunProgress& progress, double length, bool is_cut_short) {
  StepRange& steps = progress.steps;
  steps.last = length;
  steps.largest = std::max(steps.largest, length);
  if (!is_cut_short || steps.smallest == 0.0) {
    steps.smallest = steps.smallest == 0.0 ? length : std::min(steps.smallest, length);
  }
}

void count_iterations(RunProgress& progress, const MinimizerReport& report) {
  progress.last_report = report;
  progress.total_iterations += report.iterations;
  progress.total_factorizations += report.factorizations;
  progress.total_cg_iterations += report.cg_iterations;
  if (!report.linear.empty()) progress.linear_solver = report.linear;
}

void set_obstacle_forces(RunData& run, const State& at) {
  const Contact* contact = run.system->contact();
  if (contact == nullptr) return;
  run.progress.obstacle_forces =
      contact->forces(contact_point(*run.system, at, run.analysis == Analysis::kEquilibrium));
}

void enter_obstacle_forces(RunData& run) {
  const std::vector<ObstacleImpulse>& impulses = run.balance->sums().obstacles;
  std::vector<ObstacleForce>& forces = run.progress.obstacle_forces;
  for (std::size_t i = 0; i < std::min(forces.size(), impulses.size()); ++i) {
    forces[i].force = impulses[i].in_step.force / run.progress.steps.last;
    forces[i].moment = impulses[i].in_step.moment / run.progress.steps.last;
  }
}

void accept_step(RunData& run) {
  run.memory.stepper->exchange_reactions(run.reactions);
  run.progress.external_force.swap(run.work.external_force);
  run.states.switch_to_other();
}

void renew_stepper(RunData& run) {
  auto fresh = make_stepper(run.settings.time.integrator, run.settings.solver, *run.system);
  run.memory = {std::move(fresh), nullptr, nullptr, {}};
}

bool is_cancelled_within_step(RunData& run) {
  const auto asked = [](const StopRequest* request) { return request->stop_requested(); };
  if (std::ranges::none_of(run.stop_requests, asked)) return false;
  const bool is_static = run.analysis == Analysis::kEquilibrium;
  run.progress.status = RunStatus::kCancelled;
  run.progress.message = fmt::format(
      "stopped on request after step {} ({} = {:.6g}{}), in the middle of the next one, which was "
      "given up",
      run.state().step, is_static ? "load factor" : "t", run.state().time, is_static ? "" : " s");
  // Its memory belongs to a state that was not reached.
  run.memory.stepper->reset();
  return true;
}

}  // namespace tetraction
