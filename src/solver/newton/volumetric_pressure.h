// The volumetric energy of a body, with its pressures as unknowns of their own.
#pragma once

#include <vector>

#include "dynamics/nodal_volume/volumetric_law.h"
#include "tetraction/dynamics/mechanical_system.h"
#include "tetraction/fem/sparsity_pattern.h"

namespace tetraction {

class NodalPatches;

/// The volumetric energy Σ w U(J) of a body is a sum over sites: over quadrature points, or over the
/// patches of nodal volumes. A pressure p at a site, positive in tension, Pa, stands for U'(J) there. All
/// fields of sites have one number each. Functions with positions x need J > 0 nowhere, except first() and second()
/// of logarithmic laws.
class VolumetricPressure {
 public:
  /// Whether all materials of the body have a volumetric part U(J), and some of them resist changes of the
  /// volume at least `ratio` times as much as changes of the shape (λ/μ at small strains).
  static bool dominates(const MechanicalSystem& system, double ratio);

  /// Keeps a reference to `system`, which must have a U(J) everywhere and must live longer.
  explicit VolumetricPressure(const MechanicalSystem& system);

  /// first ← U'(J) and second ← U''(J) at x, Pa.
  void derivatives(const Vector& x, Vector& first, Vector& second) const;
  /// ∂J/∂x d at x.
  Vector rates(const Vector& x, const Vector& d) const;
  /// forces += Σ w p ∂J/∂x at x (3 per vertex, N).
  void add_forces(const Vector& x, const Vector& p, Vector& forces) const;
  /// values += Tᵀ(Σ w p ∂²J/∂x²)T at x, in the order of the pattern, N/m.
  void add_curvature(const Vector& x, const Vector& p, const SparsityPattern& pattern,
                     double* values) const;

 private:
  double tension(const Vector& p, Index point) const;
  template <class Each>
  Vector sum_over_sites(const Each& six_volume) const;

  const MechanicalSystem& system_;
  const NodalPatches* patches_;      // null without nodal volumes
  std::vector<VolumetricLaw> laws_;  // of every site
  Vector rest_six_volume_;           // of every site, m³
};

}  // namespace tetraction
