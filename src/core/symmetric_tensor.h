// The components of symmetric tensors.
#pragma once

#include "tetraction/core/types.h"

namespace tetraction {

/// XX YY ZZ XY YZ XZ of a symmetric tensor.
inline Eigen::Matrix<double, 6, 1> symmetric_components(const Matrix3& s) {
  return {s(0, 0), s(1, 1), s(2, 2), s(0, 1), s(1, 2), s(0, 2)};
}

}  // namespace tetraction
