// Other programs that this one starts.
#pragma once

#include <string>
#include <vector>

namespace tetraction {

/// Starts a program, which is looked for on the PATH, with these arguments, and waits for its end.
/// No shell sees them. The program is killed if this one ends before it, and ended where an InterruptGuard of this one
/// sees a signal; it does not see Ctrl-C itself. Returns its exit code, or −1 if it cannot be started or did not end by
/// itself.
int run_child_program(std::vector<std::string> arguments);

}  // namespace tetraction
