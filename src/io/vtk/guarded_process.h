// Runs code that may crash, hang or use all memory in a child process.
#pragma once

#include <functional>
#include <string>

namespace tetraction {

struct GuardLimits {
  double seconds = 30.0;                      ///< by the clock
  double processor_seconds = 15.0;            ///< on a busy machine much less than by the clock
  std::size_t memory = std::size_t{4} << 30;  ///< bytes on top of what the process has now
};

struct GuardResult {
  bool finished = false;  ///< the function returned and its bytes arrived whole
  std::string bytes;      ///< what it returned
  std::string failure;    ///< "it crashed (signal 11)", "it took longer than 30 s", …
};

/// Calls `work` in a forked child with limits on time and memory and collects the bytes that it
/// returns. `work` must not use threads: only the calling one exists in the child.
GuardResult run_guarded(const std::function<std::string()>& work, const GuardLimits& limits);

}  // namespace tetraction
