// The element types of the Gmsh format.
#pragma once

#include <cstdint>

#include "tetraction/mesh/tet_mesh.h"

namespace tetraction {

struct GmshType {
  CellType type;
  int nodes;
  int dimension;
};

/// The type with a number of the format, or nullptr if the readers do not know it.
const GmshType* find_gmsh_type(std::int64_t number);

}  // namespace tetraction
