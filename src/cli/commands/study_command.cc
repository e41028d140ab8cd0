// tetraction study: the same motion by several integrators at several steps.
#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "cli/command_line.h"
#include "cli/console.h"
#include "cli/interrupt_guard.h"
#include "cli/progress_bar.h"
#include "cli/scene_source.h"
#include "cli/study_arguments.h"
#include "cli/study_frames.h"
#include "cli/study_messages.h"
#include "cli/study_output.h"
#include "commands.h"
#include "io/results/directory_lock.h"
#include "io/results/result_folders.h"
#include "io/scene/scene_variants.h"
#include "io/stored_study/study_reader.h"
#include "io/study/study_folder.h"
#include "io/text/output_file.h"
#include "simulation/scene/parallel_features.h"
#include "tetraction/core/blas.h"
#include "tetraction/core/error.h"
#include "tetraction/core/provenance.h"
#include "tetraction/dynamics/steppers/integrator.h"
#include "tetraction/io/initial_fields.h"
#include "tetraction/io/run_recorder.h"
#include "tetraction/io/scene_reader.h"
#include "tetraction/simulation/scene_objects.h"

namespace tetraction {
namespace {

// SOLVER@STEP.
SolverComparison read_comparison(const std::string& text) {
  const auto at = text.find('@');
  const std::string number = at == std::string::npos ? "" : text.substr(at + 1);
  char* end = nullptr;
  SolverComparison comparison{text.substr(0, at), std::strtod(number.c_str(), &end)};
  if (comparison.solver.empty() || number.empty() || *end != '\0') {
    throw InputError(fmt::format(
        "--also-solver {}: write SOLVER@STEP, for instance --also-solver ceres@1e-3.", text));
  }
  return comparison;
}

StudySettings read_settings(const StudyArguments& arguments, const StudyRequests& requests) {
  StudySettings settings;
  const auto read = [&](const std::vector<std::string>& overrides) {
    return read_scene(arguments.scene, overrides);
  };
  settings.variants = read_variants(read, arguments.overrides, arguments.vary);
  settings.reference_step = arguments.reference_step;
  settings.reference_kind = from_string<ReferenceKind>(arguments.reference);
  for (const std::string& text : arguments.also_solvers) {
    settings.solver_comparisons.push_back(read_comparison(text));
  }
  if (requests.error.kind != ErrorKind::kPositions) {
    settings.error_probe = requests.error.name;
    settings.error_kind = requests.error.kind;
  }
  settings.repeats = arguments.repeats;
  settings.repeat_seconds = 0.1 * requests.budget;
  return settings;
}

// What a study works with. Everything has been checked that can be checked before its steps are chosen.
struct StudyInputs {
  StudyRequests requests;
  StudyPart part;
  StudySettings settings;
  Scene scene;
  std::string name;       // of the scene
  std::string directory;  // of the results
  std::shared_ptr<const TetMesh> mesh;
};

void tell_of_meshes(const StudyInputs& inputs, const std::vector<std::string>& unused) {
  std::vector<std::string> told;
  const auto tell = [&](const TetMesh& of) {
    const std::string remarks = mesh_remarks(of, unused);
    if (remarks.empty() || std::count(told.begin(), told.end(), remarks) > 0) return;
    told.push_back(remarks);
    print_note(remarks);
  };
  tell(*inputs.mesh);
  const TetMesh* last = inputs.mesh.get();
  for (const StudyVariant& variant : inputs.settings.variants) {
    if (variant.mesh.get() != last) tell(*variant.mesh);
    last = variant.mesh.get();
  }
}

StudyInputs read_inputs(const StudyArguments& arguments) {
  StudyInputs inputs;
  inputs.requests = study_requests(arguments);
  inputs.part = read_part(arguments.part);
  inputs.settings = read_settings(arguments, inputs.requests);
  const bool names_frames = !arguments.frames.empty() && arguments.frames.front() != "all" &&
                            arguments.frames.front() != "none";
  if (names_frames && chooses_steps(inputs.requests)) {
    throw InputError(
        "--frames names runs, but the steps are not chosen yet: give --steps, or write --frames "
        "all or none.");
  }
  if (!arguments.part.empty() && chooses_steps(inputs.requests)) {
    throw InputError(
        "--part: all parts must make the same plan, but here the program would choose steps. Take "
        "the steps from the same command with --plan instead of --part, and give them by --steps.");
  }
  if (!arguments.part.empty() && arguments.mesh_check) {
    throw InputError(
        "--mesh-check: a part of a study does not know all runs. Leave it out, merge the parts, "
        "and "
        "make the whole study in the merged directory with --mesh-check.");
  }
  const std::vector<StudyVariant>& variants = inputs.settings.variants;
  inputs.scene =
      variants.empty() ? read_scene(arguments.scene, arguments.overrides) : variants.front().scene;
  inputs.directory = output_directory(inputs.scene, arguments.out, arguments.overrides);
  check_view(arguments.view);
  require_local_engine(inputs.scene);
  inputs.name = std::filesystem::path(arguments.scene).stem().string();
  check_folder_of_study(inputs.scene, inputs.directory);
  if (!arguments.fresh) refuse_other_study(inputs.directory, inputs.name);
  for (const StudyVariant& variant : variants) require_local_engine(variant.scene);
  std::vector<std::string> unused;
  inputs.mesh = variants.empty()
                    ? std::make_shared<const TetMesh>(read_scene_mesh(inputs.scene, unused))
                    : read_variant_meshes(inputs.settings.variants, [](const Scene& variant) {
                        return read_scene_mesh(variant);
                      });
  if (!arguments.view.quiet) tell_of_meshes(inputs, unused);
  for (const StudyVariant& variant : variants) {
    try {
      check_events(variant.scene, *make_system(variant.scene, *variant.mesh));
    } catch (const InputError& error) {
      throw InputError(in_variant(variant, error.what()));
    }
  }
  return inputs;
}

// A study in its directory: the choice of steps, the plan, the runs, and their files.
class Study {
 public:
  explicit Study(const StudyArguments& arguments)
      : arguments_(arguments),
        inputs_(read_inputs(arguments)),
        frame_(begin_plan(inputs_.scene, *inputs_.mesh, inputs_.settings)),
        goes_on_(!arguments.fresh && holds_study(inputs_.directory)),
        old_plots_(plots_of_study(inputs_.directory)),
        digests_(frame_, *inputs_.mesh),
        digest_(digests_.of(planned_run(frame_, 0, Integrator::kVerlet, frame_.end))),
        trials_(inputs_.directory, frame_, *inputs_.mesh, digests_, {}),
        has_bars_(arguments.jobs == 1 && ProgressBar::possible()),
        has_told_of_blas_(arguments.view.quiet) {
    if (goes_on_) {
      inputs_.requests.seconds_per_step = times_of_choice(inputs_.directory, digest_);
    }
  }

