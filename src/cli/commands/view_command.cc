// tetraction view: play with a scene, or look at a finished run, in a window.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <optional>
#include <string>

#include "cli/command_line.h"
#include "cli/interrupt_guard.h"
#include "commands.h"
#include "tetraction/core/error.h"
#include "tetraction/core/parallel.h"
#ifdef TETRACTION_WITH_WINDOW
#include "viewer/gui/window/view_app.h"
#endif

namespace tetraction {
namespace {

struct ViewOptions {
  std::string path;
  std::optional<double> scale;
  std::string record;
};

int view(const ViewOptions& options) {
  if (options.scale && options.path.empty()) {
    throw InputError("view: --scale needs a mesh file whose coordinates it multiplies.");
  }
  if (options.scale && !(*options.scale > 0.0 && std::isfinite(*options.scale))) {
    throw InputError("view: --scale must be above 0 and finite; 0.001 for a mesh in millimetres.");
  }
#ifdef TETRACTION_WITH_WINDOW
  const InterruptGuard guard;
  return viewer::run_viewer(options.path, options.scale, options.record,
                            &InterruptGuard::interrupted);
#else
  // Threads of OpenMP that wait by spinning take the processor from the one that draws: on two busy
  // cores the first picture then takes ten times as long.
  setenv("OMP_WAIT_POLICY", "passive", 0);
  become_program("tetraction-window");
  throw InputError(
      "view: this program was built without the viewer (there is no program tetraction-window "
      "beside it). Install qtbase5-dev and libvtk9-qt-dev "
      "(scripts/setup does), configure and build again.");
#endif
}

}  // namespace

void add_view_command(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<ViewOptions>();
  CLI::App* command = app.add_subcommand(
      "view", "Open a window: simulate a scene or a mesh interactively, or replay a finished run");
  command->add_option("path", options->path,
                      "Scene (.toml), output directory of a run, a study or natural modes, or mesh "
                      "file; without a path, an example scene");
  command->add_option("--scale", options->scale,
                      "Multiplies the coordinates of a mesh file; 0.001 for one in millimetres");
  command
      ->add_option("--record", options->record,
                   "Writes the run into this folder from its first step on, as tetraction run "
                   "does; complete when the window closes")
      ->type_name("DIR");
  command->callback([options, &app, command, &exit_code] {
    // One core is left to the window, which draws while the solver works.
    if (app.count("--threads") + command->count("--threads") == 0)
      set_thread_count(std::max(1, thread_count() - 1));
    exit_code = view(*options);
  });
}

}  // namespace tetraction
