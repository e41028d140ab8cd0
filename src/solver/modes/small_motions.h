// Small motions of a body about given positions: S z = ω² z with linear equations of constraints.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "solver/linear/sparse_cholesky.h"
#include "tetraction/dynamics/mechanical_system.h"
#include "tetraction/fem/sparsity_pattern.h"

namespace tetraction {

/// M v: the momentum of velocities of all vertices, kg m/s, with the lumped mass of linear elements and the
/// consistent one of quadratic elements.
Vector momentum_of_modes(const MechanicalSystem& system, const Vector& velocity);

/// The matrix S = m^(−½) TᵀKT m^(−½) with m = TᵀMT, without the curvature of the equations. Its
/// coordinates z belong to the displacements T m^(−½) z.
///
/// M is the lumped mass of linear elements and the consistent one of quadratic elements. For the
/// latter m^(½) stands for R D^(½), where D has the lumped masses on its diagonal and the sparse matrix
/// D^(−½) TᵀMT D^(−½) is RᵀR. Then S = R⁻ᵀ S_D R⁻¹ with S_D = D^(−½) TᵀKT D^(−½).
class ScaledStiffness {
 public:
  enum class Mass { kOfElements, kLumped };

  /// Takes K at positions q, with the potentials of the force terms at `time`. `with_loads`: those of
  /// loads, too, and the symmetric part of the stiffness of loads that depend on positions. All but
  /// potentials that stand for constraints are multiplied by `load_factor`. Mass::kLumped takes M = D for
  /// quadratic elements as well, which saves a factorisation. Keeps a
  /// reference to `system`. Throws InputError if K is not defined or overflows.
  ScaledStiffness(const MechanicalSystem& system, const Vector& q, double time, bool with_loads,
                  double load_factor, Mass mass = Mass::kOfElements);

  Index size() const { return pattern_->size(); }
  const SparsityPattern& pattern() const { return *pattern_; }
  /// The largest entry on the diagonal, 1/s².
  double largest() const { return largest_; }
  /// The same, or 1 if there is no stiffness.
  double unit() const { return largest_ > 0.0 ? largest_ : 1.0; }
  /// The entries, in the pattern's order, of a matrix whose factor solve() needs: S_D − σ RᵀR, which is
  /// S − σ for linear elements.
  std::vector<double> shifted(double sigma) const;
  /// (S − σ)⁻¹ z with a factor of shifted(σ).
  Vector solve(SparseCholesky& factor, const Vector& z) const;
  /// S z, evaluated element by element. In a slow mode the strains are far smaller than the displacements.
  /// Strains that are computed first keep the digits that a sum over the entries of the matrix
  /// loses: zᵀSz has a relative error of about ε √(max S_ii/zᵀSz), that of the sum is its square over ε.
  Vector product(const Vector& z) const;
  /// m^(−½)ᵀ Tᵀ f: forces in the coordinates of S.
  Vector scaled(const Vector& forces) const;
  /// m^(−½)ᵀ y for every column.
  Matrix scaled_columns(const Matrix& columns) const;
  /// The displacements of all vertices for a vector in the coordinates of S.
  Vector displacements(const Vector& z) const;
  /// M v: the momentum of velocities of all vertices, kg m/s.
  Vector momentum(const Vector& velocity) const {
    return mass_factor_ ? momentum_of_modes(system_, velocity) : system_.momentum_of(velocity);
  }
  /// The stiffness of all force terms, N/m.
  const HessianBlocks& terms() const { return terms_; }
  /// The gradient of the same potentials, and minus the loads that depend on positions, N.
  const Vector& terms_gradient() const { return terms_gradient_; }

 private:
  template <class Visit>
  void for_each_entry(const Visit& visit) const;

  void find_mass();
  // y = a z for a symmetric matrix in the pattern.
  Vector multiply(const std::vector<double>& a, const Vector& z) const;
  // R⁻ᵀ z and R⁻¹ z.
  Vector solve_transposed_root(const Vector& z) const;
  Vector solve_root(const Vector& z) const;

  const MechanicalSystem& system_;
  const FreeCoordinates& coordinates_;
  Vector inverse_root_mass_;
  Vector position_;
  HessianBlocks terms_;
  Vector terms_gradient_;
  std::unique_ptr<SparsityPattern> pattern_;
  std::vector<double> values_;       // S_D
  std::vector<double> mass_values_;  // RᵀR; empty if it is the identity
  std::unique_ptr<SparseCholesky> mass_factor_;
  double largest_ = 0.0;
};

/// The part R = ½ (K − Kᵀ) of the stiffness K of loads that depend on positions, which S does not have.
class SkewLoadStiffness {
 public:
  /// At positions q, with the loads at `time` times `load_factor`.
  SkewLoadStiffness(const MechanicalSystem& system, const Vector& q, double time,
                    double load_factor);

  /// R u, N, for displacements of all vertices. The transposed matrix is minus this one.
  Vector product(const Vector& u) const;

 private:
  LoadStiffness stiffness_;
};

/// The damping matrix C of small motions about positions q. Viscosity and the damping of terms are linear in small
/// velocities. Damping of the mass is that of momentum_of_modes().
class DampingMatrix {
 public:
  /// Keeps references to `system` and `q`. `with_loads`: with the dampers of loads.
  DampingMatrix(const MechanicalSystem& system, const Vector& q, double time,
                bool with_loads = true);

  /// C v, N.
  Vector product(const Vector& v) const;
  /// The part of C v that force terms have.
  Vector product_of_terms(const Vector& v) const;

 private:
  const MechanicalSystem& system_;
  const Vector& q_;
  HessianBlocks of_terms_;
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
