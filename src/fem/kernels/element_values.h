// Kernels of the fields of elements. They set a number and a symmetric tensor of every element: kValueNumbers ×
// kBatchLanes numbers per batch, with the components XX YY ZZ XY YZ XZ behind the number.
#pragma once

#include "element_kernels.h"

namespace tetraction {

constexpr int kValueNumbers = 7;

/// Ψ, J/m³, which is 0 where it is not defined, and the Cauchy stress, Pa. `positions`: records as in element_kernels.h.
void element_values(const BatchView& batches, const IsotropicModel& material,
                    const double* positions, double* values);

/// J and E = ½(FᵀF − I). `rest_positions` are the records of the rest positions.
void element_deformations(const BatchView& batches, const double* rest_positions,
                          const double* positions, double* values);

}  // namespace tetraction
