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
#include "cli/progress_bar.h"
#include "cli/scene_source.h"
#include "io/checkpoints/part_checkpoint.h"
#include "io/results/result_folders.h"
#include "petsc/mesh_distribution.h"
#include "petsc/processes.h"
#include "resume.h"
#include "simulation/scene/parallel_features.h"
#include "tetraction/core/blas.h"
#include "tetraction/core/parallel.h"
#include "tetraction/io/initial_fields.h"
#include "tetraction/io/part_recorder.h"
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
      "without "
      "mpirun, or install petsc-dev and build it again (scripts/setup --all).");
}

#else

namespace {

using petsc::Processes;

// Ends the run in all processes if one of them has received a signal, or cannot write its results. With the explicit
// rules, whose steps are short, they all know it one step later, and need not wait for one another.
class SharedInterrupt : public Observer {
 public:
  SharedInterrupt(Processes& processes, const PartRecorder& recorder)
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
  const PartRecorder& recorder_;
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

struct Inputs {
  Scene scene;
  std::string directory;
  TetMesh mesh;                     // of process 0
  std::vector<std::string> unused;  // of the file of the mesh
  double mesh_time = 0.0;
};

Inputs read_inputs(const SessionArguments& arguments, const Processes& processes) {
  Inputs inputs;
  inputs.scene = read_scene(arguments.scene, arguments.overrides);
  refuse_what_parts_lack(inputs.scene, Analysis::kMotion);
  inputs.directory = output_directory(inputs.scene, arguments.out, arguments.overrides);
  if (!processes.is_first()) return inputs;
  check_folder_of_run(inputs.scene, inputs.directory);
  const auto start = std::chrono::steady_clock::now();
  inputs.mesh = read_scene_mesh(inputs.scene, inputs.unused);
  inputs.mesh_time =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return inputs;
}

// As resume_run(). Process 0 reads the checkpoint, and gives every process its part.
Resumption resume_together(Session& session, PartRecorder& recorder, const Inputs& inputs,
                           const SessionArguments& arguments, const Processes& processes) {
  const MeshPart& part = *session.system().part();
  const BodyIdentity body = session.checkpoint().body;
  ResumePoint point;
  const Processes::Failure failure = processes.together(
      [&] {
        if (processes.is_first()) {
          point = find_resume_point(session, body, inputs.directory, arguments.force);
        }
      },
      &described);
  if (failure.code != 0) throw SharedFailure{failure};
  point.resumption = static_cast<Resumption>(processes.largest(static_cast<int>(point.resumption)));
  if (point.resumption != Resumption::kContinues) return point.resumption;
  point.has_new_steps = processes.largest(point.has_new_steps ? 1 : 0) != 0;
  point.stored = handed_out(part, std::move(point.stored));
  restore_run(session, body, point);
  recorder.resume(session, point.stored);
  report_resumption(session, point, inputs.directory, arguments.quiet);
  return point.resumption;
}

// The work that all processes share.
int run_together(const SessionArguments& arguments, Inputs inputs, Processes& processes,
                 const char* label, const OutcomePrinter& print_outcome) {
  if (!arguments.quiet) {
    if (const std::string remarks = mesh_remarks(inputs.mesh, inputs.unused); !remarks.empty()) {
      print_note(remarks);
    }
    if (const std::string remarks = damping_remarks(inputs.scene); !remarks.empty()) {
      print_note(remarks);
    }
  }
  Session session(inputs.scene, distribute_mesh(processes, std::move(inputs.mesh)));
  session.add_mesh_time(inputs.mesh_time);
  const std::string slow_blas = arguments.quiet ? blas_warning() : "";
  for (const std::string& warning : session.warnings()) {
    if (warning != slow_blas || slow_blas.empty()) print_warning(warning);
  }
  PartRecorder recorder(inputs.directory, inputs.scene.output.every);
  InterruptGuard guard;
  SharedInterrupt interrupt(processes, recorder);
  recorder.set_stop_code([&interrupt] { return interrupt.exit_code(); });
  recorder.lock_directory(*session.system().part());
  recorder.keep_checkpoints(session.scene().output.checkpoint_every);
  if (arguments.resume &&
      resume_together(session, recorder, inputs, arguments, processes) == Resumption::kComplete) {
    if (arguments.json) write_json_result(read_summary(inputs.directory));
    return 0;
  }
  const std::size_t told = session.warnings().size();
  ProgressBar bar(label);
  std::vector<Observer*> observers{&recorder, &interrupt};
  if (processes.is_first() && !arguments.quiet && ProgressBar::possible()) {
    observers.push_back(&bar);
  }
  const RunStatus status = session.run(observers);
  if (arguments.json) {
    write_json_result(recorder.summary());
  } else if (!arguments.quiet) {
    print_outcome(session, inputs.directory);
  }
  print_remarks(session, told);
  return status == RunStatus::kCancelled ? interrupt.exit_code() : tetraction::exit_code(status);
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
  std::optional<Inputs> inputs;
  Processes::Failure failure =
      processes.together([&] { inputs = read_inputs(arguments, processes); }, &described);
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
