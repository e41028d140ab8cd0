// Reads VTK files so that a broken one neither crashes nor hangs the program.
#pragma once

#include <cstddef>
#include <functional>
#include <string>

#include "vtk_header.h"

class vtkUnstructuredGrid;

namespace tetraction {

/// The result of read_guarded().
struct GridFile {
  VtkHeader header;   ///< what the file announces
  std::string bytes;  ///< what `encode` made of its grid
};

/// Checks the header of a .vtu or .vtk file, by its ending. VTK then reads the file in a child process,
/// and `encode` makes bytes of the grid there. Throws FileError if the file is missing or malformed,
/// if VTK reports an error or a warning, or if `encode` throws FileError (whose text is completed with
/// the file's name).
GridFile read_guarded(const std::string& path,
                      const std::function<std::string(vtkUnstructuredGrid*)>& encode);

/// Throws FileError: the file at `path` is no good grid, because of `what`.
[[noreturn]] void refuse_grid(const std::string& path, const std::string& what);

/// Throws FileError unless there are as many points and cells as the header announces: VTK's reader
/// may return fewer, or an empty grid, without an error.
void check_counts(const std::string& path, const VtkHeader& announced, std::size_t points,
                  std::size_t cells);

}  // namespace tetraction
