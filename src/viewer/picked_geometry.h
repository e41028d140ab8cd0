// What can be said of the vertices and faces that the user picks.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "tetraction/core/types.h"

namespace tetraction::viewer {

/// The vertices of the triangles that can be reached from one of them over edges at which the normals differ
/// by less than `angle` (degrees), in ascending order. `position`: 3 per vertex.
std::vector<Index> face_vertices(const std::vector<std::array<Index, 3>>& triangles,
                                 const Vector& position, std::size_t start, double angle);

/// The distance of two vertices (m), or the angles of the triangle of three, as a sentence. Empty for other
/// numbers of vertices. `names`: the numbers of the vertices in the file.
std::string measure(const Vector& position, const std::vector<Index>& vertices,
                    const std::vector<std::string>& names);

}  // namespace tetraction::viewer
