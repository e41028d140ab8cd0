// Counts the heap allocations of a piece of code.
#pragma once

#include <cstddef>
#include <cstdint>

namespace tetraction::testing_support {

/// Whether this build can count allocations. With the address sanitizer, which replaces malloc, it
/// can not.
bool can_count_allocations();

/// While it exists, counts all allocations of at least `least` bytes in all threads, by operator
/// new and by Eigen. Only one counter may exist at a time.
class AllocationCounter {
 public:
  explicit AllocationCounter(std::size_t least);
  ~AllocationCounter();
  AllocationCounter(const AllocationCounter&) = delete;
  AllocationCounter& operator=(const AllocationCounter&) = delete;

  std::int64_t count() const;
};

}  // namespace tetraction::testing_support
