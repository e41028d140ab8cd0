// Kernels of internal viscosity, on edges as in element_kernels.h. With c = eᵀe and ċ = ėᵀe + eᵀė,
// the Kelvin–Voigt stress of viscous_potential.h has
//
//     force                at (q, v): −η V e G ċ G
//     dissipation          D = ¼ f V tr((aG)²), a = c − c₀, f = η/s
//     its gradient         ∂D/∂e = f V e G a G
//     its tangent          of the form of tangent_kernels.h: T = f V G a G, a₁ = f V
//
// so that the strain E₀ is kept as c₀ = Dᵀ(2E₀ + 1)D: six numbers an element.
#pragma once

#include "element_kernels.h"
#include "tangent_kernels.h"

namespace tetraction {

constexpr int kViscousNumbers = 6;

/// Adds the viscous forces of the elements to `forces`; rows as in element_kernels.h.
void add_viscous_force(const BatchView& batches, double viscosity, const double* positions,
                       const double* velocities, double* forces);

/// start ← c₀ = eᵀe − ¼ dᵀd with the edges d of `displacements` (null: none): kViscousNumbers ×
/// kBatchLanes a batch.
void begin_viscous_step(const BatchView& batches, const double* positions,
                        const double* displacements, double* start);

/// Σ D of the elements, J; adds ∂D/∂q to `gradients` unless it is null.
double viscous_gradient(const BatchView& batches, double factor, const double* start,
                        const double* positions, double* gradients);

/// Adds T and a₁ to a state with metric terms, which prepare_tangent() has made.
void add_viscous_tangent(const BatchView& batches, double factor, const double* start,
                         const double* positions, TangentForm form, float* state);
void add_viscous_tangent(const BatchView& batches, double factor, const double* start,
                         const double* positions, TangentForm form, double* state);

}  // namespace tetraction
