// Checks and reports that all solvers of implicit steps share.
#pragma once

#include <cmath>
#include <string>

#include "line_search.h"
#include "tetraction/core/error.h"
#include "tetraction/dynamics/problems/minimizer.h"
#include "tetraction/dynamics/problems/nonlinear_problem.h"

namespace tetraction {

/// Throws InputError for options out of their range.
inline void check_options(const MinimizerOptions& options) {
  if (!(options.tolerance > 0.0 && options.tolerance < 1.0) || options.max_iterations < 1) {
    throw InputError("The solver needs 0 < tolerance < 1 and max_iterations ≥ 1.");
  }
}

/// MinimizerReport::asked_limit. Forces far below round-off are no loads: at rest without loads nothing
/// is asked for.
inline double asked_limit(const NonlinearProblem& problem, const Vector& u, double tolerance) {
  return problem.is_loaded(u) ? tolerance * problem.force_scale() : 0.0;
}

/// Sets the limits of the report for an iteration that begins at u with report.residual. Returns false, with
/// the reason in the report, if the numbers overflow.
inline bool set_limits(const NonlinearProblem& problem, const Vector& u, double tolerance,
                       MinimizerReport& report) {
  report.residual_limit = problem.residual_limit(u, tolerance);
  report.asked_limit = asked_limit(problem, u, tolerance);
  if (std::isfinite(report.residual_limit) && std::isfinite(report.residual)) return true;
  report.termination = Termination::kInadmissible;
  report.message = "the forces or momenta are too large for double precision";
  return false;
}

/// Evaluates the problem at iterate.u, which is moved to where Φ is defined, and sets the report's residual
/// and limits. Returns false, with the reason in the report, if a minimisation cannot begin there.
inline bool begin_minimization(const MinimizationProblem& problem, double tolerance,
                               Iterate& iterate, MinimizerReport& report) {
  if (!evaluate(problem, iterate) &&
      (!make_admissible(problem, iterate.u) || !evaluate(problem, iterate))) {
    report.termination = Termination::kInadmissible;
    report.message = "the elastic energy is not defined at the start of the step";
    return false;
  }
  report.residual = iterate.residual;
  return set_limits(problem, iterate.u, tolerance, report);
}

/// Whether the residual in the report ends an iteration. Without an iteration it must be below the limit of
/// the tolerance itself, unless `first_may_do` (NonlinearProblem::is_loaded()).
inline bool is_small_enough(const MinimizerReport& report, bool first_may_do) {
  return report.residual <= report.asked_limit ||
         ((report.iterations > 0 || first_may_do) && report.residual <= report.residual_limit);
}

/// One line for MinimizerReport::message.
inline std::string termination_message(Termination termination) {
  switch (termination) {
    case Termination::kConverged:
      return "converged: the force residual is below its limit";
    case Termination::kIterationLimit:
      return "the iteration limit was reached";
    case Termination::kNoProgress:
      return "no step lowers the potential any further";
    case Termination::kInadmissible:
      break;
  }
  return "the elastic energy is not defined at the end of the minimisation";
}

}  // namespace tetraction
