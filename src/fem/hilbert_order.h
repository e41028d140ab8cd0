// Neighbours in space, near one another in a list.
#pragma once

#include <vector>

#include "tetraction/core/types.h"

namespace tetraction {

/// Numbers 0 … points.cols() − 1 in the order in which a Hilbert curve through the points' bounding
/// cube (2²¹ cells a side) meets them; ties by number. `points`: 3 × n.
std::vector<Index> hilbert_order(const Eigen::Matrix<float, 3, Eigen::Dynamic>& points);

}  // namespace tetraction
