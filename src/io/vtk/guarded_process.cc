#include "guarded_process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <limits>
#include <new>
#include <utility>

namespace tetraction {
namespace {

constexpr int kOutOfMemory = 3;
constexpr int kOtherException = 4;

// The shadow memory of a sanitizer alone is terabytes of address space.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kSanitized = true;
#elif defined(__has_feature)  // Clang
constexpr bool kSanitized = __has_feature(address_sanitizer);
#else
constexpr bool kSanitized = false;
#endif

// Address space in use, bytes; a limit below it would stop the child at once.
std::size_t address_space() {
  std::ifstream file("/proc/self/statm");
  std::size_t pages = 0;
  file >> pages;
  return pages * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

void set_limit(__rlimit_resource resource, std::size_t value, std::size_t hard) {
  const rlimit limit{value, hard};
  setrlimit(resource, &limit);
}

void write_all(int descriptor, const char* data, std::size_t size) {
  while (size > 0) {
    const ssize_t written = write(descriptor, data, size);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) _exit(kOtherException);
    data += written;
    size -= static_cast<std::size_t>(written);
  }
}

[[noreturn]] void child(const std::function<std::string()>& work, const GuardLimits& limits,
                        int out) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);  // nobody would wait for it any more
  set_limit(RLIMIT_CORE, 0, 0);
  // Below the hard limit the signal is SIGXCPU, which differs from a crash.
  const auto seconds = static_cast<std::size_t>(std::ceil(limits.processor_seconds));
  set_limit(RLIMIT_CPU, seconds, seconds + 1);
  if (!kSanitized) {
    const std::size_t memory = address_space() + limits.memory;
    set_limit(RLIMIT_AS, memory, memory);
  }
  for (const int signal : {SIGSEGV, SIGBUS, SIGABRT, SIGFPE, SIGILL, SIGXCPU}) {
    std::signal(signal, SIG_DFL);
  }
  const int null = open("/dev/null", O_WRONLY);
  dup2(null, STDERR_FILENO);
  dup2(null, STDOUT_FILENO);
  try {
    const std::string bytes = work();
    const std::uint64_t size = bytes.size();
    write_all(out, reinterpret_cast<const char*>(&size), sizeof(size));
    write_all(out, bytes.data(), bytes.size());
    _exit(0);
  } catch (const std::bad_alloc&) {
    _exit(kOutOfMemory);
  } catch (...) {
    _exit(kOtherException);
  }
}

std::string describe(int status) {
  if (WIFSIGNALED(status) && WTERMSIG(status) == SIGXCPU) return "took too long";
  if (WIFSIGNALED(status)) return fmt::format("crashed (signal {})", WTERMSIG(status));
  if (WIFEXITED(status) && WEXITSTATUS(status) == kOutOfMemory) return "ran out of memory";
  return "failed";
}

// How many bytes the child will have written, that of their number among them, which comes first.
std::size_t announced_size(const std::string& received) {
  std::uint64_t size = 0;
  std::memcpy(&size, received.data(), sizeof(size));
  return size > std::numeric_limits<std::size_t>::max() - sizeof(size) ? 0 : size + sizeof(size);
}

}  // namespace

GuardResult run_guarded(const std::function<std::string()>& work, const GuardLimits& limits) {
  using Clock = std::chrono::steady_clock;
  GuardResult result;
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) {
    result.failure = fmt::format("could not be started ({})", std::strerror(errno));
    return result;
  }
  const pid_t pid = fork();
  if (pid == 0) {
    close(ends[0]);
    child(work, limits, ends[1]);
  }
  close(ends[1]);
  if (pid < 0) {
    close(ends[0]);
    result.failure = fmt::format("could not be started ({})", std::strerror(errno));
    return result;
  }

  const auto deadline = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                           std::chrono::duration<double>(limits.seconds));
  std::string received;
  std::array<char, 65536> buffer{};
  bool late = false;
  bool is_reserved = false;
  for (;;) {
    const auto left =
        std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now()).count();
    if (left <= 0) {
      late = true;
      break;
    }
    pollfd wait{ends[0], POLLIN, 0};
    const int ready = poll(&wait, 1, static_cast<int>(left));
    if (ready < 0 && errno == EINTR) continue;
    if (ready <= 0) continue;
    const ssize_t count = read(ends[0], buffer.data(), buffer.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) break;
    received.append(buffer.data(), static_cast<std::size_t>(count));
    // A string that grows by itself may need twice the memory.
    if (!is_reserved && received.size() >= sizeof(std::uint64_t)) {
      received.reserve(std::min<std::size_t>(announced_size(received), limits.memory));
      is_reserved = true;
    }
  }
  close(ends[0]);
  if (late) kill(pid, SIGKILL);
  int status = 0;
  while (waitpid(pid, &status, 0) < 0 && errno == EINTR) {
  }
  if (late) {
    result.failure = fmt::format("took longer than {:.0f} s", limits.seconds);
    return result;
  }
  result.finished = WIFEXITED(status) && WEXITSTATUS(status) == 0 &&
                    received.size() >= sizeof(std::uint64_t) &&
                    received.size() == announced_size(received);
  if (result.finished) {
    result.bytes = std::move(received);
    result.bytes.erase(0, sizeof(std::uint64_t));
  } else {
    result.failure = describe(status);
  }
  return result;
}

}  // namespace tetraction
