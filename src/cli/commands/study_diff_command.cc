// tetraction study diff: what differs between the results of two studies.
#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "cli/console.h"
#include "commands.h"
#include "io/study/study_diff.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

// CLI11 passes options that a command does not know to the command above it. Those of `study` have no
// meaning here.
void refuse_options_of_study(const CLI::App& study) {
  for (const CLI::Option* option : study.get_options()) {
    if (option->count() == 0 || option->check_lname("threads")) continue;
    throw InputError(
        option->get_positional()
            ? fmt::format(
                  "tetraction study diff: \"{}\" stands before diff. Write study diff A B to "
                  "compare two studies, or leave diff out to make one.",
                  option->results().front())
            : fmt::format("tetraction study diff has no option {}: it makes no runs. Leave it out.",
                          option->get_name()));
  }
}

}  // namespace

void add_study_diff_command(CLI::App& study, int& exit_code) {
  struct Arguments {
    std::string a;
    std::string b;
    bool json = false;
  };
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = study.add_subcommand(
      "diff",
      "Compare the results of two studies: errors, wall times and energy errors of the runs that "
      "both have. The exit code is 0 also if they differ.");
  command->add_option("A", arguments->a, "Directory of a study, or a file with its study.json")
      ->required();
  command->add_option("B", arguments->b, "The same of the other study")->required();
  command->add_flag("--json", arguments->json, "Print the differences as JSON");
  command->callback([arguments, &study, &exit_code] {
    refuse_options_of_study(study);
    const StudyDiff diff =
        diff_studies(read_study_file(arguments->a), read_study_file(arguments->b));
    if (arguments->json) {
      write_json_result(study_diff_json(diff));
    } else {
      write_result(study_diff_table(diff));
    }
    exit_code = 0;
  });
}

}  // namespace tetraction
