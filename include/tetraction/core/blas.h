// Information about the BLAS that CHOLMOD calls: which one it is, and whether it is slow.
#pragma once

#include <string>

namespace tetraction {

/// The BLAS of this process, as found at run time.
struct BlasInfo {
  std::string library;  ///< "OpenBLAS", the file of another one, or "unknown"
  std::string core;     ///< the processor type of OpenBLAS's kernels; empty for another BLAS
};
BlasInfo blas_info();

/// While an object of this class exists, OpenBLAS runs on one thread. The dense blocks of a sparse
/// factorisation are mostly small. With more threads the factorisation is slower for meshes of up to
/// some ten thousand tetrahedra, and a fifth faster for 150,000. With one thread the results do not
/// depend on the number of cores. The class has no effect on another BLAS.
class SerialBlas {
 public:
  SerialBlas();
  ~SerialBlas();
  SerialBlas(const SerialBlas&) = delete;
  SerialBlas& operator=(const SerialBlas&) = delete;

 private:
  int threads_ = 0;  // number of threads to restore; 0 if the BLAS is not OpenBLAS
};

/// The instruction sets of a processor that the kernels of a BLAS may use.
struct ProcessorFeatures {
  bool avx2 = false;
  bool avx512 = false;
};
/// The features of this processor. All are false if it is not an x86 processor.
ProcessorFeatures processor_features();

/// A message for the user if this BLAS makes the program slow, with what to do about it. Otherwise
/// empty. `asked_core` is the value of OPENBLAS_CORETYPE, or empty if it is not set.
std::string blas_warning(const BlasInfo& blas, const ProcessorFeatures& processor,
                         const std::string& asked_core);
/// The warning for the BLAS and the processor of this process.
std::string blas_warning();

}  // namespace tetraction
