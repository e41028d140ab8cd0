#include "parallel_run.h"

#include <chrono>
#include <cstdlib>
#include <thread>

#include "cli/command_line.h"
#include "cli/console.h"

#ifdef TETRACTION_HAS_PETSC
#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "cli/interrupt_guard.h"
#include "cli/program_failure.h"
#include "petsc/mesh_distribution.h"
#include "petsc/processes.h"
#include "simulation/scene/parallel_features.h"
#include "tetraction/core/parallel.h"
#include "tetraction/io/scene_reader.h"
#endif
#include "tetraction/core/error.h"

namespace tetraction {

int launched_rank() {
  const char* rank = std::getenv("OMPI_COMM_WORLD_RANK");
  return rank != nullptr ? std::atoi(rank) : 0;
}

void let_first_process_speak() {
  if (launched_rank() == 0) return;
  set_silent(true);
  // mpirun kills the others as soon as one ends with an error.
  std::this_thread::sleep_for(std::chrono::seconds(1));
}

void require_one_process(const std::string& command) {
  if (launched_processes() == 1) return;
  let_first_process_speak();
  throw InputError("tetraction " + command +
                   " works in one process only: start it without mpirun.");
}

int launched_processes() {
  for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "MPI_LOCALNRANKS"}) {
    const char* text = std::getenv(name);
    if (text != nullptr && std::atoi(text) > 0) return std::atoi(text);
  }
  return 1;
}

#ifndef TETRACTION_HAS_PETSC

int run_parallel(const SessionArguments& /*arguments*/, const char* /*label*/,
                 const OutcomePrinter& /*print_outcome*/) {
  become_program("tetraction-petsc");
  let_first_process_speak();
  throw InputError(
      "This build has no PETSc and MPI, which solver.engine = \"petsc\" and runs with mpirun need "
      "(there is no program tetraction-petsc beside this one). Take solver.engine = \"local\" "
      "without mpirun, or install petsc-dev and build it again (scripts/setup --all).");
}

#else

namespace {

using petsc::Processes;

// Ends the run in all processes if one of them has received a signal, or cannot write its results. With the explicit
// rules, whose steps are short, they all know it one step later, and need not wait for one another.
class SharedInterrupt : public Observer {
 public:
  SharedInterrupt(Processes& processes, const RunRecorder& recorder)
      : processes_(processes), recorder_(recorder) {}
  bool on_step(const Session& session) override {
    constexpr int kCannotWrite = 1;
    const int own = recorder_.has_failed() ? kCannotWrite : 0;
    const int code = InterruptGuard::interrupted() ? InterruptGuard::exit_code() : own;
    code_ = is_implicit(session.time_settings().integrator) ? processes_.largest(code)
                                                            : processes_.largest_of_last_call(code);
    return code_ == 0;
  }
  /// The exit code of the signal, after one.
  int exit_code() const { return code_; }

 private:
  Processes& processes_;
  const RunRecorder& recorder_;
  int code_ = 0;
};

// A failure that all processes have.
struct SharedFailure {
  Processes::Failure failure;
};

Processes::Failure described() {
  try {
    throw;
  } catch (const SharedFailure& shared) {
    return shared.failure;
  } catch (...) {
    const ProgramFailure failure = present_failure();
    return {failure.code, failure.message};
  }
}

// All processes have the failure, and the first one tells it.
int end_with(const Processes::Failure& failure) {
  print_message(failure.message);
  return failure.code;
}

SessionInputs shared_inputs(const SessionArguments& arguments, const Processes& processes) {
  Scene scene = read_scene(arguments.scene, arguments.overrides);
  refuse_what_parts_lack(scene, Analysis::kMotion);
  return session_inputs(arguments, std::move(scene), processes.is_first());
}

// The work that all processes share.
int run_together(const SessionArguments& arguments, SessionInputs inputs, Processes& processes,
                 const char* label, const OutcomePrinter& print_outcome) {
  print_input_remarks(arguments, inputs);
  Session session(inputs.scene, distribute_mesh(processes, std::move(inputs.mesh)));
  RunRecorder recorder(inputs.directory, inputs.scene.output.every);
  InterruptGuard guard;
  SharedInterrupt interrupt(processes, recorder);
  recorder.lock_directory(session.system().part());
  // Process 0 reads the checkpoint.
  const auto find = [&](const BodyIdentity& body) {
    ResumePoint point;
    const Processes::Failure failure = processes.together(
        [&] {
          if (!processes.is_first()) return;
          point = find_resume_point(session, body, inputs.directory, arguments.force);
        },
        &described);
    if (failure.code != 0) throw SharedFailure{failure};
    return point;
  };
  return record_session(session, recorder, arguments, inputs,
                        {interrupt, [&interrupt] { return interrupt.exit_code(); }, find}, label,
                        print_outcome);
}

}  // namespace

int run_parallel(const SessionArguments& arguments, const char* label,
                 const OutcomePrinter& print_outcome) {
  Processes processes;
  set_silent(!processes.is_first());
  // The processes of a machine share its cores.
  if (remembered_threads() == 0) {
    set_thread_count(std::max(1, thread_count() / processes.on_this_machine()));
  }
  if (!arguments.quiet && !processes.ignored_settings().empty()) {
    print_note(
        fmt::format("PETSc has settings that are ignored ({}): the scene alone says how its "
                    "systems are solved.",
                    fmt::join(processes.ignored_settings(), ", ")));
  }
  std::optional<SessionInputs> inputs;
  Processes::Failure failure =
      processes.together([&] { inputs = shared_inputs(arguments, processes); }, &described);
  if (failure.code != 0) return end_with(failure);
  int code = 0;
  failure = processes.in_step(
      [&] { code = run_together(arguments, std::move(*inputs), processes, label, print_outcome); },
      &described,
      [](const Processes::Failure& alone) {
        set_silent(false);
        print_message(alone.message);
      });
  return failure.code != 0 ? end_with(failure) : code;
}

#endif

}  // namespace tetraction
