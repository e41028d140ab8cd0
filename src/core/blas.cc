#include "tetraction/core/blas.h"

#include <dlfcn.h>
#include <fmt/format.h>
#include <strings.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <system_error>

namespace tetraction {
namespace {

constexpr const char* kOpenBlas = "OpenBLAS";

// Core types of OpenBLAS (its driver/others/dynamic.c) whose kernels are old. Core types that are in
// neither list count as up to date.
constexpr std::array kWithoutAvx2{
    "Katmai",       "Coppermine",  "Northwood", "Prescott",  "Banias",     "Atom",       "Core2",
    "Penryn",       "Dunnington",  "Nehalem",   "Athlon",    "Opteron",    "Barcelona",  "Nano",
    "Opteron_SSE3", "Sandybridge", "Bobcat",    "Bulldozer", "Piledriver", "Steamroller"};
constexpr std::array kWithAvx2Only{"Haswell", "Zen", "Excavator"};

// Like OpenBLAS, ignores case.
bool same_core(const std::string& a, const std::string& b) {
  return strcasecmp(a.c_str(), b.c_str()) == 0;
}

template <class List>
bool contains(const List& list, const std::string& core) {
  return std::any_of(list.begin(), list.end(),
                     [&](const char* entry) { return same_core(core, entry); });
}

// The library file that contains the matrix product of this process. Empty if it is not known.
std::string file_of_blas() {
  void* product = dlsym(RTLD_DEFAULT, "dgemm_");
  Dl_info info{};
  if (product == nullptr || dladdr(product, &info) == 0 || info.dli_fname == nullptr) return {};
  // Debian's alternatives are links. The file to which they lead has the name of the library.
  std::error_code error;
  const std::filesystem::path file = std::filesystem::canonical(info.dli_fname, error);
  return error ? info.dli_fname : file.string();
}

}  // namespace

BlasInfo blas_info() {
  // This is looked up at run time, because the BLAS that is called depends on Debian's alternatives
  // and on the order in which libraries are loaded. OpenBLAS may be loaded while another one is
  // used.
  using CoreName = char* (*)();
  auto* const core_name = reinterpret_cast<CoreName>(dlsym(RTLD_DEFAULT, "openblas_get_corename"));
  const std::string file = file_of_blas();
  if (core_name != nullptr && (file.empty() || file.find("openblas") != std::string::npos)) {
    return {kOpenBlas, core_name()};
  }
  return {file.empty() ? "unknown" : file, ""};
}

namespace {

void set_blas_threads(int threads) {
  using SetThreads = void (*)(int);
  static auto* const set =
      reinterpret_cast<SetThreads>(dlsym(RTLD_DEFAULT, "openblas_set_num_threads"));
  if (set != nullptr) set(threads);
}

int blas_threads() {
  using GetThreads = int (*)();
  static auto* const get =
      reinterpret_cast<GetThreads>(dlsym(RTLD_DEFAULT, "openblas_get_num_threads"));
  return get != nullptr ? get() : 0;
}

}  // namespace

SerialBlas::SerialBlas() : threads_(blas_threads()) {
  if (threads_ > 1) set_blas_threads(1);
}

SerialBlas::~SerialBlas() {
  if (threads_ > 1) set_blas_threads(threads_);
}

ProcessorFeatures processor_features() {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_cpu_init();
  return {__builtin_cpu_supports("avx2") != 0,
          __builtin_cpu_supports("avx512f") != 0 && __builtin_cpu_supports("avx512vl") != 0};
#else
  return {};
#endif
}

std::string blas_warning(const BlasInfo& blas, const ProcessorFeatures& processor,
                         const std::string& asked_core) {
  if (blas.library != kOpenBlas) {
    return fmt::format(
        "the BLAS is not OpenBLAS ({}); with the reference BLAS factorisations take several times "
        "as long. Call scripts/setup, or choose OpenBLAS with update-alternatives --config "
        "libblas.so.3-$(g++ -print-multiarch), and the same for liblapack.so.3.",
        blas.library);
  }
  const bool slow = processor.avx2 && contains(kWithoutAvx2, blas.core);
  const bool slower = processor.avx512 && contains(kWithAvx2Only, blas.core);
  if (!slow && !slower) return {};
  // OpenBLAS ignores a name that it does not know, and then chooses the core type itself.
  if (!asked_core.empty() && same_core(asked_core, blas.core)) {
    return fmt::format(
        "OPENBLAS_CORETYPE={} in the environment keeps OpenBLAS from using {}, which this "
        "processor has: factorisations take longer. Unset it.",
        asked_core, processor.avx512 ? "AVX-512" : "AVX2");
  }
  // By itself OpenBLAS may choose AVX2 kernels on a processor with AVX-512. For AMD's Zen 4, for
  // example, version 0.3.21 chooses SkylakeX, Cooperlake or Zen, depending on the features that the
  // machine reports. This costs little, and there is no warning. Kernels without AVX2 cost much.
  if (!slow) return {};
  return fmt::format(
      "OpenBLAS takes this processor for {} and does not use its AVX2: factorisations take longer. "
      "Install a newer OpenBLAS, or set OPENBLAS_CORETYPE={} in the environment.",
      blas.core, processor.avx512 ? "SkylakeX" : "Haswell");
}

std::string blas_warning() {
  const char* asked_core = std::getenv("OPENBLAS_CORETYPE");
  return blas_warning(blas_info(), processor_features(), asked_core != nullptr ? asked_core : "");
}

}  // namespace tetraction
