// The command line of this process, for results that say how they were made.
#pragma once

#include <string>

namespace tetraction {

/// Keeps the arguments of main().
void remember_command_line(int argc, char** argv);

/// The command line as one would type it into a shell, with the program's name for its path.
std::string command_line();

/// Keeps the number of threads that --threads gives, and tells it: 0 if it was not given.
void remember_threads(int threads);
int remembered_threads();

/// Goes on as another program in the folder of this one, with the arguments of this one. Returns only if
/// there is no such program, or if it cannot be started.
void become_program(const std::string& name);

}  // namespace tetraction
