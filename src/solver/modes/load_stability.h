// Whether loads that follow the deformation let small motions grow.
#pragma once

#include "tetraction/solver/normal_modes.h"

namespace tetraction {

/// The result of a search for small motions x e^(λt) about an equilibrium.
struct LoadStability {
  /// Whether the rest is known. If not, because round-off may hide what is sought, the normal modes have to
  /// tell.
  bool is_known = false;
  bool is_bounded =
      false;  ///< whether a bound excludes growth of all motions, not of the lowest alone
  double growth_rate = 0.0;  ///< Re λ of the motion that grows fastest, 1/s; 0 if none grows
  bool is_flutter = false;   ///< whether it swings
  double ratio = 0.0;        ///< Re λ/|λ| of it
};

/// Examines the equilibrium q for motions that diverge, and vibrations that grow by more than `growth`, relative to
/// themselves, in a radian.
///
/// First a bound of the growth of all motions is tried (docs/theory.md, Equilibrium). If it does not exclude such
/// motions, those that grow and the `options.count` lowest others of the damped body are sought in a space of some dozens of
/// vectors, with an accuracy of about 1e-7. The first takes one factorisation and some twenty solutions of
/// linear systems, the second some dozens more, where normal_modes() needs hundreds.
///
/// `options`: count, time, load factor and multipliers; loads are part of the stiffness. Throws InputError as
/// normal_modes() does.
LoadStability examine_loads(const MechanicalSystem& system, const Vector& q,
                            const NormalModeOptions& options, double growth);

}  // namespace tetraction
