#include "study_merge.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <tuple>
#include <utility>

#include "core/quoting.h"
#include "io/results/result_folders.h"
#include "io/study/study_run_files.h"
#include "io/text/output_file.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

namespace fs = std::filesystem;

// The files of a run. The first three are always there; the row says that the run is complete.
constexpr std::array kRunFiles{"history.csv", kStudyTrackFile, kStudyRowFile,
                               "probes.csv",  "final.vtu",     "summary.json"};
constexpr std::size_t kNeededFiles = 3;

bool is_plain_file(const fs::path& path) {
  std::error_code unreadable;
  return fs::is_regular_file(fs::symlink_status(path, unreadable));
}

std::string error_text(const StudyResult& result) {
  return result.error_probe.empty()
             ? "the position error"
             : to_string(ErrorMeasure{result.error_kind, result.error_probe});
}

// The role of a run that has these roles in two studies: what was asked for in one of them is asked for.
StudyRole joined_role(StudyRole a, StudyRole b) {
  for (const StudyRole role : {StudyRole::kRun, StudyRole::kVariant, StudyRole::kReference}) {
    if (a == role || b == role) return role;
  }
  return StudyRole::kTrial;
}

// What a track must have so that it can be compared with others.
struct TrackShape {
  Index size = 0;
  std::size_t count = 0;
};

}  // namespace

MergedStudy::MergedStudy(const std::vector<std::string>& directories) : directories_(directories) {
  for (const std::string& directory : directories_) {
    studies_.push_back(read_stored_study(directory));
    if (!studies_.back().plan) {
      throw FileError(fmt::format(
          "{}: study.json does not say what the runs of the study compute, because another program "
          "made it, or because functions of its scene are written in Python: it cannot be merged.",
          directory));
    }
  }
  for (std::size_t i = 1; i < studies_.size(); ++i) require_same_study(i);
  join_runs();
  choose_references();
  read_rows();
  std::vector<std::optional<StudyRow>> rows;
  for (const Source& source : sources_) rows.push_back(source.row);
  result_ = compare_runs(plan_, rows, tracks());
  result_.target = studies_.front().result.target;
  for (const StoredStudy& study : studies_) {
    if (study.result.target != result_.target) result_.target.reset();
    if (!result_.mesh_check) result_.mesh_check = study.result.mesh_check;
    for (const RuleFinding& finding : study.result.findings) {
      const bool is_known = std::any_of(
          result_.findings.begin(), result_.findings.end(), [&](const RuleFinding& other) {
            return other.rule == finding.rule && other.settings == finding.settings;
          });
      if (!is_known) result_.findings.push_back(finding);
    }
  }
}

void MergedStudy::require_same_study(std::size_t other) const {
  const StoredStudy& a = studies_.front();
  const StoredStudy& b = studies_[other];
  const auto refuse = [&](const std::string& what) {
    throw InputError(fmt::format("{} and {} cannot be merged: {}.", directories_.front(),
                                 directories_[other], what));
  };
  if (a.result.end != b.result.end) {
    refuse(fmt::format("they end at {} s and {} s (time.end)", a.result.end, b.result.end));
  }
  if (error_text(a.result) != error_text(b.result)) {
    refuse(fmt::format("their errors are {} and {} (--error)", in_quotes(error_text(a.result)),
                       in_quotes(error_text(b.result))));
  }
  const RunDigests& own = a.plan->digests;
  const RunDigests& its = b.plan->digests;
  if (own.build() != its.build()) {
    refuse(fmt::format("they were made by the builds {} and {} of the program",
                       in_quotes(own.build()), in_quotes(its.build())));
  }
  const auto values = [](const StudyResult& result) {
    std::vector<std::string> texts;
    for (const VariantValues& variant : result.variants) {
      texts.push_back(variant.name);
      for (const VariedValue& varied : variant.values) {
        texts.push_back(varied.key + "=" + varied.value);
      }
    }
    return texts;
  };
  if (values(a.result) != values(b.result)) refuse("they have other variants (--vary)");
  if (own.meshes() != its.meshes()) refuse("their meshes differ");
  if (own.scenes() != its.scenes()) {
    refuse("their scenes, or files that these read, differ in other keys than [output]");
  }
}

