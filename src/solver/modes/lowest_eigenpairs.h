// The lowest eigenvalues of small motions by shift-and-invert Lanczos iterations.
#pragma once

#include <memory>
#include <vector>

#include "small_motions.h"

namespace tetraction {

struct Eigenpair {
  double value = 0.0;  ///< ω², 1/s²
  Vector vector;       ///< z of the length 1
};

/// Finds the lowest ω² of S + Q D Qᵀ in the space that the equations allow. Keeps references to its
/// arguments, which must live longer.
class ModeSearch {
 public:
  /// `known`: orthonormal eigenvectors, as columns, that are left out. Throws InputError if the matrix
  /// cannot be factorised.
  ModeSearch(const ScaledStiffness& stiffness, const LinearisedEquations& equations,
             const Matrix& known);
  ~ModeSearch();

  /// The `count` lowest eigenvalues, ascending, or all that there are. Throws Error if the iterations do
  /// not converge.
  std::vector<Eigenpair> lowest(Index count);
  /// (S + Q D Qᵀ − σ)⁻¹ r in the space that the equations allow, with a σ below all eigenvalues.
  Vector solve(const Vector& r) const;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/// (S + Q D Qᵀ − σ)⁻¹ in the space that the equations allow, with σ = 0 if S and S + Q D Qᵀ are positive definite, and
/// else with a σ below all eigenvalues. Keeps references to its arguments, which must live longer.
class ShiftedInverse {
 public:
  /// Throws InputError if the matrix cannot be factorised.
  ShiftedInverse(const ScaledStiffness& stiffness, const LinearisedEquations& equations);
  ~ShiftedInverse();

  double sigma() const;
  Vector solve(const Vector& r) const;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace tetraction
