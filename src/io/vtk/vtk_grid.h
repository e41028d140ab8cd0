// From a mesh to VTK's unstructured grid: shared by all VTK writers.
#pragma once

#include <vtkSmartPointer.h>

#include <string>

#include "tetraction/mesh/tet_mesh.h"
#include "tetraction/simulation/frame_format.h"

class vtkDataArray;
class vtkUnstructuredGrid;

namespace tetraction {

/// Points (rest positions) and tetrahedra, with `vertex_id` and `element_id`: the file's numbers.
vtkSmartPointer<vtkUnstructuredGrid> make_grid(const TetMesh& mesh);

/// components × tuples as a VTK array of floating-point numbers, or of 32-bit integers.
vtkSmartPointer<vtkDataArray> make_array(const std::string& name, const Matrix& values,
                                         bool integral,
                                         FramePrecision precision = FramePrecision::kFloat64);

/// Writes the grid as VTU with raw appended data, to a temporary file renamed into place. Throws
/// OutputError.
void write_vtu(vtkUnstructuredGrid* grid, const std::string& path,
               FrameCompression compression = FrameCompression::kZlib);

}  // namespace tetraction
