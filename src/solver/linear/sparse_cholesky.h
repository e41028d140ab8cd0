// CHOLMOD's factorisation of a symmetric positive definite matrix in a fixed pattern.
#pragma once

#include <memory>
#include <vector>

#include "single_precision_factor.h"
#include "tetraction/fem/sparsity_pattern.h"

namespace tetraction {

/// The cost that CHOLMOD's symbolic analysis predicts.
struct CholeskyCost {
  double flops = 0.0;     ///< of a factorisation
  double nonzeros = 0.0;  ///< of the factor
};

/// Analyses the pattern once. After that it can factorise and solve any number of times.
class SparseCholesky {
 public:
  /// Keeps a reference to `pattern`, which must live longer.
  explicit SparseCholesky(const SparsityPattern& pattern)
      : SparseCholesky(pattern.column_begin(), pattern.rows()) {}
  /// The lower triangle of a matrix, compressed by columns with ascending rows; entries above the diagonal are
  /// ignored. Keeps references to both, which must live longer.
  SparseCholesky(const std::vector<int>& column_begin, const std::vector<int>& rows);
  ~SparseCholesky();
  SparseCholesky(const SparseCholesky&) = delete;
  SparseCholesky& operator=(const SparseCholesky&) = delete;

  /// The cost of a factorisation. Analyses the pattern if that was not done yet.
  const CholeskyCost& cost();
  /// `values` in the pattern's order. Returns false if the matrix is not positive definite.
  bool factorize(const std::vector<double>& values);
  /// Solution of A x = b with the factor made last.
  Vector solve(const Vector& b);
  /// With A = RᵀR, R = LᵀP and a permutation P: R⁻ᵀ b and R⁻¹ b.
  Vector solve_transposed_root(const Vector& b);
  Matrix solve_transposed_root(const Matrix& columns);
  Vector solve_root(const Vector& b);

  /// Copies the factor made last. Throws Error if there is none.
  void copy_to(SinglePrecisionFactor& copy) const;
  /// Frees the numbers of the factor but keeps the analysis. The next factorize() makes new
  /// numbers.
  void release_factor();

 private:
  void analyze();

  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tetraction
