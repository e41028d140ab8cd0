#include "study_maker.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <string_view>
#include <utility>

#include "core/quoting.h"
#include "io/results/result_folders.h"
#include "io/text/output_file.h"
#include "simulation/scene/parallel_features.h"
#include "study_names.h"
#include "tetraction/core/error.h"
#include "tetraction/core/provenance.h"
#include "tetraction/io/initial_fields.h"
#include "tetraction/io/run_recorder.h"
#include "tetraction/simulation/scene_objects.h"
#include "tetraction/simulation/warnings.h"

namespace tetraction {
namespace {

// SOLVER@STEP.
SolverComparison read_comparison(const std::string& text) {
  const auto at = std::min(text.find('@'), text.size());
  const char* end = text.data() + text.size();
  SolverComparison comparison{text.substr(0, at)};
  const auto [rest, problem] =
      std::from_chars(text.data() + std::min(at + 1, text.size()), end, comparison.step);
  if (comparison.solver.empty() || problem != std::errc() || rest != end) {
    throw InputError(fmt::format(
        "--also-solver {}: write SOLVER@STEP, for instance --also-solver ceres@1e-3.", text));
  }
  return comparison;
}

// Those with settings follow their integrator.
std::vector<StudyRule> read_rules(const StudyOptions& options) {
  std::vector<std::string> names = options.integrators;
  if (names.empty()) names = rules_with_steps(options.steps);
  std::vector<StudyRule> rules;
  for (const std::string& name : names) {
    const Integrator rule = integrator_from_string(name);
    if (std::count(rules.begin(), rules.end(), StudyRule(rule)) > 0) {
      throw InputError(fmt::format("--integrators: {} is there twice.", name));
    }
    rules.emplace_back(rule);
  }
  if (names.empty()) rules.assign(all_integrators().begin(), all_integrators().end());
  for (const std::string& text : options.rules) {
    const StudyRule rule = read_study_rule(text);
    if (std::any_of(rules.begin(), rules.end(),
                    [&](const StudyRule& other) { return is_same_rule(rule, other); })) {
      throw InputError(fmt::format("--rule: {} is there twice.", to_string(rule)));
    }
    const auto last = std::find_if(rules.rbegin(), rules.rend(), [&](const StudyRule& other) {
      return other.integrator == rule.integrator;
    });
    rules.insert(last == rules.rend() ? rules.end() : last.base(), rule);
  }
  return rules;
}

StudyRequests read_requests(const StudyOptions& options) {
  StudyRequests requests;
  requests.rules = read_rules(options);
  requests.steps = assign_steps(options.steps, requests.rules);
  requests.error = read_error_measure(options.error);
  requests.budget = read_duration(options.budget, "--budget");
  if (!options.target.empty()) requests.target = read_share(options.target, "--target");
  if (!options.reference_integrator.empty()) {
    requests.reference_integrator = integrator_from_string(options.reference_integrator);
  }
  if (requests.target && !options.steps.empty()) {
    throw InputError(
        "--target searches for the steps itself: leave --steps out, or --target if these steps are "
        "meant.");
  }
  return requests;
}

void read_part(const std::string& text, StudyInputs& inputs) {
  if (text.empty()) return;
  const auto number = [](std::string_view digits) {
    std::size_t value = 0;
    const auto [end, problem] =
        std::from_chars(digits.data(), digits.data() + digits.size(), value);
    return problem == std::errc() && end == digits.data() + digits.size() ? value : 0;
  };
  const std::size_t slash = std::min(text.find('/'), text.size());
  const std::size_t part = number(std::string_view(text).substr(0, slash));
  inputs.parts = number(std::string_view(text).substr(std::min(slash + 1, text.size())));
  if (part < 1 || part > inputs.parts) {
    throw InputError(fmt::format(
        "--part {}: write K/N with K from 1 to N, such as --part 2/3 for the second of three jobs.",
        in_quotes(text)));
  }
  inputs.part = part - 1;
  if (chooses_steps(inputs.requests)) {
    throw InputError(
        "--part: all parts must make the same plan, but here the program would choose steps. Take "
        "the steps from the same command with --plan instead of --part, and give them by --steps.");
  }
  if (inputs.options.mesh_check) {
    throw InputError(
        "--mesh-check: a part of a study does not know all runs. Leave it out, merge the parts, "
        "and make the whole study in the merged directory with --mesh-check.");
  }
}

// Warnings about the materials of variants. Those of one kind are one, with the names of the further variants.
class MaterialWarnings {
 public:
  void add(const std::string& variant, const MechanicalSystem& system) {
    for (std::size_t kind = 0; kind < kKinds.size(); ++kind) {
      const std::string text = kKinds[kind](system);
      if (text.empty()) continue;
      if (texts_[kind].empty()) {
        texts_[kind] = variant.empty() ? text : fmt::format("the variant {}: {}", variant, text);
      } else {
        others_[kind].push_back(variant);
      }
    }
  }

