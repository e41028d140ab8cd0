#include "option_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <string_view>

#include "core/quoting.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

// The option of this command or of those above it, or null.
const CLI::Option* find_option(const CLI::App* command, const std::string& name) {
  for (; command != nullptr; command = command->get_parent()) {
    if (const CLI::Option* option = command->get_option_no_throw(name)) return option;
  }
  return nullptr;
}

const CLI::App* find_command(const CLI::App& parent, const std::string& name) {
  const auto found =
      parent.get_subcommands([&](const CLI::App* command) { return command->get_name() == name; });
  return found.empty() ? nullptr : found.front();
}

bool begins_like_an_option(std::string_view word) {
  constexpr std::string_view kOfNumbers = "0123456789.";
  return word.size() > 1 && word[0] == '-' && kOfNumbers.find(word[1]) == std::string_view::npos;
}

}  // namespace

void require_values(const CLI::App& app, int argc, const char* const* argv) {
  const CLI::App* command = &app;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--") return;
    if (word.empty() || word[0] != '-') {
      if (const CLI::App* next = find_command(*command, word)) command = next;
      continue;
    }
    const std::size_t equals = word.find('=');
    const std::string name = word.substr(0, equals);
    const CLI::Option* option = find_option(command, name);
    if (option == nullptr) continue;
    if (option->get_items_expected_min() == 0) {
      const std::string value = equals == std::string::npos ? "true" : word.substr(equals + 1);
      if (value == "true" || value == "false") continue;
      throw InputError(fmt::format("{} takes no value: write {} or leave it out.", name, name));
    }
    if (equals != std::string::npos) {
      if (equals + 1 < word.size()) continue;
      throw InputError(fmt::format("{} has no value behind the sign of equality.", name));
    }
    if (++i == argc) return;  // CLI11 says that the value is missing
    if (!begins_like_an_option(argv[i])) continue;
    const std::string next = excerpt(argv[i]);
    throw InputError(fmt::format(
        "{0} needs a value, but {1} follows, which looks like an option. If it is the value, write "
        "{0}={1}.",
        name, next));
  }
}

}  // namespace tetraction
