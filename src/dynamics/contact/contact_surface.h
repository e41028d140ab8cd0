// The surface of a body that may touch an obstacle.
#pragma once

#include "obstacle_contact.h"
#include "tetraction/dynamics/contact/obstacle.h"
#include "tetraction/mesh/tet_mesh.h"

namespace tetraction {

/// What keeps the corners of quadratic faces out, whose consistent weights are zero.
enum class Corners {
  kSmallArea,  ///< a thousandth of the area of the face
  kGuarded     ///< an area of their own, but in the inner half of the layer only
};

/// The surface of the faces of an obstacle. Throws InputError for a surface without faces and for corners that the
/// mesh does not have.
ContactSurface contact_surface(const TetMesh& mesh, const Obstacle& obstacle,
                               Corners corners = Corners::kSmallArea);

}  // namespace tetraction
