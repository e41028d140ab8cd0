#include "command_line.h"

#include <unistd.h>

#include <filesystem>
#include <string_view>
#include <system_error>

namespace tetraction {
namespace {

std::string& remembered() {
  static std::string text;
  return text;
}

char**& arguments() {
  static char** argv = nullptr;
  return argv;
}

int threads_given = 0;

// In single quotes if a shell would read the word in another way.
std::string shell_word(std::string_view word) {
  constexpr std::string_view kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_@%+=:,./-";
  if (!word.empty() && word.find_first_not_of(kPlain) == std::string_view::npos) {
    return std::string(word);
  }
  std::string quoted = "'";
  for (const char c : word) {
    if (c == '\'') {
      quoted += "'\\''";
    } else {
      quoted += c;
    }
  }
  return quoted + "'";
}

}  // namespace

void remember_command_line(int argc, char** argv) {
  arguments() = argv;
  std::string& text = remembered();
  text = "tetraction";
  for (int i = 1; i < argc; ++i) text += ' ' + shell_word(argv[i]);
}

std::string command_line() {
  return remembered();
}

void remember_threads(int threads) {
  threads_given = threads;
}

int remembered_threads() {
  return threads_given;
}

void become_program(const std::string& name) {
  std::error_code error;
  const std::filesystem::path own = std::filesystem::read_symlink("/proc/self/exe", error);
  if (error) return;
  execv((own.parent_path() / name).c_str(), arguments());
}

}  // namespace tetraction