  int make() {
    const ChosenStudy chosen = choose();
    if (chosen.choice.is_stopped) {
      print_note(
          "the study was interrupted while its steps were chosen: the same command goes on there");
      return InterruptGuard::exit_code();
    }
    StudyPlan plan = plan_study(inputs_.scene, *inputs_.mesh, chosen.settings);
    if (inputs_.part.number >= plan.runs.size()) {
      throw InputError(fmt::format(
          "--part {}: the study has only {} runs, so that none is left for this part. Use at most "
          "so many parts.",
          arguments_.part, plan.runs.size()));
    }
    leave_to_others(plan, inputs_.part.number, inputs_.part.count);
    check_folder_of_study(plan, inputs_.directory);
    if (arguments_.mesh_check) {
      finer_ = mesh_check_plan(plan, *inputs_.mesh);
      check_folder_of_study(*finer_, inputs_.directory);
    }
    const std::vector<std::string> frames = runs_with_frames(arguments_.frames, plan);
    StudyFolder runs(inputs_.directory, plan, *inputs_.mesh, digests_, frames);
    runs_ = &runs;
    if (arguments_.plan) {
      for (const std::string& remark : chosen.choice.remarks) print_note(remark);
      write_result(text_of_plan(plan, *inputs_.mesh, goes_on_ ? memory() : StudyMemory()));
      if (finer_) write_result(text_of_mesh_check());
      return 0;
    }
    begin();
    if (!arguments_.view.quiet) tell_of_plan(plan, chosen.choice);
    return write(plan, make_runs(plan, chosen), frames);
  }

