// The multipliers of distances and rigid handles.
#pragma once

#include "tetraction/dynamics/constraints/constraints.h"

namespace tetraction {

/// Where the constraint forces point.
enum class ConstraintDirection {
  /// Along ∂g/∂w at q_k, where the step begins. The variational rules use this direction (Marsden &
  /// West 2001, part 3; SHAKE and RATTLE are the explicit case). Together with the projection of
  /// the momenta at the end of the step it keeps linear and angular momentum exactly.
  kStart,
  /// Along ∂g/∂w at q_{k+1}. Backward Euler uses this direction, because a solution then exists for
  /// every step size.
  kEnd,
  /// Along ∂g/∂w at (w_k + w_{k+1})/2, where the quadratic g have their discrete gradient: the forces
  /// do the work λ·(g(w_{k+1}) − g(w_k)) = 0. The energy-momentum step uses this direction.
  kMiddle
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
/// `free_end` is ŵ, the configuration at the end of the step without multipliers. `response` is S,
/// the displacement of the configuration under unit forces; it is symmetric positive semidefinite.
/// `start` is w_k. `guess` holds the multipliers to begin with; if it is empty, they are zero.
///
/// The method is Newton's with backtracking, until |g| ≤ 1e-12. Redundant equations share their
/// force (least squares). It fails if the equations contradict each other or, with kStart, if the
/// motion turns by more than about a right angle within the step.
MultiplierSolution solve_multipliers(const Constraints& constraints, const Vector& free_end,
                                     const Matrix& response, const Vector& start,
                                     ConstraintDirection direction, const Vector& guess = {});

/// The same with a sparse response, that of the masses alone. From a hundred equations on, both
/// functions take methods whose cost grows with the number of equations that share vertices.
MultiplierSolution solve_multipliers(const Constraints& constraints, const Vector& free_end,
                                     const Constraints::SparseMatrix& response, const Vector& start,
                                     ConstraintDirection direction, const Vector& guess = {});

/// x with A x = b for a symmetric positive semidefinite matrix A that belongs to the equations of constraints,
/// such as GᵀSG: the least squares solution of least norm, in which redundant equations share their force.
/// Unknowns are measured in units in which the diagonal of A is one.
Vector solve_for_multipliers(const Matrix& a, const Vector& b);

/// The message for the user if no solution was found.
std::string cannot_be_met(const Constraints& constraints, Index equation);

/// p ← the momenta nearest to p (in the metric M⁻¹) whose velocities satisfy all constraints at the
/// positions q: they belong to a motion of the free coordinates, and the rate of every g is zero.
/// Prescribed components are set to M times their rates at `time`. Returns the generalised impulses
/// u on the configuration, N s; empty without equations.
Vector project_to_constraints(const Constraints& constraints, const Vector& mass, const Vector& q,
                              double time, Vector& momentum);

/// k ← what the constraints at the positions q leave of an impulse k on the body: the change of the
/// result of project_to_constraints() if k is added to its momenta.
void project_impulse(const Constraints& constraints, const Vector& mass, const Vector& q,
                     Vector& impulse);

/// q ← the positions nearest to q (in the metric M) with g = 0 and with prescribed components at
/// their targets at `time`. Returns the name of a constraint that cannot be met, or an empty text.
std::string project_positions(const Constraints& constraints, double time, Vector& q);

}  // namespace tetraction
