// The matrix whose largest eigenvalue limits the step of the explicit rules.
#pragma once

#include <memory>
#include <optional>

#include "fem/tangent_operator.h"
#include "sparse_multipliers.h"
#include "tetraction/dynamics/mechanical_system.h"

namespace tetraction {

/// The operator y = m^(−½) Tᵀ (K + wC) T m^(−½) x over the free coordinates, with m = TᵀMT. It is
/// symmetric and has the eigenvalues of M⁻¹(K + wC). K is the stiffness and C the damping matrix at
/// q. If constraints have equations, it is P y(P x) with the projection P to the motions that keep them:
/// P = I − C (CᵀC)⁺ Cᵀ, C = m^(−½) TᵀB ∂g/∂w. The class has the interface that Spectra's solvers expect of an
/// operation.
class ScaledMatrix {
 public:
  using Scalar = double;

  explicit ScaledMatrix(const MechanicalSystem& system);

  /// Takes K(q) + w C(q), with the potentials of the terms at `time`. Keeps a reference to q.
  void set_stiffness(const Vector& q, double time, double damping_weight = 0.0);
  /// Takes C(q) alone.
  void set_damping(const Vector& q, double time);

  Index rows() const { return inverse_root_mass_.size(); }
  Index cols() const { return rows(); }
  void perform_op(const double* in, double* out) const;

  /// The number of products since the last set_stiffness() or set_damping().
  Index products() const { return products_; }
  /// Whether K is applied in single precision. This is several times faster, and much more accurate
  /// than the limit needs.
  bool is_fast() const { return tangent_ != nullptr; }
  /// x·y over the free coordinates of the whole body.
  double dot(const Vector& x, const Vector& y) const;
  /// A vector that looks random, the same however the body is divided into parts.
  Vector pseudo_random_start() const;
  const MechanicalSystem& system() const { return system_; }
  /// The displacements of the vertices that belong to an eigenvector.
  Vector displacement(const Vector& eigenvector) const;
  /// A vector in which only one vertex moves: the vertex with the largest stiffness for its mass,
  /// in the direction of this stiffness. Empty if it is not known. Call it after set_stiffness().
  Vector stiffest_vertex() const;

 private:
  void multiply_stiffness(const Vector& u) const;
  void multiply_damping(const Vector& u) const;
  void gather_terms(double time);
  void set_equations();
  Vector project(Vector x) const;

  const MechanicalSystem& system_;
  const Vector* q_ = nullptr;
  double stiffness_ = 0.0;  // weights of K and C
  double damping_ = 0.0;
  HessianBlocks terms_;  // of all force terms, in the matrix
  bool has_terms_ = false;
  Vector inverse_root_mass_;
  Constraints::SparseMatrix gradients_;        // C; without columns if there are no equations
  std::optional<SparseSolution> multipliers_;  // of the matrix CᵀC
  mutable Index products_ = 0;
  mutable Vector product_;
  mutable Vector force_;
  std::unique_ptr<TangentOperator<float>> tangent_;  // where the materials allow it
  std::unique_ptr<ViscousPotential> viscous_;        // C in the tangent: 2(K + wC) in one product
  mutable AlignedVector<float> rows_;
};

}  // namespace tetraction
