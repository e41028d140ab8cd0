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
#include "cli/study_arguments.h"
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
  settings.variants = read_variants(arguments.scene, arguments.overrides, arguments.vary);
  settings.reference_step = arguments.reference_step;
  settings.reference_kind = reference_kind_from_string(arguments.reference);
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

// The number of steps of a run. Round-off makes no further one.
double step_count(const StudyPlan& plan, const PlannedRun& run) {
  return std::ceil(plan.end / run.step * (1.0 - 1e-9));
}

// What the reference is, and how many steps it takes.
std::string of_reference(const StudyPlan& plan) {
  const PlannedReference& reference = plan.references.front();
  const auto count = [&](const PlannedRun& run) { return step_count(plan, run); };
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

// The name of a run in messages.
std::string run_text(const StudyPlan& plan, const PlannedRun& run) {
  const std::string& variant = plan.variants[run.variant].name;
  return fmt::format("{}{}{}{}", to_string(run.integrator), run.compares_solver ? " " : "",
                     run.compares_solver ? run.solver : "",
                     variant.empty() ? "" : " (" + variant + ")");
}

// The runs of a plan with the times that they take, of which the first steps tell.
std::string text_of_plan(const StudyPlan& plan, const TetMesh& mesh, const StudyMemory& memory) {
  std::vector<PlanLine> lines;
  for (const PlannedRun& run : plan.runs) {
    PlanLine line{run_text(plan, run), run.step};
    if (run.role == StudyRole::kTrial) line.run += " (trial)";
    if (run.role == StudyRole::kReference) line.run += " (reference)";
    line.steps = static_cast<Index>(step_count(plan, run));
    line.is_kept = memory.kept && memory.kept(run);
    if (!line.is_kept) line.seconds = estimated_seconds(plan, run, mesh);
    lines.push_back(std::move(line));
  }
  return plan_text(lines);
}

int study(const StudyArguments& arguments) {
  const StudyRequests requests = study_requests(arguments);
  StudySettings settings = read_settings(arguments, requests);
  const bool names_frames = !arguments.frames.empty() && arguments.frames.front() != "all" &&
                            arguments.frames.front() != "none";
  if (names_frames && chooses_steps(requests)) {
    throw InputError(
        "--frames names runs, but the steps are not chosen yet: give --steps, or write --frames "
        "all or none.");
  }
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
  const StudyPlan frame = begin_plan(scene, mesh, settings);
  const bool goes_on = !arguments.fresh && holds_study(directory);
  std::optional<DirectoryLock> lock;
  const auto begin = [&] {
    if (lock) return;
    make_output_directory(directory);
    lock.emplace(directory);
  };
  const std::vector<std::string> old_plots = plots_of_study(directory);
  const RunDigests digests(frame, mesh);
  StudyFolder trials(directory, frame, mesh, digests, {});
  StudyFolder* folder = &trials;
  std::set<std::string> made;

  const bool has_bars = arguments.jobs == 1 && ProgressBar::possible();
  std::string label;
  bool has_told_of_blas = arguments.quiet;
  const auto observers = [&](const std::string& run) {
    // Everything has been checked before this, so that a mistake does not delete the results of an
    // earlier study.
    if (made.empty() && arguments.fresh && remove_study(directory) && !arguments.quiet) {
      print_note(fmt::format("{}: the results of an earlier study were deleted", directory));
    }
    made.insert(run);
    folder->begin_run(run, name);
    std::vector<std::unique_ptr<Observer>> result;
    auto recorder = std::make_unique<RunRecorder>(folder->path(run),
                                                  folder->has_frames(run) ? scene.output.every : 0);
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
    if (!has_told_of_blas && is_implicit(run.integrator)) {
      has_told_of_blas = true;
      if (const std::string warning = blas_warning(); !warning.empty()) print_warning(warning);
    }
    label = fmt::format("[{}] {} h = {:.4g} s",
                        folder == &trials ? "trial" : fmt::format("{}/{}", index + 1, count),
                        run_text(frame, run), run.step);
    if (!arguments.quiet && !has_bars) print_progress(label + "\n");
  };
  const ChosenStudy chosen = [&] {
    const InterruptGuard between_runs;
    StudyPlan trial = frame;
    return choose_study(frame, mesh, settings, requests, [&](const PlannedRun& run) {
      trial.runs = {run};
      check_folder_of_study(trial, directory);
      StudyMemory memory = trials.memory(goes_on || !made.empty());
      if (!arguments.plan) {
        begin();
        return make_tracked_run(frame, run, mesh, observers, progress, memory);
      }
      memory.made = nullptr;  // nothing is written
      return make_tracked_run(
          frame, run, mesh,
          [](const std::string&) {
            std::vector<std::unique_ptr<Observer>> result;
            result.push_back(std::make_unique<InterruptGuard>());
            return result;
          },
          {}, memory);
    });
  }();
  if (chosen.choice.is_stopped) {
    print_note(
        "the study was interrupted while its steps were chosen: the same command goes on there");
    return InterruptGuard::exit_code();
  }
  const StudyPlan plan = plan_study(scene, mesh, chosen.settings);
  check_folder_of_study(plan, directory);
  std::optional<StudyPlan> finer;
  if (arguments.mesh_check) {
    finer = mesh_check_plan(plan, mesh);
    check_folder_of_study(*finer, directory);
  }
  const std::vector<std::string> frames = runs_with_frames(arguments.frames, plan);
  StudyFolder runs(directory, plan, mesh, digests, frames);
  folder = &runs;
  StudyMemory memory = runs.memory(goes_on || !made.empty());
  memory.is_stopped = &InterruptGuard::interrupted;
  if (arguments.plan) {
    for (const std::string& remark : chosen.choice.remarks) print_note(remark);
    write_result(text_of_plan(plan, mesh, goes_on ? memory : StudyMemory()));
    if (finer) {
      StudyPlan longest = *finer;
      const auto by_step = [](const PlannedRun& a, const PlannedRun& b) { return a.step < b.step; };
      longest.runs = {*std::min_element(finer->runs.begin(), finer->runs.end(), by_step)};
      write_result("at most, on the finer mesh:\n" +
                   text_of_plan(longest, *finer->variants.front().mesh, {}));
    }
    return 0;
  }
  begin();
  if (goes_on && !arguments.quiet) {
    std::set<std::string> lost = lost_runs(directory);
    const std::set<std::string> asked = run_names(plan);
    std::erase_if(lost, [&](const std::string& run) { return !asked.contains(run); });
    tell_of_lost_runs(directory, lost);
  }
  if (!arguments.quiet) {
    print_note(of_reference(plan));
    if (chosen.choice.seconds > 0.0) {
      print_note(fmt::format("the steps were chosen; the runs that are left take about {:.2g} s",
                             chosen.choice.seconds));
    }
    if (const std::string note = of_jobs(arguments.jobs); !note.empty()) print_note(note);
  }
  const StudyResult result = [&] {
    const InterruptGuard between_runs;
    StudyResult compared = run_study(plan, mesh, observers, progress, memory, arguments.jobs);
    compared.target = requests.target;
    compared.findings = chosen.findings;
    compared.remarks.insert(compared.remarks.begin(), chosen.choice.remarks.begin(),
                            chosen.choice.remarks.end());
    if (finer) {
      const RunDigests digests_of_finer(*finer, *finer->variants.front().mesh);
      StudyFolder fine_runs(directory, *finer, *finer->variants.front().mesh, digests_of_finer, {});
      folder = &fine_runs;
      compared.mesh_check =
          check_mesh(*finer, compared, memory, fine_runs, goes_on, observers, progress);
      folder = &runs;
    }
    return compared;
  }();

  if (goes_on && !arguments.quiet) {
    const auto kept = std::count_if(plan.runs.begin(), plan.runs.end(), [&](const PlannedRun& run) {
      return !made.contains(run.directory);
    });
    print_note(made.empty()
                   ? fmt::format("{}: the study was complete, and no run was made", directory)
                   : fmt::format("{}: {} of {} runs were kept", directory, kept, plan.runs.size()));
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
        "runs that are missing, and draws them");
  }
  return stopped ? InterruptGuard::exit_code() : 0;
}

}  // namespace

void add_study_command(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand(
      "study",
      "Compare integrators, step sizes and solvers on one scene. A run that becomes unstable is a "
      "result, not an error.");
  const std::shared_ptr<const StudyArguments> arguments = add_study_options(*command);
  add_study_diff_command(*command, exit_code);
  command->callback([arguments, command, &exit_code] {
    if (command->got_subcommand("diff")) return;
    if (command->get_option("scene")->count() == 0) throw CLI::RequiredError("scene");
    exit_code = study(*arguments);
  });
}

}  // namespace tetraction
