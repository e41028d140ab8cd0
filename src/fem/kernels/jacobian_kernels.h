// The kernel that counts inverted elements.
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

}  // namespace tetraction
