// Reads a file and makes everything that the window needs to show it.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "document/off_entries.h"
#include "documents.h"
#include "viewer/gui/body/body_shape.h"
#include "viewer/gui/replay/replay.h"
#include "viewer/simulation.h"

namespace tetraction::viewer {

/// A simulation or a replay, with the data for drawing the body; for a study without frames neither of them.
struct Opened {
  std::unique_ptr<Simulation> simulation;
  std::unique_ptr<Replay> replay;
  std::shared_ptr<const BodyShape> shape;
  std::vector<OffEntry> off;         ///< entries of a scene that are switched off
  std::optional<double> mesh_scale;  ///< the scale of a mesh that was opened without a scene
  std::optional<StudyGrid> runs;     ///< of a study, of which `replay` is one that has frames
  std::shared_ptr<const StoredModes> modes;  ///< of which `replay` is the first
  std::unique_ptr<Replay> other;             ///< a run to be compared with `replay`
  std::shared_ptr<const BodyShape> other_shape;
  std::optional<Scene>
      restored;  ///< with edits that were not saved, to be set up in place of the simulation
};

/// Sets up the simulation of a document. Throws InputError.
Opened set_up(Document document);

/// Reads a scene, a mesh, or the directory of a run, a study or natural modes, depending on the path. It may take long for a large
/// mesh. Thread-safe. `scale` multiplies the coordinates of a mesh; it is not allowed for a scene or a
/// run. Throws FileError if a file is missing or malformed, and InputError if the scene is wrong.
Opened open_file(const std::string& path, std::optional<double> scale);

/// Reads a scene with edits that were not saved, and the document that they were made in (empty: the first scene). If that
/// cannot be read, the simulation is that of the scene without events. Throws FileError and InputError.
Opened open_unsaved(const std::string& file, const std::string& document);

/// Reads two runs to be compared. Throws FileError, and InputError if they cannot be compared.
Opened open_pair(const std::string& first, const std::string& second);

}  // namespace tetraction::viewer
