// The options of `tetraction study`, and the text of its plan.
#pragma once

#include <CLI/App.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "study_drawing.h"
#include "study_output.h"
#include "tetraction/simulation/study_steps.h"

namespace tetraction {

/// As they were typed. study_requests() reads those that are texts.
struct StudyArguments {
  std::string scene;
  std::string out;
  std::vector<std::string> overrides;
  std::vector<std::string> integrators;
  std::vector<std::string> rules;
  std::vector<std::string> steps;
  std::string budget = "1min";
  std::string target;
  std::optional<double> reference_step;
  std::string reference_integrator;
  std::string reference = "run";
  std::vector<std::string> vary;
  std::vector<std::string> also_solvers;
  std::vector<std::string> frames;
  std::string error;
  int jobs = 1;
  StudyView view;
  StudyDrawing drawing{};
  int repeats = 2;
  bool resume = false;
  bool fresh = false;
  bool plan = false;
  std::string part;
  bool mesh_check = false;
};

/// Adds the options to the command. They are filled in when the command line is parsed.
std::shared_ptr<StudyArguments> add_study_options(CLI::App& command);

/// Throws InputError for texts that are malformed, rules that are there twice, and options that exclude each
/// other. Without --integrators, lists of steps for single rules say which rules there are.
StudyRequests study_requests(const StudyArguments& arguments);

/// One of several jobs that share the runs of a study.
struct StudyPart {
  std::size_t number = 0;  ///< from 0
  std::size_t count = 1;
};
/// "2/3". Without a text it is all of the study. Throws InputError.
StudyPart read_part(const std::string& text);

/// One run of a plan.
struct PlanLine {
  std::string run;       ///< its rule, and its variant and solver if there are several
  double step = 0.0;     ///< s
  Index steps = 0;       ///< number of them
  double seconds = 0.0;  ///< estimated; NaN: not known
  bool is_kept = false;  ///< whether it was made before
};

/// A table of the runs, with their sum in the last line.
std::string plan_text(const std::vector<PlanLine>& lines);

}  // namespace tetraction
