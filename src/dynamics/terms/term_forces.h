// The forces of all potentials and loads, which every time-stepping rule needs.
#pragma once

#include "tetraction/dynamics/mechanical_system.h"

namespace tetraction {

/// outer ← `load` (3 per vertex, N; empty: none) plus the forces of all terms with a potential.
/// constraint_force ← the part of terms that stand for constraints (EnergyAccount::kConstraintWork).
/// Returns whether there are such terms; without them constraint_force does not change.
bool gather_term_forces(const MechanicalSystem& system, const ForcePoint& at, const Vector& load,
                        Vector& outer, Vector& constraint_force);
/// The same with discrete gradients over the step between two points (ForceTerm::add_discrete_gradient()).
bool gather_discrete_forces(const MechanicalSystem& system, const ForcePoint& from,
                            const ForcePoint& to, const Vector& load, Vector& outer,
                            Vector& constraint_force);

/// The same with the forces at a point, but those of contact with obstacles from a discrete gradient.
bool gather_middle_forces(const MechanicalSystem& system, const ForcePoint& middle,
                          const ForcePoint& from, const ForcePoint& to, const Vector& load,
                          Vector& outer, Vector& constraint_force);

}  // namespace tetraction
