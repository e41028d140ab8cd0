#include "ceres_elements.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "tetraction/core/parallel.h"
#include "tetraction/core/positive_semidefinite.h"

namespace tetraction {
namespace {

// The columns of the Jacobian that belong to one of Ceres' parameter blocks: the coordinates of one
// vertex, or of the affine set that some of the element's vertices belong to.
struct Block {
  int first = 0;
  int count = 0;
  std::vector<std::pair<int, FreeCoordinates::VertexMap>> nodes;  // node and its map
  bool identity = false;
};

class ElementCost : public ceres::CostFunction {
 public:
  ElementCost(const ElementEvaluator& evaluator, Index element, std::size_t nodes,
              std::vector<Block> blocks)
      : evaluator_(evaluator), element_(element), blocks_(std::move(blocks)) {
    set_num_residuals(3 * static_cast<int>(nodes) + 1);
    for (const Block& block : blocks_) mutable_parameter_block_sizes()->push_back(block.count);
  }

  bool Evaluate(const double* const*, double* residuals, double** jacobians) const override {
    const Index rows = num_residuals();
    const ElementResidual& result = evaluator_.element(element_);
    if (!result.defined) return false;
    std::fill(residuals, residuals + rows, 0.0);
    residuals[0] = result.root;
    if (jacobians == nullptr) return true;
    for (std::size_t b = 0; b < blocks_.size(); ++b) {
      if (jacobians[b] == nullptr) continue;
      const Block& block = blocks_[b];
      if (block.identity) {
        Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>>{
            jacobians[b], rows, 3} = result.jacobian.middleCols<3>(3 * block.nodes[0].first);
        continue;
      }
      Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> jacobian(
          jacobians[b], rows, block.count);
      jacobian.setZero();
      for (const auto& [node, map] : block.nodes) {
        jacobian += result.jacobian.middleCols<3>(3 * node) * map.columns;
      }
    }
    return true;
  }

 private:
  const ElementEvaluator& evaluator_;
  Index element_;
  std::vector<Block> blocks_;
};

}  // namespace

ElementEvaluator::ElementEvaluator(const MechanicalSystem& system, const Vector& y)
    : system_(system), y_(y), elements_(static_cast<std::size_t>(system.rest().element_count())) {}

void ElementEvaluator::begin(const MinimizationProblem& problem, const Vector& x,
                             double shift_density) {
  problem_ = &problem;
  start_ = x_ = x;
  constexpr double kRoom = 10.0;  // for the energies of force terms to fall within a step
  shifts_.resize(elements_.size());
  has_terms_ = problem.has_general_terms();
  if (has_terms_) problem.term_shares(x, false, terms_);
  const double room = has_terms_ ? kRoom * terms_.magnitude / system_.total_mass() : 0.0;
  for (std::size_t e = 0; e < shifts_.size(); ++e) {
    const auto element = static_cast<Index>(e);
    shifts_[e] =
        shift_density * system_.rest().volume(element) + room * system_.element_mass(element);
  }
  has_residuals_ = has_jacobians_ = false;
}

void ElementEvaluator::PrepareForEvaluation(bool evaluate_jacobians, bool new_evaluation_point) {
  if (new_evaluation_point) has_residuals_ = has_jacobians_ = false;
  if (evaluate_jacobians ? has_jacobians_ : has_residuals_) return;
  x_ = start_ + system_.coordinates().extend(y_);
  if (has_terms_ && !problem_->term_shares(x_, evaluate_jacobians, terms_)) {
    for (ElementResidual& element : elements_) element.defined = false;
    has_residuals_ = has_jacobians_ = true;
    return;
  }
  parallel_for(system_.rest().element_count(), 64, [&](Index begin, Index end) {
    for (Index e = begin; e < end; ++e) evaluate(e, evaluate_jacobians);
  });
  has_residuals_ = true;
  has_jacobians_ = evaluate_jacobians;
}

void ElementEvaluator::evaluate(Index e, bool with_jacobian) {
  ElementResidual& result = elements_[static_cast<std::size_t>(e)];
  ElasticPotential::ElementTerms terms;
  result.defined =
      problem_->element_terms(e, x_, has_terms_ ? &terms_ : nullptr, with_jacobian, terms);
  if (!result.defined) return;
  const double shifted = terms.energy + shifts_[static_cast<std::size_t>(e)];
  result.defined = shifted > 0.0 && std::isfinite(shifted);
  if (!result.defined) return;
  result.root = std::sqrt(2.0 * shifted);
  if (!with_jacobian) return;
  const Eigen::Map<const Vector> gradient(terms.gradient.data(), terms.gradient.size());
  result.jacobian.resize(gradient.size() + 1, gradient.size());
  result.jacobian.row(0) = gradient.transpose() / result.root;
  result.jacobian.bottomRows(gradient.size()) =
      positive_semidefinite_root(terms.hessian - gradient * gradient.transpose() / (2.0 * shifted));
}

ceres::CostFunction* make_element_cost(const ElementEvaluator& evaluator,
                                       const MechanicalSystem& system, Index e,
                                       std::vector<int>& blocks) {
  std::vector<Block> list;
  const ElementNodes nodes = system.rest().nodes(e);
  for (int a = 0; a < static_cast<int>(nodes.size()); ++a) {
    const Index v = nodes[static_cast<std::size_t>(a)];
    FreeCoordinates::VertexMap map = system.coordinates().map(v);
    if (map.count == 0) continue;
    const auto same = [&](const Block& block) { return block.first == map.first; };
    auto block = std::find_if(list.begin(), list.end(), same);
    if (block == list.end()) {
      list.push_back({map.first, map.count, {}, system.coordinates().is_free(v)});
      block = list.end() - 1;
    }
    block->nodes.emplace_back(a, std::move(map));
  }
  blocks.clear();
  for (const Block& block : list) blocks.push_back(block.first);
  return list.empty() ? nullptr : new ElementCost(evaluator, e, nodes.size(), std::move(list));
}

}  // namespace tetraction
