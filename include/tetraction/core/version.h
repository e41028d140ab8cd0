// The version of this build.
#pragma once

#include <string>

namespace tetraction {

/// Version of the library, e.g. "0.1.0".
std::string version();

}  // namespace tetraction
