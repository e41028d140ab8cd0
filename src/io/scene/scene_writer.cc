#include "tetraction/io/scene_writer.h"

#include <fmt/format.h>

#include <filesystem>
#include <string_view>

#include "tetraction/core/error.h"
#include "tetraction/io/text_file.h"
#include "written_keys.h"

namespace tetraction {
namespace {

namespace fs = std::filesystem;

std::string lines(const WrittenKeys& keys) {
  std::string text;
  for (const WrittenKey& key : keys) {
    std::string line = key.name + " = " + key.value;
    if (!key.unit.empty()) line = fmt::format("{:<32}  # {}", line, key.unit);
    text += line + "\n";
  }
  return text;
}

std::string section_text(const std::string& head, const WrittenKeys& keys,
                         const Selection* select = nullptr) {
  return fmt::format("\n{}\n{}{}", head,
                     select != nullptr ? "select = " + inline_selection(*select) + "\n" : "",
                     lines(keys));
}

// The path from the scene's folder to a file. It is absolute if they have only the root in
// common.
std::string relative_path(const std::string& file, const std::string& folder) {
  const fs::path target = fs::absolute(file).lexically_normal();
  const fs::path base = fs::absolute(folder.empty() ? "." : folder).lexically_normal();
  auto a = target.begin();
  auto b = base.begin();
  std::size_t common = 0;
  for (; a != target.end() && b != base.end() && *a == *b; ++a, ++b) ++common;
  return common > 1 ? target.lexically_relative(base).string() : target.string();
}

// The scene with the paths that a file in the folder must have, and without what a generated mesh
// does not use.
Scene with_paths_from(Scene scene, const std::string& folder) {
  MeshSettings& mesh = scene.mesh;
  if (mesh.generate) {
    mesh.file.clear();
    mesh.scale = MeshSettings{}.scale;
    mesh.unit = MeshSettings{}.unit;
  } else if (mesh.file.empty()) {
    throw InputError(
        "The scene has neither a mesh file nor a generated mesh that a scene file could name: "
        "write the mesh to a file first and set mesh.file.");
  } else {
    mesh.file = relative_path(mesh.file, folder);
  }
  for (AmplitudeSettings& amplitude : scene.amplitude) {
    if (amplitude.kind != AmplitudeKind::kFile) continue;
    amplitude.file = fs::absolute(amplitude.file).lexically_normal().string();
  }
  for (FieldSettings* field : {&scene.initial.displacement_field, &scene.initial.velocity_field}) {
    if (!field->file.empty()) field->file = relative_path(field->file, folder);
  }
  const auto set_path = [&](ObstacleSettings& obstacle) {
    if (!obstacle.file.empty()) obstacle.file = relative_path(obstacle.file, folder);
  };
  for (ObstacleSettings& obstacle : scene.obstacle) set_path(obstacle);
  for (EventSettings& event : scene.event) {
    for (Edit& edit : event.edits) {
      if (auto* set = std::get_if<SetObstacle>(&edit)) set_path(set->entry);
    }
  }
  return scene;
}

// A section whose values are all the default ones is left out, but not these.
bool is_always_written(std::string_view section) {
  return section == "mesh" || section == "material" || section == "time" || section == "output";
}

std::string part_text(const ScenePart& part, const void* settings) {
  const SceneSection& section = *part.section;
  const std::string head =
      part.is_list ? fmt::format("[[{}]]", section.name) : fmt::format("[{}]", section.name);
  const WrittenKeys keys = keys_of(section, settings);
  std::string text;
  if (part.is_list || is_always_written(section.name) ||
      keys != keys_of(section, section.defaults.get())) {
    text = section_text(head, keys, selection_of(section, settings));
  }
  if (section.type == typeid(MeshSettings)) {
    for (const MeshCopySettings& copy : static_cast<const MeshSettings*>(settings)->copies) {
      text += section_text("[[mesh.copies]]", keys_of(copy), nullptr);
    }
  }
  if (section.type == typeid(InitialSettings)) {
    for (const MomentumSettings& momentum :
         static_cast<const InitialSettings*>(settings)->momentum) {
      text += section_text("[[initial.momentum]]", keys_of(momentum), &momentum.select);
    }
  }
  return text;
}

}  // namespace

std::string scene_text(const Scene& scene, const std::string& folder) {
  const Scene written = with_paths_from(scene, folder);
  std::string text;
  for (const ScenePart& part : scene_parts()) {
    if (std::string_view(part.section->name) == "probe") {
      for (const NamedSelection& named : written.selection) {
        text += section_text(fmt::format("[selection.{}]", toml_key(named.name)),
                             selection_keys(named.select));
      }
    }
    for (const void* settings : part.entries(written)) text += part_text(part, settings);
  }
  return text.substr(1) + event_text(written);  // without the line before the first section
}

void write_scene(const Scene& scene, const std::string& path) {
  write_text_file(path, scene_text(scene, fs::path(path).parent_path().string()));
}

}  // namespace tetraction