 private:
  StudyFolder& folder() { return runs_ != nullptr ? *runs_ : trials_; }
  StudyMemory memory() {
    StudyMemory memory = folder().memory(goes_on_ || !made_.empty());
    memory.is_stopped = &InterruptGuard::interrupted;
    return memory;
  }

  // Before the first run: a choice or a plan that needs none writes nothing.
  void begin() {
    if (lock_) return;
    make_output_directory(inputs_.directory);
    lock_.emplace(inputs_.directory);
  }

  ChosenStudy choose() {
    const InterruptGuard between_runs;
    StudyPlan trial = frame_;
    return choose_study(
        frame_, *inputs_.mesh, inputs_.settings, inputs_.requests, [&](const PlannedRun& run) {
          trial.runs = {run};
          check_folder_of_study(trial, inputs_.directory);
          StudyMemory kept = memory();
          if (!arguments_.plan) {
            begin();
            return make_tracked_run(frame_, run, *inputs_.mesh, observers(), progress(), kept);
          }
          kept.made = nullptr;  // nothing is written
          return make_tracked_run(
              frame_, run, *inputs_.mesh,
              [](const std::string&) {
                std::vector<std::unique_ptr<Observer>> result;
                result.push_back(std::make_unique<InterruptGuard>());
                return result;
              },
              {}, kept);
        });
  }

  void tell_of_plan(const StudyPlan& plan, const StepChoice& choice) const {
    if (goes_on_) tell_of_lost_runs(inputs_.directory, plan);
    print_note(reference_message(plan));
    if (choice.seconds > 0.0) {
      print_note(fmt::format("the steps were chosen; the runs that are left take about {:.2g} s",
                             choice.seconds));
    }
    if (const std::string note = jobs_message(arguments_.jobs); !note.empty()) print_note(note);
  }

  // The run on the finer mesh is that with the shortest step at most.
  std::string text_of_mesh_check() const {
    StudyPlan longest = *finer_;
    const auto by_step = [](const PlannedRun& a, const PlannedRun& b) { return a.step < b.step; };
    longest.runs = {*std::min_element(finer_->runs.begin(), finer_->runs.end(), by_step)};
    return "at most, on the finer mesh:\n" +
           text_of_plan(longest, *finer_->variants.front().mesh, {});
  }

  MeshCheck check_finer_mesh(const StudyResult& result) {
    const TetMesh& mesh = *finer_->variants.front().mesh;
    const StudyMemory runs = memory();
    const RunDigests digests(*finer_, mesh);
    StudyFolder finer(inputs_.directory, *finer_, mesh, digests, {});
    StudyFolder* const before = std::exchange(runs_, &finer);
    const MeshCheck check =
        check_mesh(*finer_, result, runs, finer, goes_on_, observers(), progress());
    runs_ = before;
    return check;
  }

  StudyResult make_runs(const StudyPlan& plan, const ChosenStudy& chosen) {
    const InterruptGuard between_runs;
    StudyResult result =
        run_study(plan, *inputs_.mesh, observers(), progress(), memory(), arguments_.jobs);
    result.target = inputs_.requests.target;
    result.findings = chosen.findings;
    result.plan = chosen.plan;
    if (result.plan) result.plan->digest = digest_;
    result.remarks.insert(result.remarks.begin(), chosen.choice.remarks.begin(),
                          chosen.choice.remarks.end());
    if (finer_) result.mesh_check = check_finer_mesh(result);
    return result;
  }

