// The time steps: the Hamilton–Pontryagin rules and backward Euler.
//
//     p_{k+1}   = p_k − h ∇W(q_{k+α}) + h f
//     M v_{k+1} = p_k − (1−α) h ∇W(q_{k+α}) + (1−α) h f
//     q_{k+1}   = q_k + h v_{k+1}
//
// (Kharevych et al. 2006; Marsden & West 2001). α = 0 is the explicit rule, α = ½ the midpoint
// rule. verlet composes half steps of α = 0 and α = 1. Backward Euler takes the force at q_{k+1}
// and p = Mv. f contains user forces, damping and penalty springs.
//
// Multipliers act as impulses (∂g/∂q)ᵀλ at the ends of a step. The impulse at q_k makes
// g(q_{k+1}) = 0; the impulse at q_{k+1} makes the rate of g zero (RATTLE and its implicit
// counterpart; Marsden & West 2001, part 3). Backward Euler has the impulse at q_{k+1} only.
//
// explicit takes damping forces at the velocity M⁻¹p_k. verlet takes them at both ends of the step,
// the second with a predicted velocity. The implicit rules use dissipation potentials.
#pragma once

#include <memory>
#include <string>
#include <utility>

#include "tetraction/dynamics/contact/obstacle.h"
#include "tetraction/dynamics/mechanical_system.h"
#include "tetraction/dynamics/problems/minimizer.h"
#include "tetraction/dynamics/reactions.h"
#include "tetraction/dynamics/steppers/integrator.h"

namespace tetraction {

/// How a step ended. If it is not kOk, there is no new state, and the old one is unchanged.
enum class StepStatus {
  kOk,
  kInverted,      ///< an element is inverted where its energy is needed
  kNotFinite,     ///< a position or momentum overflowed
  kNotConverged,  ///< the minimiser gave up
  kUndefined,     ///< the potential of a force term is not defined at a vertex
  kOverdamped     ///< explicit rules: the damping forces at the start of the step would reverse
                  ///< velocities and add energy instead of dissipating it
};

/// The obstacle of a step that did not converge (kNotConverged), if it is known.
enum class StepObstacle {
  kSolver,            ///< the equations themselves: see the minimiser's report
  kPrescribedMotion,  ///< what moves as prescribed would crush elements
  kConstraints,       ///< the equations of distances or handles cannot be met
  kLoads,             ///< loads that depend on positions do not settle
  kViscosity,         ///< the estimate of the strain rate does not settle
  kRoundOff           ///< round-off of stresses hides the loads of an equilibrium
};

/// The result of one step and its contributions to the balance.
struct StepOutcome {
  StepStatus status = StepStatus::kOk;
  Index element = -1;           ///< inverted element (internal number)
  std::string message;          ///< why a step did not converge or ended at an undefined point
  MinimizerReport minimizer;    ///< implicit steps only
  double elastic_energy = 0.0;  ///< W_elastic(q_{k+1}), J
  double external_work = 0.0;   ///< of loads and of potentials that depend on the time, J
  /// The energy that dissipative terms and viscosity took, J; never negative. If the damping impulses of a step
  /// with an explicit rule add energy, which happens near the stability limit, this is 0, and what
  /// they add is an error of the integrator.
  double dissipated_energy = 0.0;
  double constraint_work = 0.0;  ///< of moving targets, penalty springs and moving obstacles, J
  double friction_dissipation = 0.0;  ///< heat of friction with obstacles, J; never negative
  double step_size = 0.0;             ///< h of a step in which obstacles act, s
  /// The impulse of each obstacle, N s, with its moment about the origin, N m s. Both contain friction.
  std::vector<ObstacleForce> obstacle_impulses;
  Vector3 linear_impulse = Vector3::Zero();   ///< of loads, damping, environment, reactions, N s
  Vector3 angular_impulse = Vector3::Zero();  ///< the same about the origin, N m s
  double impulse_size = 0.0;  ///< Σ of the magnitudes (|·|₁) of the impulses of vertices, N s
  double angular_impulse_size = 0.0;  ///< Σ of those of their moments about the origin, N m s
  /// The change of angular momentum that the minimiser's remaining residual r = ∇Φ(x) causes, N m
  /// s: h |Σ (x − q_k) × r| for midpoint, h |Σ q_{k+1} × r| for backward Euler.
  double residual_angular_impulse = 0.0;
  StepObstacle obstacle = StepObstacle::kSolver;  ///< of a step that did not converge
  /// The balance_shares() of all parts of the body at the end of the step, if the stepper has added
  /// them up together with the numbers above; otherwise empty.
  std::vector<double> balance_sums;

