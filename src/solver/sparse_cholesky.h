// CHOLMOD's factorisation of a symmetric positive definite matrix in a fixed pattern.
#pragma once

#include <memory>
#include <vector>

#include "single_precision_factor.h"
#include "tetraction/fem/sparsity_pattern.h"

namespace tetraction {

/// What CHOLMOD's symbolic analysis foretells.
struct CholeskyCost {
  double flops = 0.0;     ///< of a factorisation
  double nonzeros = 0.0;  ///< of the factor
};

/// Analyses the pattern once, then factorises and solves as often as asked.
class SparseCholesky {
 public:
  /// Keeps a reference to `pattern`, which must live longer.
  explicit SparseCholesky(const SparsityPattern& pattern);
  ~SparseCholesky();
  SparseCholesky(const SparseCholesky&) = delete;
  SparseCholesky& operator=(const SparseCholesky&) = delete;

  /// Of a factorisation; analyses the pattern if that was not done yet.
  const CholeskyCost& cost();
  /// `values` in the pattern's order. Returns false if the matrix is not positive definite.
  bool factorize(const std::vector<double>& values);
  /// Solution of A x = b with the factor made last.
  Vector solve(const Vector& b);

  /// Copies the factor made last. Throws Error if there is none.
  void copy_to(SinglePrecisionFactor& copy) const;
  /// Frees the numbers of the factor, which the next `factorize` brings back; keeps the analysis.
  void release_factor();

 private:
  void analyze();

  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tetraction
