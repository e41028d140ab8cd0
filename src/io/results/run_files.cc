#include "run_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <vector>

#include "failed_elements.h"
#include "io/study/study_run_files.h"
#include "io/text/output_file.h"
#include "tetraction/core/error.h"
#include "tetraction/io/checkpoint_file.h"

namespace tetraction {
namespace {

namespace fs = std::filesystem;

}  // namespace

bool is_frame_name(const std::string& name) {
  return name.rfind("frame_", 0) == 0 && fs::path(name).extension() == ".vtu";
}

std::string obstacle_frame_name(Index step) {
  return fmt::format("frames/obstacles_{:06}.vtu", step);
}

bool is_obstacle_frame_name(const std::string& name) {
  return name.rfind("obstacles_", 0) == 0 && fs::path(name).extension() == ".vtu";
}

void remove_frames(const std::string& directory) {
  remove_frames(directory, {});
}

void remove_frames(const std::string& directory, const std::vector<std::string>& kept) {
  const std::string frames = directory + "/frames";
  const bool has_frames = is_entry(frames);
  if (has_frames) make_own_directory(frames);  // refuses a link
  // The collection goes first, because it must not name frames that are not there.
  if (kept.empty()) remove_output(directory + "/frames.pvd");
  if (!has_frames) return;
  try {
    std::vector<fs::path> old;
    for (const auto& entry : fs::directory_iterator(frames)) {
      fs::path name = entry.path().filename();
      if (std::ranges::find(kept, name.string()) != kept.end()) continue;
      if (name.extension() == ".part") name.replace_extension();
      // A run in several processes has frames in pieces, which a .pvtu names.
      if (name.extension() == ".pvtu") name.replace_extension(".vtu");
      const bool is_ours = is_frame_name(name.string()) || is_obstacle_frame_name(name.string());
      if (is_ours) old.push_back(entry.path());
    }
    for (const fs::path& file : old) fs::remove(file);
  } catch (const fs::filesystem_error& error) {
    throw OutputError(fmt::format("{}: cannot be emptied ({}). Choose another directory.", frames,
                                  error.code().message()));
  }
  std::error_code not_empty;  // something else is in it
  fs::remove(frames, not_empty);
}

void remove_run(const std::string& directory) {
  remove_output(directory + "/" + kStudyRowFile);  // first: it says that the others are complete
  remove_checkpoints(directory);
  remove_frames(directory);
  remove_end_of_run(directory);
  for (const char* name : {"probes.csv", "history.csv", kStudyTrackFile})
    remove_output(directory + "/" + name);
}

void remove_end_of_run(const std::string& directory) {
  for (const char* name : {"final.vtu", "final.pvtu", "summary.json", kFailedElementsFile}) {
    remove_output(directory + "/" + name);
  }
}

}  // namespace tetraction
