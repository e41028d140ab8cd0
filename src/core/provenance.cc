#include "tetraction/core/provenance.h"

#include <fmt/chrono.h>
#include <sys/utsname.h>

#include <algorithm>
#include <ctime>
#include <fstream>
#include <thread>

namespace tetraction {
namespace {

// Spaces at the ends are cut off, and several in a row become one.
std::string single_spaced(const std::string& text) {
  std::string result;
  for (const char c : text) {
    const bool is_space = c == ' ' || c == '\t';
    if (!is_space) {
      result += c;
    } else if (!result.empty() && result.back() != ' ') {
      result += ' ';
    }
  }
  if (!result.empty() && result.back() == ' ') result.pop_back();
  return result;
}

std::string processor_name() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    const auto colon = line.find(':');
    if (colon == std::string::npos || line.rfind("model name", 0) != 0) continue;
    if (std::string name = single_spaced(line.substr(colon + 1)); !name.empty()) return name;
  }
  // ARM processors have no model name there.
  utsname system{};
  return uname(&system) == 0 ? system.machine : "unknown";
}

}  // namespace

Machine this_machine() {
  return {processor_name(), static_cast<int>(std::max(1U, std::thread::hardware_concurrency()))};
}

std::string utc_now() {
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)));
}

}  // namespace tetraction
