// The derivatives of contact, for `tetraction check`.
#pragma once

#include <optional>

#include "tetraction/dynamics/mechanical_system.h"
#include "tetraction/dynamics/problems/derivative_check.h"

namespace tetraction {

/// Compares force and stiffness of contact with central differences of energy and force, in layers of the obstacles:
/// the body is moved from q along each axis until its distance to the first obstacle is about half of the thickness,
/// and its surface is strained a little there. Differences are taken in fixed random directions, with steps of
/// 3e-5 of the distance. None if no obstacle is met.
std::optional<DerivativeErrors> check_contact_derivatives(const MechanicalSystem& system,
                                                          const Vector& q);

}  // namespace tetraction
