// Types of linear algebra that the whole library uses.
//
// Order of degrees of freedom (DOF): x0 y0 z0 x1 y1 z1 …. A field on n vertices is a vector of 3n
// numbers, and its value at vertex a has the entries 3a, 3a+1, 3a+2.
// Order of a flattened 3×3 matrix: column by column, vec(F)[3 j + i] = F(i, j).
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

namespace tetraction {

using Vector = Eigen::VectorXd;
using Vector3 = Eigen::Vector3d;
using Matrix3 = Eigen::Matrix3d;
using Vector9 = Eigen::Matrix<double, 9, 1>;
using Matrix9 = Eigen::Matrix<double, 9, 9>;
using Matrix = Eigen::MatrixXd;

/// Number of a vertex, an element or a degree of freedom inside the library (from 0, contiguous).
using Index = std::int64_t;

/// The three entries of vertex `a` in a DOF-ordered vector.
inline auto vertex_block(Vector& field, Index a) {
  return field.segment<3>(3 * a);
}
inline auto vertex_block(const Vector& field, Index a) {
  return field.segment<3>(3 * a);
}

/// vec(F): the nine entries of a 3×3 matrix, column by column.
inline Vector9 flatten(const Matrix3& f) {
  return Eigen::Map<const Vector9>(f.data());
}

}  // namespace tetraction
