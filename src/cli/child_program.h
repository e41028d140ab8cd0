// Other programs that this one starts.
#pragma once

#include <string>
#include <vector>

namespace tetraction {

/// Starts a program, which is looked for on the PATH, with these arguments, and waits for its end.
/// No shell sees them. The program is killed if this one ends before it. Returns whether it ended
/// with exit code 0.
bool run_child_program(std::vector<std::string> arguments);

}  // namespace tetraction
