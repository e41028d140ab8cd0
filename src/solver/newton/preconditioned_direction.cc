#include "preconditioned_direction.h"

#include <utility>

namespace tetraction {
namespace {

// A preconditioner is made anew if a system takes so many times the iterations that the first one took with
// it, and this many more.
constexpr int kAging = 2;
constexpr int kAllowed = 8;
constexpr int kMostWithoutMatrix = 2000;  // iterations with the preconditioner of MatrixFreeCg

}  // namespace

PreconditionedDirection::PreconditionedDirection(const MechanicalSystem& system,
                                                 std::unique_ptr<BodyPreconditioner> preconditioner,
                                                 int most_iterations)
    : cg_(system), preconditioner_(std::move(preconditioner)), most_iterations_(most_iterations) {}

void PreconditionedDirection::find(const MinimizationProblem& problem, const Vector& x,
                                   const Vector& gradient, double forcing, MinimizerReport& report,
                                   Vector& direction) {
  curvature_ = {};
  is_new_ = false;
  cg_.set(problem, x);
  if (is_old_) renew(problem, x, false, report);
  const auto failed = [](const CgReport& cg) { return !cg.converged && !cg.negative_curvature; };
  CgReport cg = solve(gradient, forcing, report, direction);
  // The reason may be that the preconditioner is of another time …
  if (failed(cg) && !is_new_) {
    renew(problem, x, false, report);
    cg = solve(gradient, forcing, report, direction);
  }
  // … or that it does not serve, as multigrid where elements are much deformed.
  if (failed(cg)) {
    cg = cg_.solve(gradient, forcing, kMostWithoutMatrix, direction);
    report.cg_iterations += cg.iterations;
    is_old_ = true;
  }
  is_safe_ = cg_.step_is_safe();
  if (cg.negative_curvature || failed(cg)) {
    if (cg.negative_curvature) curvature_ = cg_.negative_curvature();
    if (!is_new_ || !is_convex_) renew(problem, x, true, report);
    cg.iterations = preconditioner_->solve(-gradient, forcing, direction);
    report.cg_iterations += cg.iterations;
    is_safe_ = false;
    is_old_ = true;
  }
  if (is_new_) first_iterations_ = cg.iterations;
  is_old_ = is_old_ || cg.iterations > kAging * first_iterations_ + kAllowed;
}

bool PreconditionedDirection::probe(const MinimizationProblem& problem, const Vector& x,
                                    const Vector& right, double forcing, MinimizerReport& report) {
  curvature_ = {};
  if (is_old_ || sign_ != BodyPreconditioner::Sign::kDefinite) return false;
  cg_.set(problem, x);
  const CgReport cg = solve(right, forcing, report, ignored_);
  if (cg.negative_curvature) curvature_ = cg_.negative_curvature();
  return cg.converged || cg.negative_curvature;
}

CgReport PreconditionedDirection::solve(const Vector& right, double forcing,
                                        MinimizerReport& report, Vector& solution) {
  const CgReport cg = cg_.solve(right, forcing, most_iterations_, *preconditioner_, solution);
  report.cg_iterations += cg.iterations;
  return cg;
}

void PreconditionedDirection::renew(const MinimizationProblem& problem, const Vector& x,
                                    bool convex, MinimizerReport& report) {
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
