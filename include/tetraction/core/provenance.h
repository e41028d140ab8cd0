// Where and when a result was computed.
#pragma once

#include <string>

namespace tetraction {

/// The computer that this process runs on.
struct Machine {
  std::string processor;  ///< model name of the processor, or its architecture if that is not known
  int cores = 0;          ///< logical cores that this process may use
};
Machine this_machine();

/// The present time in UTC, as 2025-01-31T12:00:00Z.
std::string utc_now();

}  // namespace tetraction
