// A frame as VTK's unstructured grid.
#pragma once

#include <vtkSmartPointer.h>

#include "tetraction/io/frame_writer.h"

class vtkUnstructuredGrid;

namespace tetraction {

/// The points and cells of `mesh` with the time and the fields of the frame. Arrays of double precision
/// refer to the frame, which must live as long as the grid. Throws InputError if a field does not have one column
/// for each point or cell.
vtkSmartPointer<vtkUnstructuredGrid> grid_of(vtkUnstructuredGrid* mesh, const Frame& frame,
                                             FramePrecision precision);

}  // namespace tetraction
