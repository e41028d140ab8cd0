// A force term made of a potential of single vertices.
#pragma once

#include "tetraction/core/positive_semidefinite.h"
#include "tetraction/dynamics/terms/force_term.h"

namespace tetraction {

/// U(x, t) = a(t) Σ_v U_v(m_v, x_v) with a potential of one vertex and a factor that is 1 unless a
/// derived class overrides it: a field, an analytic obstacle. A derived class gives value(), gradient() and hessian() of one
/// vertex, and where U_v is not defined everywhere also defined() and admissible_fraction(). They
/// are called from several threads at once.
///
/// A constant in U_v does not change the motion, but a large one costs the energies digits.
class VertexPotential : public ForceTerm {
 public:
  /// U_v, J, of a vertex with the lumped mass m (kg) at x (m).
  virtual double value(double mass, const Vector3& x) const = 0;
  /// ∂U_v/∂x, N: minus the force.
  virtual Vector3 gradient(double mass, const Vector3& x) const = 0;
  /// ∂²U_v/∂x², symmetric, N/m. It may be indefinite.
  virtual Matrix3 hessian(double mass, const Vector3& x) const = 0;
  /// A discrete gradient of U_v: a vector f̄ with f̄·(to − from) = U_v(to) − U_v(from), near ∂U_v/∂x at
  /// the midpoint. This version is that of Gonzalez (ForceTerm::add_discrete_gradient()) for each
  /// vertex.
  virtual Vector3 discrete_gradient(double mass, const Vector3& from, const Vector3& to) const;
  /// Whether U_v is defined at x.
  virtual bool defined(const Vector3& /*x*/) const { return true; }
  /// The largest t such that U_v is defined from x to x + t d; infinite where there is no limit.
  virtual double admissible_fraction(const Vector3& /*x*/, const Vector3& /*d*/) const {
    return std::numeric_limits<double>::infinity();
  }

  /// a at the instant `at.time`, or its mean over `at.step` if there is one.
  virtual double factor(const ForcePoint& /*at*/) const { return 1.0; }

  bool has_potential() const override { return true; }
  Index undefined_vertex(const ForcePoint& at) const override;
  double longest_step(const ForcePoint& from, const Vector& displacement) const override;
  double energy(const ForcePoint& at) const override;
  double energy_change(const ForcePoint& from, const ForcePoint& to) const override;
  void add_gradient(const ForcePoint& at, Vector& gradient) const override;
  void add_hessian(const ForcePoint& at, HessianForm form, HessianBlocks& hessian) const override;
  /// With the mean of the factor over the step that leads from one point to the other.
  double driven_work(const ForcePoint& from, const ForcePoint& to) const override;
  void add_discrete_gradient(const ForcePoint& from, const ForcePoint& to,
                             Vector& gradient) const override;
};

}  // namespace tetraction
