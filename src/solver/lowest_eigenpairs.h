// The lowest eigenvalues of small motions by shift-and-invert Lanczos iterations.
#pragma once

#include <vector>

#include "small_motions.h"

namespace tetraction {

struct Eigenpair {
  double value = 0.0;  ///< ω², 1/s²
  Vector vector;       ///< z of the length 1
};

/// The `count` lowest ω² of S + Q D Qᵀ in the space that the equations allow and that is orthogonal to
/// the columns of `known`, which are orthonormal eigenvectors. There must be at least so many. Throws
/// InputError if the matrix cannot be factorised, and Error if the iterations do not converge.
std::vector<Eigenpair> lowest_eigenpairs(const ScaledStiffness& stiffness,
                                         const LinearisedEquations& equations, const Matrix& known,
                                         Index count);

}  // namespace tetraction
