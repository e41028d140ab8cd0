// The implicit step by Newton's method.
#pragma once

#include <memory>

#include "tetraction/dynamics/mechanical_system.h"
#include "tetraction/dynamics/problems/minimizer.h"
#include "tetraction/solver/linear_solver.h"

namespace tetraction {

struct NewtonOptions : MinimizerOptions {
  LinearSolver linear = LinearSolver::kAuto;
  /// If false, kFactor factorises in every iteration instead of keeping the factor.
  bool keep_factor = true;
};

/// Minimises Φ by an inexact Newton method with the exact Hessian.
///
/// An iteration solves ∇²Φ(x) d = −∇Φ(x) to a relative residual η that is proportional to the
/// square of the last reduction of |∇Φ| (Eisenstat & Walker 1996, choice 2, γ = 0.5). The first η
/// of a step comes from the first reduction in the last step. The displacement is shortened if an
/// element could be inverted on the way (fem/step_length.h), and then halved until Φ falls (Armijo,
/// 1e-4) or the residual is halved. If a direction of negative curvature is met, the system is
/// solved with a matrix that is made positive semidefinite, and the iteration then follows that
/// direction as long as Φ falls. The method stops at |Tᵀ∇Φ| ≤ NonlinearProblem::residual_limit(). If that
/// point may be a saddle, it looks for negative curvature in the Hessian there and continues if it
/// finds any. docs/theory.md says when it looks, and what that guarantees. A problem without inertia is also searched
/// along curved ways, on which parts of the body turn without being stretched.
///
/// The factor of kFactor is kept across iterations and steps. It is made anew when the iterations
/// of conjugate gradients beyond the third have cost as much as a factorisation since the last one.
/// Keeps a reference to `system`; constraints must not change during the object's life.
std::unique_ptr<Minimizer> make_newton_minimizer(const MechanicalSystem& system,
                                                 const NewtonOptions& options);

}  // namespace tetraction
