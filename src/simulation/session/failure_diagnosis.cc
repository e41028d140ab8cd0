#include "failure_diagnosis.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <utility>

#include "failure_cause.h"
#include "failure_place.h"
#include "obstacle_notes.h"
#include "simulation/stepping/limit_estimates.h"
#include "tetraction/dynamics/body_sums.h"
#include "tetraction/fem/step_length.h"

namespace tetraction {

Diagnosis diagnose_step(const RunData& run, const StepStrategy& strategy,
                        const StepOutcome& outcome, const State& tried) {
  const MechanicalSystem& system = *run.system;
  const State& state = run.state();
  const SolverSettings& solver = run.settings.solver;
  StepFailure now;
  now.step = state.step + 1;
  now.time = state.time;
  now.time_step = strategy.planned_span().length;
  now.stable_step = present_limit(run);
  if (tried.step == now.step) now.attempted_position = tried.position;
  RunStatus how = RunStatus::kUnstable;
  switch (outcome.status) {
    case StepStatus::kOk:
      break;
    case StepStatus::kInverted:
      now.what = is_automatic(run.settings.time)
                     ? "the body is crushed or torn (inverted, J <= 0, whatever the step)"
                     : "the material's energy is not defined (inverted, J <= 0)";
      if (has_stretch_limit(system.elastic())) {
        now.what += ", or a material is stretched to its limit";
      }
      break;
    case StepStatus::kNotFinite:
      now.what = outcome.message.empty() ? "positions, momenta or energies are not finite numbers"
                                         : outcome.message;
      break;
    case StepStatus::kUndefined:
      now.what = outcome.message;
      break;
    case StepStatus::kOverdamped:
      now.what = "the damping forces of one step would turn velocities around and give energy";
      break;
    case StepStatus::kNotConverged: {
      how = RunStatus::kNotConverged;
      now.what = outcome.message;
      const MinimizerReport& report = outcome.minimizer;
      if (report.iterations == 0) break;
      // The residual may be small enough, and something else keeps the step from its end.
      const bool is_large = !(report.residual <= report.residual_limit);
      // A step with moving targets or constraints minimises more than once.
      const bool several = report.iterations > solver.max_iterations;
      now.what = fmt::format("the implicit step did not converge after {} iteration{}{}: {} ",
                             report.iterations, report.iterations == 1 ? "" : "s",
                             several ? " of several minimisations" : "", outcome.message);
      now.what += is_large ? fmt::format("(force residual {:.3g} N, allowed {:.3g} N)",
                                         report.residual, report.residual_limit)
                           : fmt::format(
                                 "(the last force residual, {:.3g} N, is within the {:.3g} N "
                                 "allowed)",
                                 report.residual, report.residual_limit);
      break;
    }
  }
  if (outcome.obstacle == StepObstacle::kPrescribedMotion) {
    // Where the elements would be if the rest of the body did not follow.
    now.attempted_position = state.position;
    system.constraints().prescribe(now.time + now.time_step, now.attempted_position);
  }
  locate(run, outcome.element, now);
  now.cause = cause_of(run, outcome, now);
  if (leads_out_of_range(system, state, now.time + now.time_step)) {
    now.cause = FailureCause::kPrescribedMotion;
    now.what = "what moves as prescribed gets to positions that are not finite numbers";
  }
  if (now.cause == FailureCause::kForceTerm && outcome.status != StepStatus::kUndefined) {
    const TimeSpan span{now.time, now.time + now.time_step};
    auto bad = bad_force(system, system.force_point(state.position, now.time, span));
    if (!bad && now.attempted_position.size() > 0) {
      bad = bad_force(system, system.force_point(now.attempted_position, span.end, span));
    }
    if (bad) {
      now.what =
          fmt::format("the force term \"{}\" gives a force that is not finite at vertex {}: ",
                      bad->term, system.mesh().vertex_id(bad->vertex)) +
          now.what;
    }
    take_from_first(system.part(), bad.has_value(), now.what);
  }
  now.remedy = remedy_for(run, now, outcome, strategy.advice(now.stable_step));
  const double end = now.time + now.time_step;
  Vector prescribed = state.position;
  system.constraints().prescribe(end, prescribed);
  if (auto note = obstacle_note(system, state, end, prescribed, now.attempted_position, false);
      note && now.cause != FailureCause::kLoads) {
    now.what = note->what;
    now.remedy = note->remedy;
    return {std::move(now), how, false};
  }
  const bool has_place =
      outcome.status == StepStatus::kInverted || outcome.status == StepStatus::kNotFinite;
  return {std::move(now), how, has_place || outcome.status == StepStatus::kNotConverged};
}

Diagnosis diagnose_collapse(const RunData& run, const StepStrategy& strategy,
                            const StepCollapse& collapse) {
  const State& state = run.state();
  StepFailure now;
  now.step = state.step + 1;
  now.time = state.time;
  now.time_step = run.progress.plan.time_step;
  now.stable_step = present_limit(run);
  now.what = collapse.what;
  locate(run, collapse.element, now);
  now.cause = worst_is_held(*run.system, now) ? FailureCause::kPrescribedMotion
                                              : FailureCause::kStepAboveLimit;
  now.remedy = strategy.advice(now.stable_step);
  return {std::move(now), RunStatus::kUnstable, true};
}

Diagnosis diagnose_blow_up(const RunData& run, const StepStrategy& strategy) {
  const State& state = run.state();
  StepFailure now;
  now.step = state.step;
  now.time = state.time - run.progress.steps.last;
  now.time_step = run.progress.steps.last;
  now.stable_step = present_limit(run);
  now.what = fmt::format(
      "the energy blew up: the integrator has added {:.3g} J to the {:.3g} J that entered, most",
      run.balance->energy_error(), run.balance->energy_scale());
  now.attempted_position = state.position;
  locate(run, -1, now);
  StepOutcome outcome;
  now.cause = cause_of(run, outcome, now);
  now.remedy = remedy_for(run, now, outcome, strategy.advice(now.stable_step));
  return {std::move(now), RunStatus::kUnstable, true};
}

// A vertex near the centre of attraction is the likely cause of a failure.
std::string center_note(RunData& run) {
  const MechanicalSystem& system = *run.system;
  if (!system.environment().is_singular()) return {};
  const State& state = run.state();
  Index nearest = 0;
  const double distance =
      state.position.reshaped(3, system.vertex_count()).colwise().norm().minCoeff(&nearest);
  const double moved = state.velocity.segment<3>(3 * nearest).norm() * run.progress.plan.time_step;
  // If a vertex passes the centre at a distance below its motion in one step, it gets an arbitrary
  // energy there. It may be far away when the effect becomes visible.
  if (distance <= 4.0 * moved || distance == 0.0) {
    run.progress.passed_center = fmt::format(
        "; vertex {} came as near as {:.3g} m to the centre of attraction, where the force has no "
        "bound: give environment.softening a length",
        system.mesh().vertex_id(nearest), distance);
  }
  return run.progress.passed_center;
}

void end_run(RunData& run, const Diagnosis& diagnosis) {
  const StepFailure& failure = diagnosis.failure;
  const std::string where =
      (diagnosis.has_place ? place_of(*run.system, failure) : "") + center_note(run);
  run.progress.message =
      fmt::format("step {} (t = {:.6g} s): {}{}. {}", failure.step,
                  failure.time + failure.time_step, failure.what, where, failure.remedy);
  if (const MeshPart* part = run.system->part(); part != nullptr) {
    part->broadcast(run.progress.message, failure.process);
  }
  run.progress.status = diagnosis.status;
}

}  // namespace tetraction
