#include "implicit_stepper.h"

#include <Eigen/Geometry>
#include <utility>

#include "term_forces.h"

namespace tetraction {

ImplicitStepper::ImplicitStepper(const MechanicalSystem& system,
                                 std::shared_ptr<Minimizer> minimizer, double alpha,
                                 ConstraintDirection direction)
    : Stepper(system),
      alpha_(alpha),
      direction_(direction),
      minimizer_(std::move(minimizer)),
      problem_(system),
      guess_(system) {}

void ImplicitStepper::reset() {
  constraint_force_.resize(0);
  guess_.reset();
}

StepOutcome ImplicitStepper::step_to(State& state, double h, double end_time) {
  StepOutcome outcome;
  system_.external_force(state.time, h, load_);
  reaction_.setZero();
  problem_.begin(state, h, end_time, alpha_, load_);
  if (!find(state, end_time, outcome)) return outcome;

  next_.step = state.step + 1;
  next_.time = end_time;
  problem_.positions(u_, x_);
  // The change of position before it is rounded to a position.
  next_.velocity = ((problem_.origin() - state.position) + u_) / problem_.step();
  set_end_position(state, h);
  system_.constraints().prescribe(next_.time, next_.position);
  if (!take_momenta(state, h, outcome)) return outcome;
  if (!next_.position.allFinite() || !next_.momentum.allFinite()) {
    outcome.status = StepStatus::kNotFinite;
    return outcome;
  }
  // With the midpoint rule an element may be inverted at q_{k+1} although it is not at x. The
  // energy is that of the rounded positions, because an edit between two steps computes the same.
  const EvaluationStatus end = system_.elastic().value(next_.position, outcome.elastic_energy);
  if (!end.ok()) {
    outcome.status = StepStatus::kInverted;
    outcome.element = end.failed_element;
    return outcome;
  }
  Index vertex = -1;
  const ForceTerm* term = system_.undefined_term(next_.position, next_.time, vertex);
  if (term != nullptr) return undefined(outcome, *term, vertex);
  if (load_.size() > 0) outcome.external_work = load_.dot(next_.position - state.position);
  outcome.external_work += driven_work(state, next_);
  if (system_.is_dissipative()) outcome.dissipated_energy = problem_.dissipated_energy(u_, h);
  reaction_ /= h;
  outcome.constraint_work = constraint_work(state, next_);
  if (constraining_) reaction_ += spring_force_;
  guess_.keep(state.velocity, outcome.elastic_energy);
  std::swap(state, next_);
  return outcome;
}

bool ImplicitStepper::take_momenta(const State& state, double h, StepOutcome& outcome) {
  const double s = problem_.step();
  const Vector* gradient = nullptr;
  if (const EvaluationStatus status = problem_.elastic_gradient(u_, gradient); !status.ok()) {
    outcome.status = StepStatus::kInverted;
    outcome.element = status.failed_element;
    return false;
  }
  gather_forces(state.time + s, *gradient);
  add_impulse(x_, outer_, h, outcome);

  const bool has_equations = system_.constraints().has_equations();
  if (has_equations) start_ = state.momentum + impulse_;
  const Vector& start = has_equations ? start_ : state.momentum;
  system_.momentum_of(next_.velocity, carried_);

  Vector& residual = work_;
  residual = (carried_ - start) / s - force_;
  system_.coordinates().project_momentum(system_.mass(), residual);
  Vector3 torque = Vector3::Zero();
  for (Index v = 0; v < system_.vertex_count(); ++v) {
    torque += residual_arm(state, v).cross(vertex_block(residual, v));
  }
  outcome.residual_angular_impulse = h * torque.norm();
  set_end_momentum(state, start, h, outcome);
  return true;
}

// outer_ ← the forces at x_ that change the body's momentum, force_ ← all forces, damping_ ← those
// of damping, spring_force_ ← those of terms that stand for constraints. `gradient`: of the elastic
// energy.
void ImplicitStepper::gather_forces(double time, const Vector& gradient) {
  constraining_ = gather_term_forces(system_, x_, time, load_, outer_, spring_force_);
  force_ = outer_ - gradient;
  if (!system_.is_dissipative()) return;
  // The forces of viscosity are minus the gradient of its potential.
  damping_.setZero(system_.dof_count());
  double ignored = 0.0;
  problem_.viscous().add_value_and_gradient(problem_.step_displacement(u_), ignored, damping_);
  damping_ = -damping_;
  const Vector& point = problem_.dissipation_point();
  system_.add_damping_force(point, time, next_.velocity, damping_);
  system_.add_damping_force(point, time, next_.velocity, outer_);
  force_ += damping_;
}

}  // namespace tetraction
