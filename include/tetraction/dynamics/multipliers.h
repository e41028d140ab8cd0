// The multipliers of distances and rigid handles.
#pragma once

#include "tetraction/dynamics/constraints.h"

namespace tetraction {

/// Where the constraint forces point.
enum class ConstraintDirection {
  /// Along ∂g/∂w at the node q_k where the step begins: the variational rules (Marsden & West 2001,
  /// part 3; SHAKE and RATTLE are its explicit case). With the projection of the momenta at the end
  /// of the step, linear and angular momentum are exact.
  kStart,
  /// Along ∂g/∂w at q_{k+1}: backward Euler, which then finds a solution for any step.
  kEnd
};

/// Outcome of solve_multipliers().
struct MultiplierSolution {
  bool ok = false;
  Vector multipliers;  ///< λ, one per equation
  Vector forces;       ///< u = (∂g/∂w) λ
  Vector end;          ///< w_{k+1}
  Index worst = -1;    ///< the equation with the largest |g| if it failed
};

/// Finds λ such that w_{k+1} = ŵ + S u has g(w_{k+1}) = 0, u = (∂g/∂w) λ.
///
/// `free_end` is ŵ: where the configuration goes without multipliers; `response` S, symmetric
/// positive semidefinite: what unit forces move it by; `start` is w_k; `guess` the multipliers to
/// begin with (empty: zero). Newton's method with backtracking to |g| ≤ 1e-12; redundant equations
/// share their force (least squares). Fails if the equations contradict each other or, with kStart,
/// if the motion turns by more than about a right angle within the step.
MultiplierSolution solve_multipliers(const Constraints& constraints, const Vector& free_end,
                                     const Matrix& response, const Vector& start,
                                     ConstraintDirection direction, const Vector& guess = {});

/// What to tell the user of a failed solution.
std::string cannot_be_met(const Constraints& constraints, Index equation);

/// p ← the momenta nearest to p (in the metric M⁻¹) whose velocities keep all constraints at
/// positions q: the free coordinates' part, and no rate of any g. Prescribed components are set to
/// M times their rates at `time`. Returns the generalised impulses u on the configuration (empty
/// without equations), N s.
Vector project_to_constraints(const Constraints& constraints, const Vector& mass, const Vector& q,
                              double time, Vector& momentum);

/// q ← the positions nearest to q (in the metric M) with g = 0, prescribed components at their
/// targets. Returns the name of a constraint that cannot be met, or an empty text.
std::string project_positions(const Constraints& constraints, double time, Vector& q);

}  // namespace tetraction
