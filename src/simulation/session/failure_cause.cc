#include "failure_cause.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "dynamics/terms/term_forces.h"
#include "failure_measures.h"
#include "failure_place.h"
#include "simulation/stepping/step_strategy.h"
#include "tetraction/dynamics/body_sums.h"
#include "tetraction/dynamics/contact/contact.h"

namespace tetraction {
namespace {

// Vertices are too fast if they move so many times as fast as pressure waves.
constexpr double kAbsurdSpeed = 10.0;
// Moduli that differ by more leave a factorisation too few digits for the softer part.
constexpr double kAbsurdContrast = 1e8;
// Supports have crushed a body whose stability limit has fallen to less than this share.
constexpr double kCrushed = 0.1;
// Residuals below this share of the forces are round-off of large sums.
constexpr double kLoadRoundOff = 1e-11;

std::optional<Index> first_not_finite(const Vector& field) {
  for (Index v = 0; v < field.size() / 3; ++v) {
    if (!vertex_block(field, v).allFinite()) return v;
  }
  return std::nullopt;
}

}  // namespace

std::optional<BadForce> bad_force(const MechanicalSystem& system, const ForcePoint& at) {
  Vector force;
  for (const ForceTerm* term : system.force_terms()) {
    if (term->has_potential()) {
      force.setZero(system.dof_count());
      term->add_gradient(at, force);
      if (const auto v = first_not_finite(force)) return BadForce{term->name(), *v};
    }
    if (term->has_load()) {
      force.setZero(system.dof_count());
      term->add_load(at, force);
      if (const auto v = first_not_finite(force)) return BadForce{term->name(), *v};
    }
  }
  return std::nullopt;
}

bool leads_out_of_range(const MechanicalSystem& system, const State& from, double time) {
  bool leads = false;
  if (system.constraints().moving()) {
    Vector prescribed = from.position;
    system.constraints().prescribe(time, prescribed);
    leads = !prescribed.allFinite();
  }
  return anywhere(system.part(), leads);
}

namespace {

// Whether the body touches something at the beginning of the step, or would at its end. The stability limit says
// nothing of how long a step may be then.
bool is_in_impact(const RunData& run, double h) {
  const MechanicalSystem& system = *run.system;
  const Contact* contact = system.contact();
  if (contact == nullptr) return false;
  const State& state = run.state();
  if (std::isfinite(contact->smallest_gap(system.force_point(state.position, state.time)))) {
    return true;
  }
  Vector end;
  system.velocity_of(state.momentum, end);
  end = state.position + h * end;
  const ForcePoint after = system.force_point(end, state.time + h);
  return contact->undefined_vertex(after) >= 0 || std::isfinite(contact->smallest_gap(after));
}

}  // namespace

FailureCause cause_of(const RunData& run, const StepOutcome& outcome, const StepFailure& failure) {
  const MechanicalSystem& system = *run.system;
  const State& state = run.state();
  const TimeSettings& time = run.settings.time;
  const double h = failure.time_step;
  const MeshPart* part = system.part();
  if (outcome.status == StepStatus::kUndefined) return FailureCause::kForceTerm;
  if (outcome.status == StepStatus::kOverdamped) return FailureCause::kDamping;
  const TimeSpan span{failure.time, failure.time + h};
  Vector load;
  Vector forces;
  Vector springs;
  system.external_force(state.position, span.begin, h, load);
  const ForcePoint start = system.force_point(state.position, failure.time, span);
  if (gather_term_forces(system, start, load, forces, springs)) forces -= springs;
  bool is_bad = !forces.allFinite();
  if (!is_bad && failure.attempted_position.size() > 0 && failure.attempted_position.allFinite()) {
    const ForcePoint end = system.force_point(failure.attempted_position, span.end, span);
    is_bad = bad_force(system, end).has_value();
  }
  if (anywhere(part, is_bad)) return FailureCause::kForceTerm;
  // Forces of contact are no loads: they are as large as the motion makes them.
  Vector loads = forces;
  if (const Contact* contact = system.contact(); contact != nullptr) {
    contact->add_gradient(start, loads);
  }
  if (strain_of(system, loads) > kAbsurdStrain) return FailureCause::kLoads;
  switch (outcome.obstacle) {
    case StepObstacle::kPrescribedMotion:
      return FailureCause::kPrescribedMotion;
    case StepObstacle::kConstraints:
      return FailureCause::kConstraints;
    case StepObstacle::kLoads:
    case StepObstacle::kViscosity:
    case StepObstacle::kRoundOff:
      return FailureCause::kStepTooLarge;
    case StepObstacle::kSolver:
      break;
  }
  // A body that supports have compressed is so stiff that the limit has fallen.
  if (outcome.status == StepStatus::kInverted && anywhere(part, system.constraints().moving()) &&
      failure.stable_step < kCrushed * run.initial_limit.critical_step) {
    return FailureCause::kPrescribedMotion;
  }
  const bool implicit = is_implicit(time.integrator);
  if (!implicit && h > failure.stable_step) {
    return is_automatic(time) && outcome.status == StepStatus::kInverted &&
                   worst_is_held(system, failure)
               ? FailureCause::kPrescribedMotion
               : FailureCause::kStepAboveLimit;
  }
  if (fastest(system, state.momentum) > kAbsurdSpeed * wave_speed(system)) {
    return FailureCause::kSpeed;
  }
  if (outcome.status == StepStatus::kInverted && worst_is_held(system, failure)) {
    return FailureCause::kPrescribedMotion;
  }
  if (!implicit || outcome.status != StepStatus::kNotConverged) return FailureCause::kStepTooLarge;
  const Moduli moduli = moduli_of(system);
  if (moduli.most > kAbsurdContrast * moduli.least) return FailureCause::kStiffnessContrast;
  const MinimizerReport& report = outcome.minimizer;
  const double scale = report.asked_limit / run.settings.solver.tolerance;
  if (report.asked_limit > 0.0 && report.residual > report.residual_limit &&
      report.residual < kLoadRoundOff * scale) {
    return FailureCause::kTolerance;
  }
  if (report.termination == Termination::kIterationLimit) return FailureCause::kIterations;
  return h > failure.stable_step || is_in_impact(run, h) ? FailureCause::kStepTooLarge
                                                         : FailureCause::kSolver;
}

std::string remedy_for(const RunData& run, const StepFailure& failure, const StepOutcome& outcome,
                       const std::string& advice) {
  const MechanicalSystem& system = *run.system;
  const State& state = run.state();
  const SolverSettings& solver = run.settings.solver;
  const double h = failure.time_step;
  switch (failure.cause) {
    case FailureCause::kLoads:
      return fmt::format(
          "The loads are out of all proportion to the body, whose stiffest modulus is {:.3g} Pa: "
          "they would strain it more than a hundredfold, with any size of the steps. Check their "
          "size and units, and those of the modulus and of the mesh.",
          moduli_of(system).most);
    case FailureCause::kSpeed:
      return fmt::format(
          "A vertex moves at {:.3g} m/s relative to the body, and pressure waves in its material "
          "at {:.3g} m/s: no size of the steps helps. Check the velocities at the start, impulses "
          "and prescribed motion, and their units.",
          fastest(system, state.momentum), wave_speed(system));
    case FailureCause::kStiffnessContrast: {
      const Moduli moduli = moduli_of(system);
      return fmt::format(
          "The moduli of the body lie between {:.3g} and {:.3g} Pa, too far apart for double "
          "precision: bring them nearer together, or hold the stiff part with a constraint of kind "
          "\"rigid\".",
          moduli.least, moduli.most);
    }
    case FailureCause::kPrescribedMotion:
      if (leads_out_of_range(system, state, failure.time + h)) {
        return "Make the velocities, angular velocities, offsets and amplitudes of [[fix]] and "
               "[[constraint]] smaller, and check their units.";
      }
      return "What moves as prescribed crushes or tears the elements beside it: make the motion "
             "smaller or slower, check its direction and units, or refine the mesh there. " +
             advice;
    case FailureCause::kConstraints:
      return "Check the lengths of distances and the motion of handles. " + advice;
    case FailureCause::kTolerance:
      return fmt::format(
          "solver.tolerance = {:.3g} is below the round-off of the forces: the step came as near "
          "as double precision allows. Take solver.tolerance = {:.1g} or larger.",
          solver.tolerance,
          2.0 * outcome.minimizer.residual / outcome.minimizer.asked_limit * solver.tolerance);
    case FailureCause::kIterations: {
      const int usual = SolverSettings{}.max_iterations;
      const std::string more = fmt::format("solver.max_iterations = {} did not suffice: raise it.",
                                           solver.max_iterations);
      // So few may be too few for any step.
      if (solver.max_iterations < usual && run.settings.time.retry == 0) {
        return more + fmt::format(" The default is {}.", usual);
      }
      return more + " " + advice;
    }
    case FailureCause::kForceTerm:
      if (outcome.status == StepStatus::kUndefined) return advice;
      return "Correct the term: it must give finite forces wherever its potential is defined. "
             "Amplitudes and strengths must be finite, too.";
    case FailureCause::kSolver:
      return fmt::format(
          "The step of {:.4g} s is below the explicit stability limit of {:.4g} s, so that its "
          "size is hardly the cause. Check loads, materials, prescribed motion and the quality of "
          "the mesh (tetraction check), or take another solver.kind.",
          h, failure.stable_step);
    case FailureCause::kStepAboveLimit:
    case FailureCause::kStepTooLarge:
    case FailureCause::kDamping:
      break;
  }
  return advice;
}

}  // namespace tetraction
