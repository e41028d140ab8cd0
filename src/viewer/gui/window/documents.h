// What can be opened: scenes, meshes, and a first scene that moves.
#pragma once

#include <string>

#include "tetraction/mesh/tet_mesh.h"
#include "tetraction/simulation/scene.h"

namespace tetraction::viewer {

struct Document {
  Scene scene;
  TetMesh mesh;
};

enum class DocumentKind { kScene, kMesh, kRun };

/// By what is there: a directory or a .pvd is a run, .toml a scene, anything else a mesh.
DocumentKind kind_of(const std::string& path);

/// Throws FileError and InputError as read_scene() and read_mesh() do.
Document open_scene(const std::string& path);
/// The mesh in a scene of rubber: at rest, held nowhere, without gravity. `scale` multiplies its
/// coordinates.
Document open_mesh(const std::string& path, double scale = 1.0);
/// What the window shows when nothing was asked for: a clamped beam that swings.
Document first_scene();

}  // namespace tetraction::viewer