  std::vector<std::string> all() const {
    std::vector<std::string> warnings;
    for (std::size_t kind = 0; kind < kKinds.size(); ++kind) {
      if (texts_[kind].empty()) continue;
      warnings.push_back(texts_[kind]);
      if (others_[kind].empty()) continue;
      warnings.back() += fmt::format("{} The same kind of warning applies to {}.",
                                     warnings.back().ends_with('.') ? "" : ".",
                                     enumeration(others_[kind], kMostNamed));
    }
    return warnings;
  }

 private:
  static constexpr std::array kKinds{locking_warning, thin_wall_warning, instability_warning};
  std::array<std::string, kKinds.size()> texts_;
  std::array<std::vector<std::string>, kKinds.size()> others_;
};

StudyInputs checked(StudyInputs inputs) {
  require_local_engine(inputs.scene);
  MaterialWarnings warnings;
  if (inputs.settings.variants.empty()) {
    warnings.add("", *make_system(inputs.scene, *inputs.mesh));
  }
  for (const StudyVariant& variant : inputs.settings.variants) {
    require_local_engine(variant.scene);
    try {
      const auto system = make_system(variant.scene, *variant.mesh);
      check_events(variant.scene, *system);
      warnings.add(variant.name, *system);
    } catch (const InputError& error) {
      throw InputError(in_variant(variant, error.what()));
    }
  }
  inputs.warnings = warnings.all();
  return inputs;
}

}  // namespace

StudyInputs read_study_inputs(const StudyOptions& options, const ReadScene& read,
                              const std::vector<std::string>& overrides) {
  StudyInputs inputs;
  inputs.options = options;
  inputs.requests = read_requests(options);
  read_part(options.part, inputs);
  StudySettings& settings = inputs.settings;
  settings.variants = read_variants(read, overrides, options.vary);
  settings.reference_step = options.reference_step;
  settings.reference_kind = from_string<ReferenceKind>(options.reference);
  for (const std::string& text : options.also_solvers) {
    settings.solver_comparisons.push_back(read_comparison(text));
  }
  if (inputs.requests.error.kind != ErrorKind::kPositions) {
    settings.error_probe = inputs.requests.error.name;
    settings.error_kind = inputs.requests.error.kind;
  }
  settings.repeats = options.repeats;
  settings.repeat_seconds = 0.1 * inputs.requests.budget;
  inputs.scene = settings.variants.empty() ? read(overrides) : settings.variants.front().scene;
  return inputs;
}

void read_study_mesh(StudyInputs& inputs, const ReadMesh& read) {
  if (!inputs.directory.empty()) {
    check_folder_of_study(inputs.scene, inputs.directory);
    if (!inputs.options.fresh) refuse_other_study(inputs.directory, inputs.name);
  }
  std::vector<StudyVariant>& variants = inputs.settings.variants;
  inputs.mesh = variants.empty() ? std::make_shared<const TetMesh>(read(inputs.scene))
                                 : read_variant_meshes(variants, read);
}

Index step_count(const StudyPlan& plan, const PlannedRun& run) {
  return static_cast<Index>(std::min(std::ceil(plan.end / run.step * (1.0 - 1e-9)), 1e18));
}

StudyMaker::StudyMaker(StudyInputs inputs, StudyHooks hooks)
    : inputs_(checked(std::move(inputs))),
      hooks_(std::move(hooks)),
      frame_(begin_plan(inputs_.scene, *inputs_.mesh, inputs_.settings)),
      digests_(frame_, *inputs_.mesh),
      goes_on_(!inputs_.directory.empty() && inputs_.keeps_runs && !inputs_.options.fresh &&
               holds_study(inputs_.directory)),
      old_plots_(inputs_.directory.empty() ? std::vector<std::string>()
                                           : plots_of_study(inputs_.directory)) {
  if (inputs_.directory.empty()) return;
  folder_ = std::make_unique<StudyFolder>(inputs_.directory, frame_, *inputs_.mesh, digests_);
}

void StudyMaker::tell(const std::string& note) const {
  if (hooks_.tell) hooks_.tell(note);
}

// Before the first run: a choice or a plan that needs none writes nothing.
void StudyMaker::begin() {
  if (lock_ || folder_ == nullptr || inputs_.options.plan) return;
  make_output_directory(inputs_.directory);
  lock_.emplace(inputs_.directory);
}

StudyMemory StudyMaker::memory(StudyFolder* folder) {
  StudyMemory memory = folder == nullptr ? in_memory_ : folder->memory();
  memory.kept = [this, folder, kept = memory.kept](const PlannedRun& run) {
    const bool may_be = folder == nullptr || goes_on_ || made_.contains(run.directory);
    return may_be ? kept(run) : std::nullopt;
  };
  if (inputs_.options.plan) {
    memory.made = nullptr;  // nothing is written
  } else if (hooks_.made) {
    memory.made = [this, keep = memory.made](const PlannedRun& run, const StudyRow& row,
                                             const MotionTrack& track) {
      keep(run, row, track);
      hooks_.made(row);
    };
  }
  memory.is_stopped = hooks_.is_stopped;
  return memory;
}

ObserverFactory StudyMaker::observers(StudyFolder* folder) {
  return [this, folder](const std::string& run) {
    std::vector<std::unique_ptr<Observer>> list;
    if (!inputs_.options.plan) {
      // Everything has been checked before this, so that a mistake does not delete the results of an earlier study.
      if (folder != nullptr && made_.empty() && inputs_.options.fresh &&
          remove_study(inputs_.directory)) {
        tell(fmt::format("{}: the results of an earlier study were deleted", inputs_.directory));
      }
      made_.insert(run);
    }
    if (folder != nullptr && !inputs_.options.plan) {
      folder->begin_run(run, inputs_.name);
      auto recorder = std::make_unique<RunRecorder>(
          folder->path(run), folder->has_frames(run) ? inputs_.scene.output.every : 0);
      if (hooks_.stop_code) recorder->set_stop_code(hooks_.stop_code);
      list.push_back(std::move(recorder));
    }
    if (hooks_.observe) hooks_.observe(list);
    return list;
  };
}

TrackedRun StudyMaker::make_one(const StudyPlan& plan, const PlannedRun& run, const TetMesh& mesh,
                                StudyFolder* folder) {
  begin();
  return make_tracked_run(plan, run, mesh, observers(folder),
                          inputs_.options.plan ? StudyProgress() : hooks_.progress, memory(folder));
}

// The mesh of the mesh check, or null. Fields that are given by formulas are exact there; others are interpolated.
std::shared_ptr<const TetMesh> StudyMaker::fine_mesh() const {
  if (!inputs_.options.mesh_check) return nullptr;
  TetMesh fine = mesh_of_mesh_check(frame_, *inputs_.mesh);
  InitialSettings initial = frame_.variants.front().scene.initial;
  for (FieldSettings* field : {&initial.displacement_field, &initial.velocity_field}) {
    if (!field->file.empty()) *field = {};
  }
  add_initial_fields(initial, fine);
  return std::make_shared<const TetMesh>(std::move(fine));
}

bool StudyMaker::choose() {
  StudyRequests requests = inputs_.requests;
  const std::shared_ptr<const TetMesh> fine = fine_mesh();
  // What the choice of steps depends on.
  const std::string digest = digests_.of(planned_run(frame_, 0, Integrator::kVerlet, frame_.end));
  if (goes_on_) requests.seconds_per_step = times_of_choice(inputs_.directory, digest);
  StudyPlan trial = frame_;
  ChosenStudy chosen =
      choose_study(frame_, *inputs_.mesh, inputs_.settings, requests, [&](const PlannedRun& run) {
        trial.runs = {run};
        if (folder_) check_folder_of_study(trial, inputs_.directory);
        TrackedRun made = make_one(frame_, run, *inputs_.mesh, folder_.get());
        made.is_stopped = made.is_stopped || is_stopped();
        return made;
      });
  if (chosen.choice.is_stopped || is_stopped()) return false;
  if (chosen.plan) chosen.plan->digest = digest;
  plan_ = plan_study(inputs_.scene, *inputs_.mesh, chosen.settings);
  if (inputs_.part >= plan_.runs.size()) {
    throw InputError(fmt::format(
        "--part {}: the study has only {} runs, so that none is left for this part. Use at most so "
        "many parts.",
        inputs_.options.part, plan_.runs.size()));
  }
  leave_to_others(plan_, inputs_.part, inputs_.parts);
  if (fine) finer_ = mesh_check_plan(plan_, fine);
  if (folder_) check_folder_of_study(plan_, inputs_.directory);
  if (folder_ && finer_) check_folder_of_study(*finer_, inputs_.directory);
  for (const std::string& warning : inputs_.warnings) {
    if (hooks_.warn) hooks_.warn(warning);
  }
  chosen_ = std::move(chosen);
  return true;
}

std::vector<PlannedTime> StudyMaker::planned_times() {
  const StudyMemory kept = memory(folder_.get());
  std::vector<PlannedTime> times;
  for (const PlannedRun& run : plan_.runs) {
    if (run.is_left_out || is_stopped()) continue;
    const bool is_kept = kept.kept(run).has_value();
    times.push_back({run, is_kept, step_count(plan_, run),
                     is_kept ? 0.0 : estimated_seconds(plan_, run, *inputs_.mesh)});
  }
  return times;
}

std::optional<PlannedTime> StudyMaker::planned_mesh_check() {
  if (!finer_ || is_stopped()) return {};
  const PlannedRun& run =
      *std::min_element(finer_->runs.begin(), finer_->runs.end(),
                        [](const auto& a, const auto& b) { return a.step < b.step; });
  return PlannedTime{run, false, step_count(*finer_, run),
                     estimated_seconds(*finer_, run, *finer_->variants.front().mesh)};
}

StudyResult StudyMaker::make(const std::vector<std::string>& frames) {
  begin();
  if (folder_) folder_->set_frames(frames);
  StudyResult result = run_study(plan_, *inputs_.mesh, observers(folder_.get()), hooks_.progress,
                                 memory(folder_.get()), inputs_.options.jobs);
  chosen_->add_to(result);
  if (finer_) result.mesh_check = check_mesh(result);
  if (goes_on_) tell_of_kept_runs(result);
  return result;
}

MeshCheck StudyMaker::check_mesh(const StudyResult& result) {
  const TetMesh& mesh = *finer_->variants.front().mesh;
  MeshCheck check;
  check.vertices = mesh.vertex_count();
  check.tetrahedra = mesh.tetrahedron_count();
  check.status = RunStatus::kCancelled;
  const PlannedRun* run = run_of_mesh_check(*finer_, result);
  if (run == nullptr || result.is_interrupted || is_stopped()) return check;
  check.integrator = run->integrator;
  check.step = run->step;
  check.directory = run->directory;
  const RunDigests digests(*finer_, mesh);
  std::unique_ptr<StudyFolder> folder;
  if (folder_) {
    folder = std::make_unique<StudyFolder>(inputs_.directory, *finer_, mesh, digests);
  }
  const TrackedRun fine = make_one(*finer_, *run, mesh, folder.get());
  if (fine.is_stopped) return check;
  check.status = fine.status;
  PlannedRun coarse = *run;
  coarse.directory = coarse_run_of(*run);
  const std::shared_ptr<const MotionTrack> track = this->track(coarse);
  if (fine.track && track) check.difference = mesh_difference(*finer_, *track, *fine.track);
  return check;
}

void StudyMaker::tell_of_kept_runs(const StudyResult& result) const {
  if (made_.empty()) {
    return tell(fmt::format("{}: the study was complete, and no run was made", inputs_.directory));
  }
  const auto kept = std::count_if(plan_.runs.begin(), plan_.runs.end(), [&](const auto& run) {
    return !run.is_left_out && !made_.contains(run.directory);
  });
  tell(fmt::format("{}: {} of {} runs were kept{}", inputs_.directory, kept,
                   plan_.runs.size() - result.left_out,
                   result.mesh_check && made_.contains(result.mesh_check->directory)
                       ? ", and that on the finer mesh was made"
                       : ""));
}

StudyProvenance StudyMaker::provenance(const std::string& command) const {
  return {command, utc_now(), inputs_.keeps_runs ? study_plan_json(plan_, digests_) : ""};
}

std::shared_ptr<const MotionTrack> StudyMaker::track(const PlannedRun& run) {
  return memory(folder_.get()).track(run);
}

}  // namespace tetraction
