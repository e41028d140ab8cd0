#include "processes.h"

#include <fcntl.h>
#include <mpi.h>
#include <petscsys.h>
#include <signal.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <thread>
#include <utility>

#include "tetraction/core/error.h"

namespace tetraction::petsc {
namespace {

// The failures of processes that fail for the same reason come about at the same time.
constexpr double kPatience = 1.0;  // s
// The first process that fails speaks for the others.
constexpr double kPatiencePerRank = 0.2;  // s

// A communicator for failures, apart from the one that the work uses.
MPI_Comm& failures() {
  static MPI_Comm communicator = MPI_COMM_NULL;
  return communicator;
}

// PETSc would take options from here, among them some that write files and load libraries.
constexpr std::array kVariables{"PETSC_OPTIONS", "PETSC_OPTIONS_YAML"};
constexpr std::array kFiles{".petscrc", "petscrc"};

std::vector<std::string> settings_of_petsc() {
  std::vector<std::string> names;
  for (const char* name : kVariables) {
    const char* text = std::getenv(name);
    if (text != nullptr && *text != '\0') names.emplace_back(name);
  }
  const auto add_file = [&names](const std::string& path) {
    std::error_code error;
    if (std::filesystem::exists(path, error)) names.push_back(path);
  };
  for (const char* name : kFiles) add_file(name);
  const char* home = std::getenv("HOME");
  std::error_code error;
  if (home != nullptr && !std::filesystem::equivalent(home, ".", error)) {
    add_file(std::string(home) + "/" + kFiles[0]);
  }
  return names;
}

bool initialize() {
  int provided = 0;
  // The threads of loops do not call MPI.
  if (MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &provided) != MPI_SUCCESS)
    return false;
  // PETSc keeps the pointers.
  static char program[] = "tetraction-petsc";
  static char no_files[] = "-skip_petscrc";
  static std::array<char*, 3> words{program, no_files, nullptr};
  static char** arguments = words.data();
  static int count = 2;
  return PetscInitialize(&count, &arguments, nullptr, nullptr) == 0;
}

// Foreign files may lie in the working directory, where PETSc, the transports of MPI (UCX) and others look for settings
// while they start. They start in the root directory therefore.
bool initialize_elsewhere() {
  for (const char* name : kVariables) ::unsetenv(name);
  const int here = ::open(".", O_PATH | O_DIRECTORY | O_CLOEXEC);
  if (here < 0 || ::chdir("/") != 0) return false;
  const bool is_started = initialize();
  const bool is_back = ::fchdir(here) == 0;
  ::close(here);
  return is_started && is_back;
}

}  // namespace

struct Processes::Pending {
  int own = 0;
  int largest = 0;
  MPI_Request request = MPI_REQUEST_NULL;
};

Processes::Processes()
    : pending_(std::make_unique<Pending>()), ignored_settings_(settings_of_petsc()) {
  // PETSc and MPI change what the program does about signals.
  struct sigaction closed_pipe {};
  sigaction(SIGPIPE, nullptr, &closed_pipe);
  if (!initialize_elsewhere()) {
    throw NumericalError(
        "MPI or PETSc cannot be started: check the installation, or take one process "
        "with solver.engine = \"local\".");
  }
  // Signals are this program's own affair.
  PetscPopSignalHandler();
  sigaction(SIGPIPE, &closed_pipe, nullptr);
  PetscPushErrorHandler(PetscReturnErrorHandler, nullptr);
  MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
  MPI_Comm_size(MPI_COMM_WORLD, &count_);
  MPI_Comm_dup(MPI_COMM_WORLD, &failures());
  MPI_Comm machine = MPI_COMM_NULL;
  MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine);
  MPI_Comm_size(machine, &on_this_machine_);
  MPI_Comm_free(&machine);
}

Processes::~Processes() {
  // All processes have made as many calls: those of a run that ended otherwise were aborted.
  if (pending_->request != MPI_REQUEST_NULL) MPI_Wait(&pending_->request, MPI_STATUS_IGNORE);
  MPI_Comm_free(&failures());
  PetscFinalize();
  MPI_Finalize();
}

Processes::Failure Processes::first_of(const Failure& own) const {
  int place = own.code != 0 ? rank_ : count_;
  MPI_Allreduce(MPI_IN_PLACE, &place, 1, MPI_INT, MPI_MIN, failures());
  if (place == count_) return {};
  Failure first = own;
  MPI_Bcast(&first.code, 1, MPI_INT, place, failures());
  int size = static_cast<int>(first.message.size());
  MPI_Bcast(&size, 1, MPI_INT, place, failures());
  first.message.resize(static_cast<std::size_t>(size));
  MPI_Bcast(first.message.data(), size, MPI_CHAR, place, failures());
  return first;
}

Processes::Failure Processes::together(const std::function<void()>& work,
                                       const std::function<Failure()>& describe) const {
  Failure own;
  try {
    work();
  } catch (...) {
    own = describe();
  }
  return first_of(own);
}

Processes::Failure Processes::in_step(const std::function<void()>& work,
                                      const std::function<Failure()>& describe,
                                      const std::function<void(const Failure&)>& report) const {
  Failure own;
  try {
    work();
  } catch (...) {
    own = describe();
  }
  // Whoever is here waits for the others, but after a failure not for ever.
  MPI_Request arrived = MPI_REQUEST_NULL;
  MPI_Ibarrier(failures(), &arrived);
  if (own.code == 0) {
    MPI_Wait(&arrived, MPI_STATUS_IGNORE);
    return first_of(own);
  }
  using Clock = std::chrono::steady_clock;
  const auto end =
      Clock::now() + std::chrono::duration<double>(kPatience + kPatiencePerRank * rank_);
  for (int done = 0; done == 0;) {
    MPI_Test(&arrived, &done, MPI_STATUS_IGNORE);
    if (done != 0) break;
    if (Clock::now() > end) {
      report(own);
      MPI_Abort(MPI_COMM_WORLD, own.code);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return first_of(own);
}

int Processes::largest_of_last_call(int value) {
  Pending& p = *pending_;
  if (p.request != MPI_REQUEST_NULL) MPI_Wait(&p.request, MPI_STATUS_IGNORE);
  const int last = std::exchange(p.largest, 0);
  p.own = value;
  MPI_Iallreduce(&p.own, &p.largest, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD, &p.request);
  return last;
}

int Processes::largest(int value) const {
  MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
  return value;
}

}  // namespace tetraction::petsc
