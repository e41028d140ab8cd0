// The command line of this process, for results that say how they were made.
#pragma once

#include <string>

namespace tetraction {

/// Keeps the arguments of main().
void remember_command_line(int argc, char** argv);

/// The command line as one would type it into a shell, with the program's name for its path.
std::string command_line();

}  // namespace tetraction
