#include "opened_file.h"

#include <fmt/format.h>

#include <filesystem>
#include <system_error>
#include <utility>

#include "io/text/text_scanner.h"
#include "tetraction/core/error.h"

namespace tetraction::viewer {

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
  Opened opened;
  opened.replay = std::make_unique<Replay>(path);
  opened.replay->frame(0, nullptr);  // throws if the first frame cannot be drawn
  opened.shape = make_body_shape(opened.replay->mesh());
  return opened;
}

}  // namespace tetraction::viewer
