#include "support/allocations.h"

#include <atomic>
#include <cerrno>
#include <limits>

namespace tetraction::testing_support {
namespace {

constexpr std::size_t kOff = std::numeric_limits<std::size_t>::max();
std::atomic<std::size_t> least_counted{kOff};
std::atomic<std::int64_t> counted{0};

}  // namespace

AllocationCounter::AllocationCounter(std::size_t least) {
  counted = 0;
  least_counted = least;
}

AllocationCounter::~AllocationCounter() {
  least_counted = kOff;
}

std::int64_t AllocationCounter::count() const {
  return counted;
}

}  // namespace tetraction::testing_support

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)

bool tetraction::testing_support::can_count_allocations() {
  return false;
}

#else

bool tetraction::testing_support::can_count_allocations() {
  return true;
}

// The program's own malloc takes the place of the C library's, and calls it.
extern "C" {
void* __libc_malloc(std::size_t size);                           // NOLINT: the C library's names
void* __libc_calloc(std::size_t count, std::size_t size);        // NOLINT
void* __libc_realloc(void* old, std::size_t size);               // NOLINT
void* __libc_memalign(std::size_t alignment, std::size_t size);  // NOLINT
}

namespace {

void note(std::size_t size) {
  using namespace tetraction::testing_support;
  if (size >= least_counted.load(std::memory_order_relaxed)) ++counted;
}

}  // namespace

extern "C" void* malloc(std::size_t size) {
  note(size);
  return __libc_malloc(size);
}
extern "C" void* calloc(std::size_t count, std::size_t size) {
  note(count * size);
  return __libc_calloc(count, size);
}
extern "C" void* realloc(void* old, std::size_t size) {
  note(size);
  return __libc_realloc(old, size);
}
extern "C" void* aligned_alloc(std::size_t alignment, std::size_t size) {
  note(size);
  return __libc_memalign(alignment, size);
}
extern "C" int posix_memalign(void** result, std::size_t alignment, std::size_t size) {
  note(size);
  void* memory = __libc_memalign(alignment, size);
  if (memory == nullptr) return ENOMEM;
  *result = memory;
  return 0;
}

#endif
