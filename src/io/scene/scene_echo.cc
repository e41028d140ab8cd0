#include "tetraction/io/scene_echo.h"

#include <nlohmann/json.hpp>
#include <string_view>

#include "simulation/scene/setting_keys.h"

namespace tetraction {

std::string scene_echo(const Scene& scene) {
  Json json;
  for (const ScenePart& part : scene_parts()) {
    const std::string_view name = part.section->name;
    if (name == "output") {
      for (const EventSettings& event : scene.event) {
        json["event"].push_back(Json::parse(event.echo));
      }
    }
    if (name == "probe") {
      for (const NamedSelection& named : scene.selection) {
        json["selection"][named.name] = selection_json(named.select);
      }
    }
    for (const void* settings : part.entries(scene)) {
      Json entry = settings_json(*part.section, settings);
      if (part.is_list) {
        json[std::string(name)].push_back(std::move(entry));
      } else {
        json[std::string(name)] = std::move(entry);
      }
    }
  }
  // A path on the command line need not be UTF-8, which JSON must be.
  return json.dump(2, ' ', false, Json::error_handler_t::replace);
}

}  // namespace tetraction
