#include "input_guard.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <string_view>
#include <utility>

#include "failed_elements.h"
#include "io/mesh/mesh_files.h"
#include "io/scene/obstacle_surfaces.h"
#include "io/study/study_page.h"
#include "io/study/study_plots.h"
#include "io/study/study_run_files.h"
#include "io/text/output_file.h"
#include "result_folders.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

namespace fs = std::filesystem;

using FileNumber = std::pair<dev_t, ino_t>;
using InputNumbers = std::map<FileNumber, std::string>;  // with the names of the inputs

// Adds the file, and the links that lead to it.
void add_numbers(const std::string& input, InputNumbers& numbers) {
  constexpr int kMostLinks = 40;  // as the system
  fs::path path(input);
  for (int i = 0; i < kMostLinks; ++i) {
    struct stat status {};
    if (::lstat(path.c_str(), &status) != 0) return;
    numbers.emplace(FileNumber(status.st_dev, status.st_ino), input);
    if (!S_ISLNK(status.st_mode)) return;
    std::error_code error;
    path = path.parent_path() / fs::read_symlink(path, error);
  }
}

bool begins_and_ends(std::string_view name, std::string_view begin,
                     std::initializer_list<std::string_view> endings) {
  return name.starts_with(begin) && std::ranges::any_of(endings, [&](std::string_view ending) {
           return name.ends_with(ending);
         });
}

bool is_plot(std::string_view name) {
  const fs::path path(name);
  if (std::ranges::find(kPlotEndings, path.extension().string()) == kPlotEndings.end())
    return false;
  const std::string stem = path.stem().string();
  return stem.starts_with("probe_") ||
         std::ranges::any_of(kStudyPlots, [&](const StudyPlot& plot) { return stem == plot.name; });
}

// In the folder of a run, of modes or of a study.
bool is_result(std::string_view name) {
  constexpr std::array<std::string_view, 13> kNames{
      ".lock",      "history.csv", "probes.csv",   "frames.pvd",        "final.vtu",
      "final.pvtu", "modes.csv",   "summary.json", kFailedElementsFile, "study.csv",
      "study.json", kStudyRowFile, kStudyTrackFile};
  return std::ranges::find(kNames, name) != kNames.end() || name == kStudyPage ||
         name == kStudyJournal || begins_and_ends(name, "mode_", {".vtu", ".pvd"}) || is_plot(name);
}

// In one of the folders in such a folder.
bool is_frame(std::string_view name) {
  return begins_and_ends(name, "frame_", {".vtu", ".pvtu"}) ||
         begins_and_ends(name, "obstacles_", {".vtu"});
}
bool is_picture_of_mode(std::string_view name) {
  return begins_and_ends(name, "mode_", {".vtu"});
}
bool is_checkpoint(std::string_view name) {
  return begins_and_ends(name, "step_", {".ckpt"}) || begins_and_ends(name, "stop_", {".ckpt"});
}

void search(const fs::path& folder, bool (*is_own)(std::string_view), const InputNumbers& inputs,
            const std::string& directory) {
  std::error_code error;
  if (fs::is_symlink(folder, error)) return;  // nothing is written through it
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    std::string name = entry->path().filename().string();
    if (const std::string part = temporary_name(""); name.ends_with(part)) {
      name.resize(name.size() - part.size());
    }
    struct stat status {};
    if (!is_own(name) || ::lstat(entry->path().c_str(), &status) != 0) continue;
    const auto input = inputs.find(FileNumber(status.st_dev, status.st_ino));
    if (input == inputs.end()) continue;
    throw InputError(fmt::format(
        "{}: this input is also {}, a result in the output directory {}, where it would be "
        "overwritten or deleted. Choose another directory (on the command line: --out).",
        input->second, entry->path().string(), directory));
  }
}

}  // namespace

std::vector<std::string> input_files(const Scene& scene) {
  std::vector<std::string> files;
  const auto add = [&files](const std::string& file) {
    if (!file.empty()) files.push_back(file);
  };
  add(scene.path);
  if (!scene.mesh.generate) {
    for (const std::string& file : files_of_mesh(scene.mesh.file)) add(file);
  }
  for (const AmplitudeSettings& amplitude : scene.amplitude) {
    if (amplitude.kind == AmplitudeKind::kFile) add(amplitude.file);
  }
  for_each_obstacle(scene, [&](const ObstacleSettings& obstacle) {
    if (obstacle.kind == ObstacleKind::kMesh) add(obstacle.file);
  });
  add(scene.initial.displacement_field.file);
  add(scene.initial.velocity_field.file);
  return files;
}

void refuse_inputs_among_results(const std::vector<std::string>& inputs,
                                 const std::string& directory,
                                 const std::vector<std::string>& run_folders) {
  InputNumbers numbers;
  for (const std::string& input : inputs) add_numbers(input, numbers);
  if (numbers.empty()) return;
  std::vector<fs::path> folders{fs::path(directory) / ""};  // of a link the folder behind it
  for (const std::string& run : run_folders) folders.push_back(fs::path(directory) / run);
  for (const fs::path& folder : folders) {
    search(folder, &is_result, numbers, directory);
    search(folder / "frames", &is_frame, numbers, directory);
    search(folder / "swing", &is_picture_of_mode, numbers, directory);
    search(folder / "checkpoints", &is_checkpoint, numbers, directory);
  }
}

}  // namespace tetraction
