#include "address_space.h"

#include <dlfcn.h>
#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cstddef>
#include <vector>

#include "console.h"

namespace tetraction {
namespace {

// OpenBLAS's buffer for a thread (BUFFER_SIZE of its x86-64 and ARM builds).
constexpr std::size_t kBuffer = std::size_t{128} << 20;
// Libraries, stacks and a small scene.
constexpr std::size_t kProgram = std::size_t{250} << 20;

// Makes OpenBLAS allocate the buffer of this thread.
void use_blas_once() {
  using Product = void (*)(const char*, const char*, const int*, const int*, const int*,
                           const double*, const double*, const int*, const double*, const int*,
                           const double*, double*, const int*);
  auto* const product = reinterpret_cast<Product>(dlsym(RTLD_DEFAULT, "dgemm_"));
  if (product == nullptr) return;
  const int n = 64;
  const double one = 1.0;
  const std::vector<double> a(n * n, 1.0);
  std::vector<double> c(n * n, 0.0);
  product("N", "N", &n, &n, &n, &one, a.data(), &n, a.data(), &n, &one, c.data(), &n);
}

}  // namespace

void require_address_space() {
  using GetThreads = int (*)();
  auto* const get_threads =
      reinterpret_cast<GetThreads>(dlsym(RTLD_DEFAULT, "openblas_get_num_threads"));
  rlimit limit{};
  if (get_threads == nullptr || getrlimit(RLIMIT_AS, &limit) != 0) return;
  if (limit.rlim_cur == RLIM_INFINITY) return;
  const std::size_t needed = kProgram + static_cast<std::size_t>(get_threads()) * kBuffer;
  if (limit.rlim_cur >= needed) {
    use_blas_once();
    return;
  }
  print_message(
      fmt::format("out of memory: the limit of the address space (ulimit -v) is {} MB, and the "
                  "program needs at least {} MB on this machine. Raise the limit, or set "
                  "OPENBLAS_NUM_THREADS=1, with which {} MB are enough.",
                  limit.rlim_cur >> 20, needed >> 20, (kProgram + kBuffer) >> 20));
  // The threads of OpenBLAS never end, and the usual exit would wait for them.
  _exit(1);
}

}  // namespace tetraction
