// The part of damping that acts on single vertices.
#pragma once

#include "tetraction/dynamics/terms/damping.h"
#include "tetraction/dynamics/terms/force_term.h"

namespace tetraction {

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
