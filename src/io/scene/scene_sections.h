// The work of the scene reader beyond the descriptions of the sections.
#pragma once

#include <functional>
#include <string>

#include "key_reader.h"
#include "tetraction/simulation/scene.h"

namespace tetraction {

/// Works out the mass damping and the viscosity of `scene` from the key `ratio` of [damping], if
/// there is one. The materials must have been read before.
void read_damping_ratio(const TomlTable& damping, Scene& scene);

/// Reads all sections of a document except the events.
using SectionReader = std::function<Scene(const TomlDocument&)>;
/// Completes an obstacle whose keys have been read: reads its file.
using ObstacleReader = std::function<void(ObstacleSettings&)>;
/// Reads [[event]] into `scene`, whose other sections must have been read before.
void read_events(const TomlDocument& document, const TomlTable& root,
                 const SectionReader& read_sections, const ObstacleReader& complete_obstacle,
                 Scene& scene);

}  // namespace tetraction
