#include "tetraction/io/scene_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <utility>

#include "core/quoting.h"
#include "dynamics/contact/mesh/triangle_mesh.h"
#include "io/mesh/triangle_mesh_reader.h"
#include "io/text/csv_table.h"
#include "scene_sections.h"
#include "tetraction/core/error.h"
#include "tetraction/io/scene_echo.h"

namespace tetraction {
namespace {

namespace fs = std::filesystem;

// The parameters of a material must belong to its model.
void check_read_material(const TomlTable& table, const MaterialSettings& material) {
  try {
    check_material(material);
  } catch (const InputError& error) {
    // The parameters contradict each other. If one of them came from the command line, the file
    // alone may be right.
    std::string place = table.place();
    for (const std::string_view key : table_keys(section_of<MaterialSettings>()).valid) {
      if (key == "density") continue;
      if (table.is_override(key)) place = table.place(key);
    }
    std::string message = error.what();
    const std::string own = "material.";
    const bool named = message.rfind(own, 0) == 0;
    if (named) message.erase(0, own.size());
    throw InputError(fmt::format("{}: {}{}{}", place, table.name(), named ? "." : ": ", message));
  }
}

// The contents of the file of an amplitude.
std::vector<std::pair<double, double>> read_amplitude_file(const std::string& file) {
  std::vector<std::pair<double, double>> points;
  for (const CsvTable::Row& row : read_csv(file).rows) {
    if (row.values.size() != 2) {
      throw FileError(fmt::format(
          "{}:{}: an amplitude has two columns, time in s and factor; this line has {}.", file,
          row.line, row.values.size()));
    }
    if (!points.empty() && !(row.values[0] > points.back().first)) {
      throw FileError(fmt::format("{}:{}: the times must increase, but {} s comes after {} s.",
                                  file, row.line, row.values[0], points.back().first));
    }
    if (!points.empty() && !std::isfinite(row.values[1] - points.back().second)) {
      throw FileError(fmt::format(
          "{}:{}: neighbouring values may differ by up to 1.8e308, but {} comes after {}.", file,
          row.line, row.values[1], points.back().second));
    }
    points.emplace_back(row.values[0], row.values[1]);
  }
  return points;
}

// An amplitude has exactly one of the kinds.
void check_amplitude_kind(const TomlTable& table) {
  const std::vector<const char*> names = names_of<AmplitudeKind>();
  const NameList kinds(names.begin(), names.end());
  std::string_view kind;
  for (const std::string_view candidate : kinds) {
    if (!table.has(candidate)) continue;
    if (!kind.empty()) {
      table.refuse(candidate,
                   fmt::format("is one key too many: {} is given as well. Give one of {}.", kind,
                               listing(kinds)));
    }
    kind = candidate;
  }
  if (kind.empty()) table.refuse_table(fmt::format("needs one of {}.", listing(kinds)));
}

void complete_amplitude(const TomlTable& table, const std::string& folder, Scene& scene) {
  AmplitudeSettings& amplitude = scene.amplitude.back();
  if (amplitude.kind == AmplitudeKind::kFile) {
    const fs::path path(amplitude.file);
    if (path.is_relative()) amplitude.file = (fs::path(folder) / path).string();
    amplitude.points = read_amplitude_file(amplitude.file);
  }
  make_amplitude(amplitude);  // throws if the values contradict each other
  const auto same =
      std::count_if(scene.amplitude.begin(), scene.amplitude.end(),
                    [&](const AmplitudeSettings& other) { return other.name == amplitude.name; });
  if (same > 1) {
    table.refuse("name", fmt::format("= {} is the name of another amplitude already.",
                                     in_quotes(amplitude.name)));
  }
}

// The surfaces of obstacles by their paths. Each file is read once, however many events change its obstacle.
class ObstacleFiles {
 public:
  explicit ObstacleFiles(std::string folder) : folder_(std::move(folder)) {}

  void complete(ObstacleSettings& obstacle) {
    if (obstacle.kind != ObstacleKind::kMesh) return;
    const fs::path path(obstacle.file);
    if (path.is_relative()) obstacle.file = (fs::path(folder_) / path).lexically_normal().string();
    auto known = surfaces_.find(obstacle.file);
    if (known == surfaces_.end()) {
      TriangleFile read = read_triangle_file(obstacle.file);
      auto surface = std::make_shared<const MeshShape>(
          MeshShape{std::move(read.points), std::move(read.triangles)});
      try {
        TriangleMesh(surface->points, surface->triangles);
      } catch (const InputError& error) {
        throw FileError(fmt::format("{}: {}", obstacle.file, error.what()));
      }
      known = surfaces_.emplace(obstacle.file, std::move(surface)).first;
    }
    obstacle.surface = known->second;
  }

