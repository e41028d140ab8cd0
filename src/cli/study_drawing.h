// The plots of a study, which plot_study.py draws with matplotlib.
#pragma once

#include <string>

namespace tetraction {

/// How the plots look.
struct StudyDrawing {
  std::string title{};       ///< above each plot; empty: none
  std::string style{};       ///< a style file of matplotlib; empty: none
  int width = 170;           ///< 85 or 170 mm
  bool is_left_out = false;  ///< no plots at all
};

/// Draws the plots of the study in the directory. Returns why some or all of them are missing, or an empty text. The
/// script has then said more on standard error. Throws OutputError if their files cannot be written.
std::string draw_plots(const std::string& directory, const StudyDrawing& drawing);

}  // namespace tetraction
