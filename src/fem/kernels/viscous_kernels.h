// Kernels of internal viscosity. They work on edges in the notation of element_kernels.h. A step
// leads from the edges e₀ to e = e₀ + δ. With ċ = ėᵀe + eᵀė, the Kelvin–Voigt stress of
// viscous_potential.h gives
//
//     force                at (q, v): −η V e G ċ G
//     dissipation          D = ¼ f V tr((aG)²), a = e₀ᵀδ + δᵀe₀ + δᵀδ + c, f = η/s
//     its gradient         ∂D/∂e = f V e G a G
//     its tangent          of the form of tangent_kernels.h: S = f V G a G, a₁ = f V
//
// where ½ D_m⁻ᵀ a D_m⁻¹ = E(x) − E₀. The formula of a in terms of δ does not cancel for small steps.
// c is the correction of E₀, ½ D_m⁻ᵀ c D_m⁻¹ = E(q_k) − E₀. It has six numbers per element.
#pragma once

#include "element_kernels.h"
#include "tangent_kernels.h"

namespace tetraction {

/// The number of entries of c per element.
constexpr int kViscousNumbers = 6;

/// Adds the viscous forces of the elements to `forces`. Records are as in element_kernels.h.
void add_viscous_force(const BatchView& batches, double viscosity, const double* positions,
                       const double* velocities, double* forces);

/// One step of the elements of a block.
struct ViscousStep {
  double factor = 0.0;                    ///< f, Pa
  const double* positions = nullptr;      ///< records of q_k
  const double* displacements = nullptr;  ///< records of x − q_k
  /// c, kViscousNumbers × kBatchLanes numbers per batch; null if c is zero.
  const double* correction = nullptr;
};

/// correction ← dᵀd with the edges d of `displacements`.
void viscous_correction(const BatchView& batches, const double* displacements, double* correction);

/// Returns Σ D of the elements, J, and adds ∂D/∂q to `gradients` unless it is null.
double viscous_gradient(const BatchView& batches, const ViscousStep& step, double* gradients);

/// Adds S and a₁ of the viscosity to a state with metric terms, which prepare_tangent() has made.
void add_viscous_tangent(const BatchView& batches, const ViscousStep& step, TangentForm form,
                         float* state);
void add_viscous_tangent(const BatchView& batches, const ViscousStep& step, TangentForm form,
                         double* state);

}  // namespace tetraction
