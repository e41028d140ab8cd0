#include "tetraction/dynamics/steppers/stepper.h"

#include "common_outcome.h"
#include "tetraction/dynamics/contact/contact.h"

namespace tetraction {

Stepper::Stepper(const MechanicalSystem& system)
    : system_(system), reactions_(Reactions::zero(system.dof_count())) {}

StepOutcome Stepper::step_to(State& state, double h, double end_time) {
  StepOutcome outcome = advance(state, result_, h, end_time);
  if (outcome.ok()) state = result_;
  return outcome;
}

void Stepper::gather_loads(const State& from, double h, double alpha, Vector& load) {
  if (alpha == 0.0 || !system_.has_load_of_position()) {
    system_.external_force(from.position, from.time, h, load);
    return;
  }
  system_.velocity_of(from.momentum, predicted_);
  predicted_ = from.position + alpha * h * predicted_;
  system_.external_force(predicted_, from.time, h, load);
}

void Stepper::add_impulse(const Vector& x, const Vector& force, double dt,
                          StepOutcome& outcome) const {
  ImpulseSums sums(outcome);
  for (Index v = 0; v < system_.owned_vertex_count(); ++v) {
    sums.add_at(vertex_block(x, v), dt * vertex_block(force, v));
  }
  sums.enter(outcome);
}

void Stepper::add_reaction(const Vector& x, double delay, const Vector& impulse,
                           StepOutcome& outcome) {
  reactions_.force += impulse;
  if (delay != 0.0) reactions_.delay += delay * impulse;
  add_impulse(x, impulse, 1.0, outcome);
}

double Stepper::constraint_work(const State& from, const State& to) const {
  const Constraints& constraints = system_.constraints();
  double work = 0.0;
  if (constraints.moving()) {
    // A reaction is the force of the support plus the forces of distances at the vertex. The work
    // of a distance at its two ends adds up to zero, so that only the work of the support counts.
    Vector passed_on;
    if (reactions_.configuration_force.size() > 0) {
      passed_on = constraints.vertex_forces(reactions_.configuration_force);
    }
    constraints.for_each_prescribed_displacement(
        from.position, to.time, [&](Index v, const Vector3& displacement) {
          if (v >= system_.owned_vertex_count()) return;
          work += vertex_block(reactions_.force, v).dot(displacement);
          if (passed_on.size() > 0) work -= vertex_block(passed_on, v).dot(displacement);
        });
  }
  // For terms that stand for constraints the work of their dependence on the time counts, less the
  // change of their stored energy.
  const ForcePoint start = system_.energy_point(from.position, from.time);
  const ForcePoint end = system_.energy_point(to.position, to.time);
  for (const ForceTerm* term : system_.force_terms()) {
    if (!term->has_potential() || term->account() != EnergyAccount::kConstraintWork) continue;
    work += term->energy(start) - term->energy(end);
    work += term->driven_work(start, end);
  }
  return work;
}

double Stepper::driven_work(const State& from, const State& to) const {
  const ForcePoint start = system_.energy_point(from.position, from.time);
  const ForcePoint end = system_.energy_point(to.position, to.time);
  double work = 0.0;
  for (const ForceTerm* term : system_.force_terms()) {
    if (!term->has_potential() || term == system_.contact()) continue;
    const EnergyAccount account = term->account();
    if (account != EnergyAccount::kStored && account != EnergyAccount::kExternalWork) continue;
    work += term->driven_work(start, end);
    if (account == EnergyAccount::kExternalWork) work -= term->energy_change(start, end);
  }
  return work;
}

StepOutcome& Stepper::undefined(StepOutcome& outcome, const ForceTerm& term, Index vertex) const {
  outcome.status = StepStatus::kUndefined;
  if (&term == system_.contact() && vertex >= 0) {
    const bool among_bodies = system_.contact()->between() != nullptr;
    outcome.message = "vertex " + std::to_string(system_.mesh().vertex_id(vertex)) +
                      " would penetrate an obstacle " + (among_bodies ? "or a body " : "") +
                      "or pass through it";
    return outcome;
  }
  const std::string potential = "the potential of the force term \"" + term.name() + "\" is not ";
  outcome.message = vertex < 0 ? potential + "finite"
                               : potential + "defined at vertex " +
                                     std::to_string(system_.mesh().vertex_id(vertex)) +
                                     ", where the step led it";
  return outcome;
}

}  // namespace tetraction
