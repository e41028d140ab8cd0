// The files of a run.
#pragma once

#include <string>
#include <vector>

#include "tetraction/core/types.h"

namespace tetraction {

/// Whether `name` is that of a frame, "frame_000010.vtu".
bool is_frame_name(const std::string& name);
/// The file of the obstacles that have moved since the frame before, "frames/obstacles_000010.vtu" of step 10.
std::string obstacle_frame_name(Index step);
/// Whether `name` is that of such a file, without the folder.
bool is_obstacle_frame_name(const std::string& name);

/// Deletes frames.pvd and the frames of an earlier run in `directory`, with their obstacles and the temporary files that
/// a killed program has left, and the folder `frames` if nothing else is in it. Throws OutputError,
/// before anything is deleted, if `frames` is a link.
void remove_frames(const std::string& directory);
/// The same, but frames.pvd and the files with these names stay. Without names all go.
void remove_frames(const std::string& directory, const std::vector<std::string>& kept);

/// The same for all files of an earlier run, history.csv included. Other files stay.
void remove_run(const std::string& directory);

/// Deletes what a run writes at its end: summary.json, final.vtu or final.pvtu, and failed_elements.vtu.
void remove_end_of_run(const std::string& directory);

}  // namespace tetraction
