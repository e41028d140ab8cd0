// Reads back the frames that a run has written.
#pragma once

#include <string>
#include <vector>

#include "tetraction/core/types.h"

namespace tetraction {

/// The result of read_frame(). An array that the file does not have is an empty matrix.
struct StoredFrame {
  Index vertex_count = 0;
  Index tetrahedron_count = 0;
  std::vector<Matrix> point_arrays;  ///< components × vertices, in the order asked for
  std::vector<Matrix> cell_arrays;   ///< components × tetrahedra, in the order asked for
};

/// Reads the named arrays of one frame, a VTU file written by FrameWriter.
/// Throws FileError if the file cannot be read or is malformed.
StoredFrame read_frame(const std::string& path, const std::vector<std::string>& point_names,
                       const std::vector<std::string>& cell_names = {});

}  // namespace tetraction
