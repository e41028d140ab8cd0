// What a piece of code takes from the heap.
#pragma once

#include <cstddef>
#include <cstdint>

namespace tetraction::testing_support {

/// Whether this build can count allocations: not with the address sanitizer, which has malloc itself.
bool can_count_allocations();

/// Counts the allocations of at least `least` bytes of all threads while it lives, whoever makes them
/// (operator new, Eigen). One at a time.
class AllocationCounter {
 public:
  explicit AllocationCounter(std::size_t least);
  ~AllocationCounter();
  AllocationCounter(const AllocationCounter&) = delete;
  AllocationCounter& operator=(const AllocationCounter&) = delete;

  std::int64_t count() const;
};

}  // namespace tetraction::testing_support
