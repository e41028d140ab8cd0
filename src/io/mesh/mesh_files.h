// The format of a mesh file by its name.
#pragma once

#include <string>
#include <vector>

namespace tetraction {

/// The ending of a mesh file in lower case, such as ".msh". Throws InputError if it is not that of a
/// mesh; `done` says what would have been done to the file: "read" or "written".
std::string mesh_ending(const std::string& path, const char* done);

/// The files of a mesh with this name: TetGen's .node, .ele and .face belong together. They need not exist.
std::vector<std::string> files_of_mesh(const std::string& path);

}  // namespace tetraction
