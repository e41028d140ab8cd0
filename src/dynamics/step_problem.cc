#include "tetraction/dynamics/step_problem.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tetraction/core/parallel.h"

namespace tetraction {

StepProblem::StepProblem(const MechanicalSystem& system) : system_(system) {
  // V (λ + 2μ) |∇N|²: what one metre of a node's displacement adds to the force, element by
  // element.
  const LameParameters lame = initial_lame(system.elastic().material());
  const RestState& rest = system.rest();
  double sum = 0.0;
  for (Index e = 0; e < rest.element_count(); ++e) {
    const auto& element = rest.element(e);
    for (std::size_t p = 0; p < Shape::kPoints; ++p) {
      sum += std::pow(element.weights[p] * (std::abs(lame.lambda) + 2.0 * lame.mu) *
                          element.gradients[p].squaredNorm(),
                      2);
    }
  }
  stiffness_scale_ = std::sqrt(sum);
}

void StepProblem::begin(const State& state, double h, double alpha, const Vector& user_force) {
  step_ = alpha * h;
  previous_ = state.position;
  target_ = state.position;
  const Vector3& a = system_.environment().acceleration();
  const DofConstraints& constraints = system_.constraints();
  double squared = 0.0;
  for (Index i = 0; i < target_.size(); ++i) {
    if (constraints.is_fixed(i)) continue;
    const double mass = system_.mass()[i / 3];
    const double shift =
        step_ * (state.momentum[i] + step_ * user_force[i]) / mass + step_ * step_ * a[i % 3];
    target_[i] += shift;
    squared += std::pow(mass * shift / (step_ * step_), 2);
  }
  force_scale_ = std::sqrt(squared);
}

Evaluation StepProblem::value(const Vector& x, double& phi) const {
  const Evaluation status = system_.elastic().value(x, phi);
  if (!status.ok()) return status;
  phi += parallel_sum(system_.vertex_count(),
                      [&](Index begin, Index end) {
                        double sum = 0.0;
                        for (Index v = begin; v < end; ++v) {
                          sum += system_.mass()[v] *
                                 (vertex_block(x, v) - vertex_block(target_, v)).squaredNorm();
                        }
                        return sum;
                      }) /
         (2.0 * step_ * step_);
  return status;
}

Evaluation StepProblem::value_and_gradient(const Vector& x, double& phi, Vector& gradient) const {
  const Evaluation status = system_.elastic().value_and_gradient(x, phi, gradient);
  if (!status.ok()) return status;
  double inertia = 0.0;
  for (Index v = 0; v < system_.vertex_count(); ++v) {
    const Vector3 d = vertex_block(x, v) - vertex_block(target_, v);
    const double factor = system_.mass()[v] / (step_ * step_);
    vertex_block(gradient, v) += factor * d;
    inertia += 0.5 * factor * d.squaredNorm();
  }
  phi += inertia;
  system_.constraints().set_fixed_to_zero(gradient);
  return status;
}

Evaluation StepProblem::hessian(const Vector& x, const SparsityPattern& pattern,
                                double* values) const {
  std::fill(values, values + pattern.nonzeros(), 0.0);
  const Evaluation status = system_.elastic().add_hessian(x, pattern, values);
  if (!status.ok()) return status;
  Vector diagonal(system_.dof_count());
  for (Index i = 0; i < diagonal.size(); ++i) {
    diagonal[i] = system_.mass()[i / 3] / (step_ * step_);
  }
  pattern.add_diagonal(diagonal, values);
  return status;
}

bool StepProblem::element_terms(Index e, const Vector& x, bool with_hessian,
                                ElasticPotential::ElementTerms& terms) const {
  if (!system_.elastic().element_terms(e, x, with_hessian, terms)) return false;
  const RestState& rest = system_.rest();
  const Shape::NodeMatrix d = rest.gather(x, e) - rest.gather(target_, e);
  const double factor = system_.mass_share(e) / (step_ * step_);
  terms.energy += 0.5 * factor * d.squaredNorm();
  terms.gradient += factor * d;
  if (with_hessian) terms.hessian.diagonal().array() += factor;
  return true;
}

double StepProblem::residual_limit(const Vector& x, double tolerance) const {
  double squared = 0.0;
  for (Index v = 0; v < system_.vertex_count(); ++v) {
    const double factor = system_.mass()[v] / (step_ * step_);
    squared += factor * factor * vertex_block(x, v).squaredNorm();
  }
  // Positions carry ε|x|: F, and with it the element forces, cannot be more accurate than that.
  const double round_off = 4.0 * std::numeric_limits<double>::epsilon() *
                           (std::sqrt(squared) + stiffness_scale_ * x.cwiseAbs().maxCoeff());
  return std::max(tolerance * force_scale_, round_off);
}

}  // namespace tetraction