// The runs of all studies, each once, in the order of a plan.
void MergedStudy::join_runs() {
  std::map<std::string, std::size_t> places;
  StudyPlan joined = studies_.front().plan->plan;
  joined.runs.clear();
  joined.references.clear();
  for (std::size_t i = 0; i < studies_.size(); ++i) {
    const StoredStudy& study = studies_[i];
    if (study.plan->plan.reference_of != joined.reference_of) {
      throw InputError(
          fmt::format("{} and {} cannot be merged: their variants share their "
                      "references otherwise.",
                      directories_.front(), directories_[i]));
    }
    for (const PlannedRun& run : study.plan->plan.runs) {
      const bool is_made =
          std::any_of(study.result.rows.begin(), study.result.rows.end(), [&](const StudyRow& row) {
            return row.directory == run.directory && row.status != RunStatus::kCancelled;
          });
      const auto [place, is_new] = places.emplace(run.directory, joined.runs.size());
      if (is_new) {
        joined.runs.push_back(run);
        sources_.emplace_back();
      }
      PlannedRun& known = joined.runs[place->second];
      if (study.plan->digests.of(known) != study.plan->digests.of(run)) {
        throw InputError(
            fmt::format("{} and {} cannot be merged: their runs {} compute something different.",
                        directories_.front(), directories_[i], run.directory));
      }
      known.role = joined_role(known.role, run.role);
      known.is_left_out = known.is_left_out && run.is_left_out;
      Source& source = sources_[place->second];
      if (is_made && source.folder.empty()) {
        source.folder = (fs::path(directories_[i]) / run.directory).string();
      }
    }
  }
  std::map<std::pair<std::size_t, Integrator>, std::size_t> blocks;
  std::vector<std::size_t> order(joined.runs.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    order[i] = i;
    blocks.emplace(std::pair(joined.runs[i].variant, joined.runs[i].integrator), i);
  }
  const auto place = [&](std::size_t i) {
    const PlannedRun& run = joined.runs[i];
    return std::tuple(run.variant, blocks.at({run.variant, run.integrator}), run.compares_solver,
                      run.compares_solver ? 0.0 : run.step);
  };
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return place(a) < place(b); });
  std::vector<Source> sources;
  plan_ = joined;
  plan_.runs.clear();
  for (const std::size_t i : order) {
    plan_.runs.push_back(joined.runs[i]);
    sources.push_back(std::move(sources_[i]));
  }
  sources_ = std::move(sources);
}

// The finest reference of all studies: that with the smallest step, or, of different rules, that with the smallest
// error of its own.
void MergedStudy::choose_references() {
  const StoredStudy* best = &studies_.front();
  for (const StoredStudy& study : studies_) {
    const StudyResult& a = best->result;
    const StudyResult& b = study.result;
    const bool have_errors = std::isfinite(a.reference_error) && std::isfinite(b.reference_error);
    const bool is_finer =
        a.reference_integrator != b.reference_integrator && have_errors
            ? b.reference_error < a.reference_error
            : std::tuple(b.reference_step, -static_cast<int>(b.extrapolation.has_value())) <
                  std::tuple(a.reference_step, -static_cast<int>(a.extrapolation.has_value()));
    if (is_finer) best = &study;
  }
  const StudyPlan& from = best->plan->plan;
  plan_.references = from.references;
  plan_.has_first_mesh = from.has_first_mesh;
  for (PlannedReference& reference : plan_.references) {
    for (std::size_t& run : reference.runs) {
      const auto found = std::find_if(
          plan_.runs.begin(), plan_.runs.end(),
          [&](const PlannedRun& other) { return other.directory == from.runs[run].directory; });
      run = static_cast<std::size_t>(found - plan_.runs.begin());
    }
  }
}

void MergedStudy::read_rows() {
  const RunDigests& digests = studies_.front().plan->digests;
  for (std::size_t i = 0; i < sources_.size(); ++i) {
    Source& source = sources_[i];
    if (source.folder.empty()) continue;
    for (std::size_t k = 0; k < kNeededFiles; ++k) {
      if (is_plain_file(fs::path(source.folder) / kRunFiles[k])) continue;
      throw FileError(fmt::format(
          "{}/{}: the file of a run of the study is missing. The same command as that of the study "
          "makes this run again.",
          source.folder, kRunFiles[k]));
    }
    source.row = read_study_row(source.folder + "/" + kStudyRowFile, plan_, plan_.runs[i],
                                digests.of(plan_.runs[i]));
    if (!source.row) {
      throw FileError(fmt::format(
          "{}/{}: this is not the result of the run that study.json names: it is damaged, or was "
          "made for something else.",
          source.folder, kStudyRowFile));
    }
  }
}

