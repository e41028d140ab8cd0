// The interfaces between an implicit step and its solvers.
#pragma once

#include <string>

#include "tetraction/dynamics/problems/nonlinear_problem.h"

namespace tetraction {

/// Why a solver ended. r is the residual, ∇Φ in a minimisation.
enum class Termination {
  kConverged,       ///< |Tᵀr| ≤ residual_limit
  kIterationLimit,  ///< max_iterations reached
  kNoProgress,      ///< no step makes progress any more, and the residual is still too large
  kInadmissible     ///< the problem is not defined at the starting point nor at its origin
};

/// Options of an implicit step's solver.
struct MinimizerOptions {
  double tolerance = 1.0e-8;  ///< see NonlinearProblem::residual_limit(); 0 < tolerance < 1
  int max_iterations = 100;   ///< ≥ 1
};

/// The report of a solver.
struct MinimizerReport {
  Termination termination = Termination::kNoProgress;
  int iterations = 0;  ///< linear systems solved for a step, accepted or not
  int factorizations = 0;
  int cg_iterations = 0;        ///< of conjugate gradients, in all linear systems
  std::string linear;           ///< how the linear systems were solved, e.g. "matrix-free"
  double residual = 0.0;        ///< |Tᵀr|₂ over the free coordinates at the end, N
  double residual_limit = 0.0;  ///< the limit for it, N (NonlinearProblem::residual_limit())
  double asked_limit = 0.0;     ///< the limit of the tolerance alone: tolerance × force scale, N
  std::string message;          ///< one line, for the user
  /// Whether a direction of negative curvature was found on the way: the Hessian was not positive
  /// definite everywhere.
  bool met_negative_curvature = false;

  bool converged() const { return termination == Termination::kConverged; }
  /// Whether the step is as exact as double precision allows, but less exact than the tolerance
  /// demands.
  bool limited_by_round_off() const {
    return converged() && asked_limit > 0.0 && residual > asked_limit;
  }
};

/// Minimises Φ over the free coordinates.
class Minimizer {
 public:
  virtual ~Minimizer() = default;
  /// Minimises Φ, beginning at the displacement u from the problem's origin, and returns the
  /// minimiser in u. If Φ is not defined at u, u is first moved toward the origin until Φ is
  /// defined. Prescribed components of u must be 0 and are not changed.
  virtual MinimizerReport minimize(const MinimizationProblem& problem, Vector& u) = 0;
  /// solution = (Tᵀ∇²Φ(u)T)⁻¹ right. The multipliers of constraints need it. Returns false if the
  /// matrix is not positive definite.
  virtual bool solve_linearized(const MinimizationProblem& problem, const Vector& u,
                                const Matrix& right, Matrix& solution) = 0;
};

/// Finds a root of equations that are not the gradient of a function.
class RootFinder {
 public:
  virtual ~RootFinder() = default;
  /// Solves r(u) = 0 over the free coordinates, beginning at u, and returns the solution in u. If r
  /// is not defined at u, u is first moved toward the origin as in Minimizer::minimize(). In the
  /// report the residual is |Tᵀr|₂, and conjugate gradients stand for the method that solves the
  /// linear systems.
  virtual MinimizerReport find_root(RootProblem& problem, Vector& u) = 0;
  /// correction = −(∂r/∂u)⁻¹ r(u) with all the digits that the residual has. Returns false if it cannot be
  /// found.
  virtual bool newton_correction(RootProblem& problem, const Vector& u, Vector& correction) = 0;
  /// Solves Tᵀ(∂r/∂u) d = Tᵀf at u for each column f of `forces` (3 per vertex, N). The columns of
  /// `displacements` are d (3 per vertex, m), with a relative residual of about 1e-10. Returns false if one
  /// cannot be found.
  virtual bool solve_linearized(RootProblem& problem, const Vector& u, const Matrix& forces,
                                Matrix& displacements) = 0;
};

/// Halves u, the displacement from the problem's origin, until the problem is defined there.
/// Returns false if it is not even defined at the origin.
bool make_admissible(const NonlinearProblem& problem, Vector& u);

}  // namespace tetraction
