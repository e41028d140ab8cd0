// Newton's method for equilibria of bodies that nearly keep their volume.
#pragma once

#include <memory>

#include "tetraction/dynamics/mechanical_system.h"
#include "tetraction/dynamics/problems/minimizer.h"

namespace tetraction {

/// Whether the material of the body has a volumetric part U(J) everywhere and somewhere resists a change of volume so
/// much more than a change of shape that make_mixed_newton_minimizer() is worth while.
bool nearly_keeps_volume(const MechanicalSystem& system);

/// A minimiser for load steps of such a body. It first goes to the equilibrium by Newton's method with the
/// pressures as unknowns of their own. `inner` minimises from there: it removes what is left and examines the
/// Hessian.
///
/// Along a Newton step d of the displacements u alone J changes to second order, and a large U'' makes a large
/// energy of this change, so that only short steps lower the potential. The equations p = U'(J) for pressures p,
/// positive in tension, beside ∇Φ(u) = 0 let J deviate on the way, and the next step corrects it (a perturbed
/// Lagrangian; compare Magisano, Leonetti & Garcea 2017). Without the unknowns p a step is
///
///     (∇²Φ + Σ w (p − U') ∂²J/∂u²) d = −∇Φ,   p ← U' + U'' ∂J/∂u d.
///
/// The solutions are those of ∇Φ = 0. Where the matrix is not positive definite, it is taken without p. A
/// step is halved until the next correction with the same matrix is shorter (the natural
/// monotonicity test of Deuflhard 2004, section 3.1.4). Where that fails, or Φ has not fallen in the end, `inner` begins
/// where it would have begun, or if StaticProblem::is_divisible(), the minimisation fails at once.
std::unique_ptr<Minimizer> make_mixed_newton_minimizer(const MechanicalSystem& system,
                                                       const MinimizerOptions& options,
                                                       std::unique_ptr<Minimizer> inner);

}  // namespace tetraction
