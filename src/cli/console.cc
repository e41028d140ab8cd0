#include "console.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>

#include "core/printable_json.h"
#include "core/quoting.h"

namespace tetraction {
namespace {

int first_error = 0;  // of standard output
bool is_silent = false;

void note_failure() {
  if (first_error == 0) first_error = errno != 0 ? errno : EIO;
}

void write_bytes(std::string_view bytes) {
  if (is_silent) return;
  errno = 0;
  if (std::fwrite(bytes.data(), 1, bytes.size(), stdout) != bytes.size()) note_failure();
}

}  // namespace

void prepare_streams() {
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (fcntl(stream, F_GETFD) != -1 || errno != EBADF) continue;
    // open() takes the lowest free number, which is this one. Writing to standard output must still
    // fail.
    static_cast<void>(open("/dev/null", stream == STDERR_FILENO ? O_WRONLY : O_RDONLY));
  }
}

void set_silent(bool silent) {
  is_silent = silent;
}

void write_result(std::string_view text) {
  write_bytes(printable(text));
}

void write_json_result(std::string_view text) {
  write_bytes(printable_json(text));
}

std::string lost_results() {
  errno = 0;
  if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) note_failure();
  return first_error == 0 ? "" : std::strerror(first_error);
}

void print_progress(std::string_view text) {
  if (is_silent) return;
  static_cast<void>(std::fwrite(text.data(), 1, text.size(), stderr));
  static_cast<void>(std::fflush(stderr));
}

void print_message(std::string_view text) {
  std::string line;
  for (const char c : printable_message(text)) {
    if (c == '\n') {
      line += "\\n";  // of a file's name, for instance
    } else {
      line += c;
    }
  }
  print_progress(fmt::format("tetraction: {}\n", line));
}

void print_note(std::string_view text) {
  print_message(fmt::format("note: {}", text));
}

void print_warning(std::string_view text) {
  print_message(fmt::format("warning: {}", text));
}

}  // namespace tetraction
