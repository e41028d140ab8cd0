#include "recorded_session.h"

#include <fmt/format.h>

#include <chrono>
#include <utility>

#include "cli/console.h"
#include "cli/interrupt_guard.h"
#include "cli/progress_bar.h"
#include "cli/scene_source.h"
#include "commands.h"
#include "io/results/result_folders.h"
#include "parallel_run.h"
#include "resume.h"
#include "tetraction/core/blas.h"
#include "tetraction/io/initial_fields.h"
#include "tetraction/io/run_recorder.h"
#include "tetraction/io/scene_reader.h"

namespace tetraction {

void add_session_options(CLI::App& command, SessionArguments& arguments) {
  command.add_option("scene", arguments.scene, "Scene file (TOML)")->required();
  command.add_option("--out", arguments.out, "Output directory (default: the scene's)")
      ->check(not_empty("it names no directory"));
  command
      .add_option("--set", arguments.overrides,
                  "KEY=VALUE: overrides a scene key, e.g. time.step=1e-4")
      ->take_all()
      ->allow_extra_args(false);
  command.add_flag("--quiet", arguments.quiet, "Only warnings and errors");
  command.add_flag("--json", arguments.json, "Print summary.json to stdout");
}

void print_remarks(const Session& session, std::size_t told) {
  for (std::size_t i = told; i < session.warnings().size(); ++i) {
    print_warning(session.warnings()[i]);
  }
  for (const AppliedEdit& edit : session.edits()) {
    if (!edit.warning.empty()) {
      print_warning(fmt::format("after the event at {:.6g} s: {}", edit.at, edit.warning));
    }
  }
  if (!session.message().empty()) print_message(session.message());
}

int run_recorded(const SessionArguments& arguments, const SessionMaker& make_session,
                 const char* label, const OutcomePrinter& print_outcome) {
  if (arguments.may_be_parallel && launched_processes() > 1) {
    return run_parallel(arguments, label, print_outcome);
  }
  const Scene scene = read_scene(arguments.scene, arguments.overrides);
  if (arguments.may_be_parallel && scene.solver.engine == "petsc") {
    return run_parallel(arguments, label, print_outcome);
  }
  const std::string directory = output_directory(scene, arguments.out, arguments.overrides);
  check_folder_of_run(scene, directory);
  const auto start = std::chrono::steady_clock::now();
  std::vector<std::string> unused;
  TetMesh mesh = read_scene_mesh(scene, unused);
  const std::chrono::duration<double> mesh_time = std::chrono::steady_clock::now() - start;
  if (!arguments.quiet) {
    if (const std::string remarks = mesh_remarks(mesh, unused); !remarks.empty())
      print_note(remarks);
    if (const std::string remarks = damping_remarks(scene); !remarks.empty()) print_note(remarks);
  }
  RunRecorder recorder(directory, scene.output.every);
  recorder.lock_directory();
  recorder.set_stop_code(&InterruptGuard::exit_code);
  const std::unique_ptr<Session> made = make_session(scene, std::move(mesh));
  Session& session = *made;
  session.add_mesh_time(mesh_time.count());
  // A slow BLAS affects only the time. --quiet leaves this warning out; summary.json has it.
  const std::string slow_blas = arguments.quiet ? blas_warning() : "";
  for (const std::string& warning : session.warnings()) {
    if (warning != slow_blas || slow_blas.empty()) print_warning(warning);
  }
  if (arguments.has_checkpoints) recorder.keep_checkpoints(scene.output.checkpoint_every);
  if (arguments.resume && resume_run(session, recorder, directory, arguments.force,
                                     arguments.quiet) == Resumption::kComplete) {
    if (arguments.json) write_json_result(read_summary(directory));
    return 0;
  }
  const std::size_t told = session.warnings().size();

  InterruptGuard interrupt;
  ProgressBar bar(label);
  std::vector<Observer*> observers{&recorder, &interrupt};
  if (!arguments.quiet && ProgressBar::possible()) observers.push_back(&bar);
  const RunStatus status = session.run(observers);

  if (arguments.json) {
    write_json_result(recorder.summary());
  } else if (!arguments.quiet) {
    print_outcome(session, directory);
  }
  print_remarks(session, told);
  if (status == RunStatus::kCancelled) return InterruptGuard::exit_code();
  return tetraction::exit_code(status);
}

}  // namespace tetraction
