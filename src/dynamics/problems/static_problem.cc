#include "tetraction/dynamics/problems/static_problem.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tetraction/dynamics/body_sums.h"
#include "tetraction/dynamics/contact/contact.h"

namespace tetraction {

// The function Π is formula (28) of docs/theory.md.
StaticProblem::StaticProblem(const MechanicalSystem& system, double time)
    : PotentialProblem(system), constraints_(system.constraints()) {
  time_ = time;
  const Vector rest = system.mesh().rest_positions();
  for (const FixedDistance& distance : constraints_.list().distances) {
    const double length = (vertex_block(rest, distance.a) - vertex_block(rest, distance.b)).norm();
    rest_lengths_.push_back(length > 0.0 ? length : distance.length);
  }
  rest_way_ = rest;
  system.constraints().prescribe(time, rest_way_);
  rest_way_ -= rest;
  rest_gradient_ = constraint_gradient(rest);
}

Vector StaticProblem::constraint_gradient(const Vector& x) const {
  Vector gradient = Vector::Zero(system_.dof_count());
  for (const ForceTerm* term : system_.force_terms()) {
    if (!term->has_potential() || term->account() != EnergyAccount::kConstraintWork) continue;
    term->add_gradient(system_.force_point(x, time_), gradient);
  }
  return gradient;
}

// The length of every distance at a load factor.
void StaticProblem::set_lengths(double factor, Constraints& constraints) const {
  for (std::size_t i = 0; i < rest_lengths_.size(); ++i) {
    const double full = system_.constraints().list().distances[i].length;
    constraints.set_distance_length(
        i, factor == 1.0 ? full : rest_lengths_[i] + factor * (full - rest_lengths_[i]));
  }
}

Vector StaticProblem::load(const Vector& x) const {
  Vector load;
  system_.external_force(system_.force_point(x, time_), load);
  if (load.size() == 0) load.setZero(system_.dof_count());
  return load;
}

Vector StaticProblem::applied_force(double factor, const Vector& x) const {
  Vector force;
  system_.applied_force(system_.force_point(x, time_), force);
  if (force.size() == 0) force.setZero(system_.dof_count());
  return factor * force;
}

void StaticProblem::begin(const Vector& q, double factor, const Vector& load) {
  factor_ = load_factor_ = factor;
  examined_ = false;
  begin_at(q, time_, {});
  viscous_.begin(previous_, 0.0);
  set_lengths(factor, constraints_);
  prescribe(factor, base_);
  coefficient_.setZero(system_.dof_count());
  load_ = (1.0 - factor) * rest_gradient_ + factor * load;
  set_constant_loads(load, factor);
  gather_potentials(factor);
  measure_load();
  set_origin(base_);
}

void StaticProblem::prescribe(double factor, Vector& x) const {
  system_.constraints().prescribe(time_, x);
  if (factor < 1.0) x -= (1.0 - factor) * rest_way_;
}

double StaticProblem::constraint_error(double factor, const Vector& x) const {
  if (factor == 1.0) return system_.constraints().error(x, time_);
  Constraints constraints = system_.constraints();
  set_lengths(factor, constraints);
  Vector exact = x;
  prescribe(factor, exact);
  double error = (exact - x).cwiseAbs().maxCoeff();
  if (constraints.has_equations()) {
    error = std::max(
        error, constraints.relative_error(x) * constraints.configuration_lengths().maxCoeff());
  }
  return error;
}

EvaluationStatus StaticProblem::reactions(const Vector& u, const Vector& equation_force,
                                          Vector& reaction) const {
  double phi = 0.0;
  const EvaluationStatus status = value_and_full_gradient(u, phi, reaction);
  if (!status.ok()) return status;
  Vector free_part = reaction;
  system_.coordinates().project_momentum(system_.mass(), free_part);
  reaction -= free_part;
  if (equation_force.size() > 0) reaction += equation_force;
  // The forces of penalty springs.
  Vector x;
  positions(u, x);
  reaction -= constraint_gradient(x) - (1.0 - factor_) * rest_gradient_;
  return status;
}

EvaluationStatus StaticProblem::energies(double factor, const Vector& x, Energies& energies) const {
  State state;
  state.position = x;
  state.momentum = Vector::Zero(x.size());
  state.time = time_;
  const EvaluationStatus status = evaluate_energies(system_, state, energies);
  energies.set_environment(factor * energies.environment());
  for (std::size_t i = 0; i < energies.extra_count(); ++i) {
    const Energies::Entry entry = energies.extra(i);
    if (system_.contact() != nullptr && entry.name == system_.contact()->name()) continue;
    energies.set_extra(i, entry.name, factor * entry.value);
  }
  return status;
}

double StaticProblem::buckling_ratio(const Vector& /*u*/) const {
  return examined_ ? 0.0 : std::numeric_limits<double>::infinity();
}

}  // namespace tetraction
