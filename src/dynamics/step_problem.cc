#include "tetraction/dynamics/step_problem.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "tetraction/core/parallel.h"

namespace tetraction {
namespace {

// Vertices worth a task of their own.
constexpr Index kGrain = 2048;

// What the linear part at q leaves of the environment's energy at x, of one vertex.
double environment_rest(const Environment& environment, double mass, const Vector3& q,
                        const Vector3& x) {
  return environment.value(mass, x) - environment.value(mass, q) -
         environment.gradient(mass, q).dot(x - q);
}

}  // namespace

StepProblem::StepProblem(const MechanicalSystem& system)
    : system_(system), viscous_(system.elastic()) {}

void StepProblem::begin(const State& state, double h, double end_time, double alpha,
                        const Vector& user_force) {
  step_ = alpha * h;
  previous_ = state.position;
  impulse_.resize(0);
  elastic_.known = false;
  const Constraints& constraints = system_.constraints();
  base_ = previous_;
  constraints.for_each_prescribed_way(previous_, end_time, [&](Index v, const Vector3& way) {
    vertex_block(base_, v) += alpha * way;
  });
  const Damping& damping = system_.damping();
  const Vector none;
  const bool second_order = alpha == 0.5 && damping.viscosity > 0.0;
  if (second_order) {
    system_.velocity_of(state.momentum, full_);
    full_ *= h;
  }
  viscous_.begin(previous_, second_order ? full_ : none, damping.viscosity / step_);
  const Environment& environment = system_.environment();
  curved_environment_ = !environment.is_uniform();

  load_ = state.momentum / step_;
  if (user_force.size() > 0) load_ += user_force;
  coefficient_.resize(system_.dof_count());
  parallel_for(system_.vertex_count(), kGrain, [&](Index begin, Index end) {
    for (Index v = begin; v < end; ++v) {
      const double mass = system_.mass()[v];
      vertex_block(load_, v) -= environment.gradient(mass, vertex_block(previous_, v));
      vertex_block(coefficient_, v)
          .setConstant(mass / (step_ * step_) +
                       (damping.drag + damping.mass_damping * mass) / step_);
    }
  });
  if (constraints.has_springs()) {
    coefficient_ += constraints.spring_stiffness();
    constraints.add_spring_force(previous_, state.time + step_, load_);
  }
  make_target();
}

void StepProblem::set_impulse(const Vector& impulse) {
  impulse_ = impulse;
  make_target();
}

void StepProblem::make_target() {
  if (impulse_.size() == 0) {
    target_ = previous_ + load_.cwiseQuotient(coefficient_);
    force_scale_ = system_.coordinates().restricted_norm(load_);
  } else {
    target_ = previous_ + (load_ + impulse_ / step_).cwiseQuotient(coefficient_);
  }
}

void StepProblem::inertial_guess(Vector& x) const {
  x = target_ - previous_;
  system_.coordinates().project_velocity(system_.mass(), x);
  x += base_;
}

Evaluation StepProblem::value(const Vector& x, double& phi) const {
  const Evaluation status = system_.elastic().value(x, phi);
  if (!status.ok()) return status;
  phi += parallel_sum(system_.vertex_count(), [&](Index begin, Index end) {
    double sum = 0.0;
    for (Index v = begin; v < end; ++v) {
      const Vector3 d = vertex_block(x, v) - vertex_block(target_, v);
      sum += 0.5 * vertex_block(coefficient_, v).dot(d.cwiseAbs2());
      if (curved_environment_) {
        sum += environment_rest(system_.environment(), system_.mass()[v],
                                vertex_block(previous_, v), vertex_block(x, v));
      }
    }
    return sum;
  });
  viscous_.add_value(x, phi);
  return status;
}

Evaluation StepProblem::value_and_gradient(const Vector& x, double& phi, Vector& gradient) const {
  const Evaluation status = value_and_full_gradient(x, phi, full_);
  if (status.ok()) gradient = system_.coordinates().restrict(full_);
  return status;
}

Evaluation StepProblem::evaluate_elastic(const Vector& x) const {
  if (elastic_.known && elastic_.x == x) return {};
  const Evaluation status =
      system_.elastic().value_and_gradient(x, elastic_.energy, elastic_.gradient);
  elastic_.known = status.ok();
  if (status.ok()) elastic_.x = x;
  return status;
}

Evaluation StepProblem::elastic_energy(const Vector& x, double& energy) const {
  if (!elastic_.known || elastic_.x != x) return system_.elastic().value(x, energy);
  energy = elastic_.energy;
  return {};
}

Evaluation StepProblem::elastic_gradient(const Vector& x, const Vector*& gradient) const {
  gradient = &elastic_.gradient;
  return evaluate_elastic(x);
}

Evaluation StepProblem::value_and_full_gradient(const Vector& x, double& phi,
                                                Vector& gradient) const {
  const Evaluation status = evaluate_elastic(x);
  if (!status.ok()) return status;
  phi = elastic_.energy;
  gradient.resize(x.size());
  const Environment& environment = system_.environment();
  phi += parallel_sum(system_.vertex_count(), [&](Index begin, Index end) {
    double sum = 0.0;
    for (Index v = begin; v < end; ++v) {
      const Vector3 d = vertex_block(x, v) - vertex_block(target_, v);
      const Vector3 force = vertex_block(coefficient_, v).cwiseProduct(d);
      sum += 0.5 * force.dot(d);
      vertex_block(gradient, v) = vertex_block(std::as_const(elastic_.gradient), v) + force;
      if (curved_environment_) {
        const double mass = system_.mass()[v];
        const Vector3 from = vertex_block(previous_, v);
        const Vector3 to = vertex_block(x, v);
        sum += environment_rest(environment, mass, from, to);
        vertex_block(gradient, v) +=
            environment.gradient(mass, to) - environment.gradient(mass, from);
      }
    }
    return sum;
  });
  viscous_.add_value_and_gradient(x, phi, gradient);
  return status;
}

Evaluation StepProblem::hessian(const Vector& x, const SparsityPattern& pattern,
                                double* values) const {
  std::fill(values, values + pattern.nonzeros(), 0.0);
  const Evaluation status = system_.elastic().add_hessian(x, pattern, values);
  if (!status.ok()) return status;
  viscous_.add_hessian(x, pattern, values);
  Matrix blocks = Matrix::Zero(3, system_.dof_count());
  for (Index v = 0; v < system_.vertex_count(); ++v) {
    auto block = blocks.middleCols<3>(3 * v);
    block.diagonal() = vertex_block(coefficient_, v);
    if (curved_environment_) {
      block += system_.environment().hessian(system_.mass()[v], vertex_block(x, v));
    }
  }
  pattern.add_vertex_blocks(blocks, values);
  return status;
}

bool StepProblem::element_terms(Index e, const Vector& x, bool with_hessian,
                                ElasticPotential::ElementTerms& terms) const {
  if (!system_.elastic().element_terms(e, x, with_hessian, terms)) return false;
  viscous_.add_element_terms(e, x, with_hessian, terms);
  const double share = system_.mass_share(e);
  const auto& nodes = system_.rest().nodes(e);
  for (int a = 0; a < Shape::kNodes; ++a) {
    const Index v = nodes[static_cast<std::size_t>(a)];
    const double mass = system_.mass()[v];
    const double fraction = share / mass;
    const Vector3 d = vertex_block(x, v) - vertex_block(target_, v);
    const Vector3 k = fraction * vertex_block(coefficient_, v);
    terms.energy += 0.5 * k.dot(d.cwiseAbs2());
    terms.gradient.col(a) += k.cwiseProduct(d);
    if (with_hessian) terms.hessian.diagonal().segment<3>(3 * a) += k;
    if (curved_environment_) {
      const Environment& environment = system_.environment();
      const Vector3 from = vertex_block(previous_, v);
      const Vector3 to = vertex_block(x, v);
      terms.energy += fraction * environment_rest(environment, mass, from, to);
      terms.gradient.col(a) +=
          fraction * (environment.gradient(mass, to) - environment.gradient(mass, from));
      if (with_hessian) {
        terms.hessian.block<3, 3>(3 * a, 3 * a) += fraction * environment.hessian(mass, to);
      }
    }
  }
  return true;
}

double StepProblem::environment_share(Index e, const Vector& x) const {
  if (!curved_environment_) return 0.0;
  double energy = 0.0;
  for (const Index v : system_.rest().nodes(e)) {
    const double mass = system_.mass()[v];
    energy += system_.mass_share(e) / mass *
              std::abs(system_.environment().value(mass, vertex_block(x, v)));
  }
  return energy;
}

double StepProblem::residual_limit(const Vector& x, double tolerance) const {
  // V (λ + 2μ) |∇N|²: what one metre of a node's displacement adds to the force, element by
  // element.
  double stiffness = 0.0;
  const std::vector<MaterialModel>& materials = system_.elastic().materials();
  for (std::size_t m = 0; m < materials.size(); ++m) {
    const LameParameters lame = initial_lame(materials[m]);
    const double modulus = std::abs(lame.lambda) + 2.0 * lame.mu + 2.0 * viscous_.factor();
    stiffness += modulus * modulus * system_.elastic().squared_shape_sum(m);
  }
  // Positions carry ε|x|: F, and with it the element forces, cannot be more accurate than that.
  const double round_off =
      4.0 * std::numeric_limits<double>::epsilon() *
      (coefficient_.cwiseProduct(x).norm() + std::sqrt(stiffness) * x.cwiseAbs().maxCoeff());
  return std::max(tolerance * force_scale_, round_off);
}

}  // namespace tetraction
