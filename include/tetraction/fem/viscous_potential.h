// Internal viscosity: a Kelvin–Voigt stress beside the elastic one.
#pragma once

#include <memory>

#include "tetraction/fem/elastic_potential.h"

namespace tetraction {

enum class TangentForm;

/// Second Piola stress S = 2ηĖ with the rate of the Green strain Ė = sym(FᵀḞ): objective and
/// symmetric, so that it takes neither linear nor angular momentum from the body.
///
/// Explicit steps take its force at (q, v). In an implicit step it is the derivative of the
/// dissipation potential, written in the point x = q_k + s v where forces are evaluated,
///
///     D(x) = Σ_elements V η |E(x) − E₀|²/s,
///
/// so that Ė = (E(x) − E₀)/s. For s = h (backward Euler) E₀ = E(q_k). For s = h/2 (midpoint) x is no
/// rotation of q_k even if the step is one, and E(x) − E(q_k) is off by −⅛ ΔFᵀΔF, a first-order
/// error of the stress: E₀ = E(q_k) − ⅛h² ∇v_kᵀ∇v_k takes it out to second order. η in Pa s.
class ViscousPotential {
 public:
  using Shape = RestState::Shape;

  /// In all elements of the body of `elastic`, which must live longer.
  explicit ViscousPotential(const ElasticPotential& elastic);
  ~ViscousPotential();
  ViscousPotential(ViscousPotential&&) noexcept;

  /// force −= Σ V F (2ηĖ) ∂N at positions q and velocities v (3 per vertex, N).
  void add_force(double viscosity, const Vector& q, const Vector& v, Vector& force) const;

  /// Begins an implicit step at q_k with factor = η/s, Pa; 0 switches the terms below off.
  /// `displacement` is h v_k for the midpoint rule, else empty.
  void begin(const Vector& q, const Vector& displacement, double factor);
  double factor() const;
  /// value += D(x), J; gradient += ∇D(x), N.
  void add_value(const Vector& x, double& value) const;
  void add_value_and_gradient(const Vector& x, double& value, Vector& gradient) const;
  /// values += entries of ∇²D(x) in the pattern's order, N/m.
  void add_hessian(const Vector& x, const SparsityPattern& pattern, double* values) const;
  /// Adds the terms of element e. Safe to call from several threads.
  void add_element_terms(Index e, const Vector& x, bool with_hessian,
                         ElasticPotential::ElementTerms& terms) const;
  /// Adds the tangent of a block of elastic().blocks() at rows of positions to a state with metric
  /// terms (fem/tangent_kernels.h; private to the library).
  void add_tangent(Index block, const double* positions, TangentForm form, float* state) const;
  void add_tangent(Index block, const double* positions, TangentForm form, double* state) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace tetraction
