#include "study_folder.h"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>

#include "io/text/foreign_json.h"
#include "io/text/output_file.h"
#include "study_track_file.h"

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
    if (seconds.is_number()) times[rule] = seconds.get<double>();
  }
  return times;
}

StudyFolder::StudyFolder(std::string directory, const StudyPlan& plan, const TetMesh& mesh,
                         const RunDigests& digests, const std::vector<std::string>& frames)
    : directory_(std::move(directory)),
      plan_(plan),
      mesh_(mesh),
      digests_(digests),
      frames_(frames.begin(), frames.end()) {}

StudyMemory StudyFolder::memory(bool keeps) {
  StudyMemory memory;
  if (keeps) memory.kept = [this](const PlannedRun& run) { return kept(run); };
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
  write_study_track(file(run, kStudyTrackFile), track, digest);
  // The row comes last: it says that the run is complete.
  write_study_row(file(run, kStudyRowFile), row, digest);
  journal_->complete(run.directory);
}

std::string StudyFolder::file(const PlannedRun& run, const char* name) const {
  return path(run.directory) + "/" + name;
}

std::shared_ptr<const MotionTrack> StudyFolder::track(const PlannedRun& run) const {
  std::shared_ptr<const MotionTrack> track =
      read_study_track(file(run, kStudyTrackFile), digests_.of(run));
  const auto& own = plan_.variants[run.variant].mesh;
  const bool is_of_body = track && track->rest.size() == 3 * (own ? *own : mesh_).vertex_count();
  if (!is_of_body) return nullptr;
  // Runs of an earlier version lack the energies.
  if (!plan_.error_probe.empty() && !track->probe(plan_.error_series().series())) return nullptr;
  return track;
}

// The row of a run that computed the same, if all its files are there. Links are none of them, because what they
// lead to may be of another study.
std::optional<StudyRow> StudyFolder::kept(const PlannedRun& run) const {
  using Type = std::filesystem::file_type;
  std::vector<std::string> files{"history.csv", "final.vtu", "summary.json"};
  if (!plan_.variants[run.variant].scene.probe.empty()) files.emplace_back("probes.csv");
  if (has_frames(run.directory)) files.emplace_back("frames.pvd");
  const bool has_files = is_of_type(path(run.directory), Type::directory) &&
                         std::all_of(files.begin(), files.end(), [&](const std::string& name) {
                           return is_of_type(file(run, name.c_str()), Type::regular);
                         });
  if (!has_files || !track(run)) return {};
  return read_study_row(file(run, kStudyRowFile), run, digests_.of(run));
}

MeshCheck check_mesh(const StudyPlan& finer, const StudyResult& result, const StudyMemory& runs,
                     StudyFolder& folder, bool keeps, const ObserverFactory& observers,
                     const StudyProgress& progress) {
  MeshCheck check;
  const TetMesh& mesh = *finer.variants.front().mesh;
  check.vertices = mesh.vertex_count();
  check.tetrahedra = mesh.tetrahedron_count();
  check.status = RunStatus::kCancelled;
  const PlannedRun* run = run_of_mesh_check(finer, result);
  if (run == nullptr || result.is_interrupted) return check;
  check.integrator = run->integrator;
  check.step = run->step;
  check.directory = run->directory;
  const TrackedRun fine =
      make_tracked_run(finer, *run, mesh, observers, progress, folder.memory(keeps));
  if (fine.is_stopped) return check;
  if (const auto row = folder.memory(true).kept(*run)) check.status = row->status;
  PlannedRun coarse = *run;
  coarse.directory = coarse_run_of(*run);
  const std::shared_ptr<const MotionTrack> track = runs.track(coarse);
  if (fine.track && track) check.difference = mesh_difference(finer, *track, *fine.track);
  return check;
}

}  // namespace tetraction
