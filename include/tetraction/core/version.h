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

/// Number of threads of OpenBLAS and of CHOLMOD's OpenMP loops, for the whole process. One is
/// fastest for meshes of up to some ten thousand tetrahedra (the program sets it): CHOLMOD asks for
/// four threads by itself, which on fewer cores wait for each other most of the time.
void set_factorization_threads(int threads);

}  // namespace tetraction
