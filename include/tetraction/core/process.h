// The memory that this process has used.
#pragma once

#include <cstdint>

namespace tetraction {

/// The largest amount of RAM that the process has used so far, bytes; 0 if it is not known.
std::int64_t peak_memory_bytes();

}  // namespace tetraction
