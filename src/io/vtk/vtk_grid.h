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
/// The same for the mesh of a part (TetMesh::part), which must stay as it is as long as the grid is used: the grid
/// refers to its positions, tetrahedra and ids. It needs less memory than a copy, by some 50 bytes per tetrahedron.
vtkSmartPointer<vtkUnstructuredGrid> grid_of_part(const TetMesh& mesh);

/// components × tuples as a VTK array of floating-point numbers, or of 32-bit integers.
vtkSmartPointer<vtkDataArray> make_array(const std::string& name, const Matrix& values,
                                         bool integral,
                                         FramePrecision precision = FramePrecision::kFloat64);
/// The same in double precision without a copy: the array refers to `values`.
vtkSmartPointer<vtkDataArray> array_of(const std::string& name, const Matrix& values);

/// Writes the grid as VTU with raw appended data, to a temporary file renamed into place. Throws
/// OutputError.
void write_vtu(vtkUnstructuredGrid* grid, const std::string& path,
               FrameCompression compression = FrameCompression::kZlib);
/// The same file as text. Throws OutputError, which names `path`, if VTK cannot make it.
std::string vtu_text(vtkUnstructuredGrid* grid, const std::string& path,
                     FrameCompression compression);

/// A file of a collection at a time, as a line for write_collection(). Files at one time have different parts.
std::string collection_entry(double time, const std::string& file, int part = 0);
/// Writes a .pvd collection. The entries name files relative to its folder. Throws OutputError.
void write_collection(const std::string& entries, const std::string& path);

}  // namespace tetraction
