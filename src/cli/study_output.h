// What `tetraction study` writes and prints when it knows its result.
#pragma once

#include <CLI/App.hpp>
#include <string>
#include <vector>

#include "study_drawing.h"
#include "tetraction/io/study_writer.h"
#include "tetraction/simulation/study.h"

namespace tetraction {

/// What is printed of a study.
struct StudyView {
  std::string table;  ///< "markdown", "latex" or empty
  bool all = false;
  bool json = false;
  bool quiet = false;
};

/// A study with what its files need.
struct FinishedStudy {
  StudyResult result;
  std::string scene;      ///< name of its file
  std::string directory;  ///< as messages name it
  StudyProvenance provenance{};
};

/// --table, --all, --json and --quiet.
void add_view_options(CLI::App& command, StudyView& view);
/// --no-plots and the looks of plots.
void add_drawing_options(CLI::App& command, StudyDrawing& drawing);

/// Throws InputError for a table that is not known.
void check_view(const StudyView& view);

/// Writes study.csv, study.json, plots and page into a directory, and deletes plots that an earlier study left there.
/// Returns why there are no plots, or an empty text. A signal while they are drawn ends the drawing only. Throws
/// OutputError.
std::string write_study_files(const FinishedStudy& study, const std::string& directory,
                              const StudyDrawing& drawing, bool is_stopped, bool is_quiet,
                              const std::vector<std::string>& old_plots);

/// Prints the answer, the table or the text of study.json, and where the results are. `frames` are the runs that may
/// have frames.
void print_study(const FinishedStudy& study, const StudyView& view, const std::string& json,
                 bool has_plots, const std::vector<std::string>& frames);

}  // namespace tetraction
