// What this process has used.
#pragma once

#include <cstdint>

namespace tetraction {

/// The most memory that the process has held in RAM so far, bytes; 0 if it cannot be told.
std::int64_t peak_memory_bytes();

}  // namespace tetraction
