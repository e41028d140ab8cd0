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
  alpha_ = alpha;
  previous_ = state.position;
  impulse_.resize(0);
  elastic_.known = false;
  prescribe_base(end_time);
  const Damping& damping = system_.damping();
  viscous_.begin(previous_, damping.viscosity / step_);
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
  const Constraints& constraints = system_.constraints();
  if (constraints.has_springs()) {
    coefficient_ += constraints.spring_stiffness();
    constraints.add_spring_force(previous_, state.time + step_, load_);
  }
  force_scale_ = system_.coordinates().restricted_norm(load_);
  set_origin(base_);
  // Momenta that round-off has made are no load.
  full_ = load_ - state.momentum / step_;
  const bool applied = system_.coordinates().restricted_norm(full_) > 0.0;
  full_.setZero();
  if (!applied && force_scale_ <= round_off(full_)) force_scale_ = 0.0;
}

void StepProblem::prescribe_base(double time) {
  base_ = previous_;
  system_.constraints().for_each_prescribed_way(previous_, time, [&](Index v, const Vector3& way) {
    vertex_block(base_, v) += alpha_ * way;
  });
}

void StepProblem::set_impulse(const Vector& impulse) {
  impulse_ = impulse;
  make_remainder();
}

void StepProblem::set_origin(const Vector& positions) {
  origin_ = positions;
  elastic_.known = false;
  make_remainder();
}

void StepProblem::move_origin(Vector& u) {
  for (Index i = 0; i < u.size(); ++i) {
    const double before = origin_[i];
    const double after = before + u[i];
    u[i] = (before - after) + u[i];
    origin_[i] = after;
  }
  elastic_.known = false;
  make_remainder();
}

void StepProblem::make_remainder() {
  remainder_ = load_ - coefficient_.cwiseProduct(origin_ - previous_);
  if (impulse_.size() > 0) remainder_ += impulse_ / step_;
}

double StepProblem::origin_value() const {
  return -0.5 * (origin_ - previous_).dot(load_ + remainder_) -
         (impulse_.size() > 0 ? 0.5 / step_ * (origin_ - previous_).dot(impulse_) : 0.0);
}

const Vector& StepProblem::step_displacement(const Vector& u) const {
  if (viscous_.factor() == 0.0) return u;
  moved_ = (origin_ - previous_) + u;
  return moved_;
}

void StepProblem::inertial_guess(Vector& x) const {
  x = load_;
  if (impulse_.size() > 0) x += impulse_ / step_;
  x = x.cwiseQuotient(coefficient_);
  system_.coordinates().project_velocity(system_.mass(), x);
  x += base_;
}

void StepProblem::set_rate_estimate(const Vector& u) {
  if (needs_rate_estimate()) viscous_.set_estimate(step_displacement(u));
}

double StepProblem::dissipated_energy(const Vector& u, double h) const {
  const Damping& damping = system_.damping();
  const double ratio = h / step_;
  double viscous = 0.0;
  viscous_.add_value(step_displacement(u), viscous);
  double drag = 0.0;
  if (damping.drag > 0.0 || damping.mass_damping > 0.0) {
    for (Index v = 0; v < system_.vertex_count(); ++v) {
      const Vector3 way =
          (vertex_block(origin_, v) - vertex_block(previous_, v)) + vertex_block(u, v);
      drag += (damping.drag + damping.mass_damping * system_.mass()[v]) * way.squaredNorm();
    }
  }
  return ratio * (2.0 * viscous + drag / step_);
}

Evaluation StepProblem::value(const Vector& u, double& phi) const {
  const Evaluation status = system_.elastic().value(Positions(origin_, u), phi);
  if (!status.ok()) return status;
  phi += parallel_sum(system_.vertex_count(), [&](Index begin, Index end) {
    double sum = 0.0;
    for (Index v = begin; v < end; ++v) {
      const Vector3 d = vertex_block(u, v);
      sum +=
          d.dot(0.5 * vertex_block(coefficient_, v).cwiseProduct(d) - vertex_block(remainder_, v));
      if (curved_environment_) {
        sum += environment_rest(system_.environment(), system_.mass()[v],
                                vertex_block(previous_, v), vertex_block(origin_, v) + d);
      }
    }
    return sum;
  });
  viscous_.add_value(step_displacement(u), phi);
  return status;
}

Evaluation StepProblem::value_and_gradient(const Vector& u, double& phi, Vector& gradient) const {
  const Evaluation status = value_and_full_gradient(u, phi, full_);
  if (status.ok()) gradient = system_.coordinates().restrict(full_);
  return status;
}

Evaluation StepProblem::evaluate_elastic(const Vector& u) const {
  if (elastic_.known && elastic_.u == u) return {};
  const Evaluation status = system_.elastic().value_and_gradient(
      Positions(origin_, u), elastic_.energy, elastic_.gradient);
  elastic_.known = status.ok();
  if (status.ok()) elastic_.u = u;
  return status;
}

Evaluation StepProblem::elastic_energy(const Vector& u, double& energy) const {
  if (!elastic_.known || elastic_.u != u) {
    return system_.elastic().value(Positions(origin_, u), energy);
  }
  energy = elastic_.energy;
  return {};
}

Evaluation StepProblem::elastic_gradient(const Vector& u, const Vector*& gradient) const {
  gradient = &elastic_.gradient;
  return evaluate_elastic(u);
}

