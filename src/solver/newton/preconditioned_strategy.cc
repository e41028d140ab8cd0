#include "preconditioned_strategy.h"

namespace tetraction {
namespace {

// A preconditioner is made anew if a system takes so many times the iterations that the first one took with
// it, and this many more.
constexpr int kAging = 2;
constexpr int kAllowed = 8;
// The most iterations of a system.
constexpr int kMostWithFactor = 30;
constexpr int kMostWithMultigrid = 2000;
constexpr int kMostWithoutMatrix = 2000;  // with the preconditioner of MatrixFreeCg

}  // namespace

PreconditionedStrategy::PreconditionedStrategy(const MechanicalSystem& system,
                                               BodyPreconditioner::Kind kind,
                                               const LinearSolverChoice& choice,
                                               MatrixFreeStrategy& matrix_free)
    : system_(system),
      choice_(choice),
      matrix_free_(matrix_free),
      cg_(system),
      preconditioner_(dynamic_cast<const PreconditionerSource&>(*system.part())
                          .make_preconditioner(system, kind)),
      most_iterations_(kind == BodyPreconditioner::Kind::kFactor ? kMostWithFactor
                                                                 : kMostWithMultigrid) {}

bool PreconditionedStrategy::find(const NewtonSystem& system, MinimizerReport& report,
                                  NewtonDirection& direction) {
  const MinimizationProblem& problem = system.problem;
  const Vector& x = system.x;
  const Vector& gradient = system.gradient;
  const double forcing = choice_.refined_forcing(system.forcing);
  direction.curvature = {};
  is_new_ = false;
  cg_.set(problem, x);
  if (is_old_) renew(problem, x, false, report);
  const auto failed = [](const CgReport& cg) { return !cg.converged && !cg.negative_curvature; };
  CgReport cg = solve(gradient, forcing, report, direction.d);
  // The reason may be that the preconditioner is of another time …
  if (failed(cg) && !is_new_) {
    renew(problem, x, false, report);
    cg = solve(gradient, forcing, report, direction.d);
  }
  // … or that it does not serve, as multigrid where elements are much deformed.
  if (failed(cg)) {
    cg = cg_.solve(gradient, forcing, kMostWithoutMatrix, direction.d);
    report.cg_iterations += cg.iterations;
    is_old_ = true;
  }
  direction.is_safe = cg_.step_is_safe();
  if (cg.negative_curvature || failed(cg)) {
    if (cg.negative_curvature) direction.curvature = cg_.negative_curvature();
    if (!is_new_ || !is_convex_) renew(problem, x, true, report);
    cg.iterations = preconditioner_->solve(-gradient, forcing, direction.d);
    report.cg_iterations += cg.iterations;
    direction.is_safe = false;
    is_old_ = true;
  }
  if (is_new_) first_iterations_ = cg.iterations;
  is_old_ = is_old_ || cg.iterations > kAging * first_iterations_ + kAllowed;
  return true;
}

NegativeCurvature PreconditionedStrategy::find_negative_curvature(
    const MinimizationProblem& problem, const Vector& x, MinimizerReport& report) {
  if (!is_old_ && sign_ == BodyPreconditioner::Sign::kDefinite) {
    const Vector& right = matrix_free_.probing_vector(x.size());
    cg_.set(problem, x);
    const CgReport cg = solve(right, probing_forcing(choice_.unknowns()), report, ignored_);
    if (cg.negative_curvature) return cg_.negative_curvature();
    if (cg.converged) return {};
  }
  return matrix_free_.find_negative_curvature(problem, x, report);
}

CgReport PreconditionedStrategy::solve(const Vector& right, double forcing, MinimizerReport& report,
                                       Vector& solution) {
  const CgReport cg = cg_.solve(right, forcing, most_iterations_, *preconditioner_, solution);
  report.cg_iterations += cg.iterations;
  return cg;
}

void PreconditionedStrategy::renew(const MinimizationProblem& problem, const Vector& x, bool convex,
                                   MinimizerReport& report) {
  sign_ = preconditioner_->make(problem, x, convex);
  ++report.factorizations;
  // A factor of an indefinite matrix would hide the directions of negative curvature.
  if (sign_ == BodyPreconditioner::Sign::kIndefinite && !convex) {
    sign_ = preconditioner_->make(problem, x, true);
    ++report.factorizations;
    convex = true;
  }
  is_convex_ = convex;
  is_new_ = true;
  is_old_ = false;
}

}  // namespace tetraction
