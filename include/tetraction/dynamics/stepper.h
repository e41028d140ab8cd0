// The time steps: the Hamilton–Pontryagin rules and backward Euler.
//
//     p_{k+1}   = p_k − h ∇W(q_{k+α}) + h f
//     M v_{k+1} = p_k − (1−α) h ∇W(q_{k+α}) + (1−α) h f
//     q_{k+1}   = q_k + h v_{k+1}
//
// (Kharevych et al. 2006; Marsden & West 2001). α = 0 is the explicit rule, α = ½ the midpoint
// rule; verlet composes half steps of α = 0 and α = 1; backward Euler takes the force at q_{k+1}
// and p = Mv.
#pragma once

#include <memory>
#include <string>

#include "tetraction/dynamics/minimizer.h"

namespace tetraction {

/// How a step ended. Anything but kOk leaves the state as it was.
enum class StepStatus {
  kOk,
  kInverted,     ///< an element is inverted where its energy is needed
  kNotFinite,    ///< a position or momentum overflowed
  kNotConverged  ///< the minimiser gave up
};

/// What one step did, for the books.
struct StepOutcome {
  StepStatus status = StepStatus::kOk;
  Index element = -1;                         ///< inverted element (internal number)
  std::string message;                        ///< of the minimiser, if it gave up
  MinimizerReport minimizer;                  ///< implicit steps only
  double elastic_energy = 0.0;                ///< W_elastic(q_{k+1}), J
  double external_work = 0.0;                 ///< of the user forces, J
  Vector3 linear_impulse = Vector3::Zero();   ///< of loads, environment and reactions, N s
  Vector3 angular_impulse = Vector3::Zero();  ///< the same about the origin, N m s
  /// Change of angular momentum that the minimiser's remaining residual r = ∇Φ(x) makes, N m s:
  /// h |Σ (x − q_k) × r| (midpoint, momenta in force form), h |Σ q_{k+1} × r| (backward Euler).
  double residual_angular_impulse = 0.0;

  bool ok() const { return status == StepStatus::kOk; }
};

/// One time-stepping rule applied to one system.
///
/// Keeps the force at the end of a step for the beginning of the next; call reset() after the state
/// or the system was changed from outside.
class Stepper {
 public:
  virtual ~Stepper() = default;
  /// Advances `state` by h > 0 under user forces held constant over the step.
  virtual StepOutcome step(State& state, double h) = 0;
  virtual void reset() {}
  /// Forces that hold the fixed DOFs during the last step (3 per vertex, N), zero elsewhere.
  const Vector& reaction_force() const { return reaction_; }

 protected:
  explicit Stepper(const MechanicalSystem& system);

  /// reaction = ∇W − f at the fixed DOFs: what keeps their momentum zero.
  void set_reaction(const Vector& gradient, const Vector& user_force);
  /// Adds weight h Σ F and weight h Σ x × F of all outer forces (user, environment, reaction).
  void add_impulse(const Vector& x, const Vector& user_force, const Vector& reaction,
                   double weighted_h, StepOutcome& outcome) const;

  const MechanicalSystem& system_;
  Vector reaction_;
};

/// α = 0. Keeps a reference to `system`, as all of these.
std::unique_ptr<Stepper> make_explicit_stepper(const MechanicalSystem& system);
/// α = 0 and α = 1 half steps composed.
std::unique_ptr<Stepper> make_verlet_stepper(const MechanicalSystem& system);
/// α = ½; `minimizer` is called once a step.
std::unique_ptr<Stepper> make_midpoint_stepper(const MechanicalSystem& system,
                                               std::shared_ptr<Minimizer> minimizer);
/// Backward Euler.
std::unique_ptr<Stepper> make_backward_euler_stepper(const MechanicalSystem& system,
                                                     std::shared_ptr<Minimizer> minimizer);

}  // namespace tetraction
