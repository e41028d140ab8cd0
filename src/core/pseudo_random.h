// A vector that has a part of everything.
#pragma once

#include "tetraction/core/types.h"

namespace tetraction {

/// Numbers between −1 and 1, always the same: a vector that has a part of every eigenvector.
Vector pseudo_random(Index size);

}  // namespace tetraction
