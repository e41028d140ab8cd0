// The commands of the program. Each function adds one to the command line; when it is chosen, its
// exit code is left in `exit_code`. Errors are thrown (core/error.h).
#pragma once

#include <CLI/App.hpp>
#include <string>

namespace tetraction {

/// Refuses an empty value of an option, with this reason.
inline CLI::Validator not_empty(const char* reason) {
  return {[reason](std::string& value) { return value.empty() ? std::string(reason) : ""; }, ""};
}

void add_new_command(CLI::App& app, int& exit_code);
void add_run_command(CLI::App& app, int& exit_code);
void add_static_command(CLI::App& app, int& exit_code);
void add_study_command(CLI::App& app, int& exit_code);
/// Commands of `study`.
void add_study_diff_command(CLI::App& study, int& exit_code);
void add_study_open_command(CLI::App& study, int& exit_code);
void add_study_merge_command(CLI::App& study, int& exit_code);
void add_check_command(CLI::App& app, int& exit_code);
void add_keys_command(CLI::App& app, int& exit_code);
void add_mesh_command(CLI::App& app, int& exit_code);
void add_view_command(CLI::App& app, int& exit_code);
void add_modes_command(CLI::App& app, int& exit_code);
/// A command for the build of packages, which the help does not name: manual pages and completion.
void add_document_command(CLI::App& app, int& exit_code);

}  // namespace tetraction
