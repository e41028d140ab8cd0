// Writes the table of a step-size study.
#pragma once

#include <string>

#include "tetraction/simulation/study.h"

namespace tetraction {

/// The text of study.csv: one row for each run, 10 significant digits, empty if there is no number.
std::string study_csv(const StudyResult& result);

/// The text of study.json: the data of study.csv and those that the plots need in addition.
std::string study_json(const StudyResult& result, const std::string& scene_name);

/// The table for a terminal.
std::string study_table(const StudyResult& result);

/// Writes study.csv and study.json into a directory. Throws OutputError.
void write_study(const StudyResult& result, const std::string& scene_name,
                 const std::string& directory);

}  // namespace tetraction
