// Kernel that looks for inverted elements.
#pragma once

#include "element_kernels.h"

namespace tetraction {

/// The signs of the elements' Jacobians in a block.
struct JacobianSigns {
  std::ptrdiff_t negative = 0;  ///< how many elements have J < 0
  bool all_above_half = true;   ///< whether all have J > ½
};

/// Rows of `positions` as in element_kernels.h.
JacobianSigns jacobian_signs(const BatchView& batches, const double* positions);

}  // namespace tetraction
