// The discrete gradient of the elastic energy, with which a step conserves energy.
#pragma once

#include <functional>
#include <vector>

#include "element_blocks.h"
#include "tetraction/fem/elastic_potential.h"

namespace tetraction {

/// A mean f̄ of the elastic forces' gradient over a step from q_k to q_{k+1}, with
/// f̄·(q_{k+1} − q_k) = W(q_{k+1}) − W(q_k) (Simo & Tarnow 1992; Gonzalez 2000):
///
///     f̄ = Σ V F S̄ ∂N,   S̄ = S(C̄) + [Ψ_{k+1} − Ψ_k − S(C̄):ΔE]/(ΔE:ΔE) ΔE
///
/// F and C̄ are the means of the deformation gradients and of C at the two ends, ΔE = (C_{k+1} − C_k)/2.
/// S̄ is symmetric and acts on the mean positions, so that f̄ has neither a resultant nor a moment. The
/// numerator is of the third order in ΔE. For small ΔE it is integrated, because the difference of two
/// energies would lose digits: ∫ (S(C̄ + tΔE) − S(C̄)):ΔE dt/2 from −1 to 1.
///
/// Viscosity adds 2η Ė = f ΔE to S̄, with the factor f = η/s and s half of the step size.
class DiscreteGradient {
 public:
  /// Keeps a reference to `elastic`, which must live longer.
  explicit DiscreteGradient(const ElasticPotential& elastic);

  /// A step by its mean positions x = (q_k + q_{k+1})/2 and x − q_k (3 per vertex, m).
  struct Step {
    const Positions& middle;  ///< x
    const Vector& half_step;  ///< x − q_k
    double viscous = 0.0;     ///< f, Pa
  };
  /// gradient += f̄ (3 per vertex, N). Fails where the energy is not defined at q_{k+1}; then the
  /// gradient is unspecified. W must be defined at q_k.
  EvaluationStatus add(const Step& step, Vector& gradient) const;
  /// product += (∂f̄/∂x) d, with q_{k+1} = 2x − q_k. f̄ must be defined.
  void add_product(const Step& step, const Vector& d, Vector& product) const;

  /// Whether a sufficient condition shows that no element loses more than nine tenths of its volume between q and
  /// q + d (3 per vertex, m). It takes a fraction of the time of admissible_step().
  bool way_keeps_volumes(const Vector& q, const Vector& d) const;
  /// Whether displacements d change the deformation gradient of some element by more than `most` (Frobenius norm), or
  /// whether for some element (λ + 2μ) |change|² |D_m⁻¹|² > limit (Pa/m²), D_m being its rest edges. The
  /// change is estimated by |d| |D_m⁻¹|.
  bool deforms_more(const Vector& d, double most, double limit) const;

 private:
  bool run(const Step& step, const Vector* direction) const;
  bool run_block(Index b, const Step& step, const Vector* direction, double* records) const;

  bool all_blocks(const std::function<bool(Index)>& holds) const;

  const ElasticPotential& elastic_;
  const ElementBlocks& blocks_;
  std::vector<double> moduli_;  // the largest λ + 2μ of each block, Pa
  mutable AlignedVector<double> records_;
};

}  // namespace tetraction
