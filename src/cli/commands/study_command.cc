// tetraction study: the same motion by several integrators at several steps.
#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
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
#include "io/results/result_folders.h"
#include "io/study/study_maker.h"
#include "tetraction/core/blas.h"
#include "tetraction/core/error.h"
#include "tetraction/dynamics/steppers/integrator.h"
#include "tetraction/io/initial_fields.h"
#include "tetraction/io/scene_reader.h"

namespace tetraction {
namespace {

StudyInputs read_inputs(const StudyArguments& arguments) {
  check_view(arguments.view);
  const auto read = [&](const std::vector<std::string>& overrides) {
    return read_scene(arguments.scene, overrides);
  };
  StudyInputs inputs = read_study_inputs(arguments.study, read, arguments.overrides);
  const bool names_frames = !arguments.frames.empty() && arguments.frames.front() != "all" &&
                            arguments.frames.front() != "none";
  if (names_frames && chooses_steps(inputs.requests)) {
    throw InputError(
        "--frames names runs, but the steps are not chosen yet: give --steps, or write --frames "
        "all or none.");
  }
  inputs.name = std::filesystem::path(arguments.scene).stem().string();
  inputs.directory = output_directory(inputs.scene, arguments.out, arguments.overrides);
  std::vector<std::string> told;
  const ReadMesh read_mesh = [&](const Scene& scene) {
    std::vector<std::string> unused;
    TetMesh mesh = read_scene_mesh(scene, unused);
    const std::string remarks = mesh_remarks(mesh, unused);
    if (!arguments.view.quiet && !remarks.empty() &&
        std::count(told.begin(), told.end(), remarks) == 0) {
      told.push_back(remarks);
      print_note(remarks);
    }
    return mesh;
  };
  read_study_mesh(inputs, read_mesh);
  return inputs;
}

// What the terminal shows of a study.
class StudyCommand {
 public:
  explicit StudyCommand(const StudyArguments& arguments)
      : arguments_(arguments),
        inputs_(read_inputs(arguments)),
        maker_(inputs_, hooks()),
        has_bars_(arguments.study.jobs == 1 && ProgressBar::possible()),
        has_told_of_blas_(arguments.view.quiet) {}

  int make() {
    if (!choose()) {
      print_note(
          "the study was interrupted while its steps were chosen: the same command goes on there");
      return InterruptGuard::exit_code();
    }
    const std::vector<std::string> frames = runs_with_frames(arguments_.frames, maker_.plan());
    if (arguments_.study.plan) {
      for (const std::string& remark : maker_.choice().remarks) print_note(remark);
      write_result(text_of_plan(maker_.plan(), maker_.planned_times()));
      if (const auto check = maker_.planned_mesh_check()) {
        write_result("at most, on the finer mesh:\n" + text_of_plan(maker_.plan(), {*check}));
      }
      return 0;
    }
    if (!is_quiet()) tell_of_plan();
    return write(make_runs(frames), frames);
  }

 private:
  bool is_quiet() const { return arguments_.view.quiet; }

  bool choose() {
    const InterruptGuard between_runs;
    return maker_.choose();
  }

  StudyResult make_runs(const std::vector<std::string>& frames) {
    const InterruptGuard between_runs;
    return maker_.make(frames);
  }

  StudyHooks hooks() {
    StudyHooks hooks;
    hooks.progress = [this](std::size_t index, std::size_t count, const PlannedRun& run) {
      tell_of_run(index, count, run);
    };
    hooks.observe = [this](std::vector<std::unique_ptr<Observer>>& list) {
      list.push_back(std::make_unique<InterruptGuard>());
      // Bars of several runs would overwrite each other.
      if (!is_quiet() && has_bars_ && !arguments_.study.plan) {
        list.push_back(std::make_unique<ProgressBar>(label_));
      }
    };
    hooks.is_stopped = &InterruptGuard::interrupted;
    hooks.stop_code = &InterruptGuard::exit_code;
    hooks.tell = [this](const std::string& note) {
      if (!is_quiet()) print_note(note);
    };
    hooks.warn = [](const std::string& warning) { print_warning(warning); };
    return hooks;
  }

  void tell_of_run(std::size_t index, std::size_t count, const PlannedRun& run) {
    // This comes after the checks of the settings, whose message is then the only one.
    if (!has_told_of_blas_ && is_implicit(run.integrator)) {
      has_told_of_blas_ = true;
      if (const std::string warning = blas_warning(); !warning.empty()) print_warning(warning);
    }
    const std::string place =
        maker_.is_planned() ? fmt::format("{}/{}", index + 1, count) : std::string("trial");
    label_ = fmt::format("[{}] {} h = {:.4g} s", place, run_text(maker_.frame(), run), run.step);
    if (!is_quiet() && !has_bars_) print_progress(label_ + "\n");
  }

  void tell_of_plan() const {
    if (maker_.goes_on()) tell_of_lost_runs(inputs_.directory, maker_.plan());
    print_note(reference_message(maker_.plan()));
    if (const double seconds = maker_.choice().seconds; seconds > 0.0) {
      print_note(fmt::format("the steps were chosen; the runs that are left take about {:.2g} s",
                             seconds));
    }
    const std::string note = jobs_message(arguments_.study.jobs);
    if (!note.empty()) print_note(note);
  }

  int write(StudyResult result, const std::vector<std::string>& frames) {
    const bool is_stopped = result.is_interrupted || InterruptGuard::interrupted();
    const FinishedStudy study{std::move(result), inputs_.name, inputs_.directory,
                              maker_.provenance(command_line())};
    const std::string why_no_plots = write_study_files(study, study.directory, arguments_.drawing,
                                                       is_stopped, is_quiet(), maker_.old_plots());
    print_study(study, arguments_.view, study_json(study.result, study.scene, study.provenance),
                why_no_plots.empty(), frames);
    if (!arguments_.drawing.is_left_out && !why_no_plots.empty()) {
      if (!InterruptGuard::interrupted() && !is_stopped) {
        print_warning("plots are missing: " + why_no_plots);
      } else if (is_stopped && !is_quiet()) {
        print_note(
            "the plots were not drawn, because the study was interrupted: the same command makes "
            "the runs that are missing, and draws them");
      }
    }
    return is_stopped || InterruptGuard::interrupted() ? InterruptGuard::exit_code() : 0;
  }

  const StudyArguments& arguments_;
  const StudyInputs inputs_;
  StudyMaker maker_;
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
    exit_code = StudyCommand(*arguments).make();
  });
}

}  // namespace tetraction
