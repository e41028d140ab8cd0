// The BLAS that CHOLMOD calls: which one it is, and whether it is a slow one.
#pragma once

#include <string>

namespace tetraction {

/// The BLAS of this process, as found at run time.
struct BlasInfo {
  std::string library;  ///< "OpenBLAS", the file of another one, or "unknown"
  std::string core;     ///< of OpenBLAS: processor type its kernels are made for; else empty
};
BlasInfo blas_info();

/// While it lives, OpenBLAS runs on one thread. The fronts of a factor are mostly small, so that more
/// threads cost time up to some ten thousand tetrahedra and save a fifth at 150,000; and one thread
/// gives the same bits whatever the machine. No effect on another BLAS.
class SerialBlas {
 public:
  SerialBlas();
  ~SerialBlas();
  SerialBlas(const SerialBlas&) = delete;
  SerialBlas& operator=(const SerialBlas&) = delete;

 private:
  int threads_ = 0;  // as before; 0: not OpenBLAS
};

/// What a processor offers that the kernels of a BLAS may use.
struct ProcessorFeatures {
  bool avx2 = false;
  bool avx512 = false;
};
/// Of this processor; none where it is not an x86.
ProcessorFeatures processor_features();

/// One line for the user if the BLAS costs speed, with what to do; else empty. `asked_core` is the
/// value of OPENBLAS_CORETYPE, empty without one.
std::string blas_warning(const BlasInfo& blas, const ProcessorFeatures& processor,
                         const std::string& asked_core);
/// The same of this process.
std::string blas_warning();

}  // namespace tetraction
