#include "tetraction/core/version.h"

#include <dlfcn.h>

namespace tetraction {

std::string version() {
  return TETRACTION_VERSION;
}

BlasInfo blas_info() {
  // Looked up at run time: which BLAS is installed is Debian's alternatives' business, not the
  // linker's.
  using CoreName = char* (*)();
  if (auto* core_name = reinterpret_cast<CoreName>(dlsym(RTLD_DEFAULT, "openblas_get_corename"))) {
    return {"OpenBLAS", core_name()};
  }
  return {"unknown (reference BLAS?)", ""};
}

void set_blas_threads(int threads) {
  using SetThreads = void (*)(int);
  if (auto* set_threads =
          reinterpret_cast<SetThreads>(dlsym(RTLD_DEFAULT, "openblas_set_num_threads"))) {
    set_threads(threads);
  }
}

}  // namespace tetraction
