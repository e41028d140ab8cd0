// Prevents the results of one run or study from mixing with those of another.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "io/text/output_file.h"
#include "tetraction/simulation/scene.h"
#include "tetraction/simulation/study.h"

namespace tetraction {

/// The directory of the results: that of --out, or that of the scene, relative to the present
/// directory. Only the command line (--out, or --set output.directory) may choose one that is not
/// below the present directory; a scene that does so, also by way of a link, causes an InputError.
std::string output_directory(const Scene& scene, const std::string& out,
                             const std::vector<std::string>& overrides);

/// Throws InputError if a run that writes into `directory` would mix its results with those of a
/// study, or take the place of its own inputs (input_guard.h).
void check_folder_of_run(const Scene& scene, const std::string& directory);

/// The same for a study and the results of a run.
void check_folder_of_study(const Scene& scene, const std::string& directory);
/// Throws InputError if an input of the study is a file that its runs write or delete.
void check_folder_of_study(const StudyPlan& plan, const std::string& directory);

/// Throws InputError if `directory` holds the study of a scene with another name.
void refuse_other_study(const std::string& directory, const std::string& scene_name);

/// Whether there is a study in `directory`, also one that has not ended.
bool holds_study(const std::string& directory);

/// Whether it is the name of a folder in a directory, which does not lead out of it.
bool is_folder_name(const std::string& name);

/// The folders of all runs of a study.
std::set<std::string> run_names(const StudyPlan& plan);

/// The same for modes and the results of a run or a study.
void check_folder_of_modes(const Scene& scene, const std::string& directory);

/// Deletes the results of an earlier study in `directory`: study.csv, study.json, study.html, the plots, and the
/// results in the folders of all runs that its journal and study.json name. Other files stay. Returns whether
/// there was a study. Throws OutputError if something cannot be deleted.
bool remove_study(const std::string& directory);

/// The files of the plots of the study in `directory`, as its study.json names them.
std::vector<std::string> plots_of_study(const std::string& directory);

/// The file in the directory of a study that names the folders of its runs.
inline constexpr const char* kStudyJournal = "study_runs.csv";

/// The journal of a study: a table of the runs in its directory in the order in which they begin and are complete,
/// also of those that are not asked for any more. It grows by a line at a time, so that the work does not grow with
/// the number of runs, and it has all of them whenever the program is killed.
class StudyJournal {
 public:
  /// Goes on with the runs of an earlier journal whose folders are still there. Throws OutputError, as the functions
  /// do.
  explicit StudyJournal(const std::string& directory);

  /// To be called before the folder of a run is made.
  void begin(const std::string& run);
  void complete(const std::string& run);

 private:
  RowFile file_;
};

/// The runs that are complete as the journal in this directory says, and whose folders are not there.
std::set<std::string> lost_runs(const std::string& directory);

/// Writes a study.json that says that the study of this scene has not ended, so that a study that is cut off can be
/// told from other files. Throws OutputError.
void write_study_begun(const std::string& directory, const std::string& scene_name);

}  // namespace tetraction
