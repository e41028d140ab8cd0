// The viewer as an application.
#pragma once

#include <optional>
#include <string>

namespace tetraction::viewer {

/// Makes the settings of Qt and VTK that must be made before the QApplication exists.
void set_up_application();

/// Opens the window and returns the exit code when it is closed. `path` is a scene, a mesh or the
/// directory of a run; if it is empty, the initial scene is shown. `scale` multiplies the coordinates of
/// a mesh. Must be called once, from the main thread. Throws FileError and InputError as open_file()
/// does if the file cannot be opened, and InputError if there is no display.
int run_viewer(const std::string& path, std::optional<double> scale);

}  // namespace tetraction::viewer
