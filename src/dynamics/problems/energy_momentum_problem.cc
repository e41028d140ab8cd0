#include "energy_momentum_problem.h"

#include <algorithm>

#include "tetraction/dynamics/contact/contact.h"
#include "tetraction/dynamics/nodal_volume/nodal_volume.h"
#include "tetraction/fem/step_length.h"

namespace tetraction {

DiscreteGradientStep::DiscreteGradientStep(const MechanicalSystem& system, StepForces forces)
    : StepProblem(system), forces_(forces), gradient_(system.elastic()) {}

void DiscreteGradientStep::begin(const State& state, double h, double end_time, double alpha,
                                 const Vector& load) {
  StepProblem::begin(state, h, end_time, alpha, load);
  start_time_ = state.time;
  end_time_ = end_time;
  at_end_ = false;
  internal_.known = false;
  // The discrete gradient of a quadratic potential is its gradient at x plus a part that does not
  // depend on x: the potential need not be linear in the time.
  bool changed = false;
  if (forces_ == StepForces::kMiddleButContact) return;
  for (const ForceTerm* term : system_.force_terms()) {
    if (!term->has_potential() || !term->is_quadratic() || term->uniform_acceleration()) continue;
    full_.setZero(system_.dof_count());
    term->add_gradient(point(previous_), full_);
    full_ = -full_;
    term->add_discrete_gradient(start_point(), end_point(previous_), full_);
    add_load(-full_);
    changed = true;
  }
  if (changed) set_origin(base());
}

void DiscreteGradientStep::move(const Vector& u) const {
  half_step_ = (origin() - previous_) + u;
  end_ = origin() + (u + half_step_);
}

EvaluationStatus DiscreteGradientStep::evaluate_internal(const Vector& u) const {
  if (internal_.known && internal_.half_step == half_step_) return {};
  internal_.gradient.setZero(u.size());
  const EvaluationStatus status = add_internal(u, internal_.gradient);
  internal_.known = status.ok();
  if (status.ok()) internal_.half_step = half_step_;
  return status;
}

EvaluationStatus DiscreteGradientStep::add_internal(const Vector& u, Vector& gradient) const {
  if (forces_ == StepForces::kMiddleButContact) {
    const Vector* elastic = nullptr;
    if (const EvaluationStatus status = elastic_gradient(u, elastic); !status.ok()) return status;
    gradient += *elastic;
    if (viscous().factor() == 0.0) return {};
    add_viscous_share(u, gradient);
    return {};
  }
  const EvaluationStatus status =
      gradient_.add({Positions(origin(), u), half_step_, viscous().factor()}, gradient);
  if (!status.ok()) return status;
  if (const NodalVolume* volume = system_.nodal_volume(); volume != nullptr) {
    volume->add_discrete_gradient(Positions(origin(), u), half_step_, gradient);
  }
  return {};
}

// The viscous part is what the viscosity changes in the discrete gradient: the same formula at x.
void DiscreteGradientStep::add_viscous_share(const Vector& u, Vector& gradient) const {
  Vector with = Vector::Zero(u.size());
  Vector without = Vector::Zero(u.size());
  const Positions x(origin(), u);
  if (!gradient_.add({x, half_step_, viscous().factor()}, with).ok()) return;
  if (!gradient_.add({x, half_step_, 0.0}, without).ok()) return;
  gradient += with - without;
}

EvaluationStatus DiscreteGradientStep::conserving_residual(const Vector& u,
                                                           Vector& residual) const {
  move(u);
  if (!terms_are_defined(u) || !vertex_residual(u, residual)) return {-1, 0};
  if (const EvaluationStatus status = evaluate_internal(u); !status.ok()) return status;
  residual += internal_.gradient;
  for_each_potential([&](const ForceTerm& term) {
    if (forces_ == StepForces::kMiddleButContact) {
      shift_ = origin() + u;
      term.add_gradient(point(shift_), residual);
    } else {
      term.add_discrete_gradient(start_point(), end_point(end_), residual);
    }
  });
  if (const Contact* contact = system_.contact(); contact != nullptr) {
    contact->add_discrete_gradient(start_point(), end_point(end_), residual);
  }
  if (has_following_forces()) add_load_deviation(u, residual);
  return {};
}

EvaluationStatus DiscreteGradientStep::internal_gradient(const Vector& u,
                                                         const Vector*& gradient) const {
  move(u);
  gradient = &internal_.gradient;
  return evaluate_internal(u);
}

// move() must have been called.
bool DiscreteGradientStep::terms_are_defined(const Vector& u) const {
  const Contact* contact = system_.contact();
  bool defined = contact == nullptr || contact->undefined_vertex(end_point(end_)) < 0;
  for_each_potential([&](const ForceTerm& term) {
    shift_ = origin() + u;
    defined = defined && term.undefined_vertex(point(shift_)) < 0 &&
              term.undefined_vertex(end_point(end_)) < 0;
  });
  return defined;
}

bool DiscreteGradientStep::ends_defined(const Vector& u) const {
  move(u);
  if (forces_ == StepForces::kMiddleButContact &&
      !system_.elastic().admissible(Positions(origin(), u)).ok()) {
    return false;
  }
  return terms_are_defined(u) && system_.elastic().admissible(end_).ok();
}

double DiscreteGradientStep::longest_step_of_end(const Vector& u, const Vector& d) const {
  constexpr double kShare = 0.9;
  move(u);
  shift_ = 2.0 * d;
  double longest = 1.0;
  if (const Contact* contact = system_.contact(); contact != nullptr) {
    longest = std::min(longest, kShare * contact->longest_step(end_point(end_), shift_));
  }
  for_each_potential([&](const ForceTerm& term) {
    longest = std::min(longest, kShare * term.longest_step(end_point(end_), shift_));
    const Vector x = origin() + u;
    longest = std::min(longest, kShare * term.longest_step(point(x), d));
  });
  if (!gradient_.way_keeps_volumes(end_, shift_)) {
    longest = std::min(longest, admissible_step(system_.rest(), end_, shift_,
                                                [&](Index e) { return needs_volume(e); }));
  }
  return has_stretch_limit(system_.elastic())
             ? stretch_limited_step(system_.elastic(), end_, shift_, longest)
             : longest;
}

void DiscreteGradientStep::linearize(const Vector& u) {
  point_ = u;
  move(u);
  point_half_step_ = half_step_;
  at_end_ = forces_ == StepForces::kDiscrete && is_far_from_middle();
  set_rate_estimate(u);
  take_friction(u);
  const bool with_loads = has_following_forces();
  set_with_load_stiffness(false);
  StepProblem::term_hessian(u, HessianForm::kExact, terms_);
  add_contact_hessian(u, HessianForm::kExact, false, terms_);
  set_with_load_stiffness(with_loads);
  if (with_loads) load_stiffness(u, load_stiffness_);
}

// C at x is less than the mean of C at both ends by AᵀA, where A is half of the change of F. The body would be
// compressed by this strain at x, although it is not: the stress may make ∇²Φ indefinite where ∂r/∂u is not.
bool DiscreteGradientStep::is_far_from_middle() const {
  constexpr double kFew = 0.2;  // |A|; a rotation by 0.2 has 0.14
  const double inertia = system_.total_mass() / (volume_ * step_ * step_);
  return gradient_.deforms_more(half_step_, kFew, inertia);
}

void DiscreteGradientStep::multiply(const Vector& d, Vector& product) const {
  product = coefficient().cwiseProduct(d);
  terms_.add_product(d, product);
  if (has_following_forces()) load_stiffness_.add_product(d, product);
  if (forces_ == StepForces::kMiddleButContact) {
    shift_ = origin() + point_;
    system_.elastic().product(shift_, d, full_);
    product += full_;
    if (const NodalVolume* volume = system_.nodal_volume(); volume != nullptr) {
      volume->add_product(shift_, d, product);
    }
    if (viscous().factor() == 0.0) return;
    const Positions x(origin(), point_);
    gradient_.add_product({x, point_half_step_, viscous().factor()}, d, product);
    full_.setZero(d.size());
    gradient_.add_product({x, point_half_step_, 0.0}, d, full_);
    product -= full_;
    return;
  }
  gradient_.add_product({Positions(origin(), point_), point_half_step_, viscous().factor()}, d,
                        product);
  if (const NodalVolume* volume = system_.nodal_volume(); volume != nullptr) {
    volume->add_discrete_gradient_product(Positions(origin(), point_), point_half_step_, d,
                                          product);
  }
}

void DiscreteGradientStep::add_contact_hessian(const Vector& u, HessianForm form, bool symmetric,
                                               HessianBlocks& hessian) const {
  const Contact* contact = system_.contact();
  if (contact == nullptr) return;
  move(u);
  contact_blocks_.reset(system_.vertex_count());
  contact->add_discrete_hessian(start_point(), end_point(end_), form, symmetric, contact_blocks_);
  hessian.add(contact_blocks_, rate_of_end());
}

void DiscreteGradientStep::term_hessian(const Vector& u, HessianForm form,
                                        HessianBlocks& hessian) const {
  StepProblem::term_hessian(u, form, hessian);
  if (hessian.vertex_count() == 0) hessian.reset(system_.vertex_count());
  add_contact_hessian(u, form, true, hessian);
}

double DiscreteGradientStep::round_off(const Vector& u) const {
  const double round_off = StepProblem::round_off(u);
  const Contact* contact = system_.contact();
  if (contact == nullptr) return round_off;
  move(u);
  if (contact->undefined_vertex(end_point(end_)) >= 0) return round_off;
  return round_off + contact->round_off(end_point(end_));
}

Vector DiscreteGradientStep::end_positions(const Vector& u) const {
  return origin() + (((origin() - previous_) + u) + u);
}

Positions DiscreteGradientStep::elastic_positions(const Vector& u) const {
  if (!at_end_) return {origin(), u};
  shift_ = ((origin() - previous_) + u) + u;
  return {origin(), shift_};
}

}  // namespace tetraction
