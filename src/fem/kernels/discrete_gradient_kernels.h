// The discrete gradient of the elastic energy (fem/discrete_gradient.h) of isotropic materials. The
// kernels work on edges in the notation of element_kernels.h. A step leads from the edges e − d to e + d.
//
// With c̄ = eᵀe + dᵀd and δ = eᵀd + dᵀe, the mean of c and half of its change, and c(t) = c̄ + tδ:
//
//     tr C(t) = c̄:G + t δ:G,   tr C(t)² = c̄:Gc̄G + 2t c̄:GδG + t² δ:GδG,
//     det c(t) = det c̄ (1 + a₁t + a₂t² + a₃t³)
//
// with the invariants aᵢ of c̄⁻¹δ. The law at any point t of the step needs these numbers alone. So
// φ(t) = dΨ/dt = Ψ₁ δ:G + Ψ₂ I₂'(t) + Ψ_L ½ (ln det c(t))', and the correction of the stress is γ GδG with
// γ = N/(δ:GδG), N = Ψ(1) − Ψ(−1) − 2φ(0) or, for small steps, N = ∫ (φ(t) − φ(0)) dt by Gauss's rule.
// The pulled back mean stress times V and the discrete gradient are
//
//     s̄ = V [2 (Ψ₁ + I₁Ψ₂) G − 2Ψ₂ G c̄ G + Ψ_L c̄⁻¹ + (γ + f) G δ G],   f̄ = e s̄
//
// with the derivatives of Ψ at t = 0 and the factor f of the viscosity. With the change b = ḋᵀ(e + d) +
// (e + d)ᵀḋ of both c̄ and δ in a direction ḋ, the derivative of f̄ is ḋ s̄ + e ṡ with
//
//     ṡ = (derivative of the stress at t = 0) + V [(y:b/(δ:GδG)) G δ G + (γ + f) G b G],
//     y:b = s(1):b − s(0):b − ṡ(0):δ − 2γ δ:GbG.
#pragma once

#include "element_kernels.h"

namespace tetraction {

/// A step of the elements of a block. Records are as in element_kernels.h.
struct StepRecords {
  const double* positions = nullptr;      ///< of an origin o of the mean positions x
  const double* displacements = nullptr;  ///< x − o
  const double* half_steps = nullptr;     ///< x − q_k
  double viscous = 0.0;                   ///< f, Pa
};

/// Adds f̄ of the elements to `gradients`. Returns whether the energy is defined at the end of the step
/// in all elements.
bool add_discrete_gradient(const BatchView& batches, const IsotropicModel& material,
                           const StepRecords& step, double* gradients);
/// Adds the derivative of f̄ in the direction of these records.
void add_discrete_gradient_product(const BatchView& batches, const IsotropicModel& material,
                                   const StepRecords& step, const double* directions,
                                   double* products);

}  // namespace tetraction
