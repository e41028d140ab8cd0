// The equilibrium of a body under its loads.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tetraction/dynamics/mechanical_system.h"
#include "tetraction/dynamics/problems/minimizer.h"
#include "tetraction/simulation/scene.h"

namespace tetraction {

/// A load factor at which the equilibrium that grows out of the unloaded body ends or stops being
/// stable: a limit point or a bifurcation.
struct LimitPoint {
  double below = 0.0;   ///< a load factor with a stable equilibrium before it
  double above = 1.0;   ///< a load factor beyond it
  bool passed = false;  ///< whether another stable equilibrium was found at `above`
};

/// Loads that depend on positions, such as a pressure on a surface with a free rim, can make an equilibrium
/// unstable although its load path goes on: small motions grow there. If they swing, they count only if they grow by
/// more than a thousandth of themselves in a radian. The load steps that were made are examined, by a bound for all
/// motions or else those that grow among the lowest ones.
struct LossOfStability {
  double below = 0.0;  ///< the last load factor with an equilibrium that was found to be stable
  double above = 1.0;  ///< the first one with an unstable equilibrium
  bool is_flutter = false;     ///< whether the motion at `above` swings
  double growth_rate = 0.0;    ///< of the fastest motion at `above`, 1/s
  double damping_ratio = 0.0;  ///< what more damping of a motion that swings would stop it
  bool is_over = false;        ///< whether the last equilibrium is stable again
};

/// The results of the load steps.
struct LoadPath {
  double factor = 0.0;                   ///< the load factor that was reached
  Index steps = 0;                       ///< load steps made
  Index cuts = 0;                        ///< attempts that were repeated with a smaller increment
  std::vector<LimitPoint> limit_points;  ///< in the order of their load factors
  std::optional<LossOfStability> loss;   ///< only under loads that depend on positions
  /// Whether the load steps were examined for a loss of stability, or needed no examination, because no load
  /// depends on positions.
  bool is_examined = true;
  double residual = 0.0;        ///< |Tᵀ∇Π|₂ of the last load step, N
  double residual_limit = 0.0;  ///< what it had to be below, N
  /// The larger of the norms of loads and reactions of the last load step, N; 0 if nothing acts.
  double force = 0.0;
};

/// An equilibrium, or the last one on the way to it.
struct Equilibrium {
  bool found = false;  ///< whether `position` is an equilibrium under the full loads
  Vector position;     ///< 3 per vertex, m
  LoadPath path;
  /// The forces of the user at the load factor that was reached, 3 per vertex, N.
  Vector load;
  Vector reaction;           ///< the forces of constraints and penalty springs, 3 per vertex, N
  Index iterations = 0;      ///< linear systems solved
  Index factorizations = 0;  ///< of matrices
  Index cg_iterations = 0;   ///< of conjugate gradients
  /// If there is something to tell: why no equilibrium was found, that the path had a limit point, or
  /// that round-off is large.
  std::string message;
};

/// Finds the stable equilibrium of a body under the loads, potentials and targets at `time`, by
/// minimising its potential (StaticProblem) to round-off, beginning at rest.
///
/// It first tries the full loads at once. If the minimiser fails, an element would be inverted, or
/// the stiffness is not positive definite on the way, or the body moves several times as fast with the
/// load factor as in the step before, the increment of the load factor is halved, and
/// doubled again after an increment that needed no halving. If no increment above a thousandth is
/// possible, there is a limit point. If the minimiser finds another equilibrium beyond it, the path
/// goes on there, and the message says so. Dissipation has no effect.
///
/// Loads that depend on positions are no part of a potential. The equations of equilibrium are then
/// solved by Newton's method, which goes on from each load step to the next, whether the equilibrium is stable or not.
/// After each load step it is examined whether it is (LoadPath::loss).
///
/// One large increment may pass a limit point without a trace, if the minimiser goes straight to another
/// equilibrium. Increments of `largest_increment` at most, above 0 and at most 1, make that unlikely.
///
/// The constraints must be set. They and all else of the system stay as they are. Throws InputError for
/// wrong settings, and if a rigid motion is free (free_motions()).
Equilibrium find_equilibrium(const MechanicalSystem& system, const SolverSettings& solver = {},
                             double time = 0.0, double largest_increment = 1.0);

/// A rigid motion that neither linear constraints nor potentials restrain, in words: "move along x",
/// "rotate about the line through (0, 0.5, 0.5) along x". Parts of the body that do not hang together
/// are examined one by one. Distances and the rigidity of handles do not count. A part whose pieces touch
/// only in edges and vertices, so that they can turn against each other, has one entry more: "turn in itself as a
/// mechanism, because pieces of it touch only in …". Empty: none is free.
std::vector<std::string> free_motions(const MechanicalSystem& system, double time = 0.0);

}  // namespace tetraction
