// Obstacles that a scene gets in the window.
#pragma once

#include "document/scene_changes.h"
#include "tetraction/mesh/tet_mesh.h"

namespace tetraction::viewer {

/// A change of the obstacles of a scene that gives a new one, and one of another kind, a shape that touches nothing at
/// rest: a plane, sphere or cylinder a little below the body, or a box around it. Other changes stay as they are, and the
/// surface of a mesh has no file yet.
SceneChange with_usual_shape(const SceneChange& change, const Json& scene, const TetMesh& mesh);

}  // namespace tetraction::viewer
