// Keeps results from taking the place of the files from which they are computed.
#pragma once

#include <string>
#include <vector>

#include "tetraction/simulation/scene.h"

namespace tetraction {

/// The files from which a scene is computed: the scene file, the mesh with the files that belong to it, the tables
/// of amplitudes, the surfaces of obstacles, and the initial fields. Files need not exist.
std::vector<std::string> input_files(const Scene& scene);

/// Throws InputError if an input is a file that a run, an equilibrium, modes or a study writes or deletes in `directory`,
/// or, of a run, in one of these folders of it. Files are the same if device and inode are, whatever their names. An
/// input that is a link is the link as well as the file to which it leads.
void refuse_inputs_among_results(const std::vector<std::string>& inputs,
                                 const std::string& directory,
                                 const std::vector<std::string>& run_folders = {});

}  // namespace tetraction
