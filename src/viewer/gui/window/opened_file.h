// From a file to all that the window shows of it.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "documents.h"
#include "viewer/gui/body/body_shape.h"
#include "viewer/gui/replay/replay.h"
#include "viewer/simulation.h"

namespace tetraction::viewer {

/// What was read: a simulation, or a run to replay, and how the body looks.
struct Opened {
  std::unique_ptr<Simulation> simulation;
  std::unique_ptr<Replay> replay;
  std::shared_ptr<const BodyShape> shape;
  std::optional<double> mesh_scale;  ///< of a mesh without a scene: what multiplied its coordinates
};

/// Sets a scene up. Throws InputError.
Opened set_up(Document document);

/// Reads a scene, a mesh or the directory of a run, by what is there. May be called in any thread;
/// takes its time with a large mesh. `scale` multiplies the coordinates of a mesh; a scene and a run
/// do not take it. Throws FileError for what is missing or malformed, InputError for a scene that is
/// wrong.
Opened open_file(const std::string& path, std::optional<double> scale);

}  // namespace tetraction::viewer
