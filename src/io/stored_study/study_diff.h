// The differences between the results of two studies.
#pragma once

#include <string>
#include <vector>

#include "study_reader.h"

namespace tetraction {

/// Compares rows of two studies that have the same variant, integrator, settings, step (to a relative 1e-9) and solver.
class StudyDiff {
 public:
  /// Reads two studies, each from its directory or from a file with the text of study.json. Throws FileError as
  /// read_stored_study() does, and for a study without runs or one that was interrupted.
  StudyDiff(const std::string& a, const std::string& b);
  StudyDiff(const StudyDiff&) = delete;
  StudyDiff& operator=(const StudyDiff&) = delete;

  std::string table() const;  ///< for a terminal
  std::string json() const;   ///< Numbers that are not known are null.

 private:
  struct Side {
    explicit Side(const std::string& name);

    std::string path;  ///< as the user gave it
    StoredStudy study;
    std::string error;                  ///< "position" or "probe.NAME"
    std::string reference;              ///< reference_name()
    std::vector<const StudyRow*> rows;  ///< the runs that were asked for
    std::vector<const StudyRow*> only;  ///< those that the other study does not have
  };
  struct Pair {
    const StudyRow* a;
    const StudyRow* b;
  };

  std::vector<std::string> notes() const;
  std::vector<std::string> differences_of_scenes() const;
  bool has_one_machine() const;
  static std::string head(char letter, const Side& side);
  static std::string only_in(char letter, const Side& side);

  Side a_;
  Side b_;
  std::vector<Pair> pairs_;  // in the order of a
};

}  // namespace tetraction
