#include "command_line.h"

#include <string_view>

namespace tetraction {
namespace {

std::string& remembered() {
  static std::string text;
  return text;
}

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
  std::string& text = remembered();
  text = "tetraction";
  for (int i = 1; i < argc; ++i) text += ' ' + shell_word(argv[i]);
}

std::string command_line() {
  return remembered();
}

}  // namespace tetraction
