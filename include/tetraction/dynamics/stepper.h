// The time steps: the Hamilton–Pontryagin rules and backward Euler.
//
//     p_{k+1}   = p_k − h ∇W(q_{k+α}) + h f
//     M v_{k+1} = p_k − (1−α) h ∇W(q_{k+α}) + (1−α) h f
//     q_{k+1}   = q_k + h v_{k+1}
//
// (Kharevych et al. 2006; Marsden & West 2001). α = 0 is the explicit rule, α = ½ the midpoint
// rule; verlet composes half steps of α = 0 and α = 1; backward Euler takes the force at q_{k+1}
// and p = Mv. f holds user forces, damping and penalty springs.
//
// Multipliers act as impulses (∂g/∂q)ᵀλ at the nodes: at q_k such that g(q_{k+1}) = 0, at q_{k+1}
// such that the momenta keep g (RATTLE and its implicit counterpart; Marsden & West 2001, part 3).
// Backward Euler takes them at q_{k+1} alone. Damping: explicit at M⁻¹p_k; verlet at both ends, the
// second with a predicted velocity; the implicit rules as dissipation potentials.
#pragma once

#include <memory>
#include <string>

#include "tetraction/dynamics/integrator.h"
#include "tetraction/dynamics/minimizer.h"

namespace tetraction {

/// How a step ended. Anything but kOk leaves the state as it was.
enum class StepStatus {
  kOk,
  kInverted,      ///< an element is inverted where its energy is needed
  kNotFinite,     ///< a position or momentum overflowed
  kNotConverged,  ///< the minimiser gave up
  kUndefined,     ///< a vertex is where the potential of a force term is not defined
  kOverdamped  ///< explicit rules: the damping forces of the step are so large that they would turn
               ///< velocities around and give energy instead of taking it
};

/// What one step did, for the balance.
struct StepOutcome {
  StepStatus status = StepStatus::kOk;
  Index element = -1;              ///< inverted element (internal number)
  std::string message;             ///< why a step did not converge or ended at an undefined point
  MinimizerReport minimizer;       ///< implicit steps only
  double elastic_energy = 0.0;     ///< W_elastic(q_{k+1}), J
  double external_work = 0.0;      ///< of loads and of potentials that depend on the time, J
  double dissipated_energy = 0.0;  ///< by dissipative terms and viscosity, J; never negative
  double constraint_work = 0.0;    ///< of moving targets and penalty springs, J
  Vector3 linear_impulse = Vector3::Zero();   ///< of loads, damping, environment, reactions, N s
  Vector3 angular_impulse = Vector3::Zero();  ///< the same about the origin, N m s
  /// Change of angular momentum that the minimiser's remaining residual r = ∇Φ(x) makes, N m s:
  /// h |Σ (x − q_k) × r| (midpoint, momenta in force form), h |Σ q_{k+1} × r| (backward Euler).
  double residual_angular_impulse = 0.0;

  bool ok() const { return status == StepStatus::kOk; }
};

/// One time-stepping rule applied to one system.
///
/// Keeps the force at the end of a step for the beginning of the next; call reset() after the state
/// or the system was changed from outside, and make a new one after its constraints were, or one of
/// its materials from a built-in one to a custom one or back.
class Stepper {
 public:
  virtual ~Stepper() = default;
  /// Advances `state` by h > 0 under user forces held constant over the step.
  StepOutcome step(State& state, double h) { return step_to(state, h, state.time + h); }
  /// The same to a time that the caller knows better than by a sum of round-off: moving targets are
  /// bitwise where they are at `end_time`.
  virtual StepOutcome step_to(State& state, double h, double end_time) = 0;
  virtual void reset() {}
  /// Makes `state`, which must not have changed since the last step went well, what it was before that step.
  /// Returns false, and does nothing, where that is not known any more (implicit rules).
  virtual bool take_back(State&) { return false; }
  /// What the constraints did during the last step (3 per vertex, N): their impulse over h, and the
  /// forces of penalty springs.
  const Vector& reaction_force() const { return reaction_; }
  /// The generalised forces u on the configuration of the constraints' equations, the mean over the
  /// last step; empty without equations or before the first step.
  const Vector& configuration_force() const { return configuration_force_; }

 protected:
  explicit Stepper(const MechanicalSystem& system);

  /// Enters forces that act at positions x for the time dt: their linear and angular impulse.
  void add_impulse(const Vector& x, const Vector& force, double dt, StepOutcome& outcome) const;
  /// Enters a change of momenta that the constraints make at positions x.
  void add_reaction(const Vector& x, const Vector& impulse, StepOutcome& outcome);
  /// What moving targets did from one state to the next: the reactions, less the forces of distances,
  /// along their way; and what the penalty springs gave back, J. `reaction_` is without springs.
  double constraint_work(const State& from, const State& to) const;
  /// What potentials that depend on the time put into the body from one state to the next, J.
  double driven_work(const State& from, const State& to) const;
  /// Enters that a step has led a vertex to where the potential of a term is not defined.
  StepOutcome& undefined(StepOutcome& outcome, const ForceTerm& term, Index vertex) const;

  const MechanicalSystem& system_;
  Vector reaction_;
  Vector configuration_force_;
};

/// α = 0. Keeps a reference to `system`, as all of these.
std::unique_ptr<Stepper> make_explicit_stepper(const MechanicalSystem& system);
/// α = 0 and α = 1 half steps composed.
std::unique_ptr<Stepper> make_verlet_stepper(const MechanicalSystem& system);
/// α = ½; `minimizer` is called once a step, or a few times where there are multipliers.
std::unique_ptr<Stepper> make_midpoint_stepper(const MechanicalSystem& system,
                                               std::shared_ptr<Minimizer> minimizer);
/// The rule of that name. `minimizer` may be null for rules that are not implicit; otherwise InputError
/// is thrown.
std::unique_ptr<Stepper> make_stepper(Integrator integrator, const MechanicalSystem& system,
                                      std::shared_ptr<Minimizer> minimizer);
/// Backward Euler.
std::unique_ptr<Stepper> make_backward_euler_stepper(const MechanicalSystem& system,
                                                     std::shared_ptr<Minimizer> minimizer);

}  // namespace tetraction
