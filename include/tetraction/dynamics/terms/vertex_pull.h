// A damped spring that pulls the mean of some vertices to a point.
#pragma once

#include <vector>

#include "tetraction/dynamics/terms/force_term.h"

namespace tetraction {

/// With the mass-weighted mean x̄ = Σ m_i x_i / Σ m_i of some vertices, its velocity v̄ and a point c:
///
///     U = ½ k |x̄ − c|²,   D = ½ d |v̄|².
///
/// Every vertex gets the same acceleration, so that the spring has no moment about x̄. It is a load of
/// the user's: the work of the spring counts as external work, and its energy is no part of the total.
class VertexPull : public ForceTerm {
 public:
  VertexPull() = default;
  /// `stiffness` is k, N/m, and `damping` is d, kg/s; both are 0 or more. Vertices are internal
  /// numbers, each once.
  VertexPull(std::vector<Index> vertices, const Vector& mass, const Vector3& target,
             double stiffness, double damping);

  std::string name() const override { return "pull"; }
  EnergyAccount account() const override { return EnergyAccount::kExternalWork; }
  bool has_potential() const override { return stiffness_ > 0.0; }
  bool has_dissipation() const override { return damping_ > 0.0; }
  bool couples_vertices() const override { return vertices_.size() > 1; }
  double energy(const ForcePoint& at) const override;
  double energy_change(const ForcePoint& from, const ForcePoint& to) const override;
  void add_gradient(const ForcePoint& at, Vector& gradient) const override;
  void add_hessian(const ForcePoint& at, HessianForm form, HessianBlocks& hessian) const override;
  void add_discrete_gradient(const ForcePoint& from, const ForcePoint& to,
                             Vector& gradient) const override;
  double dissipation(const ForcePoint& at, const Vector& v) const override;
  void add_dissipation_gradient(const ForcePoint& at, const Vector& v,
                                Vector& gradient) const override;
  void add_dissipation_hessian(const ForcePoint& at, const Vector& v, HessianForm form,
                               HessianBlocks& hessian) const override;

 private:
  Vector3 mean(const Vector& field) const;
  void add(const Vector3& total, Vector& gradient) const;
  void add_outer(double factor, HessianBlocks& hessian) const;

  std::vector<Index> vertices_;
  std::vector<double> weights_;  // their shares in the mass
  Vector3 target_ = Vector3::Zero();
  double stiffness_ = 0.0;
  double damping_ = 0.0;
};

}  // namespace tetraction
