#include "tetraction/core/process.h"

#include <sys/resource.h>

#include <fstream>
#include <string>

namespace tetraction {

std::int64_t peak_memory_bytes() {
  constexpr std::int64_t kKibibyte = 1024;
  // getrusage() would do, but that a process begins with the peak of the one that started it: called
  // from a large Python program it tells of Python. The kernel's status file tells of this program.
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    std::int64_t kibibytes = 0;
    if (word == "VmHWM:" && status >> kibibytes) return kibibytes * kKibibyte;
  }
  rusage usage{};
  return getrusage(RUSAGE_SELF, &usage) == 0 ? usage.ru_maxrss * kKibibyte : 0;
}

}  // namespace tetraction
