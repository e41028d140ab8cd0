// Springs that pull vertices to prescribed positions.
#pragma once

#include <memory>
#include <vector>

#include "tetraction/dynamics/constraints/prescribed_motion.h"
#include "tetraction/dynamics/terms/force_term.h"

namespace tetraction {

/// U = Σ γ |x_i − c_i(t)|² over components i of vertices with prescribed targets c_i: the penalty
/// method for prescribed displacements, for comparison with exact ones. Its energy counts as
/// constraint work.
class PenaltySprings : public ForceTerm {
 public:
  PenaltySprings() = default;
  /// Springs to the targets of every entry of `held` whose penalty is above 0.
  PenaltySprings(const std::vector<PrescribedVertices>& held, Index vertex_count);

  bool empty() const { return springs_.empty(); }
  /// Whether a spring is attached to the vertex.
  bool holds(Index vertex) const {
    return !springs_.empty() && stiffness_.segment<3>(3 * vertex).maxCoeff() > 0.0;
  }
  /// 2γ of every degree of freedom, N/m; empty without springs.
  const Vector& stiffness() const { return stiffness_; }

  std::string name() const override { return "penalty_springs"; }
  EnergyAccount account() const override { return EnergyAccount::kConstraintWork; }
  bool has_potential() const override { return !springs_.empty(); }
  bool is_quadratic() const override { return true; }
  double energy(const ForcePoint& at) const override;
  void add_gradient(const ForcePoint& at, Vector& gradient) const override;
  void add_hessian(const ForcePoint& at, HessianForm form, HessianBlocks& hessian) const override;
  /// Computes it with the mean of the forces at the two ends.
  double driven_work(const ForcePoint& from, const ForcePoint& to) const override;

 private:
  struct Spring {
    Index dof = 0;
    double penalty = 0.0;  // γ, N/m
    Vector3 start;         // of the vertex' target at motion.since, m
    PrescribedMotion motion;
    double target(double time) const { return motion.position(start, time)[dof % 3]; }
  };

  std::vector<Spring> springs_;
  Vector stiffness_;
};

}  // namespace tetraction
