#include "tetraction/core/process.h"

#include <sys/resource.h>

#include <fstream>
#include <string>

namespace tetraction {

std::int64_t peak_memory_bytes() {
  constexpr std::int64_t kKibibyte = 1024;
  // getrusage() is not used, because there a process begins with the peak of the process that
  // started it, for example of a large Python program. The kernel's status file has the peak of
  // this process alone.
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    std::int64_t kibibytes = 0;
    if (word == "VmHWM:" && status >> kibibytes) return kibibytes * kKibibyte;
  }
  rusage usage{};
  return getrusage(RUSAGE_SELF, &usage) == 0 ? usage.ru_maxrss * kKibibyte : 0;
}

}  // namespace tetraction
