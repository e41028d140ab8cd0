// The shares of single elements in the potential, for solvers that work on elements.
#include <algorithm>
#include <cmath>

#include "dynamics/constraints/constraint_potential.h"
#include "tetraction/dynamics/contact/contact.h"
#include "tetraction/dynamics/problems/potential_problem.h"

namespace tetraction {

bool PotentialProblem::term_shares(const Vector& u, bool with_hessian, TermShares& shares) const {
  if (!move_terms(u).ok()) return false;
  shares.energy = term_energy(u);
  shares.magnitude = 0.0;
  for (const WeightedPotential& potential : potentials_) {
    shares.magnitude += potential.weight * std::abs(potential.term->energy(point(at_)));
  }
  if (contact_ != nullptr) shares.magnitude += contact_->energy(point(at_));
  if (constraint_potential_ != nullptr) {
    shares.magnitude += std::abs(constraint_potential_->value(u));
  }
  shares.gradient.setZero(system_.dof_count());
  add_term_gradient(u, shares.gradient);
  if (!with_hessian) return true;
  term_hessian(u, HessianForm::kExact, shares.hessian);
  shares.pairs_of_element.clear();
  for (const HessianBlocks::Pair& pair : shares.hessian.pairs()) {
    const Index element = element_of(pair.row, pair.column);
    if (element >= 0) shares.pairs_of_element[element].push_back(pair);
  }
  return true;
}

// An element that has both vertices, or −1.
Index PotentialProblem::element_of(Index i, Index j) const {
  if (element_of_edge_.empty()) {
    for (Index e = 0; e < system_.rest().element_count(); ++e) {
      const ElementNodes nodes = system_.rest().nodes(e);
      for (const Index a : nodes) {
        for (const Index b : nodes) {
          if (a < b) element_of_edge_.try_emplace({a, b}, e);
        }
      }
    }
  }
  const auto found = element_of_edge_.find({std::min(i, j), std::max(i, j)});
  return found == element_of_edge_.end() ? -1 : found->second;
}

bool PotentialProblem::element_terms(Index e, const Vector& u, const TermShares* terms,
                                     bool with_hessian,
                                     ElasticPotential::ElementTerms& result) const {
  const Positions x = elastic_positions(u);
  if (!system_.elastic().element_terms(e, x, with_hessian, result)) return false;
  viscous_.add_element_terms(e, x, with_hessian, result);
  const double mass = system_.element_mass(e);
  if (terms != nullptr) result.energy += mass / system_.total_mass() * terms->energy;
  const double room = length_scale();
  const ElementNodes nodes = system_.rest().nodes(e);
  for (int a = 0; a < static_cast<int>(nodes.size()); ++a) {
    const Index v = nodes[static_cast<std::size_t>(a)];
    const double fraction = system_.mass_share(e, a) / system_.mass()[v];
    const Vector3 k = vertex_block(coefficient_, v);
    for (Index i = 0; i < 3; ++i) {
      const double r = remainder_[3 * v + i];
      const double displacement = u[3 * v + i];
      if (k[i] > 0.0) {
        const double d = displacement - r / k[i];
        result.energy += 0.5 * fraction * k[i] * d * d;
        result.gradient(i, a) += fraction * k[i] * d;
      } else {
        result.energy += fraction * (std::abs(r) * room - r * displacement);
        result.gradient(i, a) -= fraction * r;
      }
    }
    if (with_hessian) result.hessian.diagonal().segment<3>(3 * a) += fraction * k;
    if (terms == nullptr) continue;
    result.gradient.col(a) += fraction * vertex_block(terms->gradient, v);
    if (with_hessian) {
      result.hessian.block<3, 3>(3 * a, 3 * a) += fraction * terms->hessian.diagonal(v);
    }
  }
  if (terms == nullptr || !with_hessian) return true;
  const auto pairs = terms->pairs_of_element.find(e);
  if (pairs == terms->pairs_of_element.end()) return true;
  const auto place = [&nodes](Index v) {
    return 3 * (std::find(nodes.begin(), nodes.end(), v) - nodes.begin());
  };
  for (const HessianBlocks::Pair& pair : pairs->second) {
    result.hessian.block<3, 3>(place(pair.row), place(pair.column)) += pair.block;
    result.hessian.block<3, 3>(place(pair.column), place(pair.row)) += pair.block.transpose();
  }
  return true;
}

double PotentialProblem::square_value() const {
  const double room = length_scale();
  double sum = 0.0;
  for (Index i = 0; i < remainder_.size(); ++i) {
    const double r = remainder_[i];
    const double k = coefficient_[i];
    sum += k > 0.0 ? 0.5 * r * r / k : std::abs(r) * room;
  }
  return sum;
}

}  // namespace tetraction
