#include "followed_loads.h"

#include <algorithm>

#include "dynamics/contact/friction/friction_step.h"
#include "tetraction/core/parallel.h"
#include "tetraction/dynamics/contact/contact.h"
#include "tetraction/dynamics/nodal_volume/nodal_volume.h"

namespace tetraction {
namespace {

constexpr Index kVerticesAtOnce = 1024;

}  // namespace

void add_stiffness_of_loads(const MechanicalSystem& system, const ForcePoint& at,
                            LoadStiffness& stiffness) {
  for (const ForceTerm* term : system.force_terms()) {
    if (!term->has_load() || !term->load_depends_on_position()) continue;
    term->add_load_stiffness(at, stiffness);
  }
}

EvaluationStatus FollowedLoads::residual(const Vector& u, Vector& residual) const {
  const EvaluationStatus status = problem_.residual(u, residual);
  if (status.ok()) problem_.add_load_deviation(u, residual);
  return status;
}

EvaluationStatus FollowedLoads::linearize(const Vector& u) {
  point_ = u;
  knows_tangent_ = false;
  problem_.take_friction(u);
  // The whole stiffness of the loads comes in place of its symmetric part.
  problem_.set_with_load_stiffness(false);
  problem_.term_hessian(u, HessianForm::kExact, terms_);
  problem_.set_with_load_stiffness(true);
  problem_.load_stiffness(u, stiffness_);
  return {};
}

void FollowedLoads::multiply(const Vector& d, Vector& product) const {
  const MinimizationProblem::HessianParts parts = problem_.hessian_parts(point_);
  problem_.positions(point_, position_);
  product = parts.diagonal.cwiseProduct(d);
  add_stiffness_product(d, product);
  if (parts.volume != nullptr) parts.volume->add_product(position_, d, product);
  terms_.add_product(d, product);
  stiffness_.add_product(d, product);
}

void FollowedLoads::add_stiffness_product(const Vector& d, Vector& product) const {
  const ElasticPotential& elastic = problem_.system().elastic();
  if (!TangentOperator<double>::supports(elastic)) {
    elastic.product(position_, d, elastic_);
    product += elastic_;
    if (problem_.viscous().factor() != 0.0) add_viscous_product(d, product);
    return;
  }
  if (!knows_tangent_) {
    if (!tangent_) tangent_ = std::make_unique<TangentOperator<double>>(elastic);
    tangent_->set(position_, problem_.viscous(), problem_.step_displacement(point_));
    knows_tangent_ = true;
  }
  constexpr Index kRecord = ElementBlocks::kRecordSize;
  const Index count = d.size() / 3;
  records_.resize(static_cast<std::size_t>(kRecord * count), 0.0);
  for (Index v = 0; v < count; ++v) {
    std::copy_n(d.data() + 3 * v, 3, records_.data() + kRecord * v);
  }
  tangent_->multiply(records_.data());
  parallel_for(count, kVerticesAtOnce, [&](Index begin, Index end) {
    for (Index v = begin; v < end; ++v) {
      vertex_block(product, v) += tangent_->record_sum(v).head<3>();
    }
  });
}

void FollowedLoads::add_viscous_product(const Vector& d, Vector& product) const {
  const RestState& rest = problem_.system().rest();
  ElasticPotential::ElementTerms terms;
  for (Index e = 0; e < rest.element_count(); ++e) {
    const ElementNodes nodes = rest.nodes(e);
    const auto size = static_cast<Index>(3 * nodes.size());
    terms.gradient.setZero(3, size / 3);
    terms.hessian.setZero(size, size);
    problem_.viscous().add_element_terms(e, Positions(problem_.origin(), point_), true, terms);
    Vector local(size);
    for (std::size_t a = 0; a < nodes.size(); ++a) {
      local.segment<3>(3 * static_cast<Index>(a)) = vertex_block(d, nodes[a]);
    }
    const Vector force = terms.hessian * local;
    for (std::size_t a = 0; a < nodes.size(); ++a) {
      vertex_block(product, nodes[a]) += force.segment<3>(3 * static_cast<Index>(a));
    }
  }
}

// The forces of a problem that belong to no potential.

// Loads belong to the start of a step, as in MechanicalSystem::external_force().
ForcePoint PotentialProblem::load_point(const Vector& x) const {
  return system_.force_point(x, span_ ? span_->begin : time_, span_);
}

void PotentialProblem::add_load_deviation(const Vector& u, Vector& residual) const {
  at_ = origin_ + u;
  system_.external_force(load_point(at_), full_);
  if (full_.size() > 0) residual += load_weight_ * (constant_loads_ - full_);
  if (!has_friction()) return;
  // The friction of the present normal forces in place of those that were known.
  velocity_ = ((origin_ - previous_) + u) / step_;
  full_.setZero(system_.dof_count());
  friction_->add_gradient(velocity_, full_);
  residual -= full_;
  FrictionStep present = *friction_;
  present.take(system_.mass(), end_positions(u));
  present.add_gradient(velocity_, residual);
}

void PotentialProblem::load_stiffness(const Vector& u, LoadStiffness& stiffness) const {
  stiffness = LoadStiffness(load_weight_);
  at_ = origin_ + u;
  add_stiffness_of_loads(system_, load_point(at_), stiffness);
  if (!has_friction()) return;
  velocity_ = ((origin_ - previous_) + u) / step_;
  FrictionStep present = *friction_;
  present.take(system_.mass(), end_positions(u));
  present.add_force_stiffness(velocity_, rate_of_end(), stiffness);
}

void PotentialProblem::take_loads(const Vector& u) {
  at_ = origin_ + u;
  system_.external_force(load_point(at_), full_);
  if (full_.size() > 0) {
    load_ += load_weight_ * (full_ - constant_loads_);
    constant_loads_ = full_;
  }
  take_friction(u);
  make_remainder();
}

void PotentialProblem::take_friction(const Vector& u) {
  if (has_friction()) friction_->take(system_.mass(), end_positions(u));
}

void PotentialProblem::begin_friction(double begin, double end, bool has_mean_forces) {
  const Contact* contact = system_.contact();
  if (contact == nullptr || !contact->has_friction()) return;
  friction_->begin(*contact, previous_, begin, end,
                   has_mean_forces ? NormalForces::kMean : NormalForces::kEnd);
}

bool PotentialProblem::has_friction() const {
  return friction_->exists();
}

}  // namespace tetraction
