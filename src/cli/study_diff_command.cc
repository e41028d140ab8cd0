// tetraction study-diff: what differs between the results of two studies.
#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "commands.h"
#include "console.h"
#include "io/results/study_diff.h"

namespace tetraction {

void add_study_diff_command(CLI::App& app, int& exit_code) {
  struct Arguments {
    std::string a;
    std::string b;
    bool json = false;
  };
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand(
      "study-diff",
      "Compare the results of two studies: errors, wall times and energy errors of the runs that "
      "both have. The exit code is 0 also if they differ.");
  command->add_option("A", arguments->a, "Directory of a study, or a file with its study.json")
      ->required();
  command->add_option("B", arguments->b, "The same of the other study")->required();
  command->add_flag("--json", arguments->json, "Print the differences as JSON");
  command->callback([arguments, &exit_code] {
    const StudyDiff diff =
        diff_studies(read_study_file(arguments->a), read_study_file(arguments->b));
    write_result(arguments->json ? study_diff_json(diff) : study_diff_table(diff));
    exit_code = 0;
  });
}

}  // namespace tetraction
