// Writes the table of a step-size study.
#pragma once

#include <string>

#include "tetraction/simulation/study.h"

namespace tetraction {

/// How and when the files of a study were made. Machine and threads stand in its rows, because runs
/// that a resumed study keeps may have been made elsewhere.
struct StudyProvenance {
  std::string command;  ///< the command line, or empty for the study of another program
  std::string date;     ///< as utc_now() gives it
  std::string plan{};   ///< the member `plan` of study.json, without which a study cannot be merged
  std::string version{};  ///< of the program, if it is not this one
};

/// The text of study.csv: one row for each run, 10 significant digits, empty if there is no number.
/// Cells with a comma or a quotation mark are quoted as RFC 4180 says.
std::string study_csv(const StudyResult& result, const StudyProvenance& provenance = {});

/// The text of study.json: the data of study.csv, those that the plots need in addition, and the
/// conclusions of study_conclusions().
std::string study_json(const StudyResult& result, const std::string& scene_name,
                       const StudyProvenance& provenance = {});

/// The table for a terminal.
std::string study_table(const StudyResult& result);

/// Writes study.csv and study.json into a directory. Throws OutputError.
void write_study(const StudyResult& result, const std::string& scene_name,
                 const std::string& directory, const StudyProvenance& provenance = {});

}  // namespace tetraction
