// Numbers of a body that several processes may hold together (mesh/mesh_part.h). All processes must call
// these functions.
#pragma once

#include "tetraction/dynamics/mechanical_system.h"

namespace tetraction {

/// The number of vertices of the body.
Index whole_vertex_count(const MechanicalSystem& system);
/// The number of tetrahedra of the body.
Index whole_tetrahedron_count(const MechanicalSystem& system);
/// The number of free coordinates of the body (FreeCoordinates::count()).
Index whole_freedom_count(const MechanicalSystem& system);
/// The sum of a field (3 per vertex) over the vertices of the body.
Vector3 whole_resultant(const MechanicalSystem& system, const Vector& field);

}  // namespace tetraction
