// The implicit step as a nonlinear least-squares problem for Ceres with CHOLMOD.
#pragma once

#include <memory>

#include "tetraction/dynamics/minimizer.h"

namespace tetraction {

/// Minimises Φ with ceres-solver, SPARSE_NORMAL_CHOLESKY on SuiteSparse's CHOLMOD.
///
/// Ceres minimises ½ Σ |r|² and takes JᵀJ for the Hessian. So that an iteration is a true Newton
/// iteration, every element enters by the *shifted square root* of its share E of Φ (elastic energy
/// and its part of the inertia), with a constant energy cV > 0:
///
///     r₀ = √(2(E + cV)),  ∂r₀ = ∂E/r₀         cost E + cV and gradient ∂E are exact
///     r₁…r₁₂ = 0,  Jacobian K with KᵀK = ∂²E − ∂E ∂Eᵀ/(2(E + cV))
///
/// so that JᵀJ = ∂²E exactly. K is a Cholesky factor; where the matrix is not positive definite its
/// negative eigenvalues are set to zero. Each vertex is a parameter block, a fixed one a constant
/// block. One ceres::Problem lives as long as the object.
/// The work is done in an evaluation callback, in parallel and in an order that does not depend on
/// the number of threads.
/// Keeps a reference to `system`; constraints must not change during the object's life.
std::unique_ptr<Minimizer> make_ceres_minimizer(const MechanicalSystem& system,
                                                const MinimizerOptions& options);

}  // namespace tetraction
