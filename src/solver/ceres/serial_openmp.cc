#include "serial_openmp.h"

#include <dlfcn.h>

namespace tetraction {
namespace {

// Looked up at run time: the program itself is not built with OpenMP, only CHOLMOD is.
template <class Function>
Function find(const char* name) {
  return reinterpret_cast<Function>(dlsym(RTLD_DEFAULT, name));
}

int max_active_levels() {
  static auto* const get = find<int (*)()>("omp_get_max_active_levels");
  return get != nullptr ? get() : 1;
}

void set_max_active_levels(int levels) {
  static auto* const set = find<void (*)(int)>("omp_set_max_active_levels");
  if (set != nullptr) set(levels);
}

}  // namespace

SerialOpenMp::SerialOpenMp() : levels_(max_active_levels()) {
  set_max_active_levels(0);
}

SerialOpenMp::~SerialOpenMp() {
  set_max_active_levels(levels_);
}

}  // namespace tetraction
