#include "study_output.h"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <filesystem>
#include <set>

#include "cli/console.h"
#include "cli/interrupt_guard.h"
#include "io/study/study_answer.h"
#include "io/study/study_page.h"
#include "io/text/output_file.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

// The runs that reached the end.
std::set<std::string> finished_runs(const StudyResult& result) {
  std::set<std::string> names;
  for (const StudyRow& row : result.rows) {
    if (row.status == RunStatus::kFinished) names.insert(row.directory);
  }
  return names;
}

// How to see the motion of the first of these runs with frames that reached the end, or else of one that did not.
std::string advice_to_look(const StudyResult& result, const std::string& directory,
                           std::vector<std::string> frames) {
  const std::set<std::string> finished = finished_runs(result);
  std::stable_partition(frames.begin(), frames.end(),
                        [&](const std::string& run) { return finished.contains(run); });
  for (const std::string& run : frames) {
    const std::string folder = fmt::format("{}/{}", directory, run);
    if (!std::filesystem::exists(folder + "/frames.pvd")) continue;
    return fmt::format(
        "to see the motion{1}: open {0}/frames.pvd in ParaView, or: tetraction view {0}\n", folder,
        finished.contains(run) ? "" : " of a run that did not reach the end");
  }
  return {};
}

AnswerFormat answer_format(const StudyView& view) {
  return view.table.empty() ? AnswerFormat::kTerminal : answer_format_from_string(view.table);
}

}  // namespace

void add_view_options(CLI::App& command, StudyView& view) {
  command.add_flag("--all", view.all, "Print the table of all runs instead of the answer");
  command.add_option("--table", view.table,
                     "markdown or latex: print nothing but the table of the answer for a paper");
  command.add_flag("--quiet", view.quiet, "Only warnings and errors");
  command.add_flag("--json", view.json, "Print study.json to stdout");
}

void add_drawing_options(CLI::App& command, StudyDrawing& drawing) {
  command.add_flag("--no-plots", drawing.is_left_out, "Do not draw plots");
  command.add_option("--title", drawing.title, "Title of the plots (default: none)");
  command.add_option("--style", drawing.style, "Style file of matplotlib for the plots")
      ->check(CLI::ExistingFile);
  command.add_option("--width", drawing.width, "Width of the plots: 85 or 170 mm")
      ->check(CLI::IsMember({85, 170}));
}

void check_view(const StudyView& view) {
  answer_format(view);
}

std::string write_study_files(const FinishedStudy& study, const std::string& directory,
                              const StudyDrawing& drawing, bool is_stopped, bool is_quiet,
                              const std::vector<std::string>& old_plots) {
  write_study(study.result, study.scene, directory, study.provenance);
  // They would be those of other runs.
  for (const std::string& plot : old_plots) remove_output(plot);
  remove_output(directory + "/" + kStudyPage);
  for (const std::string& remark : study.result.remarks) print_note(remark);
  std::string why_no_plots;
  std::string said;
  bool is_unwritable = false;
  const InterruptGuard until_the_page_is_there;
  if (is_stopped) {
    // Whoever interrupts a study does not want to wait for pictures of a part of it.
    why_no_plots = "the study was interrupted";
    said = "The plots were not drawn, because the study was interrupted.";
  } else if (drawing.is_left_out) {
    why_no_plots = "they were left out";
    said = "The plots were left out with --no-plots.";
  } else {
    if (!is_quiet) print_progress("drawing the plots\n");
    const DrawnPlots drawn = draw_plots(directory, drawing);
    if (drawn.is_stopped && !is_quiet) {
      print_note("the drawing of the plots was interrupted: the same command draws them");
    }
    why_no_plots = drawn.why_missing;
    is_unwritable = drawn.is_unwritable;
    if (!why_no_plots.empty()) said = "Plots are missing: " + why_no_plots + ".";
  }
  write_study_page(study.result, study.scene, directory, study.provenance, said);
  if (is_unwritable) {
    throw OutputError(directory + ": plots are missing: " + why_no_plots +
                      ". Make room there, or choose another directory with --out; the same command "
                      "then draws them.");
  }
  return why_no_plots;
}

void print_study(const FinishedStudy& study, const StudyView& view, const std::string& json,
                 bool has_plots, const std::vector<std::string>& frames) {
  if (view.json) return write_json_result(json);
  if (!view.table.empty()) return write_result(answer_text(study.result, answer_format(view)));
  if (view.quiet) return;
  if (study.result.left_out > 0) {
    print_result("This is a part of a study: {} of its {} runs.\n\n", study.result.rows.size(),
                 study.result.rows.size() + study.result.left_out);
  }
  write_result(view.all ? study_table(study.result) : answer_text(study.result));
  print_result("\nresults: {0}/study.html, {0}/study.csv, {0}/study.json{1}\n{2}", study.directory,
               has_plots ? ", plots (*.png, *.svg, *.pdf)" : "",
               advice_to_look(study.result, study.directory, frames));
}

}  // namespace tetraction
