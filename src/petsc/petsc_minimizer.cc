#include "petsc_minimizer.h"

#include "linear_system.h"
#include "solver/forcing_term.h"
#include "solver/line_search.h"
#include "solver/solver_checks.h"

namespace tetraction::petsc {
namespace {

// A preconditioner is made anew if a system takes so many times the iterations that the first one took with
// it, and this many more.
constexpr int kAging = 2;
constexpr int kAllowed = 8;

class PetscMinimizer : public Minimizer {
 public:
  PetscMinimizer(const MechanicalSystem& system, const MpiPart& part,
                 const MinimizerOptions& options, const std::string& linear)
      : options_(options),
        system_(system, part,
                linear == "factor" ? LinearSystem::Preconditioner::kFactor
                                   : LinearSystem::Preconditioner::kMultigrid) {
    check_options(options);
  }

  MinimizerReport minimize(const MinimizationProblem& problem, Vector& u) override {
    MinimizerReport report;
    at_.u = u;
    if (!begin_minimization(problem, options_.tolerance, at_, report)) return report;
    descend(problem, report);
    u = at_.u;
    report.linear = system_.name();
    report.message = termination_message(report.termination);
    return report;
  }

  // The multipliers of constraints would need it, which a body in parts does not have.
  bool solve_linearized(const MinimizationProblem&, const Vector&, const Matrix&,
                        Matrix&) override {
    return false;
  }

 private:
  void descend(const MinimizationProblem& problem, MinimizerReport& report) {
    ForcingTerm forcing(first_forcing_);
    const bool first_may_do = !problem.is_loaded(at_.u);
    while (!is_small_enough(report, first_may_do)) {
      if (report.iterations >= options_.max_iterations) {
        report.termination = Termination::kIterationLimit;
        return;
      }
      ++report.iterations;
      const double before = report.residual;
      find(problem, forcing.next(report), report);
      const bool found =
          line_search_.search(problem, {direction_, false, report.residual_limit}, at_);
      report.residual = at_.residual;
      if (!found) {
        report.termination = Termination::kNoProgress;
        return;
      }
      forcing.enter(report.residual / before);
      if (report.iterations == 1) first_forcing_ = forcing.first_of_next_step();
    }
    report.termination = Termination::kConverged;
  }

  // direction_ ← a solution of the linear system at at_.u.
  void find(const MinimizationProblem& problem, double forcing, MinimizerReport& report) {
    system_.set(problem, at_.u, false);
    if (is_old_ || system_.is_outdated()) renew(problem, false, report);
    LinearSystem::Report done = solve(forcing, report);
    // The preconditioner of another time, or the matrix, may be the reason.
    if (!done.converged && !is_new_) {
      renew(problem, false, report);
      done = solve(forcing, report);
    }
    if (!done.converged) {
      report.met_negative_curvature = report.met_negative_curvature || done.indefinite;
      system_.set(problem, at_.u, true);
      renew(problem, true, report);
      done = solve(forcing, report);
      is_old_ = true;
    }
    if (is_new_) first_iterations_ = done.iterations;
    is_new_ = false;
    is_old_ = is_old_ || done.iterations > kAging * first_iterations_ + kAllowed;
  }

  LinearSystem::Report solve(double forcing, MinimizerReport& report) {
    const LinearSystem::Report done = system_.solve(at_.force, forcing, direction_);
    report.cg_iterations += done.iterations;
    return done;
  }

  void renew(const MinimizationProblem& problem, bool convex, MinimizerReport& report) {
    system_.make_preconditioner(problem, at_.u, convex);
    ++report.factorizations;
    is_new_ = true;
    is_old_ = false;
  }

  MinimizerOptions options_;
  LinearSystem system_;
  LineSearch line_search_;
  Iterate at_;
  Vector direction_;
  double first_forcing_ = ForcingTerm::kFirst;
  bool is_new_ = false;  // the preconditioner belongs to the present matrix
  bool is_old_ = false;
  int first_iterations_ = 0;  // of the first system with the preconditioner
};

}  // namespace

std::unique_ptr<Minimizer> make_petsc_minimizer(const MechanicalSystem& system, const MpiPart& part,
                                                const MinimizerOptions& options,
                                                const std::string& linear) {
  if (!TangentOperator<double>::supports(system.elastic())) {
    throw InputError(
        "Implicit steps with a material of a program do not work in several processes yet: take "
        "integrator = \"verlet\" or \"explicit\", or run the scene in one process.");
  }
  return std::make_unique<PetscMinimizer>(system, part, options, linear);
}

}  // namespace tetraction::petsc
