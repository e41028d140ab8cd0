// A vector of pseudo-random numbers.
#pragma once

#include "tetraction/core/types.h"

namespace tetraction {

/// Pseudo-random numbers between −1 and 1 that are always the same. Such a vector has a component
/// along practically every eigenvector of a matrix.
Vector pseudo_random(Index size);

}  // namespace tetraction
