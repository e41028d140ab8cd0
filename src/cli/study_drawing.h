// The plots of a study, which the Python modules in study_plots draw with matplotlib.
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

struct DrawnPlots {
  std::string why_missing{};   ///< why some or all of them are missing; empty: none is
  bool is_unwritable = false;  ///< whether files cannot be written
  bool is_stopped = false;     ///< whether a signal ended the drawing
};

/// Draws the plots of the study in the directory. If plots are missing, the script has said more on standard error.
DrawnPlots draw_plots(const std::string& directory, const StudyDrawing& drawing);

}  // namespace tetraction
