// Opens scenes and meshes, and makes the first scene.
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

/// The kind of a path: a directory or a .pvd is a run, a .toml is a scene, anything else is a mesh.
DocumentKind kind_of(const std::string& path);

/// Throws FileError and InputError as read_scene() and read_mesh() do.
Document open_scene(const std::string& path);
/// The mesh in a scene of rubber: at rest, held nowhere, without gravity. `scale` multiplies its
/// coordinates.
Document open_mesh(const std::string& path, double scale = 1.0);
/// The scene that the window shows if nothing else is opened: a clamped beam that swings.
Document first_scene();

}  // namespace tetraction::viewer
