#include "tetraction/dynamics/problems/step_problem.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "tetraction/core/parallel.h"
#include "tetraction/dynamics/body_sums.h"
#include "tetraction/dynamics/contact/contact.h"

namespace tetraction {
namespace {

// Otherwise nothing singles out the frame in which the supports are at rest: the momentum of the whole
// body must not hide the forces within it.
bool is_held_at_rest(const MechanicalSystem& system) {
  const std::vector<PrescribedVertices>& held = system.constraints().list().held;
  return anywhere(system.part(),
                  std::any_of(held.begin(), held.end(), [](const PrescribedVertices& each) {
                    return !each.vertices.empty() && each.motion.at_rest();
                  }));
}

}  // namespace

// The function Φ is formula (12) of docs/theory.md, with all force terms formula (29).
void StepProblem::begin(const State& state, double h, double end_time, double alpha,
                        const Vector& load) {
  alpha_ = alpha;
  step_ = alpha * h;
  begin_at(state.position, state.time + step_, TimeSpan{state.time, state.time + h});
  prescribe_base(end_time);
  dissipation_point_ = previous_;
  if (alpha == 0.5 && system_.is_dissipative()) {
    system_.velocity_of(state.momentum, velocity_);
    dissipation_point_ += step_ * velocity_;
  }
  viscous_.begin(previous_, system_.damping().viscosity / step_);
  load_ = state.momentum / step_;
  if (load.size() > 0) load_ += load;
  set_constant_loads(load, 1.0);
  coefficient_.resize(system_.dof_count());
  parallel_for(system_.vertex_count(), kVertexGrain, [&](Index begin, Index end) {
    for (Index v = begin; v < end; ++v) {
      vertex_block(coefficient_, v).setConstant(system_.mass()[v] / (step_ * step_));
    }
  });
  gather_potentials(1.0);
  gather_dissipations();
  begin_friction(state.time, end_time, !has_contact_potential());
  measure_load();
  set_origin(base_);
  // Momenta that are mere round-off, summed up over many steps, do not count as a load.
  constexpr double kSteps = 1e3;
  full_ = load_ - state.momentum / step_;
  const bool applied = system_.restricted_norm(full_) > 0.0;
  if (!is_held_at_rest(system_)) {
    Vector3 velocity = Vector3::Zero();  // of the centre of mass
    for (Index v = 0; v < system_.owned_vertex_count(); ++v) {
      velocity += vertex_block(state.momentum, v) / system_.total_mass();
    }
    sum_over_parts(system_.part(), velocity.data(), 3);
    full_ = load_;
    for (Index v = 0; v < system_.vertex_count(); ++v) {
      vertex_block(full_, v) -= system_.mass()[v] / step_ * velocity;
    }
    force_scale_ = system_.restricted_norm(full_);
  }
  full_.setZero();
  if (!applied && force_scale_ <= kSteps * round_off(full_)) force_scale_ = 0.0;
}

void StepProblem::prescribe_base(double time) {
  base_ = previous_;
  system_.constraints().for_each_prescribed_displacement(
      previous_, time, [&](Index v, const Vector3& displacement) {
        vertex_block(base_, v) += alpha_ * displacement;
      });
}

void StepProblem::inertial_guess(Vector& x) const {
  x = load_;
  if (constraint_force().size() > 0) x += constraint_force();
  x = x.cwiseQuotient(coefficient_);
  system_.coordinates().project_velocity(system_.mass(), x);
  x += base_;
}

void StepProblem::clear_way(Vector& x) const {
  const Contact* contact = system_.contact();
  if (contact == nullptr) return;
  const ForcePoint start = system_.force_point(previous_, span_->begin);
  const double factor = 1.0 / alpha_;  // from x to the end of the step
  Vector end = previous_ + factor * (x - previous_);
  if (!contact->clear_way(start, system_.force_point(end, span_->end), end)) return;
  x = previous_ + alpha_ * (end - previous_) - base_;
  system_.coordinates().project_velocity(system_.mass(), x);
  x += base_;
}

void StepProblem::set_rate_estimate(const Vector& u) {
  if (needs_rate_estimate()) viscous_.set_estimate(step_displacement(u));
}

double StepProblem::dissipated_energy(const Vector& u, double h) const {
  double viscous = 0.0;
  viscous_.add_value(step_displacement(u), viscous);
  double rate = 0.0;
  const ForcePoint start = point(dissipation_point_);
  velocity_ = ((origin() - previous_) + u) / step_;
  for (const ForceTerm* term : system_.force_terms()) {
    if (!term->has_dissipation()) continue;
    full_.setZero(system_.dof_count());
    term->add_dissipation_gradient(start, velocity_, full_);
    rate += own_dot(system_, velocity_, full_);
  }
  return h / step_ * 2.0 * viscous + h * rate;
}

double StepProblem::buckling_ratio(const Vector& u) const {
  double energy = 0.0;
  if (!elastic_energy(u, energy).ok()) return std::numeric_limits<double>::infinity();
  const double cell = 6.0 * volume_ / static_cast<double>(global_tetrahedron_count(system_));
  return 6.0 * energy * step_ * step_ / (system_.total_mass() * std::pow(cell, 2.0 / 3.0));
}

}  // namespace tetraction
