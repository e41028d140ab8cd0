// The viewer as an application.
#pragma once

#include <functional>
#include <optional>
#include <string>

namespace tetraction::viewer {

/// Makes the settings of Qt and VTK that must be made before the QApplication exists.
void set_up_application();

/// Opens the window and returns the exit code when it is closed. `path` is a scene, a mesh or the
/// directory of a run; if it is empty, the initial scene is shown. `scale` multiplies the coordinates of
/// a mesh. If `record` is not empty, the run is recorded in this folder from its first step on; InputError is
/// thrown if there is a run in it already, or if `path` is not a simulation. The window closes without a
/// question, and the recording is complete, as soon as `interrupted` returns true. Must be called once, from the main thread. Throws FileError and InputError as open_file()
/// does if the file cannot be opened, and InputError if there is no display.
int run_viewer(const std::string& path, std::optional<double> scale, const std::string& record,
               const std::function<bool()>& interrupted);

}  // namespace tetraction::viewer
