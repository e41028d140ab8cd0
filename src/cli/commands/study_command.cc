// tetraction study: the same motion by several integrators at several steps.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "cli/command_line.h"
#include "cli/console.h"
#include "cli/interrupt_guard.h"
#include "cli/program_failure.h"
#include "cli/progress_bar.h"
#include "cli/scene_source.h"
#include "cli/study_drawing.h"
#include "cli/study_frames.h"
#include "cli/study_variants.h"
#include "commands.h"
#include "io/results/directory_lock.h"
#include "io/results/result_folders.h"
#include "io/study/study_answer.h"
#include "io/study/study_folder.h"
#include "io/study/study_page.h"
#include "io/text/output_file.h"
#include "simulation/scene/parallel_features.h"
#include "tetraction/core/blas.h"
#include "tetraction/core/error.h"
#include "tetraction/core/parallel.h"
#include "tetraction/core/provenance.h"
#include "tetraction/dynamics/steppers/integrator.h"
#include "tetraction/io/initial_fields.h"
#include "tetraction/io/run_recorder.h"
#include "tetraction/io/scene_reader.h"
#include "tetraction/io/study_writer.h"
#include "tetraction/simulation/scene_objects.h"

namespace tetraction {
namespace {

struct StudyArguments {
  std::string scene;
  std::string out;
  std::vector<std::string> overrides;
  std::vector<std::string> integrators;
  std::vector<double> steps;
  std::optional<double> reference_step;
  std::string reference_integrator = "midpoint";
  std::string reference = "run";
  std::vector<std::string> vary;
  std::vector<std::string> also_solvers;
  std::vector<std::string> frames;
  std::string error;
  int jobs = 1;
  bool quiet = false;
  bool json = false;
  bool no_plots = false;
  StudyDrawing drawing;
  bool resume = false;
  bool all = false;
  std::string table;
  bool fresh = false;
};

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

// probe.NAME: the name. position: empty.
std::string read_error_probe(const std::string& text) {
  const std::string prefix = "probe.";
  if (text.empty() || text == "position") return {};
  if (text.rfind(prefix, 0) == 0 && text.size() > prefix.size()) return text.substr(prefix.size());
  throw InputError(
      fmt::format("--error {}: write --error probe.NAME with the name of a [[probe]] of the scene, "
                  "or --error position.",
                  text));
}

StudySettings read_settings(const StudyArguments& arguments) {
  StudySettings settings;
  settings.variants = read_variants(arguments.scene, arguments.overrides, arguments.vary);
  for (const std::string& name : arguments.integrators) {
    const Integrator integrator = integrator_from_string(name);
    if (std::count(settings.integrators.begin(), settings.integrators.end(), integrator) > 0) {
      throw InputError(fmt::format("--integrators: {} is there twice.", name));
    }
    settings.integrators.push_back(integrator);
  }
  settings.steps = arguments.steps;
  settings.reference_step = arguments.reference_step;
  settings.reference_integrator = integrator_from_string(arguments.reference_integrator);
  settings.reference_kind = reference_kind_from_string(arguments.reference);
  for (const std::string& text : arguments.also_solvers) {
    settings.solver_comparisons.push_back(read_comparison(text));
  }
  settings.error_probe = read_error_probe(arguments.error);
  return settings;
}

// Whether the study has an implicit run.
bool has_implicit_runs(const StudyPlan& plan) {
  return std::any_of(plan.runs.begin(), plan.runs.end(),
                     [](const PlannedRun& run) { return is_implicit(run.integrator); });
}

// What the reference is, and how many steps it takes.
std::string of_reference(const StudyPlan& plan) {
  const PlannedReference& reference = plan.references.front();
  const auto count = [&](const PlannedRun& run) {
    return std::ceil(plan.end / run.step * (1.0 - 1e-9));
  };
  const std::string name = plan.references.size() == 1
                               ? "reference"
                               : fmt::format("each of the {} references", plan.references.size());
  const PlannedRun& finest = plan.finest_run(reference);
  const std::string rule = to_string(finest.integrator);
  if (reference.runs.size() == 1) {
    std::string second;
    for (const PlannedRun& run : plan.runs) {
      if (run.role != StudyRole::kReference || run.variant != finest.variant ||
          run.step == finest.step) {
        continue;
      }
      second = fmt::format("; and one with {:.4g} s for its error, which makes {:.9g} steps",
                           run.step, count(run));
    }
    return fmt::format("{}: {} with steps of {:.4g} s, which makes {:.9g} steps{}", name, rule,
                       finest.step, count(finest), second);
  }
  std::vector<std::string> steps;
  double sum = 0.0;
  for (const std::size_t i : reference.runs) {
    steps.push_back(fmt::format("{:.4g}", plan.runs[i].step));
    sum += count(plan.runs[i]);
  }
  return fmt::format(
      "{}: Richardson extrapolation of {} with steps of {} s, which makes {:.9g} steps together",
      name, rule, fmt::join(steps, ", "), sum);
}

// What becomes of the wall times of runs that are made at the same time.
std::string of_jobs(int jobs) {
  const int threads = thread_count();
  const int cores = this_machine().cores;
  if (jobs * threads <= cores) return {};
  if (jobs == 1) {
    return fmt::format(
        "{} threads are more than the {} core{} of this machine: the wall times of the runs do not "
        "count. With --threads {} they would.",
        threads, cores, cores == 1 ? "" : "s", cores);
  }
  return fmt::format(
      "{} runs at a time with {} thread{} each need more than the {} core{} of this machine: the "
      "wall times of runs that share them do not count{}",
      jobs, threads, threads == 1 ? "" : "s", cores, cores == 1 ? "" : "s",
      jobs <= cores ? fmt::format(". With --threads {} they would.", cores / jobs) : "");
}

// The runs that reached the end.
std::set<std::string> finished_runs(const StudyResult& result) {
  std::set<std::string> names;
  for (const StudyRow& row : result.rows) {
    if (row.status == RunStatus::kFinished) names.insert(row.directory);
  }
  return names;
}

// How to see the motion of the first of the runs with frames that reached the end, or else of one that did not.
std::string advice_to_look(const StudyResult& result, const std::string& directory,
                           std::vector<std::string> frames) {
  const std::set<std::string> finished = finished_runs(result);
  std::stable_partition(frames.begin(), frames.end(),
                        [&](const std::string& run) { return finished.contains(run); });
  for (const std::string& run : frames) {
    const std::string folder = fmt::format("{}/{}", directory, run);
    if (!std::filesystem::exists(folder + "/frames.pvd")) continue;
    return fmt::format(
        "to see the motion{1}: open {0}/frames.pvd in ParaView, or: tetraction view {0}\n", folder,
        finished.contains(run) ? "" : " of a run that did not reach the end");
  }
  return {};
}

// Says which runs were complete and have lost their folders since.
void tell_of_lost_runs(const std::string& directory, const std::set<std::string>& lost) {
  if (lost.empty()) return;
  constexpr std::size_t kMost = 5;
  std::vector<std::string> some;
  for (const std::string& run : lost) {
    if (some.size() < kMost) some.push_back(run);
  }
  const std::string names =
      fmt::format("{}{}", fmt::join(some, ", "), lost.size() > kMost ? ", …" : "");
  print_note(
      lost.size() == 1
          ? fmt::format("{}: the folder of a complete run is no longer there, and the run is "
                        "made again: {}",
                        directory, names)
          : fmt::format("{}: the folders of {} complete runs are no longer there, and the "
                        "runs are made again: {}",
                        directory, lost.size(), names));
}

int study(const StudyArguments& arguments) {
  StudySettings settings = read_settings(arguments);
  const Scene scene = settings.variants.empty() ? read_scene(arguments.scene, arguments.overrides)
                                                : settings.variants.front().scene;
  const std::string directory = output_directory(scene, arguments.out, arguments.overrides);
  const AnswerOptions answer{arguments.table.empty() ? AnswerFormat::kTerminal
                                                     : answer_format_from_string(arguments.table)};
  require_local_engine(scene);
  const std::string name = std::filesystem::path(arguments.scene).stem().string();
  check_folder_of_study(scene, directory);
  if (!arguments.fresh) refuse_other_study(directory, name);
  for (const StudyVariant& variant : settings.variants) require_local_engine(variant.scene);
  std::vector<std::string> unused;
  const std::shared_ptr<const TetMesh> first_mesh =
      settings.variants.empty() ? std::make_shared<const TetMesh>(read_scene_mesh(scene, unused))
                                : read_variant_meshes(settings.variants);
  const TetMesh& mesh = *first_mesh;
  if (!arguments.quiet) {
    std::vector<std::string> told;
    const auto tell = [&](const TetMesh& of) {
      const std::string remarks = mesh_remarks(of, unused);
      if (remarks.empty() || std::count(told.begin(), told.end(), remarks) > 0) return;
      told.push_back(remarks);
      print_note(remarks);
    };
    tell(mesh);
    const TetMesh* last = &mesh;
    for (const StudyVariant& variant : settings.variants) {
      if (variant.mesh.get() != last) tell(*variant.mesh);
      last = variant.mesh.get();
    }
  }
  for (const StudyVariant& variant : settings.variants) {
    try {
      check_events(variant.scene, *make_system(variant.scene, *variant.mesh));
    } catch (const InputError& error) {
      throw InputError(in_variant(variant, error.what()));
    }
  }
  const StudyPlan plan = plan_study(scene, mesh, settings);
  check_folder_of_study(plan, directory);
  const std::vector<std::string> frames = runs_with_frames(arguments.frames, plan);
  if (!arguments.quiet) {
    print_note(of_reference(plan));
    if (const std::string note = of_jobs(arguments.jobs); !note.empty()) print_note(note);
  }
  make_output_directory(directory);
  const DirectoryLock lock(directory);

  const bool goes_on = !arguments.fresh && holds_study(directory);
  if (goes_on && !arguments.quiet) {
    std::set<std::string> lost = lost_runs(directory);
    const std::set<std::string> asked = run_names(plan);
    std::erase_if(lost, [&](const std::string& run) { return !asked.contains(run); });
    tell_of_lost_runs(directory, lost);
  }
  const std::vector<std::string> old_plots = plots_of_study(directory);
  StudyFolder runs(directory, plan, mesh, frames);

  const bool has_bars = arguments.jobs == 1 && ProgressBar::possible();
  std::string label;
  std::size_t made = 0;
  const auto observers = [&](const std::string& run) {
    // Everything has been checked before this, so that a mistake does not delete the results of an
    // earlier study.
    if (made++ == 0 && arguments.fresh && remove_study(directory) && !arguments.quiet) {
      print_note(fmt::format("{}: the results of an earlier study were deleted", directory));
    }
    runs.begin_run(run, name);
    std::vector<std::unique_ptr<Observer>> result;
    auto recorder = std::make_unique<RunRecorder>(runs.path(run),
                                                  runs.has_frames(run) ? scene.output.every : 0);
    recorder->set_stop_code(&InterruptGuard::exit_code);
    result.push_back(std::move(recorder));
    result.push_back(std::make_unique<InterruptGuard>());
    // Bars of several runs would overwrite each other.
    if (!arguments.quiet && has_bars) {
      result.push_back(std::make_unique<ProgressBar>(label));
    }
    return result;
  };
  const auto progress = [&](std::size_t index, std::size_t count, const PlannedRun& run) {
    // This comes after the checks of the settings, whose message is then the only one.
    if (made == 0 && label.empty() && !arguments.quiet && has_implicit_runs(plan)) {
      if (const std::string warning = blas_warning(); !warning.empty()) print_warning(warning);
    }
    const std::string& variant = plan.variants[run.variant].name;
    label =
        fmt::format("[{}/{}] {}{}{}{} h = {:.4g} s", index + 1, count, to_string(run.integrator),
                    run.compares_solver ? " " : "", run.compares_solver ? run.solver : "",
                    variant.empty() ? "" : " (" + variant + ")", run.step);
    if (!arguments.quiet && !has_bars) print_progress(label + "\n");
  };
  const StudyResult result = [&] {
    const InterruptGuard between_runs;
    return run_study(plan, mesh, observers, progress, runs.memory(goes_on), arguments.jobs);
  }();

  if (goes_on && !arguments.quiet) {
    const std::size_t count = plan.runs.size();
    print_note(made == 0 ? fmt::format("{}: the study was complete, and no run was made", directory)
                         : fmt::format("{}: {} of {} runs were kept", directory,
                                       count - std::min(made, count), count));
  }
  const StudyProvenance provenance{command_line(), utc_now()};
  write_study(result, name, directory, provenance);
  // They would be those of other runs.
  for (const std::string& plot : old_plots) remove_output(plot);
  for (const std::string& remark : result.remarks) print_note(remark);
  // Whoever interrupts a study does not want to wait for pictures of a part of it.
  const bool stopped = result.is_interrupted || InterruptGuard::interrupted();
  const bool plots = !arguments.no_plots && !stopped;
  const std::string missing = plots ? draw_plots(directory, arguments.drawing) : "";
  const bool plotted = plots && missing.empty();
  write_study_page(result, name, directory, provenance,
                   plotted   ? ""
                   : stopped ? "The plots were not drawn, because the study was interrupted."
                   : arguments.no_plots ? "The plots were left out with --no-plots."
                                        : "The plots were not drawn: " + missing + ".");
  if (arguments.json) {
    write_json_result(study_json(result, name, provenance));
  } else if (!arguments.table.empty()) {
    write_result(answer_text(result, answer));
  } else if (!arguments.quiet) {
    write_result(arguments.all ? study_table(result) : answer_text(result, answer));
    print_result("\nresults: {0}/study.html, {0}/study.csv, {0}/study.json{1}\n{2}", directory,
                 plotted ? ", plots (*.png, *.svg, *.pdf)" : "",
                 advice_to_look(result, directory, frames));
  }
  if (plots && !plotted) {
    print_warning("the plots were not drawn: " + missing);
  } else if (stopped && !arguments.no_plots && !arguments.quiet) {
    print_note(
        "the plots were not drawn, because the study was interrupted: the same command makes the "
        "runs "
        "that are missing, and draws them");
  }
  return stopped ? InterruptGuard::exit_code() : 0;
}

}  // namespace

void add_study_command(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<StudyArguments>();
  CLI::App* command = app.add_subcommand(
      "study",
      "Compare integrators, step sizes and solvers on one scene. A run that becomes unstable is a "
      "result, not an error.");
  command->add_option("scene", arguments->scene,
                      "Scene file (TOML). Write ./diff for a file whose name is diff.");
  command
      ->add_option(
          "--integrators", arguments->integrators,
          fmt::format("Comma-separated: {} (default: all)", fmt::join(integrator_names(), ",")))
      ->delimiter(',')
      ->allow_extra_args(false);
  command
      ->add_option("--steps", arguments->steps,
                   "Comma-separated step sizes in s (default: 1/4, 1/2, 2, 8, 32 times the "
                   "stability limit)")
      ->delimiter(',')
      ->allow_extra_args(false);
  command
      ->add_option("--reference", arguments->reference,
                   "run: the reference is one run (default). richardson: it is extrapolated from "
                   "runs with twice, once and half the reference step, and its error is estimated.")
      ->check(not_empty("it names no kind of reference"));
  command->add_option("--reference-step", arguments->reference_step,
                      "Step of the reference run (default: the finest of the study)");
  command->add_option("--reference-integrator", arguments->reference_integrator,
                      "Integrator of the reference run (default: midpoint)");
  command
      ->add_option(
          "--vary", arguments->vary,
          "KEY=V1,V2,...: makes the whole study with each value of a scene key, e.g. "
          "fix.0.mode=exact,penalty. Several --vary give all combinations. Each variant is "
          "compared with a reference of its own; those that differ in solver keys only share one.")
      ->check(not_empty("it names no key"))
      ->take_all()
      ->allow_extra_args(false);
  command
      ->add_option("--also-solver", arguments->also_solvers,
                   "Comma-separated SOLVER@STEP, e.g. ceres@1e-3: each adds a run with another "
                   "solver than the scene's and the first implicit integrator of the study")
      ->delimiter(',')
      ->allow_extra_args(false);
  command
      ->add_option(
          "--frames", arguments->frames,
          "Runs that write frames for ParaView and the viewer: all, none, or a comma-separated "
          "list "
          "of their folders, e.g. midpoint-0.01 (default: the scene's integrator at the step "
          "nearest to the scene's)")
      ->delimiter(',')
      ->allow_extra_args(false);
  command
      ->add_option("--error", arguments->error,
                   "probe.NAME: orders and plots use the error of this probe over time instead of "
                   "that of the final positions")
      ->check(not_empty("it names no error"));
  command->add_option("--out", arguments->out, "Output directory (default: the scene's)")
      ->check(not_empty("it names no directory"));
  command->add_option("--set", arguments->overrides, "KEY=VALUE: overrides a scene key")
      ->take_all()
      ->allow_extra_args(false);
  command
      ->add_option(
          "--jobs", arguments->jobs,
          "Number of runs that are made at the same time (default: 1), each with --threads "
          "threads. Wall times count only where the machine has a core for each thread of "
          "all these runs.")
      ->check(CLI::Range(1, 1024));
  command->add_flag(
      "--fresh", arguments->fresh,
      "Delete what an earlier study has left in the directory, and make all runs anew "
      "(default: runs that compute the same are kept)");
  command->add_flag("--resume", arguments->resume, "Nothing: runs are always kept without --fresh")
      ->excludes("--fresh");
  command->add_flag("--all", arguments->all, "Print the table of all runs instead of the answer");
  command->add_option("--table", arguments->table,
                      "markdown or latex: print nothing but the table of the answer for a paper");
  command->add_flag("--no-plots", arguments->no_plots, "Do not draw plots");
  command->add_option("--title", arguments->drawing.title, "Title of the plots (default: none)");
  command->add_option("--style", arguments->drawing.style, "Style file of matplotlib for the plots")
      ->check(CLI::ExistingFile);
  command->add_option("--width", arguments->drawing.width, "Width of the plots: 85 or 170 mm")
      ->check(CLI::IsMember({85, 170}));
  command->add_flag("--quiet", arguments->quiet, "Only warnings and errors");
  command->add_flag("--json", arguments->json, "Print study.json to stdout");
  add_study_diff_command(*command, exit_code);
  command->callback([arguments, command, &exit_code] {
    if (command->got_subcommand("diff")) return;
    if (command->get_option("scene")->count() == 0) throw CLI::RequiredError("scene");
    exit_code = study(*arguments);
  });
}

}  // namespace tetraction