Evaluation StepProblem::value_and_full_gradient(const Vector& u, double& phi,
                                                Vector& gradient) const {
  const Evaluation status = evaluate_elastic(u);
  if (!status.ok()) return status;
  phi = elastic_.energy;
  gradient.resize(u.size());
  const Environment& environment = system_.environment();
  phi += parallel_sum(system_.vertex_count(), [&](Index begin, Index end) {
    double sum = 0.0;
    for (Index v = begin; v < end; ++v) {
      const Vector3 d = vertex_block(u, v);
      const Vector3 stiff = vertex_block(coefficient_, v).cwiseProduct(d);
      const Vector3 rest = vertex_block(remainder_, v);
      sum += d.dot(0.5 * stiff - rest);
      vertex_block(gradient, v) =
          vertex_block(std::as_const(elastic_.gradient), v) + (stiff - rest);
      if (curved_environment_) {
        const double mass = system_.mass()[v];
        const Vector3 from = vertex_block(previous_, v);
        const Vector3 to = vertex_block(origin_, v) + d;
        sum += environment_rest(environment, mass, from, to);
        vertex_block(gradient, v) +=
            environment.gradient(mass, to) - environment.gradient(mass, from);
      }
    }
    return sum;
  });
  viscous_.add_value_and_gradient(step_displacement(u), phi, gradient);
  return status;
}

Evaluation StepProblem::hessian(const Vector& u, const SparsityPattern& pattern,
                                double* values) const {
  std::fill(values, values + pattern.nonzeros(), 0.0);
  const Evaluation status = system_.elastic().add_hessian(Positions(origin_, u), pattern, values);
  if (!status.ok()) return status;
  viscous_.add_hessian(step_displacement(u), pattern, values);
  Matrix blocks = Matrix::Zero(3, system_.dof_count());
  for (Index v = 0; v < system_.vertex_count(); ++v) {
    auto block = blocks.middleCols<3>(3 * v);
    block.diagonal() = vertex_block(coefficient_, v);
    if (curved_environment_) {
      block += system_.environment().hessian(system_.mass()[v],
                                             vertex_block(origin_, v) + vertex_block(u, v));
    }
  }
  pattern.add_vertex_blocks(blocks, values);
  return status;
}

bool StepProblem::element_terms(Index e, const Vector& u, bool with_hessian,
                                ElasticPotential::ElementTerms& terms) const {
  const Positions x(origin_, u);
  if (!system_.elastic().element_terms(e, x, with_hessian, terms)) return false;
  viscous_.add_element_terms(e, x, with_hessian, terms);
  const double share = system_.mass_share(e);
  const auto& nodes = system_.rest().nodes(e);
  for (int a = 0; a < Shape::kNodes; ++a) {
    const Index v = nodes[static_cast<std::size_t>(a)];
    const double mass = system_.mass()[v];
    const double fraction = share / mass;
    const Vector3 k = vertex_block(coefficient_, v);
    const Vector3 d = vertex_block(u, v) - vertex_block(remainder_, v).cwiseQuotient(k);
    const Vector3 force = fraction * k.cwiseProduct(d);
    terms.energy += 0.5 * force.dot(d);
    terms.gradient.col(a) += force;
    if (with_hessian) terms.hessian.diagonal().segment<3>(3 * a) += fraction * k;
    if (curved_environment_) {
      const Environment& environment = system_.environment();
      const Vector3 from = vertex_block(previous_, v);
      const Vector3 to = vertex_block(origin_, v) + vertex_block(u, v);
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

double StepProblem::square_value() const {
  return 0.5 * remainder_.cwiseAbs2().cwiseQuotient(coefficient_).sum();
}

double StepProblem::environment_share(Index e, const Vector& u) const {
  if (!curved_environment_) return 0.0;
  double energy = 0.0;
  for (const Index v : system_.rest().nodes(e)) {
    const double mass = system_.mass()[v];
    const Vector3 x = vertex_block(origin_, v) + vertex_block(u, v);
    energy += system_.mass_share(e) / mass * std::abs(system_.environment().value(mass, x));
  }
  return energy;
}

double StepProblem::round_off(const Vector& u) const {
  // C V |∇N|²: what one metre of a node's displacement adds to the force, element by element.
  double stiffness = 0.0;
  double with_edges = 0.0;
  const std::vector<MaterialModel>& materials = system_.elastic().materials();
  for (std::size_t m = 0; m < materials.size(); ++m) {
    const LameParameters lame = initial_lame(materials[m]);
    const double modulus = std::abs(lame.lambda) + 2.0 * lame.mu + 2.0 * viscous_.factor();
    const ElasticPotential::ShapeSums& sums = system_.elastic().shape_sums(m);
    stiffness += modulus * modulus * sums.squared;
    with_edges += modulus * modulus * sums.with_edges;
  }
  return 0.5 * std::numeric_limits<double>::epsilon() *
         (coefficient_.cwiseProduct(u).norm() + force_scale_ +
          std::sqrt(stiffness) * u.cwiseAbs().maxCoeff() + std::sqrt(with_edges));
}

double StepProblem::residual_limit(const Vector& u, double tolerance) const {
  return std::max(tolerance * force_scale_, round_off(u));
}

}  // namespace tetraction
