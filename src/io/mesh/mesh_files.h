// The format of a mesh file by its name.
#pragma once

#include <string>

namespace tetraction {

/// The ending of a mesh file in lower case, such as ".msh". Throws InputError if it is not that of a
/// mesh; `done` says what would have been done to the file: "read" or "written".
std::string mesh_ending(const std::string& path, const char* done);

}  // namespace tetraction
