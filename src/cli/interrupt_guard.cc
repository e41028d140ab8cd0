#include "interrupt_guard.h"

#include <poll.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdint>
#include <ctime>
#include <string_view>

namespace tetraction {
namespace {

std::atomic<int> first_signal{0};
std::atomic<std::int64_t> first_time{0};  // of a clock, ns

static_assert(std::atomic<int>::is_always_lock_free);  // what a signal handler may use
static_assert(std::atomic<std::int64_t>::is_always_lock_free);

std::int64_t now() {
  timespec time{};
  clock_gettime(CLOCK_MONOTONIC, &time);
  return std::int64_t{1'000'000'000} * time.tv_sec + time.tv_nsec;
}

// It may run in any thread and at any moment: it calls only what signal handlers may call.
void note_signal(int number) {
  constexpr std::int64_t kSameSignal = 300'000'000;
  const int saved_errno = errno;
  int none = 0;
  if (first_signal.compare_exchange_strong(none, number)) {
    first_time = now();
  } else if (first_time != 0 && now() - first_time > kSameSignal) {
    constexpr std::string_view kText = "\ntetraction: stopped at once on the second signal\n";
    pollfd err{STDERR_FILENO, POLLOUT, 0};
    // A terminal or pipe that takes nothing must not keep the program from ending.
    if (poll(&err, 1, 0) == 1) {
      const ssize_t ignored = write(STDERR_FILENO, kText.data(), kText.size());
      static_cast<void>(ignored);
    }
    _exit(128 + number);
  }
  errno = saved_errno;
}

}  // namespace

InterruptGuard::InterruptGuard() {
  for (std::size_t i = 0; i < kSignals.size(); ++i) {
    sigaction(kSignals[i], nullptr, &previous_[i]);
    if (previous_[i].sa_handler == SIG_IGN) continue;
    struct sigaction action {};
    action.sa_handler = note_signal;
    action.sa_flags = SA_RESTART;
    sigemptyset(&action.sa_mask);
    sigaction(kSignals[i], &action, nullptr);
  }
}

InterruptGuard::~InterruptGuard() {
  for (std::size_t i = 0; i < kSignals.size(); ++i) {
    sigaction(kSignals[i], &previous_[i], nullptr);
  }
}

bool InterruptGuard::interrupted() {
  return first_signal != 0;
}

int InterruptGuard::exit_code() {
  return 128 + (interrupted() ? first_signal.load() : SIGINT);
}

}  // namespace tetraction
