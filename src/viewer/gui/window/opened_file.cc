#include "opened_file.h"

#include <fmt/format.h>

#include <filesystem>
#include <system_error>
#include <utility>

#include "io/stored_study/study_reader.h"
#include "io/study/study_page.h"
#include "io/text/text_scanner.h"
#include "tetraction/core/error.h"

namespace tetraction::viewer {
namespace {

namespace fs = std::filesystem;

bool has(const std::string& directory, const char* file) {
  std::error_code error;
  return fs::exists(fs::path(directory) / file, error) || error;
}

void set_replay(Opened& opened, std::unique_ptr<Replay> replay) {
  replay->frame(0, nullptr);  // throws if the first frame cannot be drawn
  opened.shape = make_body_shape(replay->mesh());
  opened.replay = std::move(replay);
}

Opened open_run(const std::string& path) {
  Opened opened;
  set_replay(opened, std::make_unique<Replay>(path));
  return opened;
}

Opened open_modes(const std::string& directory) {
  Opened opened;
  opened.modes = std::make_shared<StoredModes>(directory);
  set_replay(opened, std::make_unique<Replay>(*opened.modes, 0));
  return opened;
}

// Shows the first run with frames that can be read.
Opened open_study(const std::string& directory) {
  Opened opened;
  const StoredStudy study = read_stored_study(directory);
  opened.runs = grid_of_all_runs(study.result);
  for (const StudyRow& row : study.result.rows) {
    const std::string run = directory + "/" + row.directory;
    if (opened.replay || !has(run, "frames.pvd")) continue;
    try {
      set_replay(opened, std::make_unique<Replay>(run));
    } catch (const FileError&) {
      // The user is told when this run is opened.
    }
  }
  return opened;
}

}  // namespace

Opened set_up(Document document) {
  Opened opened;
  opened.simulation =
      std::make_unique<Simulation>(std::move(document.scene), std::move(document.mesh));
  opened.shape = make_body_shape(opened.simulation->mesh());
  return opened;
}

Opened open_file(const std::string& path, std::optional<double> scale) {
  std::error_code ignored;
  if (std::filesystem::status(path, ignored).type() == std::filesystem::file_type::not_found) {
    throw FileError(
        fmt::format("{}: there is no such file or directory. Give a scene (.toml), a mesh, or the "
                    "output directory of a run.",
                    path));
  }
  const DocumentKind kind = kind_of(path);
  if (scale && kind != DocumentKind::kMesh) {
    throw InputError(fmt::format(
        "{}: a scale is for a mesh file. In a scene, mesh.scale multiplies the coordinates.",
        path));
  }
  if (kind == DocumentKind::kScene) {
    Opened opened = set_up(open_scene(path));
    opened.off = off_entries_in(read_file(path));
    return opened;
  }
  if (kind == DocumentKind::kMesh) {
    Opened opened = set_up(open_mesh(path, scale.value_or(1.0)));
    opened.mesh_scale = scale.value_or(1.0);
    return opened;
  }
  if (std::error_code error; fs::is_directory(path, error)) {
    if (has(path, "study.json")) return open_study(path);
    if (has(path, "modes.csv") && !has(path, "frames.pvd")) return open_modes(path);
  }
  return open_run(path);
}

Opened open_unsaved(const std::string& file, const std::string& document) {
  Scene restored = open_scene(file).scene;
  Document before;
  const bool is_mesh = !document.empty() && kind_of(document) == DocumentKind::kMesh;
  try {
    before = document.empty() ? first_scene()
             : is_mesh        ? open_mesh(document, restored.mesh.scale)
                              : open_scene(document);
  } catch (const Error&) {
    before = open_scene(file);
    before.scene.event.clear();
  }
  Opened opened = set_up(std::move(before));
  if (is_mesh) opened.mesh_scale = restored.mesh.scale;
  opened.off = off_entries_in(read_file(file));
  opened.restored = std::move(restored);
  return opened;
}

Opened open_pair(const std::string& first, const std::string& second) {
  Opened opened = open_run(first);
  Opened other = open_run(second);
  if (opened.replay->kind() != other.replay->kind()) {
    throw InputError(
        fmt::format("{} and {}: the computation of an equilibrium and a motion cannot be compared.",
                    first, second));
  }
  opened.other = std::move(other.replay);
  opened.other_shape = std::move(other.shape);
  return opened;
}

}  // namespace tetraction::viewer