  // The observers of a run that begins.
  ObserverFactory observers() {
    return [this](const std::string& run) {
      // Everything has been checked before this, so that a mistake does not delete the results of an
      // earlier study.
      if (made_.empty() && arguments_.fresh && remove_study(inputs_.directory) &&
          !arguments_.view.quiet) {
        print_note(
            fmt::format("{}: the results of an earlier study were deleted", inputs_.directory));
      }
      made_.insert(run);
      folder().begin_run(run, inputs_.name);
      std::vector<std::unique_ptr<Observer>> result;
      auto recorder = std::make_unique<RunRecorder>(
          folder().path(run), folder().has_frames(run) ? inputs_.scene.output.every : 0);
      recorder->set_stop_code(&InterruptGuard::exit_code);
      result.push_back(std::move(recorder));
      result.push_back(std::make_unique<InterruptGuard>());
      // Bars of several runs would overwrite each other.
      if (!arguments_.view.quiet && has_bars_) {
        result.push_back(std::make_unique<ProgressBar>(label_));
      }
      return result;
    };
  }

  StudyProgress progress() {
    return [this](std::size_t index, std::size_t count, const PlannedRun& run) {
      // This comes after the checks of the settings, whose message is then the only one.
      if (!has_told_of_blas_ && is_implicit(run.integrator)) {
        has_told_of_blas_ = true;
        if (const std::string warning = blas_warning(); !warning.empty()) print_warning(warning);
      }
      label_ = fmt::format("[{}] {} h = {:.4g} s",
                           runs_ == nullptr ? "trial" : fmt::format("{}/{}", index + 1, count),
                           run_text(frame_, run), run.step);
      if (!arguments_.view.quiet && !has_bars_) print_progress(label_ + "\n");
    };
  }

  int write(const StudyPlan& plan, StudyResult result, const std::vector<std::string>& frames) {
    const std::string& directory = inputs_.directory;
    const bool is_quiet = arguments_.view.quiet;
    if (goes_on_ && !is_quiet) {
      const auto kept =
          std::count_if(plan.runs.begin(), plan.runs.end(), [&](const PlannedRun& run) {
            return !run.is_left_out && !made_.contains(run.directory);
          });
      print_note(made_.empty()
                     ? fmt::format("{}: the study was complete, and no run was made", directory)
                     : fmt::format("{}: {} of {} runs were kept", directory, kept,
                                   plan.runs.size() - result.left_out));
    }
    const bool is_stopped = result.is_interrupted || InterruptGuard::interrupted();
    const FinishedStudy study{std::move(result),
                              inputs_.name,
                              directory,
                              {command_line(), utc_now(), study_plan_json(plan, digests_)}};
    const std::string why_no_plots =
        write_study_files(study, directory, arguments_.drawing, is_stopped, old_plots_);
    print_study(study, arguments_.view, study_json(study.result, study.scene, study.provenance),
                why_no_plots.empty(), frames);
    if (!arguments_.drawing.is_left_out && !why_no_plots.empty()) {
      if (!is_stopped) {
        print_warning("plots are missing: " + why_no_plots);
      } else if (!is_quiet) {
        print_note(
            "the plots were not drawn, because the study was interrupted: the same command makes "
            "the runs that are missing, and draws them");
      }
    }
    return is_stopped ? InterruptGuard::exit_code() : 0;
  }

  const StudyArguments& arguments_;
  StudyInputs inputs_;
  const StudyPlan frame_;             // without runs
  std::optional<StudyPlan> finer_{};  // with --mesh-check
  const bool goes_on_;                // from an earlier study in the directory
  const std::vector<std::string> old_plots_;
  const RunDigests digests_;
  const std::string digest_;  // of what the choice of steps depends on
  StudyFolder trials_;
  StudyFolder* runs_ = nullptr;  // once there is a plan
  std::optional<DirectoryLock> lock_;
  std::set<std::string> made_;
  const bool has_bars_;
  bool has_told_of_blas_;
  std::string label_;
};

}  // namespace

void add_study_command(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand(
      "study",
      "Compare integrators, step sizes and solvers on one scene. A run that becomes unstable is a "
      "result, not an error.");
  const std::shared_ptr<const StudyArguments> arguments = add_study_options(*command);
  add_study_diff_command(*command, exit_code);
  add_study_open_command(*command, exit_code);
  add_study_merge_command(*command, exit_code);
  command->callback([arguments, command, &exit_code] {
    if (!command->get_subcommands().empty()) return;
    if (command->get_option("scene")->count() == 0) throw CLI::RequiredError("scene");
    exit_code = Study(*arguments).make();
  });
}

}  // namespace tetraction
