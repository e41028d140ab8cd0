// Decompositions of small dense matrices. They are compiled once here, because Eigen's solvers take
// the compiler seconds for each type of matrix.
#pragma once

#include "tetraction/core/types.h"

namespace tetraction {

struct SymmetricEigen3 {
  Vector3 values;   ///< ascending
  Matrix3 vectors;  ///< in the columns, of length 1
};
/// The eigenpairs of the symmetric matrix `a`, of which the lower triangle is read.
SymmetricEigen3 symmetric_eigen(const Matrix3& a);

struct SymmetricEigen {
  Vector values;   ///< ascending
  Matrix vectors;  ///< in the columns, of length 1
};
/// The same for a matrix of any size.
SymmetricEigen symmetric_eigen(const Matrix& a);

struct SingularVectors {
  Matrix u;  ///< square and orthogonal
  Matrix v;  ///< as many columns as the smaller side of the matrix
};
/// The singular vectors of a = u S vᵀ, in the order of descending singular values.
SingularVectors singular_vectors(const Matrix& a);

}  // namespace tetraction
