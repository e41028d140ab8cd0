// tetraction keys: the keys of the scene file.
#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "cli/console.h"
#include "commands.h"
#include "tetraction/io/key_tables.h"

namespace tetraction {

void add_keys_command(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand(
      "keys", "Print the keys of the scene file: type, unit, default, meaning and range");
  const auto section = std::make_shared<std::string>();
  command->add_option("SECTION", *section, "One section, such as time or fix; default: all");
  command->callback([section, &exit_code] {
    if (!section->empty()) {
      write_result(key_table(*section));
    } else {
      for (const std::string& name : key_table_names()) {
        print_result("[{}]\n{}\n", name, key_table(name));
      }
    }
    exit_code = 0;
  });
}

}  // namespace tetraction
