#include "newton_linear_solver.h"

#include <cmath>

namespace tetraction {

NewtonLinearSolver::NewtonLinearSolver(const MechanicalSystem& system, const NewtonOptions& options)
    : system_(system),
      choice_(system, options),
      matrix_free_(system, choice_),
      factor_(system, options.keep_factor, choice_, matrix_free_),
      diagonal_(system, choice_, factor_) {}

void NewtonLinearSolver::begin_step(const MinimizationProblem& problem, const Vector& x) {
  choice_.begin_step();
  // A factor or coarse space for another step size belongs to a very different matrix.
  const Vector& diagonal = problem.hessian_parts(x).diagonal;
  const double sum =
      sum_over_parts(system_.part(), diagonal.head(3 * system_.owned_vertex_count()).sum());
  if (std::abs(sum - coefficient_sum_) > 0.01 * std::abs(sum)) {
    coefficient_sum_ = sum;
    factor_.forget();
    matrix_free_.forget();
    if (preconditioned_) preconditioned_->forget();
  }
}

bool NewtonLinearSolver::find(const NewtonSystem& system, MinimizerReport& report,
                              NewtonDirection& direction) {
  if (system.has_new_matrix) matrix_free_.leave_matrix();
  direction.curvature = {};
  direction.is_safe = direction.is_definite = false;
  if (system.begins_iteration && choice_.begin_iteration(report.residual)) factor_.forget();
  const bool is_exact = choice_.takes_exact_factor();
  bool found = false;
  if (is_exact && system_.part() == nullptr) {
    found = factor_.find_exactly(system, report, direction);
  } else {
    const bool with_matrix = is_exact || choice_.current() != LinearSolver::kMatrixFree;
    found = strategy(with_matrix).find(system, report, direction);
    if (!found && !with_matrix) {
      choice_.take_factor();
      found = strategy(true).find(system, report, direction);
    }
  }
  return everywhere(system_.part(), found && direction.d.allFinite());
}

NegativeCurvature NewtonLinearSolver::find_negative_curvature(const MinimizationProblem& problem,
                                                              const Vector& x,
                                                              MinimizerReport& report) {
  return strategy(choice_.current() != LinearSolver::kMatrixFree)
      .find_negative_curvature(problem, x, report);
}

// The strategy of the present choice, or the one that takes its place if it shall have a matrix.
LinearStrategy& NewtonLinearSolver::strategy(bool with_matrix) {
  if (!with_matrix) return matrix_free_;
  const bool is_cg = choice_.current() == LinearSolver::kCg;
  if (system_.part() == nullptr) {
    if (is_cg) return diagonal_;
    return factor_;
  }
  if (!preconditioned_) {
    using Kind = BodyPreconditioner::Kind;
    preconditioned_ = std::make_unique<PreconditionedStrategy>(
        system_, is_cg ? Kind::kMultigrid : Kind::kFactor, choice_, matrix_free_);
  }
  return *preconditioned_;
}

std::string NewtonLinearSolver::name() const {
  if (choice_.current() == LinearSolver::kMatrixFree) return "matrix-free";
  if (preconditioned_) return preconditioned_->name();
  return choice_.current() == LinearSolver::kCg ? "cg" : "factor";
}

}  // namespace tetraction
