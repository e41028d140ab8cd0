// The period of the motion that the loads or the start of a scene excite.
#pragma once

#include <string>

#include "tetraction/dynamics/mechanical_system.h"
#include "tetraction/simulation/scene.h"

namespace tetraction {

struct ExcitedPeriod {
  double period = 0.0;  ///< s; 0: there is none
  /// Where it comes from: "mode 1 (12.3 Hz)", "the amplitude shake". Without a period why there is none.
  std::string source;
};

/// The period of the lowest normal mode that the scene excites, or the period of an oscillating
/// amplitude that acts if that is shorter.
///
/// A mode φ (φᵀMφ = 1) about the undeformed body is excited by momenta p at the start, with the energy ½(φᵀp)², by
/// the force F of all loads, potentials and stresses at the initial positions, with ½(φᵀF/ω)², and by
/// prescribed motions, which cause a force G, with ½(φᵀĠ/ω²)². F and G are taken at 32 times of the run. A mode
/// counts if its energy is at least a twentieth of the largest one and its motion is no round-off. The
/// 10 lowest modes are looked at, and then 30 more if none of them counts.
///
/// Sets the constraints of `system`, which make_system() made of the scene. Throws InputError as
/// make_initial_state() does.
ExcitedPeriod excited_period(const Scene& scene, MechanicalSystem& system);

}  // namespace tetraction
