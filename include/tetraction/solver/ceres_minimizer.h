// The implicit step as a nonlinear least-squares problem for Ceres with CHOLMOD.
#pragma once

#include <memory>

#include "tetraction/dynamics/mechanical_system.h"
#include "tetraction/dynamics/problems/minimizer.h"

namespace tetraction {

/// Minimises Φ with ceres-solver, SPARSE_NORMAL_CHOLESKY on SuiteSparse's CHOLMOD.
///
/// Ceres minimises ½ Σ |r|² and uses JᵀJ as the Hessian. Every element enters by the *shifted
/// square root* of its share E of Φ (elastic energy and its part of the inertia), with a constant
/// energy cV > 0, so that an iteration is a true Newton iteration:
///
///     r₀ = √(2(E + cV)),  ∂r₀ = ∂E/r₀         cost E + cV and gradient ∂E are exact
///     r₁…r₁₂ = 0,  Jacobian K with KᵀK = ∂²E − ∂E ∂Eᵀ/(2(E + cV))
///
/// This gives JᵀJ = ∂²E exactly. K is a Cholesky factor. If the matrix is not positive definite,
/// its negative eigenvalues are set to zero. The free coordinates of each vertex and of each affine
/// set are a parameter block. One ceres::Problem lives as long as the object. The elements are
/// evaluated in an evaluation callback, in parallel and in an order that does not depend on the
/// number of threads. Keeps a reference to `system`; constraints must not change during the
/// object's life.
std::unique_ptr<Minimizer> make_ceres_minimizer(const MechanicalSystem& system,
                                                const MinimizerOptions& options);

/// Throws InputError if the body has a term that couples vertices of no common tetrahedron, which
/// the residuals of single elements cannot have: mesh.volume = "nodal", and some force terms.
void check_ceres(const MechanicalSystem& system);
/// The same for one term.
void check_ceres(const ForceTerm& term);

}  // namespace tetraction
