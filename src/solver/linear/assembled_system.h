// Newton's linear systems with an assembled matrix. They are solved by conjugate gradients that are
// preconditioned with the diagonal or with CHOLMOD's factor of an older matrix.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "matrix_free_cg.h"
#include "sparse_cholesky.h"
#include "tetraction/dynamics/mechanical_system.h"
#include "tetraction/dynamics/problems/nonlinear_problem.h"

namespace tetraction {

/// ∇²Φ over the free coordinates in a fixed sparsity pattern, and CHOLMOD's factor. The pattern
/// grows where a force term couples vertices that it does not couple yet.
class AssembledSystem {
 public:
  explicit AssembledSystem(const MechanicalSystem& system);

  /// Assembles the exact Hessian at x. Returns false if Φ is not defined there.
  bool assemble(const MinimizationProblem& problem, const Vector& x);
  /// Assembles the Hessian at x from the elements' shares of Φ, with the negative eigenvalues of
  /// every share set to zero.
  void assemble_projected(const MinimizationProblem& problem, const Vector& x);
  /// add(pattern, values) adds to the matrix that was assembled last, in the order of the pattern.
  template <class Add>
  void add(const Add& add) {
    add(std::as_const(matrix_->pattern), values_.data());
  }
  /// Factorises the matrix as it is. Returns false if it is not positive definite.
  bool factorize();
  bool has_factor() const { return has_factor_; }
  /// Solves with the factor, which may be that of an older matrix. Its numbers in double precision
  /// must not have been released.
  Vector back_solve(const Vector& right) { return matrix_->cholesky.solve(right); }
  /// The factor in single precision. A solve with it reads less than half the memory.
  SinglePrecisionFactor& single_precision_factor();
  /// Frees the numbers of the factor in double precision, two thirds of the memory of both factors.
  void release_double_precision() { matrix_->cholesky.release_factor(); }

  /// To be called after factorize() failed. Factorises the matrix of assemble_projected() instead,
  /// as a preconditioner. The matrix itself stays as it is. Returns false if this fails as well.
  bool factorize_projected(const MinimizationProblem& problem, const Vector& x);
  /// Factorises the Hessian at x. Where it is not positive definite, looks for a direction of
  /// negative curvature by conjugate gradients on a pseudo-random right-hand side, preconditioned
  /// by the projected factor. Nothing is found where Φ is not defined or the matrix is
  /// semidefinite. Without inertia it is lowest_curvature(), if the matrix is not too indefinite for that.
  /// `factorizations` grows by their number.
  NegativeCurvature find_negative_curvature(const MinimizationProblem& problem, const Vector& x,
                                            int& factorizations);

  /// Factorises the matrix with its diagonal enlarged by the least part, of some round-offs, with which it is
  /// positive definite, as a preconditioner of solve_by_elements(). The matrix itself stays as it is. Returns
  /// false if it is indefinite beyond round-off.
  bool factorize_shifted();
  /// To be called after factorize() failed. Factorises A + σD, where D is the diagonal and σ, up to a factor of
  /// four, the least with which the sum is positive definite. The search begins at the last σ. Unlike the projected
  /// matrix the sum is near A in all directions but those of negative curvature. The matrix itself stays as it
  /// is. `attempts` grows by the factorisations. Returns false if σ would be above a hundredth.
  bool factorize_least_shifted(int& attempts);
  /// The direction of the most negative curvature relative to D, nearly, by inverse iteration with that factor. Its
  /// curvature is that of the elements at the point of set_elements(). Nothing is found if it is not negative.
  NegativeCurvature lowest_curvature();
  /// Linearises at x, where Φ must be defined, for solve_by_elements() and curvature(), without viscosity.
  void set_elements(const MinimizationProblem& problem, const Vector& x);
  /// solution ≈ A⁻¹ right by conjugate gradients with products that are evaluated element by element,
  /// preconditioned by the factor, which may be that of an older matrix. The strains that a slow motion
  /// of a slender body causes are far smaller than displacements, and such products keep their digits, which
  /// the entries of the matrix have lost. For the same reason the residual r is measured
  /// by rᵀM⁻¹r with the preconditioner M, which must fall by the square of `forcing`.
  CgReport solve_by_elements(const Vector& right, double forcing, int max_iterations,
                             Vector& solution);
  /// dᵀ∇²Φ d, J (d: 3 per vertex), from the same products.
  double curvature(const Vector& d) const;

  enum class Preconditioner { kDiagonal, kSinglePrecisionFactor, kFactor };
  /// solution ≈ A⁻¹ right to a relative residual of `forcing`, |r|₂/|right|₂.
  CgReport solve(const Vector& right, Preconditioner preconditioner, double forcing,
                 int max_iterations, Vector& solution);
  /// The direction, after a solve that met negative curvature. Its length has no meaning.
  NegativeCurvature negative_curvature() const;

  Index size() const { return matrix_->pattern.size(); }
  Index nonzeros() const { return matrix_->pattern.nonzeros(); }
  const CholeskyCost& cost() { return matrix_->cholesky.cost(); }

 private:
  using Pairs = std::vector<std::pair<Index, Index>>;
  // The objects that belong to one pattern.
  struct MatrixParts {
    MatrixParts(const MechanicalSystem& system, const Pairs& pairs)
        : pattern(system.rest(), system.coordinates(), pairs), cholesky(pattern) {}
    SparsityPattern pattern;
    SparseCholesky cholesky;
  };

  // terms_ ← the Hessian of force terms at x, with a place in the pattern for each of its pairs.
  void set_terms(const MinimizationProblem& problem, const Vector& x, HessianForm form);
  void multiply(const Vector& x, Vector& y) const;
  // Adds a part of the absolute diagonal of `exact` to it and factorises the sum.
  bool factorize_shifted_by(double part, const std::vector<double>& exact);
  // ∇²Φ d at the point of set_elements().
  Vector product_by_elements(const Vector& d) const;

  const MechanicalSystem& system_;
  const FreeCoordinates& coordinates_;
  Pairs pairs_;                        // that the pattern has beside those of elements
  std::vector<Index> outer_vertices_;  // of the outer products that the pattern has
  std::unique_ptr<MatrixParts> matrix_;
  HessianBlocks terms_;
  std::vector<double> values_;
  // Arguments of set_elements(): the positions, the diagonal, nodal volumes if there are any, and the force terms.
  Vector point_;
  Vector diagonal_;
  const NodalVolume* volume_ = nullptr;
  HessianBlocks element_terms_;
  Vector residual_;  // of the last solve
  Vector curved_direction_;
  double curvature_ = 0.0;
  double shift_ = 0.0;  // of the last factorize_least_shifted()
  SinglePrecisionFactor single_;
  bool has_factor_ = false;
  bool has_single_ = false;
};

}  // namespace tetraction
