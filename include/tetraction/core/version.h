// What this build is and runs on.
#pragma once

#include <string>

namespace tetraction {

/// Version of the library, e.g. "0.1.0".
std::string version();

/// The BLAS that CHOLMOD calls, as found at run time.
struct BlasInfo {
  std::string library;  ///< "OpenBLAS" or "unknown (reference BLAS?)"
  std::string core;     ///< processor type its kernels are made for, or empty
};
BlasInfo blas_info();

/// Number of threads of the BLAS, where it is OpenBLAS, for the whole process; no effect otherwise.
/// One (what the program sets) is fastest for meshes of up to some ten thousand tetrahedra.
void set_blas_threads(int threads);

}  // namespace tetraction
