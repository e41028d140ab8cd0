// Motions of a body that meet no stiffness.
#pragma once

#include <vector>

#include "small_motions.h"
#include "tetraction/solver/normal_modes.h"

namespace tetraction {

/// Modes without stiffness, in the coordinates of S.
struct FreeModes {
  Matrix vectors;                    ///< orthonormal columns
  std::vector<bool> is_mechanism{};  ///< whether pieces turn against each other, for each column
};

/// Rigid motions of the body at q, and of the pieces of a mechanism, that the constraints allow and that meet no
/// stiffness, nor one of the loads if the body is `under_loads`. Whether a motion is free follows from the constraints
/// and from the terms that could resist it, each compared with its own size. The elements do not resist it, so that
/// their stiffness does not matter. Throws InputError for a mesh of more than 32 parts.
FreeModes free_rigid_motions(const MechanicalSystem& system, const Vector& q,
                             const NormalModeOptions& options, const ScaledStiffness& stiffness,
                             const LinearisedEquations& equations, bool under_loads);

}  // namespace tetraction
