// The options of `tetraction study`.
#pragma once

#include <CLI/App.hpp>
#include <memory>
#include <string>
#include <vector>

#include "io/study/study_maker.h"
#include "study_drawing.h"
#include "study_output.h"

namespace tetraction {

/// As they were typed.
struct StudyArguments {
  std::string scene;
  std::string out;
  std::vector<std::string> overrides;
  std::vector<std::string> frames;
  StudyOptions study{};
  StudyView view{};
  StudyDrawing drawing{};
  bool resume = false;
};

/// Adds the options to the command. They are filled in when the command line is parsed.
std::shared_ptr<StudyArguments> add_study_options(CLI::App& command);

}  // namespace tetraction