  bool ok() const { return status == StepStatus::kOk; }
};

/// One time-stepping rule applied to one system.
///
/// A stepper may keep the force at the end of a step for the beginning of the next one. Call
/// reset() after the state or the system was changed from outside, and before a step from any other
/// state than the one that the last step led to. Make a new stepper after the constraints were
/// changed, or after a material was changed from a built-in one to a custom one or back.
class Stepper {
 public:
  virtual ~Stepper() = default;
  /// Makes the step of size h > 0 that leads from `from` to `end_time`, which the caller may know
  /// without the round-off of from.time + h. The result is written to `to`, which must be another
  /// object. `from` is not changed, whatever happens. After a step that failed, or that ended with an
  /// exception of a material or a force term, `to` has no meaning. If its vectors have the size of
  /// the body already, they keep their addresses. User forces enter with their mean over the step.
  /// Moving targets are bitwise at their positions at `end_time`.
  virtual StepOutcome advance(const State& from, State& to, double h, double end_time) = 0;
  /// Advances `state` by h > 0. Its vectors keep their addresses. This takes a copy of the state,
  /// about a tenth of the time of an explicit step. A loop that calls advance() with two states in
  /// turn needs no copy.
  StepOutcome step(State& state, double h) { return step_to(state, h, state.time + h); }
  /// The same, to `end_time`.
  StepOutcome step_to(State& state, double h, double end_time);
  virtual void reset() {}
  /// Those of the last step.
  const Reactions& reactions() const { return reactions_; }
  /// Sets what reactions() returns until the next step.
  void set_reactions(const Reactions& reactions) { reactions_ = reactions; }
  /// Exchanges what reactions() returns for those of an earlier step with the same constraints, or zero. A
  /// caller can so keep them without a copy, because a step that fails may change them.
  void exchange_reactions(Reactions& reactions) { std::swap(reactions_, reactions); }

 protected:
  explicit Stepper(const MechanicalSystem& system);

  /// load ← the loads in the step of size h that begins at `from`, as their mean over it (3 per
  /// vertex, N); empty if there are none. Loads that depend on positions take those of
  /// q_k + α h M⁻¹p_k.
  void gather_loads(const State& from, double h, double alpha, Vector& load);
  /// Enters the linear and angular impulse of forces that act at positions x for the time dt.
  void add_impulse(const Vector& x, const Vector& force, double dt, StepOutcome& outcome) const;
  /// Enters a change of momenta that the constraints make at positions x, `delay` seconds before the end of the step.
  void add_reaction(const Vector& x, double delay, const Vector& impulse, StepOutcome& outcome);
  /// The work of the constraints from one state to the next, J. It is the work of the reactions,
  /// less the forces of distances, along the displacement of the moving targets, and the energy
  /// that penalty springs gave to the body. `reactions_` must not contain the springs.
  double constraint_work(const State& from, const State& to) const;
  /// The work of loads that have a potential, and that of stored potentials which depend on the
  /// time, on the body between two states, J.
  double driven_work(const State& from, const State& to) const;
  /// Enters that a step led a vertex to a point where the potential of a term is not defined.
  StepOutcome& undefined(StepOutcome& outcome, const ForceTerm& term, Index vertex) const;

  const MechanicalSystem& system_;
  Reactions reactions_;

 private:
  State result_;      // of step_to(); empty before its first call
  Vector predicted_;  // positions for gather_loads()
};

/// The rule with α = 0. This and the other steppers keep a reference to `system`.
std::unique_ptr<Stepper> make_explicit_stepper(const MechanicalSystem& system);
/// The composition of a half step with α = 0 and a half step with α = 1.
std::unique_ptr<Stepper> make_verlet_stepper(const MechanicalSystem& system);
/// The rule with α = ½. `minimizer` is called once per step, or a few times if there are
/// multipliers, viscosity or prescribed vertices that move far. Loads that depend on positions make the
/// step a system of equations that belongs to no minimum. `root_finder` solves it. Without one (null),
/// minimisations with constant loads are repeated until the loads fit the positions, which fails if
/// the loads change much with the positions.
std::unique_ptr<Stepper> make_midpoint_stepper(const MechanicalSystem& system,
                                               std::shared_ptr<Minimizer> minimizer,
                                               std::shared_ptr<RootFinder> root_finder = nullptr);
/// The rule of that name. `minimizer` may be null for rules that are not implicit, and `root_finder`
/// for rules that do not need one (needs_root_finder()); otherwise InputError is thrown.
std::unique_ptr<Stepper> make_stepper(Integrator integrator, const MechanicalSystem& system,
                                      std::shared_ptr<Minimizer> minimizer,
                                      std::shared_ptr<RootFinder> root_finder = nullptr);
/// Backward Euler. The solvers are used as for the midpoint rule.
std::unique_ptr<Stepper> make_backward_euler_stepper(
    const MechanicalSystem& system, std::shared_ptr<Minimizer> minimizer,
    std::shared_ptr<RootFinder> root_finder = nullptr);
/// The step that conserves energy and both momenta (Simo & Tarnow 1992; Gonzalez 2000). `root_finder`
/// solves its equations. `minimizer` is used where constraints have equations, and for a first guess
/// where others fail. Both must be for the same system.
std::unique_ptr<Stepper> make_energy_momentum_stepper(const MechanicalSystem& system,
                                                      std::shared_ptr<Minimizer> minimizer,
                                                      std::shared_ptr<RootFinder> root_finder);

}  // namespace tetraction
