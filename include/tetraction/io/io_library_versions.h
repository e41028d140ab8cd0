// The versions of the libraries that read and write files.
#pragma once

#include <vector>

#include "tetraction/core/version.h"

namespace tetraction {

/// The libraries behind tetraction::io, beyond core_library_versions().
std::vector<LibraryVersion> io_library_versions();

}  // namespace tetraction
