// tetraction view: play with a scene, or look at a finished run, in a window.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <string>

#include "commands.h"
#include "tetraction/core/error.h"
#include "tetraction/core/parallel.h"
#ifdef TETRACTION_HAS_VIEWER
#include "viewer/gui/view_app.h"
#endif

namespace tetraction {
namespace {

int view(const std::string& path) {
#ifdef TETRACTION_HAS_VIEWER
  if (const std::string problem = viewer::display_problem(); !problem.empty()) {
    throw InputError(problem);
  }
  return viewer::run_viewer(path);
#else
  static_cast<void>(path);
  throw InputError(
      "view: this program was built without the viewer. Install qtbase5-dev and libvtk9-qt-dev "
      "(scripts/setup does), configure and build again.");
#endif
}

}  // namespace

void add_view_command(CLI::App& app, int& exit_code) {
  auto path = std::make_shared<std::string>();
  CLI::App* command = app.add_subcommand(
      "view", "Open a window: play with a scene or a mesh, or replay a finished run");
  command->add_option("path", *path,
                      "Scene (.toml), output directory of a run, or mesh file; without one: a "
                      "first scene");
  command->callback([path, &app, command, &exit_code] {
    // The window draws while the solver works: one core is its own.
    if (app.count("--threads") + command->count("--threads") == 0)
      set_thread_count(std::max(1, thread_count() - 1));
    exit_code = view(*path);
  });
}

}  // namespace tetraction
