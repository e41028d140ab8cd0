#include "implicit_stepper.h"

#include <Eigen/Geometry>
#include <utility>

#include "common_outcome.h"
#include "converge_loads.h"
#include "dynamics/contact/friction/friction_step.h"
#include "dynamics/terms/term_forces.h"
#include "tetraction/dynamics/body_sums.h"
#include "tetraction/dynamics/contact/contact.h"

namespace tetraction {

ImplicitStepper::ImplicitStepper(const MechanicalSystem& system,
                                 std::shared_ptr<Minimizer> minimizer,
                                 std::shared_ptr<RootFinder> root_finder, double alpha,
                                 ConstraintDirection direction)
    : ImplicitStepper(std::make_unique<StepProblem>(system), std::move(minimizer),
                      std::move(root_finder), alpha, direction) {}

ImplicitStepper::ImplicitStepper(std::unique_ptr<StepProblem> problem,
                                 std::shared_ptr<Minimizer> minimizer,
                                 std::shared_ptr<RootFinder> root_finder, double alpha,
                                 ConstraintDirection direction)
    : Stepper(problem->system()),
      problem_(std::move(problem)),
      solve_(*problem_, std::move(minimizer), std::move(root_finder), 1.0 / alpha, direction),
      guess_(system_, system_.constraints().moving()),
      moving_(anywhere(system_.part(), system_.constraints().moving())),
      alpha_(alpha) {}

void ImplicitStepper::reset() {
  solve_.forget();
  guess_.reset();
}

StepOutcome ImplicitStepper::advance(const State& from, State& to, double h, double end_time) {
  StepOutcome outcome = advance_part(from, to, h, end_time);
  make_common(system_.part(), outcome);
  if (outcome.ok()) guess_.keep(from.velocity, outcome.elastic_energy);
  return outcome;
}

StepOutcome ImplicitStepper::advance_part(const State& from, State& to, double h, double end_time) {
  StepOutcome outcome;
  gather_loads(from, h, alpha_, load_);
  reactions_.force.setZero();
  reactions_.delay.setZero();
  problem_->begin(from, h, end_time, alpha_, load_);
  if (!solve_step(from, end_time, outcome)) return outcome;
  if (!converge_loads(from, h, end_time, outcome)) return outcome;

  to.step = from.step + 1;
  to.time = end_time;
  const Vector& u = solve_.u();
  problem_->positions(u, x_);
  constraint_force_ = solve_.constraint_force();
  if (system_.constraints().has_equations()) {
    impulse_ = problem_->step() * system_.constraints().vertex_forces(constraint_force_);
  }
  // The change of position before it is rounded to a position.
  to.velocity = ((problem_->origin() - from.position) + u) / problem_->step();
  set_end_position(from, to, h);
  system_.constraints().prescribe(to.time, to.position);
  if (!take_momenta(from, to, h, outcome)) return outcome;
  if (!to.position.allFinite() || !to.momentum.allFinite()) {
    outcome.status = StepStatus::kNotFinite;
    return outcome;
  }
  // With the midpoint rule an element may be inverted at q_{k+1} although it is not at x. The
  // energy is that of the rounded positions, because an edit between two steps computes the same.
  const EvaluationStatus end = system_.elastic_energy(to.position, outcome.elastic_energy);
  if (!end.ok()) {
    outcome.status = StepStatus::kInverted;
    outcome.element = end.failed_element;
    return outcome;
  }
  Index vertex = -1;
  const ForceTerm* term = system_.undefined_term(to.position, to.time, vertex);
  if (term != nullptr) return undefined(outcome, *term, vertex);
  if (load_.size() > 0) {
    outcome.external_work = own_dot(system_, load_, to.position - from.position);
  }
  outcome.external_work += driven_work(from, to);
  if (system_.is_dissipative()) outcome.dissipated_energy = problem_->dissipated_energy(u, h);
  reactions_.force /= h;
  reactions_.delay /= h;
  outcome.constraint_work = work_of_constraints(from, to);
  if (system_.contact() != nullptr) outcome.constraint_work += work_of_obstacles(from, to);
  enter_friction(h, to, outcome);
  if (constraining_) {
    reactions_.force += spring_force_;
    reactions_.delay += (1.0 - alpha_) * h * spring_force_;
  }
  if (!has_finite_balance(outcome)) {
    outcome.status = StepStatus::kNotFinite;
  }
  return outcome;
}

double ImplicitStepper::work_of_obstacles(const State& from, const State& to) const {
  const double h = to.time - from.time;
  return system_.contact()->work_of_motion(obstacle_forces_, from.time + alpha_ * h,
                                           {from.time, to.time}, h);
}

// The energy of friction, and the impulses of obstacles.
void ImplicitStepper::enter_friction(double h, const State& to, StepOutcome& outcome) {
  if (system_.contact() == nullptr) return;
  enter_obstacle_impulses(obstacle_forces_, h, outcome);
  outcome.step_size = h;
  if (!problem_->has_friction()) return;
  const FrictionStep& friction = problem_->friction();
  const FrictionPower power = friction.power(to.velocity);
  outcome.friction_dissipation = h * power.dissipated;
  outcome.constraint_work += h * power.of_obstacles;
  friction.for_each_force(to.velocity, [&](std::size_t k, Index v, const Vector3& force) {
    if (k == outcome.obstacle_impulses.size()) return;  // between bodies
    ObstacleForce& impulse = outcome.obstacle_impulses[k];
    impulse.force += h * force;
    impulse.moment += h * vertex_block(x_, v).cross(force);
  });
}

// outer_ += the forces of friction.
void ImplicitStepper::add_friction(const State& to) {
  if (!problem_->has_friction()) return;
  problem_->friction().for_each_force(to.velocity, [&](std::size_t, Index v, const Vector3& force) {
    vertex_block(outer_, v) += force;
  });
}

// Loads that depend on positions are those of the solution. Without a root finder, and with the multipliers of
// constraints, they are first others, and are replaced by those of the solution until both agree within
// the tolerance.
bool ImplicitStepper::converge_loads(const State& from, double h, double end_time,
                                     StepOutcome& outcome) {
  if (!system_.has_load_of_position()) return true;
  load_ = problem_->constant_loads();
  const auto load_of_solution = [&](Vector& load) {
    problem_->positions(solve_.u(), x_);
    system_.external_force(x_, from.time, h, load);
  };
  const auto is_small = [&](const Vector& change, const Vector& /*load*/) {
    return system_.coordinates().restricted_norm(change) <= outcome.minimizer.residual_limit;
  };
  const auto solve_with = [&](const Vector& load) {
    problem_->begin(from, h, end_time, alpha_, load);
    problem_->set_origin(x_);
    solve_.u().setZero();
    return solve_again(from, outcome);
  };
  const LoadConvergence settling =
      tetraction::converge_loads(load_, load_of_solution, is_small, solve_with);
  if (settling == LoadConvergence::kConverged) return true;
  if (settling == LoadConvergence::kNotSolved) return false;
  outcome.status = StepStatus::kNotConverged;
  outcome.message =
      "the loads that depend on positions, such as those on the rim of a pressure, do not settle";
  outcome.obstacle = StepObstacle::kLoads;
  return false;
}

bool ImplicitStepper::take_momenta(const State& from, State& to, double h, StepOutcome& outcome) {
  const double s = problem_->step();
  if (!gather_forces(from, to, h, outcome)) return false;
  add_impulse(x_, outer_, h, outcome);

  const bool has_equations = system_.constraints().has_equations();
  if (has_equations) start_ = from.momentum + impulse_;
  const Vector& start = has_equations ? start_ : from.momentum;
  system_.momentum_of(to.velocity, carried_);

  Vector& residual = work_;
  residual = (carried_ - start) / s - force_;
  system_.coordinates().project_momentum(system_.mass(), residual);
  Vector3 torque = Vector3::Zero();
  for (Index v = 0; v < system_.owned_vertex_count(); ++v) {
    torque += residual_arm(from, v).cross(vertex_block(residual, v));
  }
  sum_over_parts(system_.part(), torque.data(), 3);
  outcome.residual_angular_impulse = h * torque.norm();
  set_end_momentum(from, to, start, h, outcome);
  return true;
}

bool ImplicitStepper::gather_forces(const State& from, const State& to, double h,
                                    StepOutcome& outcome) {
  const Vector* gradient = nullptr;  // of the elastic energy
  if (const EvaluationStatus status = problem_->elastic_gradient(solve_.u(), gradient);
      !status.ok()) {
    outcome.status = StepStatus::kInverted;
    outcome.element = status.failed_element;
    return false;
  }
  const TimeSpan step{from.time, from.time + h};
  const double time = from.time + problem_->step();
  constraining_ = gather_term_forces(system_, system_.force_point(x_, time, step), load_, outer_,
                                     spring_force_);
  if (const Contact* contact = system_.contact(); contact != nullptr) {
    obstacle_forces_ = contact->forces(system_.force_point(x_, time));
    add_friction(to);
  }
  force_ = outer_ - *gradient;
  if (!system_.is_dissipative()) return true;
  // The forces of viscosity are minus the gradient of its potential.
  damping_.setZero(system_.dof_count());
  double ignored = 0.0;
  problem_->viscous().add_value_and_gradient(problem_->step_displacement(solve_.u()), ignored,
                                             damping_);
  if (problem_->viscous().factor() != 0.0) add_shared(system_.part(), damping_, 3);
  damping_ = -damping_;
  add_damping(from, to.velocity, damping_);
  add_damping(from, to.velocity, outer_);
  force_ += damping_;
  return true;
}

void ImplicitStepper::add_damping(const State& from, const Vector& velocity, Vector& forces) const {
  system_.add_damping_force(problem_->dissipation_point(), from.time + problem_->step(), velocity,
                            forces);
}

}  // namespace tetraction
