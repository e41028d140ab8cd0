#include "followed_loads.h"

#include "tetraction/dynamics/nodal_volume/nodal_volume.h"

namespace tetraction {

EvaluationStatus FollowedLoads::residual(const Vector& u, Vector& residual) const {
  const EvaluationStatus status = problem_.residual(u, residual);
  if (status.ok()) problem_.add_load_deviation(u, residual);
  return status;
}

EvaluationStatus FollowedLoads::linearize(const Vector& u) {
  point_ = u;
  problem_.take_friction(u);
  // The whole stiffness of the loads comes in place of its symmetric part.
  problem_.set_with_load_stiffness(false);
  problem_.term_hessian(u, HessianForm::kExact, terms_);
  problem_.set_with_load_stiffness(true);
  problem_.load_stiffness(u, stiffness_);
  return {};
}

void FollowedLoads::multiply(const Vector& d, Vector& product) const {
  const MechanicalSystem& system = problem_.system();
  const MinimizationProblem::HessianParts parts = problem_.hessian_parts(point_);
  problem_.positions(point_, position_);
  product = parts.diagonal.cwiseProduct(d);
  system.elastic().product(position_, d, elastic_);
  product += elastic_;
  if (parts.volume != nullptr) parts.volume->add_product(position_, d, product);
  if (problem_.viscous().factor() != 0.0) add_viscous_product(d, product);
  terms_.add_product(d, product);
  stiffness_.add_product(d, product);
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

}  // namespace tetraction
