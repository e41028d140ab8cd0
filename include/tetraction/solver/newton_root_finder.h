// Newton's method for equations whose derivative need not be symmetric.
#pragma once

#include <memory>

#include "tetraction/dynamics/mechanical_system.h"
#include "tetraction/dynamics/problems/minimizer.h"
#include "tetraction/solver/newton_minimizer.h"

namespace tetraction {

/// Finds a root of r by an inexact Newton method.
///
/// An iteration solves (∂r/∂u) d = −r by GMRES with the product of RootProblem::multiply(). The
/// forcing terms are those of NewtonMinimizer. The preconditioner is CHOLMOD's factor of the Hessian
/// of RootProblem::approximation(), which is kept across iterations and steps and made anew when
/// GMRES needs more than a few iterations with it. If that Hessian is not positive definite, the
/// factor is that of a positive semidefinite matrix near it. The displacement is shortened to the
/// longest admissible step, and then halved until |r| falls. The method stops at
/// |Tᵀr| ≤ NonlinearProblem::residual_limit(). Unlike a minimiser it may end at any root.
/// Keeps a reference to `system`; constraints must not change during the object's life.
std::unique_ptr<RootFinder> make_newton_root_finder(const MechanicalSystem& system,
                                                    const MinimizerOptions& options);

/// The same with the linear solvers of NewtonMinimizer as the preconditioner: in each iteration of
/// GMRES they solve a system with the Hessian of RootProblem::approximation() to a few digits, without a
/// matrix where that is cheaper. So an iteration costs little more than one of a minimisation if the two
/// matrices are close. GMRES is the flexible one (Saad 1993).
std::unique_ptr<RootFinder> make_newton_krylov_root_finder(const MechanicalSystem& system,
                                                           const NewtonOptions& options);

}  // namespace tetraction
