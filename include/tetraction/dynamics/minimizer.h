// What an implicit step asks of a solver.
#pragma once

#include <string>

#include "tetraction/dynamics/step_problem.h"

namespace tetraction {

/// Why a minimisation ended.
enum class Termination {
  kConverged,       ///< |Tᵀ∇Φ| ≤ residual_limit
  kIterationLimit,  ///< max_iterations reached
  kNoProgress,      ///< no step lowers Φ any further, and the gradient is still too large
  kInadmissible     ///< Φ is not defined at the starting point nor at q_k
};

/// Options of an implicit step's solver.
struct MinimizerOptions {
  double tolerance = 1.0e-8;  ///< see StepProblem::residual_limit; 0 < tolerance < 1
  int max_iterations = 100;   ///< ≥ 1
};

/// What a minimisation did.
struct MinimizerReport {
  Termination termination = Termination::kNoProgress;
  int iterations = 0;  ///< linear systems solved for a step, accepted or not
  int factorizations = 0;
  int cg_iterations = 0;        ///< of conjugate gradients, in all linear systems
  std::string linear;           ///< how the linear systems were solved, e.g. "matrix-free"
  double residual = 0.0;        ///< |Tᵀ∇Φ|₂ over the free coordinates at the end, N
  double residual_limit = 0.0;  ///< what it was held against, N (StepProblem::residual_limit)
  double asked_limit = 0.0;     ///< what the tolerance asks for: tolerance × force scale, N
  std::string message;          ///< one line, for the user

  bool converged() const { return termination == Termination::kConverged; }
  /// Whether the step is as good as double precision allows, and not as good as was asked for.
  bool limited_by_round_off() const {
    return converged() && asked_limit > 0.0 && residual > asked_limit;
  }
};

/// Minimises Φ over the free coordinates.
class Minimizer {
 public:
  virtual ~Minimizer() = default;
  /// Starts from the displacement u from the problem's origin (a point with an inverted element is
  /// first moved toward the origin until Φ is defined) and leaves the minimiser there. Prescribed
  /// components of u must be 0 and are not touched.
  virtual MinimizerReport minimize(const StepProblem& problem, Vector& u) = 0;
  /// solution = (Tᵀ∇²Φ(u)T)⁻¹ right, for the multipliers of constraints. Returns false if the matrix
  /// is not positive definite.
  virtual bool solve_linearized(const StepProblem& problem, const Vector& u, const Matrix& right,
                                Matrix& solution) = 0;
};

/// Moves u toward 0, the problem's origin, halving the way, until Φ is defined there.
/// Returns false if it is not even defined at the origin.
bool make_admissible(const StepProblem& problem, Vector& u);

}  // namespace tetraction
