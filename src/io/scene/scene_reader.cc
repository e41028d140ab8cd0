#include "tetraction/io/scene_reader.h"

#include <fmt/format.h>

#include <filesystem>

#include "key_reader.h"
#include "scene_sections.h"
#include "tetraction/core/error.h"
#include "tetraction/io/scene_echo.h"

namespace tetraction {
namespace {

MaterialSettings read_material(const TomlTable& table) {
  MaterialSettings material;
  read_keys(table, material);
  material.where = table.where();
  try {
    check_material(material);
  } catch (const InputError& error) {
    // The parameters contradict each other. If one of them came from the command line, the file
    // alone may be right.
    std::string place = table.place();
    for (const std::string_view key : table_keys<MaterialSettings>().valid) {
      if (key == "density") continue;
      if (table.is_override(key)) place = table.place(key);
    }
    std::string message = error.what();
    const std::string own = "material.";
    const bool named = message.rfind(own, 0) == 0;
    if (named) message.erase(0, own.size());
    throw InputError(fmt::format("{}: {}{}{}", place, table.name(), named ? "." : ": ", message));
  }
  return material;
}

// A section that may be absent: everything then has its default.
template <class Settings>
Settings read_section(const TomlTable& root) {
  Settings settings;
  const char* name = section_of<Settings>().name;
  if (root.has(name)) read_keys(root.table(name, table_keys<Settings>()), settings);
  return settings;
}

MaterialRegionSettings read_material_region(const TomlTable& table) {
  MaterialRegionSettings region;
  region.where = table.where();
  region.select = read_selection(table);
  region.material = read_material(table);
  return region;
}

const TableKeys& root_keys() {
  static const TableKeys keys{{"mesh",       "material",   "material_region", "time",
                               "solver",     "damping",    "environment",     "fix",
                               "constraint", "force",      "moment",          "traction",
                               "pressure",   "body_force", "amplitude",       "initial",
                               "event",      "output",     "selection",       "probe"}};
  return keys;
}

// Every amplitude that is used must be there. Messages name the place where it is used.
void check_amplitudes(const TomlTable& root, const Scene& scene) {
  const auto check = [&scene](const std::string& name, const std::string& where) {
    find_amplitude(scene.amplitude, name, where);
  };
  if (root.has("environment")) {
    check(scene.environment.amplitude,
          root.table("environment", table_keys<EnvironmentSettings>()).where());
  }
  for (const FixSettings& fix : scene.fix) check(fix.amplitude, fix.where);
  for (const ConstraintSettings& constraint : scene.constraint) {
    check(constraint.amplitude, constraint.where);
  }
  for (const LoadKind kind : load_kinds()) {
    for (const ForceSettings& load : scene.list(kind)) check(load.amplitude, load.where);
  }
}

// Everything but the events.
Scene read_sections(const TomlDocument& document, const std::string& path) {
  const TomlTable root(document, document.root(), "", root_keys());
  Scene scene;
  scene.path = path;
  scene.selection = read_named_selections(root);
  const std::string folder = std::filesystem::path(path).parent_path().string();
  scene.mesh = read_mesh_settings(root, folder);
  root.require("material",
               "under [material], give model, youngs_modulus, poissons_ratio and density.");
  scene.material = read_material(root.table("material", table_keys<MaterialSettings>()));
  NameList region_keys = table_keys<MaterialSettings>().valid;
  for (const std::string_view key : table_keys<MaterialRegionSettings>().valid) {
    region_keys.push_back(key);
  }
  for (const TomlTable& table : root.tables("material_region", {region_keys})) {
    scene.material_region.push_back(read_material_region(table));
  }
  scene.time = read_section<TimeSettings>(root);
  scene.solver = read_section<SolverSettings>(root);
  read_damping(root, scene);
  scene.environment = read_section<EnvironmentSettings>(root);
  scene.environment.direction = unit_direction(scene.environment.direction);
  for (const TomlTable& table : root.tables("fix", table_keys<FixSettings>())) {
    scene.fix.push_back(read_fix(table));
  }
  for (const TomlTable& table : root.tables("constraint", table_keys<ConstraintSettings>())) {
    scene.constraint.push_back(read_constraint(table));
  }
  for (const LoadKind kind : load_kinds()) {
    for (const TomlTable& table : root.tables(to_string(kind), load_keys(kind))) {
      scene.list(kind).push_back(read_load(table, kind));
    }
  }
  scene.amplitude = read_amplitudes(root, folder);
  scene.initial = read_initial(root, folder);
  scene.output = read_section<OutputSettings>(root);
  for (const TomlTable& table : root.tables("probe", table_keys<ProbeSettings>())) {
    scene.probe.push_back(read_probe(table));
  }
  check_amplitudes(root, scene);
  return scene;
}

}  // namespace

namespace {

Scene read_document(const TomlDocument& document, const std::string& path) {
  Scene scene = read_sections(document, path);
  const TomlTable root(document, document.root(), "", root_keys());
  read_events(
      document, root, [&path](const TomlDocument& changed) { return read_sections(changed, path); },
      scene);
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
