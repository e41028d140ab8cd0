// Decompositions of small dense matrices. They are compiled in one source file, because the compiler
// needs seconds for Eigen's solvers of each matrix type.
#pragma once

#include "tetraction/core/types.h"

namespace tetraction {

struct SymmetricEigen3 {
  Vector3 values;   ///< ascending
  Matrix3 vectors;  ///< one per column, of length 1
};
/// The eigenvalues and eigenvectors of the symmetric matrix `a`. Only its lower triangle is read.
SymmetricEigen3 symmetric_eigen(const Matrix3& a);

struct SymmetricEigen {
  Vector values;   ///< ascending
  Matrix vectors;  ///< one per column, of length 1
};
/// The eigenvalues and eigenvectors of a symmetric matrix of any size. Errors of eigenvalues are of the order
/// of round-off relative to the largest one.
SymmetricEigen symmetric_eigen(const Matrix& a);
/// The same by Jacobi's method, which also computes small eigenvalues to their own round-off if the matrix
/// is D A D with a diagonal matrix D and a well-conditioned A (J. Demmel, K. Veselić, SIAM J. Matrix Anal.
/// Appl. 13, 1992). It is fast if the matrix is nearly diagonal.
SymmetricEigen jacobi_eigen(Matrix a);

struct SingularVectors {
  Matrix u;  ///< square and orthogonal
  Matrix v;  ///< its number of columns is the smaller dimension of the matrix
};
/// The singular vectors of a = u S vᵀ, in the order of descending singular values.
SingularVectors singular_vectors(const Matrix& a);

/// The rotation R of the polar decomposition of a, det R = +1 always (Kabsch's sign).
Matrix3 proper_rotation(const Matrix3& a);

}  // namespace tetraction
