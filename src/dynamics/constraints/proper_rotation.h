// The rotation that is nearest to a matrix.
#pragma once

#include "tetraction/core/types.h"

namespace tetraction {

/// The rotation R of the polar decomposition of a, det R = +1 always (Kabsch's sign).
Matrix3 proper_rotation(const Matrix3& a);

}  // namespace tetraction
