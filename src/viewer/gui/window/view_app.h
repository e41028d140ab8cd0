// The viewer as a program.
#pragma once

#include <optional>
#include <string>

namespace tetraction::viewer {

/// Settings that Qt and VTK want before there is an application.
void set_up_application();

/// Opens the window on a scene, a mesh (whose coordinates `scale` multiplies) or a run's directory
/// (empty: a first scene that moves), and returns the exit code when it is closed. To be called once,
/// from the program's first thread. Throws FileError and InputError, as open_file() does, for what
/// cannot be opened: then there is no window, or it is closed. Throws InputError without a display.
int run_viewer(const std::string& path, std::optional<double> scale);

}  // namespace tetraction::viewer
