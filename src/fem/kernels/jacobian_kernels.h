// Kernels that look at J = det F of elements and at its change.
#pragma once

#include "element_kernels.h"

namespace tetraction {

/// A summary of J = det F of the elements in a block.
struct JacobianSigns {
  std::ptrdiff_t negative = 0;  ///< number of elements with J < 0
  bool all_above_half = true;   ///< whether all have J > ½
};

/// `positions`: records as in element_kernels.h.
JacobianSigns jacobian_signs(const BatchView& batches, const double* positions);

/// Whether a sufficient condition shows that J is positive at q and that no element loses more than nine tenths of
/// its volume anywhere between q and q + d: the negative terms of the polynomial J(q + t d), 0 ≤ t ≤ 1, add up to less
/// than nine tenths of J(q). `positions` are records of q and `displacements` of d.
bool way_keeps_volumes(const BatchView& batches, const double* positions,
                       const double* displacements);

/// The largest changes of the deformation gradient F in a block by displacements d of its vertices, in terms of
/// |d D_m⁻¹| ≤ |d| |D_m⁻¹| with the rest edges D_m and Frobenius norms.
struct LargestChanges {
  double square = 0.0;             ///< |d|² |D_m⁻¹|²
  double square_by_lengths = 0.0;  ///< |d|² |D_m⁻¹|⁴, 1/m²
};
LargestChanges largest_changes(const BatchView& batches, const double* displacements);

}  // namespace tetraction
