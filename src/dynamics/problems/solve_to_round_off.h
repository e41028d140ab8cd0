// Calls of a solver for one step, with as many digits as double precision has.
#pragma once

#include <functional>

#include "tetraction/dynamics/problems/minimizer.h"
#include "tetraction/dynamics/problems/potential_problem.h"

namespace tetraction {

/// The factor by which the estimate of round-off may be too small: a residual of less than this times
/// the estimate is taken for round-off.
inline constexpr double kRoundOffMargin = 100.0;

/// Whether a residual at u that gets no smaller may be round-off. PotentialProblem::round_off() has the moduli of small
/// strains. Where that estimate is too small, the stiffness at u counts, which may be far larger, as near the limit of a
/// chain-stretching law: positions that are rounded by ½ε of an element's length ℓ change its forces by
/// ½ε |∇²W_e| ℓ. All parts of a body must call it.
bool is_round_off(const PotentialProblem& problem, const Vector& u, double residual);

/// Makes `all` the report of the last call, with the counts of the calls before it added.
void add_call(const MinimizerReport& report, MinimizerReport& all);

/// Displacements from the origin have round-off of their own. If it prevents `call`, which solves the
/// problem and changes u, from reaching the tolerance, the origin is moved to the point that was reached
/// and `call` is repeated. If the tolerance still is not reached and the residual is round-off, the
/// result counts as converged, and the report says so (MinimizerReport::limited_by_round_off).
/// `all` is the report of all calls for the step.
MinimizerReport solve_to_round_off(PotentialProblem& problem, Vector& u, MinimizerReport& all,
                                   const std::function<MinimizerReport()>& call);

}  // namespace tetraction
