// An order of points in which neighbours in space are near one another.
#pragma once

#include <vector>

#include "tetraction/core/types.h"

namespace tetraction {

/// The numbers 0 … points.cols() − 1 in the order in which a Hilbert curve through the bounding
/// cube of the points (2²¹ cells along a side) meets them. Points in the same cell are ordered by
/// number. `points`: 3 × n.
std::vector<Index> hilbert_order(const Eigen::Matrix<float, 3, Eigen::Dynamic>& points);

}  // namespace tetraction
