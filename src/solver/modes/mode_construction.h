// Normal modes made of eigenvectors.
#pragma once

#include <limits>

#include "small_motions.h"
#include "tetraction/solver/normal_modes.h"

namespace tetraction {

inline constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

/// Estimates of the round-off of eigenvalues.
struct RoundOff {
  double largest = 0.0;  ///< of S
  double turning = 0.0;  ///< (c/L)² with the wave speed c and the size L of the body, 1/s²
  double beyond = std::numeric_limits<double>::infinity();  ///< |ω²| that no mode left out is below

  /// The part of an eigenvector that belongs to modes that were left out has changed ω² by this part.
  /// S as a matrix, which gives the eigenvectors, has an error of about ε max S_ii.
  double of_vector(double omega_squared) const;
  /// The relative error of a frequency.
  double of_frequency(double omega_squared) const;
};

/// The mode of an eigenvector z of S.
NormalMode make_mode(const MechanicalSystem& system, const ScaledStiffness& stiffness,
                     const RoundOff& round_off, double omega_squared, const Vector& z);
/// A mode without stiffness.
NormalMode make_rigid_mode(const MechanicalSystem& system, const ScaledStiffness& stiffness,
                           const Vector& z, bool is_mechanism = false);
/// Sets the damping ratio of a mode φ, ζ = φᵀCφ/(2ω).
void enter_damping(const DampingMatrix& damping, NormalMode& mode);

}  // namespace tetraction
