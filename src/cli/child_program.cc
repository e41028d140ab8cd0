#include "child_program.h"

#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <thread>
#include <utility>

#include "interrupt_guard.h"

namespace tetraction {

int run_child_program(std::vector<std::string> arguments) {
  // Made before the fork, after which only few functions may be called.
  std::vector<char*> words;
  words.reserve(arguments.size() + 1);
  for (std::string& argument : arguments) words.push_back(argument.data());
  words.push_back(nullptr);
  const pid_t parent = getpid();
  const pid_t pid = fork();
  if (pid < 0) return -1;
  if (pid == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != parent) _exit(1);  // it has ended already
    unblock_signals();
    std::signal(SIGPIPE, SIG_DFL);
    std::signal(SIGXFSZ, SIG_DFL);
    std::signal(SIGINT, SIG_IGN);  // a terminal sends it to both programs
    execvp(words.front(), words.data());
    _exit(127);
  }
  int status = 0;
  bool is_told = false;
  for (pid_t ended = 0; ended != pid;) {
    const bool is_stopped = InterruptGuard::interrupted();
    if (is_stopped && !std::exchange(is_told, true)) kill(pid, SIGTERM);
    ended = waitpid(pid, &status, WNOHANG);
    if (ended < 0 && errno != EINTR) return -1;
    if (ended != pid) std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

}  // namespace tetraction
