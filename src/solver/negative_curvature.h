// Directions in which a potential bends downwards, and the way along them.
#pragma once

#include "tetraction/dynamics/step_problem.h"

namespace tetraction {

/// A direction d (3 per vertex, along what the constraints leave free) with dᵀ∇²Φ d < 0.
struct NegativeCurvature {
  Vector direction;
  double curvature = 0.0;  ///< dᵀ∇²Φ d

  bool found() const { return direction.size() > 0; }
};

/// x ← x + t d, or x − t d, with Φ(x + t d) ≤ Φ(x) − 0.1 |t ∇Φ·d + ½ t² dᵀ∇²Φ d|, first along the sign
/// in which Φ does not rise: t is halved from as far as no element is inverted and the body's own
/// size, and on until Φ no longer falls (curvilinear searches: Moré & Sorensen 1979). False, and x
/// as it was, where no such t lowers Φ by more than its round-off.
/// `phi`, `gradient`: Φ(x) and ∇Φ(x), 3 per vertex.
bool follow(const StepProblem& problem, const NegativeCurvature& way, double phi,
            const Vector& gradient, Vector& x);

/// The longest step from x along `displacement`, at most 1: admissible_step() over the elements whose
/// energy is defined for J > 0 only (Saint Venant–Kirchhoff is for any J and may have to go through 0),
/// and nine tenths of the way to where a force term may not be defined. `elements_are_safe`: none can
/// be inverted.
double longest_step(const StepProblem& problem, const Vector& x, const Vector& displacement,
                    bool elements_are_safe = false);

}  // namespace tetraction
