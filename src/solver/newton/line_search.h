// The line searches of Newton's method.
#pragma once

#include "solver/linear/negative_curvature.h"
#include "tetraction/dynamics/problems/nonlinear_problem.h"
#include "turning_path.h"

namespace tetraction {

/// A point of an iteration, with what was evaluated there.
struct Iterate {
  Vector u;               ///< 3 per vertex, m
  double phi = 0.0;       ///< Φ(u), J; 0 if the problem has no Φ
  Vector force;           ///< r(u), which is ∇Φ in a minimisation, 3 per vertex, N
  double residual = 0.0;  ///< |Tᵀr|₂, N
};

/// Evaluates the problem at iterate.u. Returns false if it is not defined there or not finite.
bool evaluate(const MinimizationProblem& problem, Iterate& iterate);
bool evaluate(const RootProblem& problem, Iterate& iterate);

/// Step halving along a direction, from the longest admissible step on. Keeps work space.
class LineSearch {
 public:
  /// The direction of a search.
  struct Line {
    const Vector& direction;         ///< 3 per vertex, m
    bool elements_are_safe = false;  ///< no element can be inverted along it
    double residual_limit = 0.0;     ///< a residual that small ends the search, N
    TurningPath* path =
        nullptr;  ///< for a curved path where the longest straight step fails; null: none
  };
  /// Moves `iterate` to the first trial point that lowers Φ (Armijo 1966, with 1e-4) or halves the
  /// residual. If the decrease of Φ is below its round-off, a residual that falls by a tenth is
  /// enough. If the longest step fails, points of the curved path are tried before shorter steps, unless round-off
  /// hides the decrease. Returns false and leaves `iterate` unchanged if the direction does not descend or no
  /// trial point is good enough.
  bool search(const MinimizationProblem& problem, const Line& line, Iterate& iterate);
  /// The same with the residual |r| ≤ (1 − 1e-4 t) |r₀| as the only measure.
  bool search(const RootProblem& problem, const Line& line, Iterate& iterate);

 private:
  template <class Problem, class TryAt, class Judge, class Turn>
  bool halve(const Problem& problem, const Line& line, const TryAt& is_worth_trying,
             const Judge& judge, const Turn& turns, Iterate& iterate);
  template <class Judge>
  bool turn(const MinimizationProblem& problem, const Line& line, const Judge& judge,
            Iterate& iterate);

  Iterate before_;
};

/// Moves iterate.u along d or −d to a point with Φ(u + t d) ≤ Φ(u) − 0.1 |t ∇Φ·d + ½ t² dᵀ∇²Φ d| and
/// evaluates the problem there. The sign in which Φ does not rise is tried first. t begins at the
/// longest step without an inverted element, but moves no vertex further than the size of the body.
/// It is halved until the condition holds, and then further as long as Φ falls (compare the
/// curvilinear searches of Moré & Sorensen 1979). Returns false and leaves `iterate` unchanged if no
/// such t lowers Φ by more than its round-off.
///
/// A path is curved. It begins where the largest rotation or strain on it is of the order of one.
bool follow(const MinimizationProblem& problem, const NegativeCurvature& descent, Iterate& iterate,
            TurningPath* path = nullptr);

}  // namespace tetraction
