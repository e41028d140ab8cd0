// Newton's linear systems, and the interface of what solves them.
#pragma once

#include <cmath>

#include "solver/linear/negative_curvature.h"
#include "tetraction/dynamics/problems/minimizer.h"
#include "tetraction/dynamics/problems/nonlinear_problem.h"

namespace tetraction {

/// ∇²Φ(x) d = −∇Φ, to be solved to |Tᵀ(∇²Φ d + ∇Φ)| ≤ forcing |Tᵀ∇Φ|.
struct NewtonSystem {
  const MinimizationProblem& problem;
  const Vector& x;
  const Vector& gradient;  ///< ∇Φ(x) or another right-hand side, 3 per vertex
  double forcing;
  bool has_new_matrix = true;  ///< false: ∇²Φ(x) is that of the last system
  /// Whether an iteration begins with it. One that does not tells nothing about the progress of Newton's method.
  bool begins_iteration = true;
};

/// An approximate solution of a NewtonSystem, and what is known about it.
struct NewtonDirection {
  Vector d;                     ///< 3 per vertex
  NegativeCurvature curvature;  ///< a direction that the solver found; usually there is none
  bool is_safe = false;  ///< whether it is known that no element is inverted on the way along d
  bool is_definite =
      false;  ///< whether ∇²Φ(x) itself was factorised, so that it is positive definite
};

/// A solver of Newton's linear systems.
class LinearStrategy {
 public:
  virtual ~LinearStrategy() = default;
  /// Finds a direction. Returns false if none was found. Members of `direction` that the solver does not
  /// determine stay as they are.
  virtual bool find(const NewtonSystem& system, MinimizerReport& report,
                    NewtonDirection& direction) = 0;
  /// Looks for a direction of negative curvature at x. If none is found, ∇²Φ(x) is positive
  /// semidefinite.
  ///
  /// A factorisation gives an exact answer, up to round-off. Otherwise conjugate gradients are run
  /// on a pseudo-random right-hand side b. As long as they meet no negative curvature, the
  /// component of their residual along an eigenvector with a negative eigenvalue never shrinks. So
  /// once the residual is 0.01/√n of b, there is no such eigenvector, unless b is nearly orthogonal
  /// to it. For a random b this has a probability below 1 % (compare Royer, O'Neill & Wright 2020,
  /// Assumption 3).
  virtual NegativeCurvature find_negative_curvature(const MinimizationProblem& problem,
                                                    const Vector& x, MinimizerReport& report) = 0;
};

/// The relative residual 0.01/√n of find_negative_curvature().
inline double probing_forcing(Index unknowns) {
  // A random vector is assumed to have a component of at least this part of its expected size.
  constexpr double kAcross = 0.01;
  return kAcross / std::sqrt(static_cast<double>(unknowns));
}

}  // namespace tetraction
