// The consistent mass of a body, for computations without time steps.
#pragma once

#include "tetraction/dynamics/mechanical_system.h"

namespace tetraction {

/// ∫ N_a N_b dV over element e at rest for its nodes a and b, m³: 4 × 4 for linear elements and
/// 10 × 10 for quadratic ones. Exact with straight and with curved edges: N_a N_b det(∂X/∂ξ) has degree 7,
/// and so has the rule (Grundmann & Möller 1978).
///
/// Time steps use lumped masses (Body::mass()), because an explicit step divides by them.
/// Those of quadratic elements cost accuracy: the frequencies of a body converge with order 4 for
/// the consistent mass and with order 2 for the lumped one.
Matrix element_mass_matrix(const RestState& rest, Index e);

/// M v: the momentum of a field of velocities with the consistent mass, 3 per vertex, kg m/s.
Vector consistent_momentum(const MechanicalSystem& system, const Vector& velocity);

/// ∫ ρ₀ N_a dV for every vertex a, kg: the weights with which a force per mass, such as gravity, acts
/// on the vertices. They add up to the mass of the body. Those of linear elements are the lumped
/// masses. At the corners of quadratic elements they are negative in general (−1/20 of the mass of an
/// element with straight edges, and 1/5 in the middle of each edge).
Vector consistent_weights(const MechanicalSystem& system);

}  // namespace tetraction
