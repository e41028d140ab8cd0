// tetraction run in several processes.
#pragma once

#include <string>

#include "recorded_session.h"

namespace tetraction {

/// The number of processes that mpirun, or another launcher, started together with this one; 1 without one.
int launched_processes();
/// The number of this process among them, from 0; 0 without a launcher that tells it.
int launched_rank();
/// Before an error that all processes meet: all but the first one are silent from now on, and wait until it has
/// printed its message.
void let_first_process_speak();
/// Throws InputError if this process was started together with others, which would all print the same and write the
/// same files. The first process tells it.
void require_one_process(const std::string& command);

/// Computes one session in all processes of an MPI run, of which the first one prints and writes, and returns
/// the exit code, which is the same in all of them. Throws InputError if the program was built without the
/// engine.
int run_parallel(const SessionArguments& arguments, const char* label,
                 const OutcomePrinter& print_outcome);

}  // namespace tetraction
