// tetraction study diff, open and merge: what is done with studies that have been made.
#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "cli/command_line.h"
#include "cli/console.h"
#include "cli/interrupt_guard.h"
#include "cli/study_output.h"
#include "commands.h"
#include "io/results/result_folders.h"
#include "io/stored_study/study_diff.h"
#include "io/stored_study/study_merge.h"
#include "io/stored_study/study_reader.h"
#include "io/text/output_file.h"
#include "tetraction/core/error.h"
#include "tetraction/core/provenance.h"

namespace tetraction {
namespace {

// CLI11 passes options that a command does not know to the command above it. Those of `study` have no
// meaning here.
void refuse_options_of_study(const CLI::App& study, const CLI::App& command) {
  const std::string name = command.get_name();
  for (const CLI::Option* option : study.get_options()) {
    if (option->count() == 0 || option->check_lname("threads")) continue;
    throw InputError(
        option->get_positional()
            ? fmt::format("tetraction study {0}: \"{1}\" stands before {0}. Write study {0} and "
                          "then the directories, or leave {0} out to make a study.",
                          name, option->results().front())
            : fmt::format("tetraction study {} has no option {}: it makes no runs. Leave it out.",
                          name, option->get_name()));
  }
}

std::vector<std::string> folders_of_runs(const StudyResult& result) {
  std::vector<std::string> folders;
  for (const StudyRow& row : result.rows) folders.push_back(row.directory);
  return folders;
}

void open_study(const std::string& directory, const StudyView& view) {
  check_view(view);
  if (!std::filesystem::is_directory(directory)) {
    throw FileError(directory + ": there is no such directory.");
  }
  StoredStudy stored = read_stored_study(directory);
  const std::vector<std::string> plots = plots_of_study(directory);
  const bool has_plots = std::any_of(plots.begin(), plots.end(), is_entry);
  for (const std::string& remark : stored.result.remarks) print_note(remark);
  const FinishedStudy study{std::move(stored.result), stored.scene, directory, stored.provenance};
  print_study(study, view, stored.text, has_plots, folders_of_runs(study.result));
}

struct MergeArguments {
  std::vector<std::string> studies;
  std::string out;
  StudyView view;
  StudyDrawing drawing;
};

int merge_studies(const MergeArguments& arguments) {
  check_view(arguments.view);
  for (const std::string& study : arguments.studies) {
    std::error_code not_there;
    if (!std::filesystem::equivalent(study, arguments.out, not_there)) continue;
    throw InputError(fmt::format(
        "{}: the directory of the merged study is one of the studies. Choose another one with "
        "--out.",
        arguments.out));
  }
  const MergedStudy merged(arguments.studies);
  ReplacementDirectory directory(arguments.out);
  merged.copy_runs(directory.temporary());
  const FinishedStudy study{
      merged.result(), merged.scene(), arguments.out, {command_line(), utc_now(), merged.plan()}};
  const std::string why_no_plots = write_study_files(
      study, directory.temporary(), arguments.drawing, false, arguments.view.quiet, {});
  directory.finish();
  print_study(study, arguments.view, study_json(study.result, study.scene, study.provenance),
              why_no_plots.empty(), {});
  const bool is_stopped = InterruptGuard::interrupted();
  if (!arguments.drawing.is_left_out && !why_no_plots.empty() && !is_stopped) {
    print_warning("the plots were not drawn: " + why_no_plots);
  }
  return is_stopped ? InterruptGuard::exit_code() : 0;
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
  command->callback([arguments, command, &study, &exit_code] {
    refuse_options_of_study(study, *command);
    const StudyDiff diff(arguments->a, arguments->b);
    if (arguments->json) {
      write_json_result(diff.json());
    } else {
      write_result(diff.table());
    }
    exit_code = 0;
  });
}

void add_study_open_command(CLI::App& study, int& exit_code) {
  struct Arguments {
    std::string directory;
    StudyView view;
  };
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = study.add_subcommand(
      "open", "Print the answer of a study that has been made, and where its page is.");
  command->add_option("DIR", arguments->directory, "Directory of a study")->required();
  add_view_options(*command, arguments->view);
  command->callback([arguments, command, &study, &exit_code] {
    refuse_options_of_study(study, *command);
    open_study(arguments->directory, arguments->view);
    exit_code = 0;
  });
}

void add_study_merge_command(CLI::App& study, int& exit_code) {
  auto arguments = std::make_shared<MergeArguments>();
  CLI::App* command = study.add_subcommand(
      "merge",
      "Join studies of the same scene, such as the parts of --part, in a new directory. All errors "
      "and orders are computed anew, against the finest reference. A run that several studies "
      "have is that of the first one.");
  command->add_option("STUDY", arguments->studies, "Directories of the studies")
      ->required()
      ->expected(2, 1024);
  command->add_option("--out", arguments->out, "Directory of the merged study")
      ->required()
      ->check(not_empty("it names no directory"));
  add_view_options(*command, arguments->view);
  add_drawing_options(*command, arguments->drawing);
  command->callback([arguments, command, &study, &exit_code] {
    refuse_options_of_study(study, *command);
    exit_code = merge_studies(*arguments);
  });
}

}  // namespace tetraction
