// Directions of negative curvature of Φ, and steps along them.
#pragma once

#include "tetraction/dynamics/step_problem.h"

namespace tetraction {

/// A direction d that the constraints allow (3 per vertex), with dᵀ∇²Φ d < 0.
struct NegativeCurvature {
  Vector direction;
  double curvature = 0.0;  ///< dᵀ∇²Φ d

  bool found() const { return direction.size() > 0; }
};

/// Moves x along d or −d to a point with Φ(x + t d) ≤ Φ(x) − 0.1 |t ∇Φ·d + ½ t² dᵀ∇²Φ d|. The sign
/// in which Φ does not rise is tried first. t begins at the longest step without an inverted
/// element, but moves no vertex further than the size of the body. It is halved until the condition
/// holds, and then further as long as Φ falls (compare the curvilinear searches of Moré & Sorensen
/// 1979). Returns false and leaves x unchanged if no such t lowers Φ by more than its round-off.
/// `phi` and `gradient` are Φ(x) and ∇Φ(x), 3 per vertex.
bool follow(const StepProblem& problem, const NegativeCurvature& way, double phi,
            const Vector& gradient, Vector& x);

/// The longest step from x along `displacement`, at most 1. It is limited by admissible_step() over
/// the elements whose energy is defined for J > 0 only (Saint Venant–Kirchhoff is defined for any J
/// and may have to pass J = 0), and by nine tenths of the way to where a force term may not be
/// defined. If `elements_are_safe`, no element can be inverted, and elements are not examined.
double longest_step(const StepProblem& problem, const Vector& x, const Vector& displacement,
                    bool elements_are_safe = false);

}  // namespace tetraction
