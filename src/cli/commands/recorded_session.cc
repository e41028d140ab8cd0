#include "recorded_session.h"

#include <fmt/format.h>

#include <chrono>
#include <cstddef>
#include <utility>

#include "cli/console.h"
#include "cli/interrupt_guard.h"
#include "cli/progress_bar.h"
#include "cli/scene_source.h"
#include "commands.h"
#include "io/results/result_folders.h"
#include "parallel_run.h"
#include "tetraction/core/blas.h"
#include "tetraction/io/initial_fields.h"
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

namespace {

// The warnings and messages of a session after its run. The first `told` warnings have been printed.
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

}  // namespace

SessionInputs session_inputs(const SessionArguments& arguments, Scene scene, bool reads_mesh) {
  SessionInputs inputs;
  inputs.scene = std::move(scene);
  inputs.directory = output_directory(inputs.scene, arguments.out, arguments.overrides);
  if (!reads_mesh) return inputs;
  check_folder_of_run(inputs.scene, inputs.directory);
  const auto start = std::chrono::steady_clock::now();
  inputs.mesh = read_scene_mesh(inputs.scene, inputs.unused);
  inputs.mesh_time =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return inputs;
}

void print_input_remarks(const SessionArguments& arguments, const SessionInputs& inputs) {
  if (arguments.quiet) return;
  for (const std::string& remarks :
       {mesh_remarks(inputs.mesh, inputs.unused), damping_remarks(inputs.scene)}) {
    if (!remarks.empty()) print_note(remarks);
  }
}

int record_session(Session& session, RunRecorder& recorder, const SessionArguments& arguments,
                   const SessionInputs& inputs, const RunControl& control, const char* label,
                   const OutcomePrinter& print_outcome) {
  session.add_mesh_time(inputs.mesh_time);
  // A slow BLAS affects only the time. --quiet leaves this warning out; summary.json has it.
  const std::string slow_blas = arguments.quiet ? blas_warning() : "";
  for (const std::string& warning : session.warnings()) {
    if (warning != slow_blas || slow_blas.empty()) print_warning(warning);
  }
  recorder.set_stop_code(control.stop_code);
  if (arguments.has_checkpoints) {
    recorder.keep_checkpoints(session.scene().output.checkpoint_every);
  }
  if (arguments.resume && resume_run(session, recorder, inputs.directory, arguments.quiet,
                                     control.find_resume_point) == Resumption::kComplete) {
    if (arguments.json) write_json_result(read_summary(inputs.directory));
    return 0;
  }
  const std::size_t told = session.warnings().size();
  ProgressBar bar(label);
  std::vector<Observer*> observers{&recorder, &control.interrupt};
  const MeshPart* part = session.system().part();
  const bool is_first = part == nullptr || part->rank() == 0;
  if (is_first && !arguments.quiet && ProgressBar::possible()) observers.push_back(&bar);
  const RunStatus status = session.run(observers);
  if (arguments.json) {
    write_json_result(recorder.summary());
  } else if (!arguments.quiet) {
    print_outcome(session, inputs.directory);
  }
  print_remarks(session, told);
  return status == RunStatus::kCancelled ? control.stop_code() : tetraction::exit_code(status);
}

int run_recorded(const SessionArguments& arguments, const SessionMaker& make_session,
                 const char* label, const OutcomePrinter& print_outcome) {
  if (arguments.may_be_parallel && launched_processes() > 1) {
    return run_parallel(arguments, label, print_outcome);
  }
  Scene scene = read_scene(arguments.scene, arguments.overrides);
  if (arguments.may_be_parallel && scene.solver.engine == "petsc") {
    return run_parallel(arguments, label, print_outcome);
  }
  SessionInputs inputs = session_inputs(arguments, std::move(scene), true);
  print_input_remarks(arguments, inputs);
  RunRecorder recorder(inputs.directory, inputs.scene.output.every);
  recorder.lock_directory();
  const std::unique_ptr<Session> session = make_session(inputs.scene, std::move(inputs.mesh));
  InterruptGuard interrupt;
  const auto find = [&](const BodyIdentity& body) {
    return find_resume_point(*session, body, inputs.directory, arguments.force);
  };
  return record_session(*session, recorder, arguments, inputs,
                        {interrupt, &InterruptGuard::exit_code, find}, label, print_outcome);
}

}  // namespace tetraction
