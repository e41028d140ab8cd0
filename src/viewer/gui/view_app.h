// The viewer as a program.
#pragma once

#include <string>

namespace tetraction::viewer {

/// Why no window can be opened here, as a sentence with what to do; empty if one can.
std::string display_problem();

/// Settings that Qt and VTK want before there is an application.
void set_up_application();

/// Opens the window on a scene, a mesh or a run's directory (empty: a first scene that moves), and
/// returns the exit code when it is closed. To be called once, from the program's first thread.
int run_viewer(const std::string& path);

}  // namespace tetraction::viewer
