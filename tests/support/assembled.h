// Assembled symmetric matrices, of which a pattern has the lower triangles.
#pragma once

#include <vector>

#include "tetraction/fem/sparsity_pattern.h"

namespace tetraction::testing_support {

/// Calls visit(row, column, value) for each entry of the lower triangle.
template <class Visit>
void for_each_entry(const SparsityPattern& pattern, const std::vector<double>& values,
                    const Visit& visit) {
  for (Index j = 0; j < pattern.size(); ++j) {
    for (int k = pattern.column_begin()[static_cast<std::size_t>(j)];
         k < pattern.column_begin()[static_cast<std::size_t>(j) + 1]; ++k) {
      visit(Index{pattern.rows()[static_cast<std::size_t>(k)]}, j,
            values[static_cast<std::size_t>(k)]);
    }
  }
}

inline Matrix dense_matrix(const SparsityPattern& pattern, const std::vector<double>& values) {
  Matrix matrix = Matrix::Zero(pattern.size(), pattern.size());
  for_each_entry(pattern, values,
                 [&](Index i, Index j, double value) { matrix(i, j) = matrix(j, i) = value; });
  return matrix;
}

/// The product of the matrix with x.
inline Vector sparse_product(const SparsityPattern& pattern, const std::vector<double>& values,
                             const Vector& x) {
  Vector product = Vector::Zero(x.size());
  for_each_entry(pattern, values, [&](Index i, Index j, double value) {
    product[i] += value * x[j];
    if (i != j) product[j] += value * x[i];
  });
  return product;
}

}  // namespace tetraction::testing_support
