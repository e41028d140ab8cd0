// Normal modes with the unsymmetric stiffness of loads that follow the deformation.
#pragma once

#include <vector>

#include "lowest_eigenpairs.h"
#include "mode_construction.h"
#include "small_motions.h"
#include "tetraction/solver/normal_modes.h"

namespace tetraction {

/// The modes with the whole stiffness of the loads. `start`: eigenvectors of S as columns, of which the
/// first are the rigid motions, which are eigenvectors of the whole stiffness, too. `units`: the unit
/// translations along x, y, z, in the coordinates of S.
std::vector<NormalMode> modes_under_loads(const MechanicalSystem& system, const Vector& q,
                                          const NormalModeOptions& options,
                                          const ScaledStiffness& stiffness,
                                          const LinearisedEquations& equations,
                                          const RoundOff& round_off, const ModeSearch& search,
                                          const Matrix& start, Index rigid, const Matrix& units,
                                          Index count);

}  // namespace tetraction
