#include "tetraction/solver/newton_root_finder.h"

#include <cmath>
#include <utility>

#include "assembled_system.h"
#include "core/gmres.h"
#include "forcing_term.h"
#include "line_search.h"
#include "solver_checks.h"

namespace tetraction {
namespace {

class NewtonRootFinder : public RootFinder {
 public:
  NewtonRootFinder(const MechanicalSystem& system, const MinimizerOptions& options)
      : options_(options), matrix_(system) {
    check_options(options);
  }

  MinimizerReport find_root(RootProblem& problem, Vector& u) override {
    MinimizerReport report;
    report.linear = "gmres";
    at_.u = u;
    if (!make_admissible(problem, at_.u) || !evaluate(std::as_const(problem), at_)) {
      report.termination = Termination::kInadmissible;
      report.message = "the forces are not defined at the start of the step";
      return report;
    }
    report.residual = at_.residual;
    report.residual_limit = problem.residual_limit(at_.u, options_.tolerance);
    report.asked_limit = asked_limit(problem, at_.u, options_.tolerance);
    if (!std::isfinite(report.residual_limit)) {
      report.termination = Termination::kInadmissible;
      report.message = "the forces or momenta are too large for double precision";
      return report;
    }
    iterate(problem, report);
    u = at_.u;
    report.message = report.termination == Termination::kNoProgress
                         ? "no step lowers the force residual any further"
                         : termination_message(report.termination);
    return report;
  }

 private:
  void iterate(RootProblem& problem, MinimizerReport& report) {
    ForcingTerm forcing(first_forcing_);
    const bool first_may_do = !problem.is_loaded(at_.u);
    while (!is_small_enough(report, first_may_do)) {
      if (report.iterations >= options_.max_iterations) {
        report.termination = Termination::kIterationLimit;
        return;
      }
      ++report.iterations;
      const double before = report.residual;
      const bool found =
          problem.linearize(at_.u).ok() && find_direction(problem, forcing.next(report), report) &&
          line_search_.search(problem, {direction_, false, report.residual_limit}, at_);
      report.residual = at_.residual;
      if (!found) {
        // A new factor may give a direction of more digits.
        if (!factor_is_old_) {
          report.termination = Termination::kNoProgress;
          return;
        }
        matrix_is_stale_ = true;
        continue;
      }
      factor_is_old_ = true;
      forcing.enter(report.residual / before);
      if (report.iterations == 1) first_forcing_ = forcing.first_of_next_step();
    }
    report.termination = Termination::kConverged;
  }

  // direction_ ≈ −(∂r/∂u)⁻¹ r.
  bool find_direction(const RootProblem& problem, double forcing, MinimizerReport& report) {
    // With a factor of the same matrix GMRES takes a few iterations, one for each unsymmetric part.
    constexpr int kMany = 20;
    constexpr int kMost = 200;
    if (matrix_is_stale_ || !matrix_.has_factor()) {
      if (!factorize(problem, report)) return false;
    }
    GmresReport solved = solve(problem, forcing, factor_is_old_ ? kMany : kMost, report);
    if (!solved.converged && factor_is_old_) {
      if (!factorize(problem, report)) return false;
      solved = solve(problem, forcing, kMost, report);
    }
    return direction_.allFinite() && solved.reduction < 1.0;
  }

  bool factorize(const RootProblem& problem, MinimizerReport& report) {
    const MinimizationProblem& approximation = problem.approximation();
    ++report.factorizations;
    matrix_is_stale_ = true;
    if (!matrix_.assemble(approximation, at_.u)) return false;
    if (!matrix_.factorize()) {
      ++report.factorizations;
      if (!matrix_.factorize_projected(approximation, at_.u)) return false;
    }
    matrix_is_stale_ = factor_is_old_ = false;
    return true;
  }

  GmresReport solve(const RootProblem& problem, double forcing, int most, MinimizerReport& report) {
    const FreeCoordinates& coordinates = problem.coordinates();
    const GmresReport solved = gmres(
        -coordinates.restrict(at_.force),
        [&](const Vector& y, Vector& product) {
          problem.multiply(coordinates.extend(y), full_);
          product = coordinates.restrict(full_);
        },
        [&](const Vector& y, Vector& z) { z = matrix_.back_solve(y); }, forcing, most, free_);
    report.cg_iterations += solved.iterations;
    direction_ = coordinates.extend(free_);
    return solved;
  }

  MinimizerOptions options_;
  AssembledSystem matrix_;
  LineSearch line_search_;
  double first_forcing_ = ForcingTerm::kFirst;
  bool matrix_is_stale_ = true;
  bool factor_is_old_ = false;  // it belongs to another point
  Iterate at_;
  Vector direction_;  // 3 per vertex
  Vector free_;       // the same over the free coordinates
  Vector full_;       // work space, 3 per vertex
};

}  // namespace

std::unique_ptr<RootFinder> make_newton_root_finder(const MechanicalSystem& system,
                                                    const MinimizerOptions& options) {
  return std::make_unique<NewtonRootFinder>(system, options);
}

}  // namespace tetraction
