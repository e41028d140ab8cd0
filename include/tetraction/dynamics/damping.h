// Damping coefficients, and the part of damping that acts on single vertices.
#pragma once

#include "tetraction/dynamics/force_term.h"

namespace tetraction {

/// Dissipative forces, each the derivative of a dissipation potential; all 0 or more.
struct Damping {
  double drag = 0.0;          ///< k_D: force −k_D v on every vertex, kg/s
  double mass_damping = 0.0;  ///< a: force −a M v, 1/s
  double viscosity = 0.0;     ///< η: second Piola stress 2ηĖ, Pa s (fem/viscous_potential.h)

  bool none() const { return drag == 0.0 && mass_damping == 0.0 && viscosity == 0.0; }
};

/// Drag and mass damping: D = ½ Σ_v (k_D + a m_v)|v_v|².
class VertexDamping : public ForceTerm {
 public:
  VertexDamping() = default;
  explicit VertexDamping(const Damping& damping)
      : drag_(damping.drag), mass_damping_(damping.mass_damping) {}

  std::string name() const override { return "vertex_damping"; }
  EnergyAccount account() const override { return EnergyAccount::kNone; }
  bool has_dissipation() const override { return drag_ > 0.0 || mass_damping_ > 0.0; }
  bool is_quadratic() const override { return true; }
  double dissipation(const ForcePoint& at, const Vector& v) const override;
  void add_dissipation_gradient(const ForcePoint& at, const Vector& v,
                                Vector& gradient) const override;
  void add_dissipation_hessian(const ForcePoint& at, const Vector& v, HessianForm form,
                               HessianBlocks& hessian) const override;

 private:
  double coefficient(double mass) const { return drag_ + mass_damping_ * mass; }

  double drag_ = 0.0;
  double mass_damping_ = 0.0;
};

}  // namespace tetraction
