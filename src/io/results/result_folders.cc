#include "result_folders.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <system_error>
#include <utility>

#include "io/results/directory_lock.h"
#include "io/results/input_guard.h"
#include "io/results/run_files.h"
#include "io/study/study_page.h"
#include "io/study/study_plots.h"
#include "io/text/foreign_json.h"
#include "io/text/output_file.h"
#include "tetraction/core/error.h"
#include "tetraction/core/version.h"
#include "tetraction/io/text_file.h"

namespace tetraction {
namespace {

namespace fs = std::filesystem;

constexpr const char* kModes = "computation of modes";

bool is_there(const fs::path& path) {
  std::error_code error;
  return fs::exists(path, error);
}

bool holds_run(const fs::path& directory) {
  return is_there(directory / "history.csv") &&
         (is_there(directory / "frames.pvd") || is_there(directory / "summary.json"));
}

bool holds_modes(const fs::path& directory) {
  return is_there(directory / "modes.csv");
}

nlohmann::json read_study(const fs::path& directory) {
  return parse_foreign_json(read_output((directory / "study.json").string()));
}

// The plots of the probes that study.json names.
std::vector<std::string> probe_plots(const fs::path& directory) {
  const auto json = read_study(directory);
  std::vector<std::string> plots;
  if (!json.is_object() || !json.contains("probes") || !json["probes"].is_array()) return plots;
  for (const auto& probe : json["probes"]) {
    if (!probe.is_object() || !probe.contains("name") || !probe["name"].is_string()) continue;
    const auto name = probe["name"].get<std::string>();
    if (name.find('/') == std::string::npos) plots.push_back("probe_" + name);
  }
  return plots;
}

constexpr const char* kJournalHead = "run,state\n";
constexpr const char* kBegun = "begun";
constexpr const char* kComplete = "complete";

std::string line_of(const std::string& run, const char* state) {
  return fmt::format("{},{}\n", run, state);
}

// The runs of the journal of a study with their states. A line that was cut off is left out.
std::vector<std::pair<std::string, std::string>> read_journal(const fs::path& directory) {
  const std::string text = read_output((directory / kStudyJournal).string());
  std::vector<std::pair<std::string, std::string>> runs;
  std::size_t begin = std::string(kJournalHead).size();
  if (text.rfind(kJournalHead, 0) != 0) return runs;
  for (std::size_t end = 0; (end = text.find('\n', begin)) != std::string::npos; begin = end + 1) {
    const std::string line = text.substr(begin, end - begin);
    const auto comma = line.rfind(',');
    if (comma != std::string::npos) {
      runs.emplace_back(line.substr(0, comma), line.substr(comma + 1));
    }
  }
  return runs;
}

// A name as a file with JSON has it: names of files need not be UTF-8, which JSON must be.
nlohmann::json in_json(const std::string& name) {
  return nlohmann::json::parse(
      nlohmann::json(name).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
}

// The runs of the journal with their last states.
std::map<std::string, std::string> states_of_runs(const fs::path& directory) {
  std::map<std::string, std::string> states;
  for (auto& [run, state] : read_journal(directory)) states[run] = state;
  return states;
}

// Folders of runs that the journal of a study or study.json names. What is not the name of a folder there
// is left out.
std::vector<fs::path> folders_of_study(const fs::path& directory) {
  const auto json = read_study(directory);
  std::vector<fs::path> folders;
  std::set<std::string> known;  // the reference is one of the runs, too
  const auto add = [&](const std::string& run) {
    if (!is_folder_name(run)) return;
    const fs::path name(run);
    if (!known.insert(run).second) return;
    // The folder behind a link is not the study's.
    std::error_code error;
    // A run without frames that was interrupted has only its history.
    if (fs::is_symlink(directory / name, error)) return;
    const fs::path folder = directory / name;
    if (is_there(folder / "history.csv")) folders.push_back(folder);
  };
  const auto add_entry = [&](const nlohmann::json& run) {
    if (!run.is_object() || !run.contains("directory") || !run["directory"].is_string()) return;
    add(run["directory"].get<std::string>());
  };
  for (const auto& [run, state] : read_journal(directory)) add(run);
  if (!json.is_object()) return folders;
  if (json.contains("reference")) add_entry(json["reference"]);
  for (const char* list : {"references", "runs"}) {
    if (!json.contains(list) || !json[list].is_array()) continue;
    for (const auto& run : json[list]) add_entry(run);
  }
  return folders;
}

void remove_results_of_run(const fs::path& folder) {
  {
    const DirectoryLock lock(folder.string());  // a run of its own may write there now
    remove_run(folder.string());
  }
  // The folder stays if there is something else in it.
  std::error_code not_empty;
  fs::remove(folder, not_empty);
}

// Whether a path that a scene gives is a folder below the working directory, with all links followed.
bool leads_below_here(const fs::path& directory) {
  if (!directory.is_relative()) return false;
  std::error_code error;
  const fs::path here = fs::canonical(".", error);
  fs::path place = here;
  // One part after the other: behind a link, ".." is the folder above that to which the link leads.
  for (const fs::path& part : directory) {
    if (part.empty()) continue;  // behind a slash at the end
    place = fs::weakly_canonical(place / part, error);
    // A link to nothing would lead to what somebody puts there later.
    if (!error && fs::is_symlink(fs::symlink_status(place, error))) return false;
    // A place that cannot be examined cannot be written to either, and this has its own message.
    if (error && error != std::errc::no_such_file_or_directory) return true;
  }
  const fs::path relative = place.lexically_relative(here);
  return !relative.empty() && relative != "." && *relative.begin() != "..";
}

[[noreturn]] void refuse_to_mix(const std::string& directory, const char* there,
                                const char* coming) {
  throw InputError(
      fmt::format("{}: this directory holds the results of a {}, with which those of the {} would "
                  "be mixed. Choose another directory with --out, or delete it.",
                  directory, there, coming));
}

// Also in the folders of an earlier study, which are deleted.
void refuse_inputs_among_runs(const std::vector<std::string>& inputs, const std::string& directory,
                              std::set<std::string> runs) {
  for (const fs::path& folder : folders_of_study(directory)) runs.insert(folder.filename());
  refuse_inputs_among_results(inputs, directory, {runs.begin(), runs.end()});
}

}  // namespace

std::string output_directory(const Scene& scene, const std::string& out,
                             const std::vector<std::string>& overrides) {
  if (!out.empty()) return out;
  const std::string& directory = scene.output.directory;
  const bool is_said = std::any_of(overrides.begin(), overrides.end(), [](const std::string& text) {
    return text.rfind("output.directory", 0) == 0;
  });
  if (is_said || leads_below_here(directory)) return directory;
  throw InputError(fmt::format(
      "output.directory = \"{}\": the scene names a directory that is not below the present one, "
      "or that a link leads out of it. If this is what you want, say so with --out.",
      directory));
}

void check_folder_of_run(const Scene& scene, const std::string& directory) {
  if (holds_study(directory)) refuse_to_mix(directory, "study", "run");
  if (holds_modes(directory)) refuse_to_mix(directory, kModes, "run");
  refuse_inputs_among_results(input_files(scene), directory);
}

void check_folder_of_study(const Scene& scene, const std::string& directory) {
  if (holds_run(directory)) refuse_to_mix(directory, "run", "study");
  if (holds_modes(directory)) refuse_to_mix(directory, kModes, "study");
  refuse_inputs_among_runs(input_files(scene), directory, {});
}

void check_folder_of_study(const StudyPlan& plan, const std::string& directory) {
  std::set<std::string> inputs;
  for (const StudyVariant& variant : plan.variants) {
    for (std::string& file : input_files(variant.scene)) inputs.insert(std::move(file));
  }
  const std::set<std::string> runs = run_names(plan);
  // Before anything of an earlier study is replaced.
  for (const std::string& run : runs) check_own_directory(directory + "/" + run);
  refuse_inputs_among_runs({inputs.begin(), inputs.end()}, directory, runs);
}

bool is_folder_name(const std::string& name) {
  const bool is_plain = name.find('/') == std::string::npos && name.find('\0') == std::string::npos;
  return is_plain && !name.empty() && name != "." && name != "..";
}

std::set<std::string> run_names(const StudyPlan& plan) {
  std::set<std::string> names;
  for (const PlannedRun& run : plan.runs) names.insert(run.directory);
  return names;
}

void check_folder_of_modes(const Scene& scene, const std::string& directory) {
  if (holds_run(directory)) refuse_to_mix(directory, "run", kModes);
  if (holds_study(directory)) refuse_to_mix(directory, "study", kModes);
  refuse_inputs_among_results(input_files(scene), directory);
}

bool holds_study(const std::string& directory) {
  const fs::path root(directory);
  return is_there(root / "study.json") || is_there(root / "study.csv");
}

void refuse_other_study(const std::string& directory, const std::string& scene_name) {
  const auto json = read_study(directory);
  const auto& name = member_of(json, "scene");
  if (!name.is_string() || name == in_json(scene_name)) return;
  throw InputError(
      fmt::format("{}: this directory holds the study of another scene, {}. Choose another "
                  "directory with --out, or delete that study with --fresh.",
                  directory, name.get<std::string>()));
}

std::vector<std::string> plots_of_study(const std::string& directory) {
  const fs::path root(directory);
  std::vector<std::string> plots = probe_plots(root);
  for (const StudyPlot& plot : kStudyPlots) plots.emplace_back(plot.name);
  std::vector<std::string> files;
  for (const std::string& plot : plots) {
    for (const char* ending : kPlotEndings) files.push_back((root / (plot + ending)).string());
  }
  return files;
}

bool remove_study(const std::string& directory) {
  const fs::path root(directory);
  if (!holds_study(directory)) return false;
  try {
    for (const fs::path& folder : folders_of_study(root)) remove_results_of_run(folder);
    for (const std::string& plot : plots_of_study(directory)) remove_output(plot);
    remove_output((root / kStudyPage).string());
    remove_output((root / kStudyJournal).string());
    remove_output((root / "study.csv").string());
    remove_output((root / "study.json").string());
  } catch (const fs::filesystem_error& error) {
    throw OutputError(
        fmt::format("{}: the results of the earlier study cannot be deleted ({}). Choose another "
                    "directory with --out.",
                    error.path1().string(), error.code().message()));
  }
  return true;
}

StudyJournal::StudyJournal(const std::string& directory)
    : file_(directory + "/" + kStudyJournal, [&] {
        std::string text = kJournalHead;
        for (const auto& [run, state] : states_of_runs(directory)) {
          if (is_entry(directory + "/" + run)) text += line_of(run, state.c_str());
        }
        return text;
      }()) {}

void StudyJournal::begin(const std::string& run) {
  file_.add(line_of(run, kBegun));
  file_.flush();
}

void StudyJournal::complete(const std::string& run) {
  file_.add(line_of(run, kComplete));
  file_.flush();
}

void write_study_begun(const std::string& directory, const std::string& scene_name) {
  nlohmann::ordered_json json;
  json["version"] = version();
  json["scene"] = in_json(scene_name).get<std::string>();
  json["message"] = "The study has not ended: it runs, or was cut off.";
  json["runs"] = nlohmann::ordered_json::array();
  write_text_file(directory + "/study.json", json.dump(2) + "\n");
}

std::set<std::string> lost_runs(const std::string& directory) {
  std::set<std::string> lost;
  for (const auto& [run, state] : states_of_runs(directory)) {
    if (state == kComplete && !is_entry(directory + "/" + run)) lost.insert(run);
  }
  return lost;
}

}  // namespace tetraction
