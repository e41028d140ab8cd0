// VTK's numbers of cell types.
#pragma once

#include <cstddef>

#include "tetraction/mesh/tet_mesh.h"

namespace tetraction {

/// The cell type that a number of VTK's stands for. The number of vertices tells the order of cells of any
/// order.
CellType vtk_cell_type(int vtk, std::size_t vertices);

/// How many vertices such a cell has; 0 where the number is free.
std::size_t vtk_cell_size(int vtk);

}  // namespace tetraction
