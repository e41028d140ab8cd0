// Guesses for large steps: the body turns as its angular momentum says.
#pragma once

#include "tetraction/dynamics/mechanical_system.h"

namespace tetraction {

/// The change of the strains in a step.
enum class GuessedStrain {
  kKept,     ///< they turn with the body
  kMirrored  ///< they change their sign, as those of vibrations do that are much faster than the step
};

/// The angular velocity ω = I⁻¹ L of the body about its centre of mass, rad/s.
Vector3 spin_of(const MechanicalSystem& system, const State& state);

/// A guess for the middle x = (q_k + q_{k+1})/2 of a step of size h of a free body, whose centre of mass
/// moves by `move` in it. The turn θ is that with which a step keeps the angular momentum of a rigid
/// body, sin θ = h|ω|; if h|ω| > 1 it is a right angle.
void guess_rotated(const MechanicalSystem& system, const State& from, double h, const Vector3& move,
                   GuessedStrain strain, Vector& x);

}  // namespace tetraction
