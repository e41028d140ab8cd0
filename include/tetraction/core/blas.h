// Information about the BLAS that CHOLMOD calls: which one it is, and whether it is slow.
#pragma once

#include <string>

namespace tetraction {

/// The BLAS of this process, as found at run time.
struct BlasInfo {
  std::string library;  ///< "OpenBLAS", the file of another one, or "unknown"
  std::string core;     ///< of OpenBLAS: processor type its kernels are made for; else empty
};
BlasInfo blas_info();

/// While an object of this class lives, OpenBLAS runs on one thread. The dense fronts of a sparse
/// factorisation are mostly small: more threads cost time up to some ten thousand tetrahedra and
/// save a fifth at 150,000. One thread also gives bitwise the same results on every machine. The
/// class has no effect on another BLAS.
class SerialBlas {
 public:
  SerialBlas();
  ~SerialBlas();
  SerialBlas(const SerialBlas&) = delete;
  SerialBlas& operator=(const SerialBlas&) = delete;

 private:
  int threads_ = 0;  // as before; 0: not OpenBLAS
};

/// The instruction sets of a processor that the kernels of a BLAS may use.
struct ProcessorFeatures {
  bool avx2 = false;
  bool avx512 = false;
};
/// The features of this processor; none of them if it is not an x86.
ProcessorFeatures processor_features();

/// One line for the user if this BLAS makes the program slow, with the remedy; otherwise empty.
/// `asked_core` is the value of OPENBLAS_CORETYPE, empty if it is not set.
std::string blas_warning(const BlasInfo& blas, const ProcessorFeatures& processor,
                         const std::string& asked_core);
/// The warning for the BLAS and the processor of this process.
std::string blas_warning();

}  // namespace tetraction
