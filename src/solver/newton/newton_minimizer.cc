#include "tetraction/solver/newton_minimizer.h"

#include <cmath>

#include "forcing_term.h"
#include "line_search.h"
#include "newton_linear_solver.h"
#include "solver_checks.h"

namespace tetraction {
namespace {

class NewtonMinimizer : public Minimizer {
 public:
  NewtonMinimizer(const MechanicalSystem& system, const NewtonOptions& options)
      : options_(options), linear_(system, options), path_(system) {
    check_options(options);
  }

  MinimizerReport minimize(const MinimizationProblem& problem, Vector& x) override {
    MinimizerReport report;
    linear_.begin_step(problem, x);
    at_.u = x;
    if (!begin_minimization(problem, options_.tolerance, at_, report)) return report;
    met_curvature_ = false;
    for (;;) {
      descend(problem, report);
      const bool ended = report.converged() || report.termination == Termination::kNoProgress;
      // The gradient vanishes at a saddle, too, and Newton's method may stop near one.
      if (!ended || !is_suspect(problem, report) ||
          !leave(problem, find_negative_curvature(problem, report), report)) {
        break;
      }
      report.met_negative_curvature = true;
      ++report.iterations;
    }
    x = at_.u;
    report.linear = linear_.name();
    report.message = termination_message(report.termination);
    if (!report.converged() &&
        (options_.linear == LinearSolver::kCg || options_.linear == LinearSolver::kMatrixFree)) {
      report.message += "; solver.linear = \"auto\" or \"factor\" gives better directions";
    }
    report.met_negative_curvature |= met_curvature_;
    if (report.converged()) linear_.end_step(report.iterations);
    return report;
  }

  bool solve_linearized(const MinimizationProblem& problem, const Vector& x, const Matrix& right,
                        Matrix& solution) override {
    return linear_.solve_exactly(problem, x, right, solution);
  }

 private:
  // Newton's method until the residual is small enough or no direction makes progress. A residual that does not
  // get smaller near round-off is as small as it can be.
  void descend(const MinimizationProblem& problem, MinimizerReport& report) {
    constexpr double kNear = 2.0;  // times the estimate of round-off
    constexpr int kStalls = 2;
    ForcingTerm forcing(first_forcing_);
    int stalls = 0;
    int moves = 0;
    const auto is_near = [&] { return report.residual <= kNear * problem.round_off(at_.u); };
    const bool first_may_do = !problem.is_loaded(at_.u);
    while (!is_small_enough(report, first_may_do)) {
      if (report.iterations >= options_.max_iterations) {
        report.termination = Termination::kIterationLimit;
        return;
      }
      ++report.iterations;
      const double before = report.residual;
      const NewtonSystem system{problem, at_.u, at_.force, forcing.next(report)};
      if (!linear_.find(system, report, direction_) || !search(problem, report)) {
        if (moves > 0 && is_near()) break;
        if (linear_.refine()) continue;
        report.termination = Termination::kNoProgress;
        return;
      }
      if (direction_.curvature.found()) {
        met_curvature_ = true;
        leave(problem, direction_.curvature, report);
      }
      stalls = report.residual > 0.5 * before ? stalls + 1 : 0;
      ++moves;
      if (stalls >= kStalls && is_near()) break;
      forcing.enter(report.residual / before);
      if (report.iterations == 1) first_forcing_ = forcing.first_of_next_step();
    }
    report.termination = Termination::kConverged;
  }

  bool search(const MinimizationProblem& problem, MinimizerReport& report) {
    const bool found = line_search_.search(
        problem, {direction_.d, direction_.is_safe, report.residual_limit, path(problem)}, at_);
    report.residual = at_.residual;
    return found;
  }

  // Whether to examine the Hessian at the end of a minimisation. It is always examined if a
  // direction of negative curvature was met, if the step was a large one, or if the body may
  // buckle. Otherwise it is examined so seldom that it costs no more than one per cent of the work.
  bool is_suspect(const MinimizationProblem& problem, const MinimizerReport& report) {
    constexpr int kOrdinary = 5;     // iterations
    constexpr double kShare = 0.01;  // of the work
    constexpr double kNewton = 5.0;  // work of an iteration of Newton's method …
    constexpr double kStep = 15.0;   // … and of a step, in iterations of conjugate gradients
    credit_ += kShare * (kStep + kNewton * report.iterations + report.cg_iterations);
    const bool may_buckle = buckles(problem);
    // Where no step makes progress, the last direction began at the end.
    if (!problem.has_inertia() && !report.converged() && direction_.is_definite) return false;
    if (met_curvature_ || !report.converged()) return true;
    if (direction_.is_definite) return false;
    // The first guess was good enough, as for a body at rest.
    const bool nothing_known = report.iterations == 0 && !known_;
    known_ = report.iterations == 0;
    return nothing_known || may_buckle || report.iterations > kOrdinary || credit_ > price_;
  }

  // Whether the body may buckle in this step. If the Hessian was definite at a similar ratio, it
  // need not be examined again.
  bool buckles(const MinimizationProblem& problem) {
    constexpr double kGrowth = 1.2;
    constexpr double kMemory = 0.97;
    const double ratio = problem.buckling_ratio(at_.u);
    if (std::isinf(ratio)) return true;
    definite_ratio_ *= kMemory;
    if (ratio <= 1.0 || ratio <= kGrowth * definite_ratio_) return false;
    definite_ratio_ = ratio;
    return true;
  }

  NegativeCurvature find_negative_curvature(const MinimizationProblem& problem,
                                            MinimizerReport& report) {
    constexpr double kFactorization = 30.0;  // work of one, in iterations of conjugate gradients
    const int iterations = report.cg_iterations;
    const int factorizations = report.factorizations;
    NegativeCurvature found = linear_.find_negative_curvature(problem, at_.u, report);
    price_ = 1.0 + report.cg_iterations - iterations +
             kFactorization * (report.factorizations - factorizations);
    credit_ = 0.0;
    return found;
  }

  // Moves to a lower point along a direction of negative curvature. Returns false if there is none.
  bool leave(const MinimizationProblem& problem, const NegativeCurvature& curvature,
             MinimizerReport& report) {
    const bool left = follow(problem, curvature, at_, path(problem));
    report.residual = at_.residual;
    return left;
  }

  // Without inertia a minimum may be far away, along a curved valley.
  TurningPath* path(const MinimizationProblem& problem) {
    return !problem.has_inertia() && linear_.affords_factor() ? &path_ : nullptr;
  }

  NewtonOptions options_;
  NewtonLinearSolver linear_;
  TurningPath path_;
  LineSearch line_search_;
  double first_forcing_ = ForcingTerm::kFirst;
  bool met_curvature_ = false;   // in this minimisation
  bool known_ = false;           // the last minimisation took no iteration either
  double definite_ratio_ = 0.0;  // buckling ratio when the Hessian was examined last
  double credit_ = 0.0;  // for examining the next Hessian, in iterations of conjugate gradients
  double price_ = 30.0;  // of the last one
  Iterate at_;
  NewtonDirection direction_;  // the last one
};

}  // namespace

std::unique_ptr<Minimizer> make_newton_minimizer(const MechanicalSystem& system,
                                                 const NewtonOptions& options) {
  return std::make_unique<NewtonMinimizer>(system, options);
}

}  // namespace tetraction
