// The point at which the minimisation of an implicit step begins.
#pragma once

#include <array>
#include <vector>

#include "tetraction/dynamics/problems/step_problem.h"

namespace tetraction {

/// Sets the origin of a step problem to the guess with the lowest Φ. The guesses are: the motion by
/// inertia alone; q_k itself; the last velocity, constant or extrapolated from earlier steps; and,
/// for a body without constraints, the rigid motion nearest to the motion by inertia, which is
/// close to the motion of a stiff body at any step size.
class FirstGuess {
 public:
  /// `prescribed_move` says whether prescribed vertices move. Keeps a reference to `system`, which
  /// must live longer.
  FirstGuess(const MechanicalSystem& system, bool prescribed_move);

  /// Forgets earlier steps. Call it after the state or the system was changed from outside.
  void reset();
  /// The quality of the best guess.
  enum class Quality {
    kGood,
    kCrushed,   ///< prescribed vertices crush or invert elements beside them
    kUndefined  ///< Φ is defined at none of the guesses; the origin is the problem's base()
  };
  /// Sets the origin. Unless the guess is good, carry_along() should be used.
  Quality choose(StepProblem& problem, const State& state);
  static constexpr int kCount = 6;  ///< the number of guesses
  /// x ← guess number `i`. Returns false if it is not possible in this step.
  bool propose(int i, const StepProblem& problem, const State& state, Vector& x) const {
    if (!is_possible(i)) return false;
    make(i, problem, state, x);
    return true;
  }
  /// Moves the prescribed components of x to their values in problem.base(), and the rest of the
  /// body by the harmonic extension of this displacement: the one with the least Σ V |∇u|² over the
  /// free coordinates.
  void carry_along(const PotentialProblem& problem, Vector& x) const;
  /// Whether the elements at prescribed vertices keep a sufficient part of their volume at `from`.
  bool keeps_volumes(const Vector& from, const Vector& x) const;
  /// Call it after a step from a state with this velocity. `elastic_energy` is that at q_{k+1}.
  void keep(const Vector& velocity, double elastic_energy);

 private:
  static constexpr int kStay = 1;   // q_k; 0: inertia; 2 to 4: velocities
  static constexpr int kRigid = 5;  // the last one

  bool is_possible(int guess) const { return guess == kRigid ? free_ : guess < 3 + earlier_count_; }
  void make(int guess, const StepProblem& problem, const State& state, Vector& x) const;
  // Whether Φ at q_k is the elastic energy there.
  bool knows_value_of_stay() const {
    return knows_energy_ && !moving_ && system_.contact() == nullptr;
  }

  // The rigid motion of q with the least Σ m |x − target|² (shape matching, Müller et al. 2005).
  void make_rigid(const Vector& q, const Vector& target, Vector& x) const;

  const MechanicalSystem& system_;
  bool free_ = false;    // the body has no constraints
  bool moving_ = false;  // prescribed vertices move
  int best_ = 0;         // of the last step
  // Velocities of the steps before the last one, and how many of them are known.
  std::array<Vector, 2> earlier_;
  int earlier_count_ = 0;
  bool knows_energy_ = false;
  double elastic_energy_ = 0.0;        // at q_k
  std::vector<Index> moved_elements_;  // some of whose vertices are prescribed
  Vector zero_;
  Vector least_;
  Vector trial_;
  Vector gradient_;
};

}  // namespace tetraction