TrackSource MergedStudy::tracks() const {
  // Runs that are compared with the same reference have the same vertices.
  auto shapes = std::make_shared<std::map<std::size_t, TrackShape>>();
  return [this, shapes](const PlannedRun& run) {
    const auto place =
        std::find_if(plan_.runs.begin(), plan_.runs.end(),
                     [&](const PlannedRun& other) { return other.directory == run.directory; });
    const Source& source = sources_[static_cast<std::size_t>(place - plan_.runs.begin())];
    const std::string path = source.folder + "/" + kStudyTrackFile;
    std::shared_ptr<const MotionTrack> track =
        read_study_track(path, studies_.front().plan->digests.of(*place));
    const std::size_t reference = plan_.reference_of[run.variant];
    const std::size_t group = plan_.has_first_mesh[reference] ? 0 : reference;
    bool fits = track != nullptr && track->end == plan_.end;
    if (fits) {
      const TrackShape own{track->rest.size(), track->count};
      const TrackShape known = shapes->emplace(group, own).first->second;
      fits = known.size == own.size && known.count == own.count;
      for (const ProbeColumns& probe : plan_.probes) {
        if (probe.name != plan_.error_probe) continue;
        const ProbeRecord* record = track->probe(probe.name);
        fits = fits && record != nullptr && record->width == probe.size();
      }
      fits = fits && (plan_.error_probe.empty() || track->probe(plan_.error_probe) != nullptr);
    }
    if (!fits) {
      throw FileError(fmt::format(
          "{}: the positions of the run are damaged, or those of another run. The same command as "
          "that of the study makes this run again.",
          path));
    }
    return track;
  };
}

std::string MergedStudy::plan() const {
  return study_plan_json(plan_, studies_.front().plan->digests);
}

void MergedStudy::copy_runs(const std::string& directory) const {
  StudyJournal journal(directory);
  for (std::size_t i = 0; i < sources_.size(); ++i) {
    if (!sources_[i].row) continue;
    const std::string& name = plan_.runs[i].directory;
    const std::string folder = directory + "/" + name;
    journal.begin(name);
    make_own_directory(folder);
    for (const char* file : kRunFiles) {
      const fs::path from = fs::path(sources_[i].folder) / file;
      if (!is_plain_file(from)) continue;
      const std::string to = folder + "/" + file;
      std::error_code problem;
      fs::copy_file(from, to, problem);
      if (problem) fail_to_write(to, problem.value());
    }
    journal.complete(name);
  }
}

ReplacementDirectory::ReplacementDirectory(std::string path)
    : path_(std::move(path)), temporary_() {
  // A slash at the end would make the temporary name one inside the directory.
  while (path_.size() > 1 && path_.back() == '/') path_.pop_back();
  temporary_ = temporary_name(path_);
  std::error_code problem;
  const bool is_free = !is_entry(path_) || (fs::is_directory(fs::symlink_status(path_, problem)) &&
                                            fs::is_empty(path_, problem));
  if (!is_free) {
    throw InputError(
        fmt::format("{}: this is not an empty directory. Choose another one with --out.", path_));
  }
  const fs::path above = fs::path(path_).parent_path();
  if (!above.empty()) fs::create_directories(above, problem);
  if (problem) fail_to_write(path_, problem.value());
  fs::remove_all(temporary_, problem);  // of a program that was killed
  if (!fs::create_directory(temporary_, problem)) fail_to_write(temporary_, problem.value());
}

ReplacementDirectory::~ReplacementDirectory() {
  std::error_code ignored;
  if (!temporary_.empty()) fs::remove_all(temporary_, ignored);
}

void ReplacementDirectory::finish() {
  std::error_code problem;
  fs::rename(temporary_, path_, problem);
  if (problem) fail_to_write(path_, problem.value());
  temporary_.clear();
}

}  // namespace tetraction
