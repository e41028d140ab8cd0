// Surfaces of obstacles as VTK's unstructured grids of polygons.
#pragma once

#include <memory>
#include <string>

#include "tetraction/io/obstacle_surface.h"
#include "tetraction/simulation/frame_format.h"

namespace tetraction {

/// The text of a VTU file of polygons and lines, with their `obstacle`, the number from 0. All points have the `displacement`
/// zero, so that filters that move the body by it leave obstacles where they are. `path` is for messages. Throws
/// OutputError.
std::string obstacle_file(const ObstacleSurface& surface, const std::string& path,
                          FrameCompression compression);

/// Reads such a file, guarded as other VTK files (guarded_grid.h). Throws FileError, also for cells that are
/// no lines and no polygons of three or four corners, and for points that are not finite.
std::shared_ptr<const ObstacleSurface> read_obstacle_file(const std::string& path);

}  // namespace tetraction
