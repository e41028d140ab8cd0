// The rim of a part of a surface.
#pragma once

#include <array>
#include <vector>

#include "tetraction/core/types.h"

namespace tetraction {

/// The edges of oriented triangles that have no opposite edge, in the direction of their triangles. A
/// closed surface has none.
std::vector<std::array<Index, 2>> rim_edges(const std::vector<std::array<Index, 3>>& triangles);

}  // namespace tetraction
