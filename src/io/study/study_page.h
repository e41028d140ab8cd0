// study.html: a study on one page that needs no other file and no network.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "study_grid.h"
#include "tetraction/io/study_writer.h"
#include "tetraction/simulation/study.h"

namespace tetraction {

inline constexpr const char* kStudyPage = "study.html";

/// The wall times of a run by phase, s.
struct RunPhases {
  std::string rule;  ///< rule_name()
  std::string label;
  double step = 0.0;  ///< s
  double mesh = 0.0;
  double setup = 0.0;
  double stability = 0.0;
  double stepping = 0.0;
  double output = 0.0;

  double total() const { return mesh + setup + stability + stepping + output; }
};

/// A plot for the page.
struct StudyPicture {
  std::string heading;
  std::string caption;
  std::string svg;  ///< content of the SVG file
};

/// What the page shows beside the result.
struct StudyPageContents {
  std::string scene_name;
  StudyProvenance provenance;
  std::optional<StudyPicture> answer_picture{};  ///< the errors over the step
  std::vector<StudyPicture> pictures;            ///< all other plots
  std::string why_no_pictures;                   ///< why some or all are missing
  std::vector<RunPhases> phases;
};

/// The table of all runs, with the columns that are not empty in all of them.
StudyGrid grid_of_all_runs(const StudyResult& result);

/// The text of the page: the template study_page.html with its parts filled in.
std::string study_page(const StudyResult& result, const StudyPageContents& contents);

/// Reads the plots that are there and the summaries of the runs in the directory of a study, and writes the page
/// there. It says why some or all plots are missing, unless that is empty. Throws OutputError.
void write_study_page(const StudyResult& result, const std::string& scene_name,
                      const std::string& directory, const StudyProvenance& provenance,
                      const std::string& why_no_pictures);

}  // namespace tetraction
