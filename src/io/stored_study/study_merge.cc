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
  std::vector<std::optional<StudyRow>> rows;
  for (std::size_t i = 0; i < folders_.size(); ++i) rows.push_back(row(i));
  result_ = compare_runs(plan_, rows, tracks());
  result_.target = studies_.front().result.target;
  for (std::size_t i = 0; i < studies_.size(); ++i) {
    const StoredStudy& study = studies_[i];
    if (study.result.target != result_.target) result_.target.reset();
    if (!result_.mesh_check && study.result.mesh_check) {
      result_.mesh_check = study.result.mesh_check;
      mesh_check_folder_ = directories_[i] + "/" + result_.mesh_check->directory;
    }
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
  const auto refuse = [&](const std::string& what) { fail(other, what); };
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
  const auto is_same_variant = [](const VariantValues& x, const VariantValues& y) {
    return x.name == y.name && x.values == y.values;
  };
  if (!std::equal(a.result.variants.begin(), a.result.variants.end(), b.result.variants.begin(),
                  b.result.variants.end(), is_same_variant)) {
    refuse("they have other variants (--vary)");
  }
  if (own.meshes() != its.meshes()) refuse("their meshes differ");
  if (own.scenes() != its.scenes()) {
    refuse("their scenes, or files that these read, differ in other keys than [output]");
  }
  if (a.plan->plan.reference_of != b.plan->plan.reference_of) {
    refuse("their variants share their references otherwise");
  }
}

void MergedStudy::fail(std::size_t other, const std::string& what) const {
  throw InputError(fmt::format("{} and {} cannot be merged: {}.", directories_.front(),
                               directories_[other], what));
}

// The runs of all studies, each once, in the order of a plan.
void MergedStudy::join_runs() {
  struct Run {
    PlannedRun run;
    std::string folder;
    std::size_t rule;  // the place of the first run with its variant and rule
  };
  std::vector<Run> joined;
  for (std::size_t i = 0; i < studies_.size(); ++i) {
    const StoredStudy& study = studies_[i];
    for (const PlannedRun& run : study.plan->plan.runs) {
      const auto find = [&](const auto& is_it) {
        return std::find_if(joined.begin(), joined.end(), is_it);
      };
      auto known = find([&](const Run& each) { return each.run.directory == run.directory; });
      if (known == joined.end()) {
        const auto first = find([&](const Run& each) {
          return each.run.variant == run.variant && each.run.rule() == run.rule();
        });
        joined.push_back({run, "", static_cast<std::size_t>(first - joined.begin())});
        known = joined.end() - 1;
      }
      if (study.plan->digests.of(known->run) != study.plan->digests.of(run)) {
        fail(i, fmt::format("their runs {} compute something different", run.directory));
      }
      known->run.role = joined_role(known->run.role, run.role);
      known->run.is_left_out = known->run.is_left_out && run.is_left_out;
      const std::vector<StudyRow>& rows = study.result.rows;
      const bool is_made = std::any_of(rows.begin(), rows.end(), [&](const StudyRow& row) {
        return row.directory == run.directory && row.status != RunStatus::kCancelled;
      });
      if (is_made && known->folder.empty()) known->folder = directories_[i] + "/" + run.directory;
    }
  }
  std::stable_sort(joined.begin(), joined.end(), [](const Run& a, const Run& b) {
    const auto place = [](const Run& each) {
      return std::tuple(each.run.variant, each.rule, each.run.compares_solver,
                        each.run.compares_solver ? 0.0 : each.run.step);
    };
    return place(a) < place(b);
  });
  plan_ = studies_.front().plan->plan;
  plan_.runs.clear();
  for (const Run& each : joined) {
    plan_.runs.push_back(each.run);
    folders_.push_back(each.folder);
  }
}

std::size_t MergedStudy::place_of(const std::string& directory) const {
  const auto found = std::find_if(plan_.runs.begin(), plan_.runs.end(), [&](const PlannedRun& run) {
    return run.directory == directory;
  });
  return static_cast<std::size_t>(found - plan_.runs.begin());
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
    for (std::size_t& run : reference.runs) run = place_of(from.runs[run].directory);
  }
}

std::optional<StudyRow> MergedStudy::row(std::size_t run) const {
  const std::string& folder = folders_[run];
  if (folder.empty()) return {};
  for (std::size_t k = 0; k < kNeededFiles; ++k) {
    if (is_plain_file(fs::path(folder) / kRunFiles[k])) continue;
    throw FileError(fmt::format(
        "{}/{}: the file of a run of the study is missing. The same command as that of the study "
        "makes this run again.",
        folder, kRunFiles[k]));
  }
  std::optional<StudyRow> row = read_study_row(folder + "/" + kStudyRowFile, plan_, plan_.runs[run],
                                               studies_.front().plan->digests.of(plan_.runs[run]));
  if (row) return row;
  throw FileError(fmt::format(
      "{}/{}: this is not the result of the run that study.json names: it is damaged, or was made "
      "for something else.",
      folder, kStudyRowFile));
}

TrackSource MergedStudy::tracks() const {
  // Runs that are compared with the same reference have the same vertices.
  auto sizes = std::make_shared<std::map<std::size_t, std::pair<Index, std::size_t>>>();
  return [this, sizes](const PlannedRun& run) {
    const std::string path = folders_[place_of(run.directory)] + "/" + kStudyTrackFile;
    std::shared_ptr<const MotionTrack> track =
        read_study_track(path, studies_.front().plan->digests.of(run));
    const std::size_t reference = plan_.reference_of[run.variant];
    const std::size_t group = plan_.has_first_mesh[reference] ? 0 : reference;
    bool fits = track != nullptr && track->end == plan_.end;
    if (fits) {
      const std::pair size(track->rest.size(), track->count);
      fits = sizes->emplace(group, size).first->second == size;
      const std::string series = plan_.error_series().series();
      const ProbeRecord* record = series.empty() ? nullptr : track->probe(series);
      fits = fits && (record != nullptr || series.empty());
      for (const ProbeColumns& probe : plan_.probes) {
        fits = fits && (probe.name != series || record->width == probe.size());
      }
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
  const auto copy = [&](const std::string& run, const std::string& name) {
    const std::string folder = directory + "/" + name;
    journal.begin(name);
    make_own_directory(folder);
    for (const char* file : kRunFiles) {
      const fs::path from = fs::path(run) / file;
      if (!is_plain_file(from)) continue;
      const std::string to = folder + "/" + file;
      std::error_code problem;
      fs::copy_file(from, to, problem);
      if (problem) fail_to_write(to, problem.value());
    }
    journal.complete(name);
  };
  for (std::size_t i = 0; i < folders_.size(); ++i) {
    if (!folders_[i].empty()) copy(folders_[i], plan_.runs[i].directory);
  }
  const auto& check = result_.mesh_check;
  if (check && !check->directory.empty()) copy(mesh_check_folder_, check->directory);
}

}  // namespace tetraction
