// Kernels of internal viscosity, on edges as in element_kernels.h. A step leads from the edges e₀
// to e = e₀ + δ. With ċ = ėᵀe + eᵀė, the Kelvin–Voigt stress of viscous_potential.h has
//
//     force                at (q, v): −η V e G ċ G
//     dissipation          D = ¼ f V tr((aG)²), a = e₀ᵀδ + δᵀe₀ + δᵀδ + c, f = η/s
//     its gradient         ∂D/∂e = f V e G a G
//     its tangent          of the form of tangent_kernels.h: T = f V G a G, a₁ = f V
//
// where ½ D⁻ᵀ a D⁻¹ = E(x) − E₀. It is written in δ so that no digits are lost. c stands for the
// difference between E₀ and E(q_k); it has six numbers per element.
#pragma once

#include "element_kernels.h"
#include "tangent_kernels.h"

namespace tetraction {

constexpr int kViscousNumbers = 6;

/// Adds the viscous forces of the elements to `forces`. Records are as in element_kernels.h.
void add_viscous_force(const BatchView& batches, double viscosity, const double* positions,
                       const double* velocities, double* forces);

/// One step of the elements of a block.
struct ViscousStep {
  double factor = 0.0;                    ///< f, Pa
  const double* positions = nullptr;      ///< records of q_k
  const double* displacements = nullptr;  ///< records of x − q_k
  /// c, kViscousNumbers × kBatchLanes a batch; null: zero.
  const double* correction = nullptr;
};

/// correction ← dᵀd with the edges d of `displacements`.
void viscous_correction(const BatchView& batches, const double* displacements, double* correction);

/// Σ D of the elements, J; adds ∂D/∂q to `gradients` unless it is null.
double viscous_gradient(const BatchView& batches, const ViscousStep& step, double* gradients);

/// Adds T and a₁ to a state with metric terms, which prepare_tangent() has made.
void add_viscous_tangent(const BatchView& batches, const ViscousStep& step, TangentForm form,
                         float* state);
void add_viscous_tangent(const BatchView& batches, const ViscousStep& step, TangentForm form,
                         double* state);

}  // namespace tetraction
