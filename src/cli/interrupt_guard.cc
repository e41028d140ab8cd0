#include "interrupt_guard.h"

#include <poll.h>
#include <pthread.h>
#include <sys/syscall.h>
#include <ucontext.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>
#include <thread>

namespace tetraction {
namespace {

std::atomic<int> first_signal{0};
std::atomic<bool> was_stopped{false};
std::atomic<int> guards{0};
std::atomic<int> threads_told{0};

sigset_t watched_signals() {
  sigset_t set;
  sigemptyset(&set);
  for (const int number : {SIGINT, SIGTERM, SIGQUIT, SIGHUP}) {
    struct sigaction present {};
    sigaction(number, nullptr, &present);
    if (number != SIGHUP || present.sa_handler != SIG_IGN) sigaddset(&set, number);
  }
  return set;
}

// The handler of a signal to a thread that blocks the watched ones there: they are added to the mask
// that is restored when the handler returns.
void block_here(int, siginfo_t*, void* context) {
  auto* const interrupted = static_cast<ucontext_t*>(context);
  for (const int number : {SIGINT, SIGTERM, SIGQUIT, SIGHUP}) {
    sigaddset(&interrupted->uc_sigmask, number);
  }
  ++threads_told;
}

// A library may have started threads before main(), as OpenBLAS does.
void block_in_other_threads() {
  namespace fs = std::filesystem;
  const int number = SIGRTMIN;
  struct sigaction action {};
  struct sigaction previous {};
  action.sa_sigaction = block_here;
  action.sa_flags = SA_SIGINFO | SA_RESTART;
  sigemptyset(&action.sa_mask);
  sigaction(number, &action, &previous);
  int told = 0;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator("/proc/self/task", error)) {
    const int thread = std::atoi(entry.path().filename().c_str());
    if (thread != gettid() && syscall(SYS_tgkill, getpid(), thread, number) == 0) ++told;
  }
  // Usually at once. The program works without it as well.
  for (int i = 0; i < 1000 && threads_told < told; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  if (threads_told == told) sigaction(number, &previous, nullptr);
}

[[noreturn]] void end_at_once(int number) {
  constexpr std::string_view kText = "\ntetraction: stopped at once on the second signal\n";
  pollfd err{STDERR_FILENO, POLLOUT, 0};
  // A terminal or pipe that takes nothing must not keep the program from ending.
  if (poll(&err, 1, 0) == 1) {
    const ssize_t ignored = write(STDERR_FILENO, kText.data(), kText.size());
    static_cast<void>(ignored);
  }
  _exit(128 + number);
}

// Does what the signal does by default.
void end_by(int number) {
  std::signal(number, SIG_DFL);
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, number);
  pthread_sigmask(SIG_UNBLOCK, &set, nullptr);
  std::raise(number);
}

void watch(const sigset_t& set) {
  using Clock = std::chrono::steady_clock;
  constexpr auto kSameSignal = std::chrono::milliseconds(300);
  Clock::time_point first_time;
  for (;;) {
    int number = 0;
    if (sigwait(&set, &number) != 0) continue;
    if (guards == 0) {
      end_by(number);
    } else if (first_signal == 0) {
      first_signal = number;
      was_stopped = true;
      first_time = Clock::now();
    } else if (Clock::now() - first_time > kSameSignal) {
      end_at_once(number);
    }
  }
}

}  // namespace

void watch_signals() {
  const sigset_t set = watched_signals();
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
  try {
    std::thread(watch, set).detach();
    block_in_other_threads();
  } catch (const std::system_error&) {  // no thread can be made: signals end the program at once
    pthread_sigmask(SIG_UNBLOCK, &set, nullptr);
  }
}

void unblock_signals() {
  sigset_t set;
  sigemptyset(&set);
  for (const int number : {SIGINT, SIGTERM, SIGQUIT, SIGHUP}) sigaddset(&set, number);
  pthread_sigmask(SIG_UNBLOCK, &set, nullptr);
}

InterruptGuard::InterruptGuard() {
  ++guards;
}

InterruptGuard::~InterruptGuard() {
  --guards;
}

bool InterruptGuard::interrupted() {
  return first_signal != 0;
}

const std::atomic<bool>& InterruptGuard::stop_flag() const {
  return was_stopped;
}

int InterruptGuard::exit_code() {
  return 128 + (interrupted() ? first_signal.load() : SIGINT);
}

}  // namespace tetraction
