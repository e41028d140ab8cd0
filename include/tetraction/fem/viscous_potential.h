// Internal viscosity: a Kelvin–Voigt stress that is added to the elastic stress.
#pragma once

#include <memory>

#include "tetraction/fem/elastic_potential.h"

namespace tetraction {

/// The second Piola–Kirchhoff stress of the viscosity is S = 2ηĖ with the rate of the Green strain
/// Ė = sym(FᵀḞ) and η in Pa s. S is objective and symmetric, so that it takes neither linear nor
/// angular momentum from the body.
///
/// Explicit steps evaluate the viscous force at (q, v). In an implicit step the viscous force is
/// −∇D of a dissipation potential D of the positions x = q_k + s v at which forces are evaluated,
///
///     D(x) = Σ_elements V η |E(x) − E₀|²/s,     Ė = (E(x) − E₀)/s.
///
/// For s = h (backward Euler) E₀ = E(q_k). For s = h/2 (midpoint) the strain rate must be that of
/// the motion at x, Ė = sym(Fᵀ(F − F_k))/s. The viscosity then creates no energy, whatever the
/// step, and the dissipation 2η|Ė|² is never negative. This rate corresponds to E₀ = E(q_k) −
/// ½ΔFᵀΔF with ΔF = F(x) − F_k, which depends on x itself. Therefore D is minimised with an
/// estimate of ΔF (set_estimate()). The estimate is replaced by the ΔF of the minimiser until both
/// agree.
class ViscousPotential {
 public:
  using Shape = RestState::Shape;

  /// The viscosity acts in all elements of `elastic`, which must live longer.
  explicit ViscousPotential(const ElasticPotential& elastic);
  ~ViscousPotential();
  ViscousPotential(ViscousPotential&&) noexcept;

  /// force −= Σ V F (2ηĖ) ∂N at positions q and velocities v (3 per vertex, N).
  void add_force(double viscosity, const Vector& q, const Vector& v, Vector& force) const;

  /// Begins an implicit step at q_k with factor = η/s, Pa. With the factor 0 the functions below
  /// add nothing. Keeps a reference to `q` until the next step begins.
  void begin(const Vector& q, double factor);
  /// Sets E₀ = E(q_k) − ½ΔFᵀΔF with ΔF of this displacement (3 per vertex, m). Before the first
  /// call in a step E₀ is E(q_k).
  void set_estimate(const Vector& displacement);
  double factor() const;
  /// value += D (J) and, in the second form, gradient += ∇D (N) at x = q_k + displacement.
  void add_value(const Vector& displacement, double& value) const;
  void add_value_and_gradient(const Vector& displacement, double& value, Vector& gradient) const;
  /// values += entries of ∇²D in the pattern's order, N/m.
  void add_hessian(const Vector& displacement, const SparsityPattern& pattern,
                   double* values) const;
  /// Adds the terms of element e at positions x. May be called from several threads.
  void add_element_terms(Index e, const Positions& x, bool with_hessian,
                         ElasticPotential::ElementTerms& terms) const;

 private:
  friend struct BlockAccess;  // the fast loops of the library (src/fem/element_blocks.h)
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tetraction
