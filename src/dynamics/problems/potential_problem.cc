#include "tetraction/dynamics/problems/potential_problem.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <limits>
#include <utility>
#include <variant>

#include "dynamics/constraints/constraint_potential.h"
#include "dynamics/contact/friction/friction_step.h"
#include "dynamics/terms/followed_loads.h"
#include "tetraction/core/parallel.h"
#include "tetraction/dynamics/body_sums.h"
#include "tetraction/dynamics/contact/contact.h"
#include "tetraction/fem/step_length.h"

namespace tetraction {
PotentialProblem::PotentialProblem(const MechanicalSystem& system)
    : system_(system),
      volume_(system.mesh().total_volume()),
      viscous_(system.elastic()),
      friction_(std::make_unique<FrictionStep>()) {}

PotentialProblem::~PotentialProblem() = default;

void PotentialProblem::begin_at(const Vector& positions, double time,
                                const std::optional<TimeSpan>& step) {
  previous_ = positions;
  base_ = previous_;
  time_ = time;
  span_ = step;
  constraint_force_.resize(0);
  constraint_potential_ = nullptr;
  elastic_.known = false;
  potentials_.clear();
  dissipations_.clear();
  contact_ = nullptr;
  friction_->clear();
}

void PotentialProblem::gather_potentials(double weight) {
  if (has_contact_potential()) contact_ = system_.contact();
  const ForcePoint at = point(previous_);
  full_.setZero(system_.dof_count());
  for (const ForceTerm* term : system_.force_terms()) {
    if (!term->has_potential() || term == system_.contact()) continue;
    const WeightedPotential potential{
        term, term->account() == EnergyAccount::kConstraintWork ? 1.0 : weight};
    if (!term->is_quadratic()) {
      if (potentials_.empty()) start_gradient_.setZero(system_.dof_count());
      potentials_.push_back(potential);
      add_gradient(potential, at, start_gradient_);
      continue;
    }
    add_gradient(potential, at, full_);
    if (term->uniform_acceleration()) continue;
    blocks_.reset(system_.vertex_count());
    term->add_hessian(at, HessianForm::kExact, blocks_);
    add_diagonal(potential.weight);
  }
  load_ -= full_;
  if (!potentials_.empty()) load_ -= start_gradient_;
}

void PotentialProblem::gather_dissipations() {
  velocity_.setZero(system_.dof_count());
  for (const ForceTerm* term : system_.force_terms()) {
    if (!term->has_dissipation()) continue;
    if (!term->is_quadratic()) {
      dissipations_.push_back(term);
      continue;
    }
    blocks_.reset(system_.vertex_count());
    term->add_dissipation_hessian(point(previous_), velocity_, HessianForm::kExact, blocks_);
    add_diagonal(1.0 / step_);
  }
}

// k += factor times the diagonal of blocks_.
void PotentialProblem::add_diagonal(double factor) {
  for (Index v = 0; v < system_.vertex_count(); ++v) {
    vertex_block(coefficient_, v) += factor * Matrix3(blocks_.diagonal(v)).diagonal();
  }
}

void PotentialProblem::add_gradient(const WeightedPotential& potential, const ForcePoint& at,
                                    Vector& gradient) const {
  if (potential.weight == 1.0) {
    potential.term->add_gradient(at, gradient);
    return;
  }
  weighted_gradient_.setZero(gradient.size());
  potential.term->add_gradient(at, weighted_gradient_);
  gradient += potential.weight * weighted_gradient_;
}

void PotentialProblem::measure_load() {
  load_norm_ = force_scale_ = system_.restricted_norm(load_);
}

void PotentialProblem::set_constraint_force(const Vector& force) {
  constraint_force_ = force;
  make_remainder();
}

void PotentialProblem::set_constraint_potential(ConstraintPotential* potential) {
  constraint_potential_ = potential;
  if (potential != nullptr) potential->set_origin(origin_);
}

double PotentialProblem::length_scale() const {
  return std::cbrt(volume_);
}

void PotentialProblem::set_origin(const Vector& positions) {
  origin_ = positions;
  elastic_.known = false;
  make_remainder();
}

void PotentialProblem::move_origin(Vector& u) {
  for (Index i = 0; i < u.size(); ++i) {
    const double before = origin_[i];
    const double after = before + u[i];
    u[i] = (before - after) + u[i];
    origin_[i] = after;
  }
  elastic_.known = false;
  make_remainder();
}

void PotentialProblem::make_remainder() {
  remainder_ = load_ - coefficient_.cwiseProduct(origin_ - previous_);
  if (constraint_force_.size() > 0) remainder_ += constraint_force_;
  if (constraint_potential_ != nullptr) constraint_potential_->set_origin(origin_);
}

double PotentialProblem::origin_value() const {
  if (system_.part() != nullptr) return -0.5 * dot(origin_ - previous_, load_ + remainder_);
  return -0.5 * (origin_ - previous_).dot(load_ + remainder_) -
         (constraint_force_.size() > 0 ? 0.5 * (origin_ - previous_).dot(constraint_force_) : 0.0);
}

double PotentialProblem::dot(const Vector& a, const Vector& b) const {
  return sum_over_parts(system_.part(), own_dot(system_, a, b));
}

double PotentialProblem::largest(const Vector& u) const {
  return largest_of_parts(system_.part(), u.cwiseAbs().maxCoeff());
}

ForcePoint PotentialProblem::energy_point(const Vector& x) const {
  const ForcePoint at = system_.energy_point(x, time_);
  ForcePoint own{at.mass, at.position, at.time, span_, load_factor_};
  return own;
}

const Vector& PotentialProblem::step_displacement(const Vector& u) const {
  if (viscous_.factor() == 0.0) return u;
  moved_ = (origin_ - previous_) + u;
  return moved_;
}

EvaluationStatus PotentialProblem::move_terms(const Vector& u) const {
  if (!has_general_terms()) return {};
  at_ = origin_ + u;
  if (!dissipations_.empty() || has_friction()) velocity_ = ((origin_ - previous_) + u) / step_;
  if (contact_ != nullptr) {
    const Index vertex = contact_->undefined_vertex(point(at_));
    if (vertex >= 0) return {-1, vertex};
  }
  for (const WeightedPotential& potential : potentials_) {
    const Index vertex = potential.term->undefined_vertex(point(at_));
    if (vertex >= 0) return {-1, vertex};
  }
  return {};
}

// The energy of the own vertices of a part.
double PotentialProblem::term_energy(const Vector& u) const {
  const ForcePoint start = energy_point(previous_);
  const ForcePoint at = energy_point(at_);
  double energy = 0.0;
  for (const WeightedPotential& potential : potentials_) {
    energy += potential.weight * potential.term->energy_change(start, at);
  }
  if (!potentials_.empty()) {
    energy -= parallel_sum(system_.owned_vertex_count(), [&](Index begin, Index end) {
      double sum = 0.0;
      for (Index v = begin; v < end; ++v) {
        sum += vertex_block(start_gradient_, v)
                   .dot(vertex_block(std::as_const(at_), v) - vertex_block(previous_, v));
      }
      return sum;
    });
  }
  if (contact_ != nullptr) energy += contact_->energy(at);
  if (has_friction()) energy += step_ * friction_->potential(velocity_);
  for (const ForceTerm* term : dissipations_) {
    energy += step_ * term->dissipation(energy_point(dissipation_point_), velocity_);
  }
  if (constraint_potential_ != nullptr) energy += constraint_potential_->value(u);
  return energy;
}

void PotentialProblem::add_term_gradient(const Vector& u, Vector& gradient) const {
  if (!potentials_.empty()) gradient -= start_gradient_;
  for (const WeightedPotential& potential : potentials_) {
    add_gradient(potential, point(at_), gradient);
  }
  if (contact_ != nullptr) contact_->add_gradient(point(at_), gradient);
  if (has_friction()) friction_->add_gradient(velocity_, gradient);
  for (const ForceTerm* term : dissipations_) {
    term->add_dissipation_gradient(point(dissipation_point_), velocity_, gradient);
  }
  if (constraint_potential_ != nullptr) constraint_potential_->add_gradient(u, gradient);
}

bool PotentialProblem::vertex_residual(const Vector& u, Vector& residual) const {
  if (!move_terms(u).ok()) return false;
  residual = coefficient_.cwiseProduct(u) - remainder_;
  if (!potentials_.empty()) residual -= start_gradient_;
  if (has_friction()) friction_->add_gradient(velocity_, residual);
  for (const ForceTerm* term : dissipations_) {
    term->add_dissipation_gradient(point(dissipation_point_), velocity_, residual);
  }
  return true;
}

void PotentialProblem::term_hessian(const Vector& u, HessianForm form,
                                    HessianBlocks& hessian) const {
  hessian.reset(system_.vertex_count());
  if (!has_general_terms()) return;
  at_ = origin_ + u;
  if (!dissipations_.empty() || has_friction()) {
    velocity_ = ((origin_ - previous_) + u) / step_;
    if (has_friction()) friction_->add_hessian(velocity_, hessian);
    for (const ForceTerm* term : dissipations_) {
      term->add_dissipation_hessian(point(dissipation_point_), velocity_, form, hessian);
    }
    hessian.scale(1.0 / step_);
  }
  if (contact_ != nullptr) contact_->add_hessian(point(at_), form, hessian);
  for (const auto& [term, weight] : potentials_) {
    if (weight == 1.0) {
      term->add_hessian(point(at_), form, hessian);
      continue;
    }
    weighted_.reset(system_.vertex_count());
    term->add_hessian(point(at_), form, weighted_);
    hessian.add(weighted_, weight);
  }
  if (constraint_potential_ != nullptr) constraint_potential_->add_hessian(u, form, hessian);
  if (!with_load_stiffness_ || form == HessianForm::kConvex) return;
  // Without the friction, because it may make the Hessian indefinite, of which GMRES gains nothing.
  load_stiffness_ = LoadStiffness(load_weight_);
  add_stiffness_of_loads(system_, load_point(at_), load_stiffness_);
  load_stiffness_.add_symmetric_part(hessian);
}

double PotentialProblem::longest_step(const Vector& u, const Vector& d,
                                      bool elements_are_safe) const {
  constexpr double kShare = 0.9;
  const double longest = std::min(1.0, kShare * longest_term_step(u, d));
  const bool is_limited = has_stretch_limit(system_.elastic());
  if (elements_are_safe && !is_limited) return least_of_parts(system_.part(), longest);
  at_ = origin_ + u;
  double step = std::min(
      longest, admissible_step(system_.rest(), at_, d, [&](Index e) { return needs_volume(e); }));
  if (is_limited) step = stretch_limited_step(system_.elastic(), at_, d, step);
  return least_of_parts(system_.part(), step);
}

bool PotentialProblem::needs_volume(Index e) const {
  const ElasticPotential& elastic = system_.elastic();
  return std::visit(
      []<class M>(const M&) {
        if constexpr (std::same_as<M, CustomMaterial>) {
          return true;
        } else {
          return !M::kDefinedForAnyJacobian;
        }
      },
      elastic.materials()[static_cast<std::size_t>(elastic.material_index(e))].model());
}

double PotentialProblem::longest_term_step(const Vector& u, const Vector& d) const {
  double longest = std::numeric_limits<double>::infinity();
  if (potentials_.empty() && contact_ == nullptr) return longest;
  at_ = origin_ + u;
  if (contact_ != nullptr) longest = contact_->longest_step(point(at_), d);
  for (const WeightedPotential& potential : potentials_) {
    longest = std::min(longest, potential.term->longest_step(point(at_), d));
  }
  return longest;
}

bool PotentialProblem::is_defined(const Vector& u) const {
  return everywhere(system_.part(),
                    move_terms(u).ok() && system_.elastic().admissible(Positions(origin_, u)).ok());
}

EvaluationStatus PotentialProblem::value(const Vector& u, double& phi) const {
  phi = 0.0;
  const EvaluationStatus terms = move_terms(u);
  if (!terms.ok()) return agree(terms, phi);
  const EvaluationStatus status = system_.elastic_energy(Positions(origin_, u), phi);
  if (!status.ok()) return agree(status, phi);
  phi += parallel_sum(system_.owned_vertex_count(), [&](Index begin, Index end) {
    double sum = 0.0;
    for (Index v = begin; v < end; ++v) {
      const Vector3 d = vertex_block(u, v);
      sum +=
          d.dot(0.5 * vertex_block(coefficient_, v).cwiseProduct(d) - vertex_block(remainder_, v));
    }
    return sum;
  });
  if (has_general_terms()) phi += term_energy(u);
  viscous_.add_value(step_displacement(u), phi);
  return agree(status, phi);
}

// For a body in parts: the sum of Φ over the parts, and whether it is defined in all of them.
EvaluationStatus PotentialProblem::agree(EvaluationStatus status, double& phi) const {
  if (system_.part() == nullptr) return status;
  std::array<double, 2> sums{status.ok() ? 0.0 : 1.0, status.ok() ? phi : 0.0};
  system_.part()->sum(sums.data(), 2);
  phi = sums[1];
  if (sums[0] > 0.0 && status.ok()) status.failed_element = 0;  // of another part
  return status;
}

bool PotentialProblem::is_elastic_known(const Vector& u) const {
  return everywhere(system_.part(), elastic_.known && elastic_.u == u);
}

EvaluationStatus PotentialProblem::evaluate_elastic(const Vector& u) const {
  if (is_elastic_known(u)) return {};
  const EvaluationStatus status = system_.elastic_energy_and_gradient(
      Positions(origin_, u), elastic_.energy, elastic_.gradient);
  elastic_.known = status.ok();
  if (status.ok()) elastic_.u = u;
  return status;
}

EvaluationStatus PotentialProblem::elastic_energy(const Vector& u, double& energy) const {
  if (!is_elastic_known(u)) {
    return agree(system_.elastic_energy(Positions(origin_, u), energy), energy);
  }
  energy = sum_over_parts(system_.part(), elastic_.energy);
  return {};
}

EvaluationStatus PotentialProblem::elastic_gradient(const Vector& u,
                                                    const Vector*& gradient) const {
  gradient = &elastic_.gradient;
  return evaluate_elastic(u);
}

EvaluationStatus PotentialProblem::value_and_full_gradient(const Vector& u, double& phi,
                                                           Vector& gradient) const {
  phi = 0.0;
  const EvaluationStatus terms = move_terms(u);
  // Other parts wait for the gradient of this one.
  if (!terms.ok() && system_.part() == nullptr) return terms;
  EvaluationStatus status = evaluate_elastic(u);
  if (!terms.ok()) status = terms;
  if (!status.ok() && system_.part() == nullptr) return status;
  if (!everywhere(system_.part(), status.ok())) {
    elastic_.known = false;
    return agree(status, phi);
  }
  phi = elastic_.energy;
  gradient.resize(u.size());
  const Index owned = system_.owned_vertex_count();
  phi += parallel_sum(system_.vertex_count(), [&](Index begin, Index end) {
    double sum = 0.0;
    for (Index v = begin; v < end; ++v) {
      const Vector3 d = vertex_block(u, v);
      const Vector3 stiff = vertex_block(coefficient_, v).cwiseProduct(d);
      const Vector3 rest = vertex_block(remainder_, v);
      if (v < owned) sum += d.dot(0.5 * stiff - rest);
      vertex_block(gradient, v) =
          vertex_block(std::as_const(elastic_.gradient), v) + (stiff - rest);
    }
    return sum;
  });
  if (has_general_terms()) {
    phi += term_energy(u);
    add_term_gradient(u, gradient);
  }
  add_viscous(u, phi, gradient);
  return agree(status, phi);
}

void PotentialProblem::add_viscous(const Vector& u, double& phi, Vector& gradient) const {
  if (system_.part() == nullptr || viscous_.factor() == 0.0) {
    viscous_.add_value_and_gradient(step_displacement(u), phi, gradient);
    return;
  }
  Vector own = Vector::Zero(gradient.size());
  viscous_.add_value_and_gradient(step_displacement(u), phi, own);
  add_shared(system_.part(), own, 3);
  gradient += own;
}

MinimizationProblem::HessianParts PotentialProblem::hessian_parts(const Vector& u) const {
  return {system_.elastic(), system_.nodal_volume(), elastic_positions(u),
          viscous_,          step_displacement(u),   coefficient_};
}

double PotentialProblem::round_off(const Vector& u) const {
  ElasticPotential::StiffnessSums sums = system_.stiffness_sums(2.0 * viscous_.factor());
  if (const MeshPart* part = system_.part(); part != nullptr) {
    const Index size = 3 * system_.owned_vertex_count();
    std::array<double, 3> own{sums.squared, sums.with_edges,
                              coefficient_.head(size).cwiseProduct(u.head(size)).squaredNorm()};
    part->sum(own.data(), 3);
    return 0.5 * std::numeric_limits<double>::epsilon() *
           (std::sqrt(own[2]) + load_norm_ + std::sqrt(own[0]) * largest(u) + std::sqrt(own[1]));
  }
  double round_off =
      0.5 * std::numeric_limits<double>::epsilon() *
      (coefficient_.cwiseProduct(u).norm() + load_norm_ +
       std::sqrt(sums.squared) * u.cwiseAbs().maxCoeff() + std::sqrt(sums.with_edges));
  if (contact_ != nullptr) {
    const Vector x = origin_ + u;
    if (contact_->undefined_vertex(point(x)) < 0) round_off += contact_->round_off(point(x));
  }
  return round_off;
}

}  // namespace tetraction
