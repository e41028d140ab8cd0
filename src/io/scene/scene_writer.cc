#include "tetraction/io/scene_writer.h"

#include <fmt/format.h>

#include <filesystem>
#include <utility>

#include "event_writer.h"
#include "scene_keys.h"
#include "tetraction/core/error.h"
#include "tetraction/io/text_file.h"

namespace tetraction {
namespace {

namespace fs = std::filesystem;

std::string lines(const SceneKeys& keys) {
  std::string text;
  for (const SceneKey& key : keys) {
    std::string line = key.name + " = " + key.value;
    if (!key.unit.empty()) line = fmt::format("{:<32}  # {}", line, key.unit);
    text += line + "\n";
  }
  return text;
}

std::string section(const char* head, const SceneKeys& keys, const Selection* select = nullptr) {
  return fmt::format("\n{}\n{}{}", head,
                     select != nullptr ? "select = " + inline_selection(*select) + "\n" : "",
                     lines(keys));
}

// A section whose values are all the default ones is left out.
template <class Settings>
std::string section_unless_default(const char* head, const Settings& settings) {
  const SceneKeys keys = keys_of(settings);
  const SceneKeys defaults = keys_of(Settings{});
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (keys[i].value != defaults[i].value) return section(head, keys);
  }
  return {};
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

SceneKeys keys_of_mesh(const MeshSettings& mesh, const std::string& folder) {
  if (!mesh.generate) {
    if (mesh.file.empty()) {
      throw InputError(
          "The scene has neither a mesh file nor a generated mesh that a scene file could name: "
          "write the mesh to a file first and set mesh.file.");
    }
    SceneKeys keys{{"file", toml_text(relative_path(mesh.file, folder))}};
    for (SceneKey& key : keys_of(mesh)) keys.push_back(std::move(key));
    return keys;
  }
  const GeneratorSettings& generator = *mesh.generate;
  SceneKeys keys;
  switch (generator.kind) {
    case GeneratorKind::kBeam:
    case GeneratorKind::kBox:
      keys = {{"kind", toml_text(to_string(generator.kind))},
              {"size", toml_list(generator.size)},
              {"cells", fmt::format("[{}, {}, {}]", generator.cells[0], generator.cells[1],
                                    generator.cells[2])}};
      break;
    case GeneratorKind::kCube:
      keys = {{"kind", toml_text("cube")},
              {"size", toml_number(generator.size.x())},
              {"cells", std::to_string(generator.cells[0])}};
      break;
    case GeneratorKind::kTetrahedron:
      keys = {{"kind", toml_text("tetrahedron")}, {"size", toml_number(generator.size.x())}};
      break;
  }
  SceneKeys all{{"generate", inline_table(keys), "m"}};
  for (SceneKey& key : keys_of(mesh)) {
    // These belong to files.
    if (key.name != "scale" && key.name != "unit") all.push_back(std::move(key));
  }
  return all;
}

std::string initial_section(InitialSettings initial, const std::string& folder) {
  for (FieldSettings* field : {&initial.displacement_field, &initial.velocity_field}) {
    if (!field->file.empty()) field->file = relative_path(field->file, folder);
  }
  const SceneKeys keys = keys_of(initial);
  std::string text = keys.empty() ? "" : section("[initial]", keys);
  for (const MomentumSettings& momentum : initial.momentum) {
    text += section("[[initial.momentum]]", keys_of(momentum), &momentum.select);
  }
  return text;
}

}  // namespace

std::string scene_text(const Scene& scene, const std::string& folder) {
  std::string text = "[mesh]\n" + lines(keys_of_mesh(scene.mesh, folder));
  text += section("[material]", keys_of(scene.material));
  for (const MaterialRegionSettings& region : scene.material_region) {
    text += section("[[material_region]]", keys_of(region.material), &region.select);
  }
  text += section("[time]", keys_of(scene.time));
  text += section_unless_default("[solver]", scene.solver);
  text += section_unless_default("[damping]", scene.damping);
  text += section_unless_default("[environment]", scene.environment);
  for (const FixSettings& fix : scene.fix) text += section("[[fix]]", keys_of(fix), &fix.select);
  for (const ConstraintSettings& constraint : scene.constraint) {
    text += section("[[constraint]]", keys_of(constraint),
                    has_selection(constraint.kind) ? &constraint.select : nullptr);
  }
  for (const LoadKind kind : load_kinds()) {
    const std::string head = fmt::format("[[{}]]", to_string(kind));
    for (const ForceSettings& load : scene.list(kind)) {
      text += section(head.c_str(), keys_of(load), &load.select);
    }
  }
  for (const AmplitudeSettings& amplitude : scene.amplitude) {
    text += section("[[amplitude]]", keys_of(amplitude));
  }
  text += initial_section(scene.initial, folder);
  text += section("[output]", keys_of(scene.output));
  for (const NamedSelection& named : scene.selection) {
    const std::string head = fmt::format("[selection.{}]", toml_key(named.name));
    text += section(head.c_str(), selection_keys(named.select));
  }
  for (const ProbeSettings& probe : scene.probe) {
    text += section("[[probe]]", keys_of(probe), probe.point ? nullptr : &probe.select);
  }
  return text + event_text(scene);
}

void write_scene(const Scene& scene, const std::string& path) {
  write_text_file(path, scene_text(scene, fs::path(path).parent_path().string()));
}

}  // namespace tetraction
