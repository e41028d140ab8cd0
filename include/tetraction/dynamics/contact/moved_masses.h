// Masses of a body whose contact vertices are light, so that they do not chatter.
#pragma once

#include <vector>

#include "tetraction/dynamics/body.h"

namespace tetraction {

/// Lumped masses of all vertices, kg, of which the vertices in `contact` keep a share s of theirs, 0 < s ≤ 1.
///
/// A vertex of mass m on the stiff layer of an obstacle is an oscillator of its own, which no step
/// resolves: the force of contact jumps between nothing and far too much. Almost without a mass, the vertex follows the
/// layer instead (Khenous, Laborde and Renard 2008).
///
/// The rest of its mass, (1 − s) m, moves to the other vertices of its tetrahedra that are not in `contact`, in
/// proportion to the masses of the tetrahedra that both share. Where it has no such neighbours, the nearest ones
/// along edges take equal parts. Then the mass m_j* of each vertex that is not in `contact` becomes
///
///     m_j = m_j* (1 + p(X_j))
///
/// with the polynomial p of second degree that keeps the total mass, the centre of mass and the tensor of
/// inertia at rest, so that rigid motions are those of the body as it was. Where this would take more than three
/// quarters of the mass of a vertex, as in plates of few layers, p is linear and keeps mass and centre.
///
/// `contact` is ascending. Throws InputError where that takes more than nine tenths, or where the body has no vertices
/// inside.
Vector moved_masses(const Body& body, const std::vector<Index>& contact, double share);

}  // namespace tetraction
