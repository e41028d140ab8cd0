// The version of this build, and those of the libraries in it.
#pragma once

#include <string>
#include <vector>

namespace tetraction {

/// Version of the library, e.g. "0.1.0".
std::string version();

/// A library that the program uses, and its version.
struct LibraryVersion {
  std::string name;     ///< e.g. "Ceres"
  std::string version;  ///< e.g. "2.1.0"
};

/// The libraries behind tetraction::core. blas_info() (core/blas.h) tells of BLAS.
std::vector<LibraryVersion> core_library_versions();

}  // namespace tetraction
