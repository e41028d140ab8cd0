#include "study_folder.h"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>

#include "io/text/foreign_json.h"
#include "io/text/output_file.h"

namespace tetraction {
namespace {

bool is_of_type(const std::string& path, std::filesystem::file_type type) {
  std::error_code unreadable;
  return std::filesystem::symlink_status(path, unreadable).type() == type;
}

}  // namespace

std::map<Integrator, double> times_of_choice(const std::string& directory,
                                             const std::string& digest) {
  const auto json = parse_foreign_json(read_output(directory + "/study.json"));
  const auto& plan = member_of(json, "choice");
  std::map<Integrator, double> times;
  if (member_of(plan, "digest") != digest) return times;
  for (const Integrator rule : all_integrators()) {
    const auto& seconds = member_of(member_of(plan, "seconds_per_step"), to_string(rule).c_str());
    // Longer ones are none of a study. 0 says that the first steps failed.
    constexpr double kMost = 1e6;
    const double value = number_or(seconds, -1.0);
    if (value >= 0.0 && value <= kMost) times[rule] = value;
  }
  return times;
}

StudyFolder::StudyFolder(std::string directory, const StudyPlan& plan, const TetMesh& mesh,
                         const RunDigests& digests)
    : directory_(std::move(directory)), plan_(plan), mesh_(mesh), digests_(digests) {}

StudyMemory StudyFolder::memory() {
  StudyMemory memory;
  memory.kept = [this](const PlannedRun& run) { return kept(run); };
  memory.made = [this](const PlannedRun& run, const StudyRow& row, const MotionTrack& track) {
    keep(run, row, track);
  };
  memory.repeated = [this](const PlannedRun& run, const StudyRow& row) {
    write_study_row(file(run, kStudyRowFile), row, digests_.of(run));
  };
  memory.track = [this](const PlannedRun& run) { return track(run); };
  return memory;
}

void StudyFolder::begin_run(const std::string& run, const std::string& scene_name) {
  if (!journal_) {
    write_study_begun(directory_, scene_name);
    journal_.emplace(directory_);
  }
  journal_->begin(run);
  make_own_directory(path(run));
}

void StudyFolder::keep(const PlannedRun& run, const StudyRow& row, const MotionTrack& track) {
  const std::string digest = digests_.of(run);
  read_.erase(run.directory);
  write_study_track(file(run, kStudyTrackFile), track, digest);
  // The row comes last: it says that the run is complete.
  write_study_row(file(run, kStudyRowFile), row, digest);
  journal_->complete(run.directory);
}

std::string StudyFolder::file(const PlannedRun& run, const char* name) const {
  return path(run.directory) + "/" + name;
}

// A track is read twice, when it is asked whether the run is kept and when its errors are computed. Those that fit into
// some memory stay there.
std::shared_ptr<const MotionTrack> StudyFolder::track(const PlannedRun& run) {
  if (const auto known = read_.find(run.directory); known != read_.end()) return known->second;
  const std::string path = file(run, kStudyTrackFile);
  std::shared_ptr<const MotionTrack> track = read_study_track(path, digests_.of(run));
  const auto& own = plan_.variants[run.variant].mesh;
  const bool is_of_body = track && track->rest.size() == 3 * (own ? *own : mesh_).vertex_count();
  if (!is_of_body) return nullptr;
  // Runs of an earlier version lack the energies.
  if (!plan_.error_probe.empty() && !track->probe(plan_.error_series().series())) return nullptr;
  constexpr std::uintmax_t kMostBytes = std::uintmax_t{256} << 20U;
  std::error_code unknown;
  const std::uintmax_t bytes = std::filesystem::file_size(path, unknown);
  if (!unknown && bytes <= kMostBytes - read_bytes_) {
    read_bytes_ += bytes;
    read_[run.directory] = track;
  }
  return track;
}

// The row of a run that computed the same, if all its files are there. Links are none of them, because what they
// lead to may be of another study.
std::optional<StudyRow> StudyFolder::kept(const PlannedRun& run) {
  using Type = std::filesystem::file_type;
  std::vector<std::string> files{"history.csv", "final.vtu", "summary.json"};
  if (!plan_.variants[run.variant].scene.probe.empty()) files.emplace_back("probes.csv");
  if (has_frames(run.directory)) files.emplace_back("frames.pvd");
  const bool has_files = is_of_type(path(run.directory), Type::directory) &&
                         std::all_of(files.begin(), files.end(), [&](const std::string& name) {
                           return is_of_type(file(run, name.c_str()), Type::regular);
                         });
  if (!has_files || !track(run)) return {};
  return read_study_row(file(run, kStudyRowFile), plan_, run, digests_.of(run));
}

}  // namespace tetraction