 private:
  std::string folder_;
  std::map<std::string, std::shared_ptr<const MeshShape>> surfaces_;
};

void complete_initial(const TomlTable& table, const std::string& folder, InitialSettings& initial) {
  for (const char* key : {"stretch", "displacement", "displacement_array"}) {
    if (table.has(key)) initial.places.emplace(key, table.place(key));
  }
  for (FieldSettings* field : {&initial.displacement_field, &initial.velocity_field}) {
    if (field->file.empty()) continue;
    field->file = (fs::path(folder) / field->file).lexically_normal().string();
  }
}

void refuse_two_places(const TomlTable& probe) {
  constexpr std::array kPlaces{"select", "point", "obstacle"};
  for (std::size_t b = 1; b < kPlaces.size(); ++b) {
    for (std::size_t a = 0; a < b; ++a) {
      if (!probe.has(kPlaces.at(a)) || !probe.has(kPlaces.at(b))) continue;
      probe.refuse(kPlaces.at(b), one_key_too_many(kPlaces.at(a), kPlaces.at(b),
                                                   ", and each says where the probe is"));
    }
  }
}

// Reads the table of a section into a scene, and what belongs to it beyond its keys. `folder` is
// where the scene lies: the paths of files are relative to it.
void read_part(const TomlTable& table, const ScenePart& part, const std::string& folder,
               ObstacleFiles& files, Scene& scene) {
  const std::string_view name = part.section->name;
  if (name == "amplitude") check_amplitude_kind(table);
  read_settings(table, *part.section, part.add(scene));
  if (name == "probe") refuse_two_places(table);
  if (name == "mesh" && !scene.mesh.file.empty()) {
    scene.mesh.file = (fs::path(folder) / scene.mesh.file).lexically_normal().string();
  } else if (name == "material") {
    check_read_material(table, scene.material);
  } else if (name == "material_region") {
    check_read_material(table, scene.material_region.back().material);
  } else if (name == "damping") {
    read_damping_ratio(table, scene);
  } else if (name == "environment") {
    scene.environment.direction = unit_direction(scene.environment.direction);
  } else if (name == "amplitude") {
    complete_amplitude(table, folder, scene);
  } else if (name == "obstacle") {
    files.complete(scene.obstacle.back());
  } else if (name == "initial") {
    complete_initial(table, folder, scene.initial);
  }
}

TableKeys root_keys() {
  TableKeys keys;
  for (const ScenePart& part : scene_parts()) {
    const std::string_view name = part.section->name;
    if (name == "output") keys.valid.emplace_back("event");
    if (name == "probe") keys.valid.emplace_back("selection");
    keys.valid.push_back(name);
  }
  return keys;
}

// Every amplitude that is used must be there. Messages name the place where it is used.
void check_amplitudes(const TomlTable& root, const Scene& scene) {
  for (const ScenePart& part : scene_parts()) {
    const SceneSection& section = *part.section;
    const SceneKey* key = section.find("amplitude");
    if (key == nullptr || !root.has(section.name)) continue;
    for (const void* settings : part.entries(scene)) {
      const auto& name = *static_cast<const std::string*>(key->value->member(settings));
      find_amplitude(scene.amplitude, name,
                     section.where ? *section.where(const_cast<void*>(settings))
                                   : root.table(section.name, table_keys(section)).where());
    }
  }
}

// Everything but the events.
Scene read_sections(const TomlDocument& document, const std::string& path, ObstacleFiles& files) {
  const TomlTable root(document, document.root(), "", root_keys());
  Scene scene;
  scene.path = path;
  scene.selection = read_named_selections(root);
  const std::string folder = fs::path(path).parent_path().string();
  for (const ScenePart& part : scene_parts()) {
    const char* name = part.section->name;
    if (part.section->needed != nullptr) root.require(name, part.section->needed);
    if (!root.has(name)) continue;
    const TableKeys keys = table_keys(*part.section);
    const std::vector<TomlTable> tables =
        part.is_list ? root.tables(name, keys) : std::vector{root.table(name, keys)};
    for (const TomlTable& table : tables) read_part(table, part, folder, files, scene);
  }
  check_amplitudes(root, scene);
  return scene;
}

Scene read_document(const TomlDocument& document, const std::string& path) {
  ObstacleFiles files(fs::path(path).parent_path().string());
  Scene scene = read_sections(document, path, files);
  const TomlTable root(document, document.root(), "", root_keys());
  read_events(
      document, root,
      [&](const TomlDocument& changed) { return read_sections(changed, path, files); },
      [&](ObstacleSettings& obstacle) { files.complete(obstacle); }, scene);
  scene.echo = scene_echo(scene);
  return scene;
}

}  // namespace

Scene read_scene(const std::string& path, const std::vector<std::string>& overrides) {
  return read_document(TomlDocument(path, overrides), path);
}

Scene read_scene_text(const std::string& text, const std::string& path,
                      const std::vector<std::string>& overrides) {
  return read_document(TomlDocument(path, text, overrides), path);
}

}  // namespace tetraction
