#include "scene_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <regex>

#include "io/toml/toml_document.h"
#include "io/toml/toml_text.h"
#include "outline.h"
#include "tetraction/core/error.h"
#include "tetraction/io/scene_reader.h"
#include "tetraction/io/scene_writer.h"

namespace tetraction {
namespace {

constexpr const char* kMadeMesh = "made by a program";

std::string folder_of_scene(const Scene& scene) {
  return std::filesystem::path(scene.path).parent_path().string();
}

bool has_mesh_of_program(const Scene& scene) {
  return scene.mesh.file.empty() && !scene.mesh.generate;
}

// Messages about entries name them as the window does. The lines of the text are not those of a file.
Scene with_titles(Scene scene) {
  for (const ScenePart& part : scene_parts()) {
    const std::vector<const void*> entries = part.entries(scene);
    for (std::size_t i = 0; i < entries.size(); ++i) {
      if (!part.section->where) continue;
      *part.section->where(const_cast<void*>(entries[i])) = title_of_entry({part.section->name, i});
    }
  }
  for (std::size_t i = 0; i < scene.event.size(); ++i) {
    scene.event[i].where = title_of_entry({"event", i});
  }
  return scene;
}

}  // namespace

Json scene_json(const Scene& scene) {
  Scene sections = scene;
  // The text of an event names all keys of a section, and the file perhaps one.
  const bool has_file = std::ranges::all_of(scene.event, [](const EventSettings& event) {
    return !event.echo.empty() && !Json::parse(event.echo).contains("note");
  });
  if (has_file) sections.event.clear();
  if (has_mesh_of_program(scene)) sections.mesh.file = kMadeMesh;
  Json json = to_json(TomlDocument("scene", scene_text(sections, folder_of_scene(scene)),
                                   std::vector<std::string>())
                          .root());
  if (has_mesh_of_program(scene)) json["mesh"].erase("file");
  for (const EventSettings& event : scene.event) {
    if (has_file) json["event"].push_back(Json::parse(event.echo));
  }
  return json;
}

std::string table_text(const std::string& name, const Json& tables) {
  std::string text;
  const auto add = [&](const std::string& head, const Json& table) {
    text += head + "\n";
    for (const auto& [key, value] : table.items()) {
      if (!value.is_null()) text += toml_key(key) + " = " + toml_value(value) + "\n";
    }
  };
  if (tables.is_object()) add(fmt::format("[{}]", name), tables);
  if (tables.is_array()) {
    for (const Json& table : tables) add(fmt::format("[[{}]]", name), table);
  }
  return text;
}

Scene scene_of_json(const Json& json, const Scene& base) {
  std::string text;
  for (const auto& [name, tables] : json.items()) text += table_text(name, tables);
  const Json& mesh = json.at("mesh");
  const bool keeps_mesh =
      has_mesh_of_program(base) && !mesh.contains("file") && !mesh.contains("generate");
  try {
    if (!keeps_mesh) return with_titles(read_scene_text(text, base.path));
    Json with_file = json;
    with_file["mesh"]["file"] = kMadeMesh;
    Scene scene = scene_of_json(with_file, base);
    scene.mesh.file.clear();
    return scene;
  } catch (const InputError& error) {
    // The lines are those of the text above, which nobody sees.
    const std::string message = error.what();
    static const std::regex place(R"(^.*?:\d+:\d+: )");
    throw InputError(std::regex_replace(message, place, ""));
  }
}

}  // namespace tetraction
