// Opens scenes and meshes, and makes the initial scene.
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

/// The kind of a path. A directory or a .pvd file is a run, a .toml file is a scene, and any other file
/// is a mesh.
DocumentKind kind_of(const std::string& path);

/// Throws FileError and InputError as read_scene() and read_mesh() do.
Document open_scene(const std::string& path);
/// A scene with the mesh as a free body of rubber at rest, without gravity. `scale` multiplies the
/// coordinates.
Document open_mesh(const std::string& path, double scale = 1.0);
/// The scene that the window shows if no file is given: a clamped beam that swings.
Document first_scene();

}  // namespace tetraction::viewer
