// The processes of an MPI run.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace tetraction::petsc {

/// The state that all processes of an MPI run share. One object lives as long as the program uses MPI and PETSc, which
/// it starts and ends.
class Processes {
 public:
  /// Starts MPI and PETSc, which read no settings of their own from the working directory and from variables for
  /// PETSc. Throws NumericalError if they cannot be started.
  Processes();
  ~Processes();
  Processes(const Processes&) = delete;
  Processes& operator=(const Processes&) = delete;

  int rank() const { return rank_; }
  int count() const { return count_; }
  bool is_first() const { return rank_ == 0; }
  /// Settings for PETSc that are there and were not read, such as "PETSC_OPTIONS" and ".petscrc".
  const std::vector<std::string>& ignored_settings() const { return ignored_settings_; }
  /// How many of the processes are on this machine.
  int on_this_machine() const { return on_this_machine_; }

  /// A code for an exception that a process met, and what it was.
  struct Failure {
    int code = 0;  ///< 0: none
    std::string message;
  };
  /// Runs `work`, which must not talk to other processes, on every process. If it fails somewhere, all
  /// processes get the failure of the first one that failed; otherwise one with the code 0. `describe` makes
  /// a failure of the exception that is being handled.
  Failure together(const std::function<void()>& work,
                   const std::function<Failure()>& describe) const;
  /// The same for work in which processes wait for one another. If one of them fails alone, the others would
  /// wait for ever: it then calls report(failure), and all processes end with its code.
  Failure in_step(const std::function<void()>& work, const std::function<Failure()>& describe,
                  const std::function<void(const Failure&)>& report) const;
  /// The largest value of all processes.
  int largest(int value) const;
  /// The largest value of the last call on all processes; 0 at the first call. Nobody waits for the present value, which
  /// travels while the processes work.
  int largest_of_last_call(int value);

 private:
  Failure first_of(const Failure& own) const;

  // The state of largest_of_last_call().
  struct Pending;
  std::unique_ptr<Pending> pending_;
  std::vector<std::string> ignored_settings_;
  int rank_ = 0;
  int count_ = 1;
  int on_this_machine_ = 1;
};

}  // namespace tetraction::petsc
