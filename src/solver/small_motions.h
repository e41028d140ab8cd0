// Small motions of a body about given positions: S z = ω² z with linear equations of constraints.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "tetraction/dynamics/mechanical_system.h"
#include "tetraction/fem/sparsity_pattern.h"

namespace tetraction {

/// The matrix S = m^(−½) TᵀKT m^(−½) with m = TᵀMT, without the curvature of the equations. Its
/// coordinates z belong to the displacements T m^(−½) z.
class ScaledStiffness {
 public:
  /// Takes K at positions q, with the potentials of the force terms at `time`. `with_loads`: those of
  /// loads, too, and the symmetric part of the stiffness of loads that depend on positions. Keeps a
  /// reference to the coordinates of `system`. Throws InputError if K is not defined or overflows.
  ScaledStiffness(const MechanicalSystem& system, const Vector& q, double time, bool with_loads);

  Index size() const { return pattern_->size(); }
  const SparsityPattern& pattern() const { return *pattern_; }
  /// The largest entry on the diagonal, 1/s².
  double largest() const { return largest_; }
  /// The same, or 1 if there is no stiffness.
  double unit() const { return largest_ > 0.0 ? largest_ : 1.0; }
  /// The entries of S − σ in the pattern's order.
  std::vector<double> shifted(double sigma) const;
  /// S z.
  Vector product(const Vector& z) const;
  /// m^(−½) Tᵀ f: forces in the coordinates of S.
  Vector scaled(const Vector& forces) const {
    return inverse_root_mass_.cwiseProduct(coordinates_.restrict(forces));
  }
  /// m^(−½) y for every column.
  Matrix scaled_columns(const Matrix& columns) const {
    return inverse_root_mass_.asDiagonal() * columns;
  }
  /// The displacements of all vertices for a vector in the coordinates of S.
  Vector displacements(const Vector& z) const {
    return coordinates_.extend(inverse_root_mass_.cwiseProduct(z));
  }
  /// The product of the stiffness of all force terms with displacements, N.
  Vector terms_product(const Vector& displacements) const;

 private:
  template <class Visit>
  void for_each_entry(const Visit& visit) const;

  const FreeCoordinates& coordinates_;
  Vector inverse_root_mass_;
  HessianBlocks terms_;
  std::unique_ptr<SparsityPattern> pattern_;
  std::vector<double> values_;
  double largest_ = 0.0;
};

/// The linearised equations of constraints, in the coordinates of S. Motions z satisfy HᵀQᵀz = 0, and
/// S has the further part Q D Qᵀ.
struct LinearisedEquations {
  Matrix q;          ///< orthonormal basis of the coordinates that the equations depend on
  Matrix h;          ///< orthonormal basis of the gradients, in terms of q
  Matrix allowed;    ///< orthonormal complement of h
  Matrix curvature;  ///< D

  LinearisedEquations(const MechanicalSystem& system, const ScaledStiffness& stiffness,
                      const Vector& position, const Vector& multipliers);

  Index count() const { return h.cols(); }
  /// Q D Qᵀ z.
  Vector curvature_product(const Vector& z) const { return q * (curvature * (q.transpose() * z)); }
  /// The part of z that the equations allow.
  Vector project(const Vector& z) const {
    if (count() == 0) return z;
    return z - q * (h * (h.transpose() * (q.transpose() * z)));
  }
};

}  // namespace tetraction
