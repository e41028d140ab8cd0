// Rigid motions in displacements and forces of a body's vertices.
#pragma once

#include <vector>

#include "tetraction/core/types.h"

namespace tetraction {

/// The displacements d (3 per vertex, m) without the small rigid motion t + ω × x that is nearest to
/// them (least squares over the vertices where `acts` is true). The result is zero at the other vertices.
/// As forces at the positions x its numbers have neither a resultant nor a moment.
Vector without_rigid_motion(const Vector& x, const Vector& d, const std::vector<bool>& acts);

/// The rotation ω of inertia⁻¹ `moment` about the centre of mass, for instance the angular velocity of an
/// angular momentum. Axes about which the body has no inertia, as that of a line of vertices, are left
/// out.
Vector3 rotation_of(const Matrix3& inertia, const Vector3& moment);

/// Whether the forces g (3 per vertex, N) at the positions x have no resultant and no moment, up to
/// round-off.
bool is_in_balance(const Vector& x, const Vector& g);

}  // namespace tetraction
