// The differences between the results of two studies.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace tetraction {

/// A row of study.json.
struct StudyDiffRow {
  std::string variant;
  std::string integrator;
  double step = 0.0;  ///< s
  std::string solver;
  std::string settings;  ///< of a rule of its own
  std::string status;
  std::map<std::string, double> numbers;  ///< the members kInDiff; NaN if they are not known
  std::string processor;
  int threads = 0;
  bool shares_machine = false;  ///< its wall time does not count
};

/// A study as study.json has it.
struct StudyFile {
  std::string path;  ///< as the user gave it
  std::string version;
  std::string command;
  std::string date;
  std::string scene;
  std::string error;             ///< "position" or "probe.NAME"
  std::string reference;         ///< "midpoint at 0.0001 s", for people
  double reference_error = 0.0;  ///< estimated; NaN if it is not known
  std::vector<StudyDiffRow> rows;
};

/// Rows of two studies that have the same variant, integrator, settings, step (to a relative 1e-9) and solver.
struct StudyDiffPair {
  StudyDiffRow a;
  StudyDiffRow b;
};

struct StudyDiff {
  StudyFile a;
  StudyFile b;
  std::vector<StudyDiffPair> pairs;  ///< in the order of a
  std::vector<StudyDiffRow> only_in_a;
  std::vector<StudyDiffRow> only_in_b;
  std::vector<std::string> notes;  ///< what limits the comparison, as sentences
};

/// Reads a study from its directory, or from a file with the text of study.json. Throws FileError
/// if there is none, if it has not ended or was interrupted, or if it is damaged.
StudyFile read_study_file(const std::string& path);

/// Compares two studies.
StudyDiff diff_studies(StudyFile a, StudyFile b);

/// The table for a terminal.
std::string study_diff_table(const StudyDiff& diff);

/// The same as JSON. Numbers that are not known are null.
std::string study_diff_json(const StudyDiff& diff);

}  // namespace tetraction
