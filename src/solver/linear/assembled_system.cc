#include "assembled_system.h"

#include <algorithm>
#include <cmath>

#include "core/pseudo_random.h"
#include "tetraction/core/parallel.h"
#include "tetraction/core/positive_semidefinite.h"
#include "tetraction/dynamics/nodal_volume/nodal_volume.h"

namespace tetraction {
namespace {

constexpr double kSeed = 0.1;  // of the residual asked for: the last solve's residual in this one
constexpr double kCertain = 1e-6;         // residual at which there is no more to be found
constexpr double kRoundOffShift = 1e-11;  // of the diagonal: more than round-off needs

}  // namespace

AssembledSystem::AssembledSystem(const MechanicalSystem& system)
    : system_(system),
      coordinates_(system.coordinates()),
      matrix_(std::make_unique<MatrixParts>(system, pairs_)),
      values_(static_cast<std::size_t>(matrix_->pattern.nonzeros())) {}

void AssembledSystem::set_terms(const MinimizationProblem& problem, const Vector& x,
                                HessianForm form) {
  terms_.reset(system_.vertex_count());
  if (problem.has_general_terms()) problem.term_hessian(x, form, terms_);
  if (system_.nodal_volume() != nullptr) {
    const MinimizationProblem::HessianParts parts = problem.hessian_parts(x);
    parts.volume->add_outer_products(parts.positions, form, terms_);
  } else if (!problem.has_general_terms()) {
    return;
  }
  const bool complete = terms_.outer_vertices() == outer_vertices_ &&
                        std::all_of(terms_.pairs().begin(), terms_.pairs().end(),
                                    [&](const HessianBlocks::Pair& pair) {
                                      return matrix_->pattern.couples(pair.row, pair.column);
                                    });
  if (complete) return;
  // Coupled pairs may change from step to step, as in contact. Old pairs stay in the pattern until
  // there are too many of them.
  constexpr std::size_t kMost = 4;
  Pairs next;
  terms_.for_each_pair([&](Index i, Index j, const Matrix3&) { next.emplace_back(i, j); });
  if (pairs_.size() > kMost * next.size()) pairs_.clear();
  pairs_.insert(pairs_.end(), next.begin(), next.end());
  outer_vertices_ = terms_.outer_vertices();
  std::sort(pairs_.begin(), pairs_.end());
  pairs_.erase(std::unique(pairs_.begin(), pairs_.end()), pairs_.end());
  matrix_ = std::make_unique<MatrixParts>(system_, pairs_);
  values_.assign(static_cast<std::size_t>(matrix_->pattern.nonzeros()), 0.0);
  has_factor_ = has_single_ = false;
}

bool AssembledSystem::assemble(const MinimizationProblem& problem, const Vector& x) {
  set_terms(problem, x, HessianForm::kExact);
  return problem.hessian(x, terms_, matrix_->pattern, values_.data()).ok();
}

void AssembledSystem::assemble_projected(const MinimizationProblem& problem, const Vector& x) {
  set_terms(problem, x, HessianForm::kConvex);
  std::fill(values_.begin(), values_.end(), 0.0);
  const SparsityPattern& pattern = matrix_->pattern;
  for (const std::vector<Index>& color : pattern.colors()) {
    parallel_for(static_cast<Index>(color.size()), 64, [&](Index begin, Index end) {
      ElasticPotential::ElementTerms terms;
      for (Index i = begin; i < end; ++i) {
        const Index e = color[static_cast<std::size_t>(i)];
        problem.element_terms(e, x, nullptr, true, terms);
        pattern.scatter(e, positive_semidefinite_part(Matrix(terms.hessian)), values_.data());
      }
    });
  }
  if (!problem.has_general_terms() && system_.nodal_volume() == nullptr) return;
  pattern.add_vertex_blocks(terms_.whole_diagonal(), values_.data());
  terms_.for_each_pair([&](Index i, Index j, const Matrix3& block) {
    pattern.add_pair_block(i, j, block, values_.data());
  });
}

bool AssembledSystem::factorize() {
  has_single_ = false;
  has_factor_ = matrix_->cholesky.factorize(values_);
  return has_factor_;
}

bool AssembledSystem::factorize_projected(const MinimizationProblem& problem, const Vector& x) {
  const std::vector<double> exact = values_;
  const MatrixParts* const parts = matrix_.get();
  assemble_projected(problem, x);
  const bool done = factorize();
  // If the convex form couples other vertices, the pattern has changed. If it must change once more, the factor is lost.
  if (matrix_.get() != parts) return assemble(problem, x) && done && has_factor_;
  values_ = exact;
  return done;
}

NegativeCurvature AssembledSystem::find_negative_curvature(const MinimizationProblem& problem,
                                                           const Vector& x, int& factorizations) {
  constexpr int kMost = 500;
  ++factorizations;
  if (!assemble(problem, x) || factorize()) return {};
  if (!problem.has_inertia()) {
    set_elements(problem, x);
    if (factorize_least_shifted(factorizations)) return lowest_curvature();
  }
  if (!factorize_projected(problem, x)) return {};
  Vector ignored;
  const CgReport cg =
      solve(pseudo_random(size()), Preconditioner::kFactor, kCertain, kMost, ignored);
  if (!cg.negative_curvature) return {};
  ++factorizations;
  NegativeCurvature found = negative_curvature();
  if (problem.has_inertia()) return found;
  found.curvature = curvature(found.direction);
  return found.curvature < 0.0 ? found : NegativeCurvature();
}

bool AssembledSystem::factorize_shifted_by(double part, const std::vector<double>& exact) {
  const std::vector<int>& begin = matrix_->pattern.column_begin();
  for (std::size_t j = 0; j + 1 < begin.size(); ++j) {
    const auto k = static_cast<std::size_t>(begin[j]);  // the diagonal comes first
    values_[k] = exact[k] + part * std::abs(exact[k]);
  }
  return factorize();
}

bool AssembledSystem::factorize_shifted() {
  const std::vector<double> exact = values_;
  bool done = false;
  for (double part = 1e-15; part < kRoundOffShift && !done; part *= 10.0) {
    done = factorize_shifted_by(part, exact);
  }
  values_ = exact;
  return done;
}

bool AssembledSystem::factorize_least_shifted(int& attempts) {
  constexpr double kRatio = 4.0;
  constexpr double kMost = 0.01;
  const std::vector<double> exact = values_;
  const auto is_definite = [&](double part) {
    ++attempts;
    return factorize_shifted_by(part, exact);
  };
  double part = std::max(shift_, kRoundOffShift);
  if (is_definite(part)) {
    while (part > kRoundOffShift && is_definite(part / kRatio)) part /= kRatio;
    if (!has_factor_) is_definite(part);
  } else {
    do {
      part *= kRatio;
    } while (part <= kMost && !is_definite(part));
  }
  shift_ = has_factor_ ? part : 0.0;
  values_ = exact;
  return has_factor_;
}

NegativeCurvature AssembledSystem::lowest_curvature() {
  constexpr int kIterations = 4;
  const std::vector<int>& begin = matrix_->pattern.column_begin();
  Vector diagonal(size());
  for (Index j = 0; j < size(); ++j) {
    diagonal[j] = std::abs(values_[static_cast<std::size_t>(begin[static_cast<std::size_t>(j)])]);
  }
  Vector direction = pseudo_random(size());
  for (int i = 0; i < kIterations; ++i) {
    direction = back_solve(diagonal.cwiseProduct(direction));
    direction /= direction.norm();
  }
  NegativeCurvature found{coordinates_.extend(direction), 0.0};
  found.curvature = curvature(found.direction);
  return found.curvature < 0.0 ? found : NegativeCurvature();
}

void AssembledSystem::set_elements(const MinimizationProblem& problem, const Vector& x) {
  const MinimizationProblem::HessianParts parts = problem.hessian_parts(x);
  point_ = parts.positions.origin();
  if (parts.positions.displacement() != nullptr) point_ += *parts.positions.displacement();
  diagonal_ = parts.diagonal;
  volume_ = parts.volume;
  element_terms_.reset(system_.vertex_count());
  if (problem.has_general_terms()) problem.term_hessian(x, HessianForm::kExact, element_terms_);
}

Vector AssembledSystem::product_by_elements(const Vector& d) const {
  Vector product;
  system_.elastic().product(point_, d, product);
  product += diagonal_.cwiseProduct(d);
  if (volume_ != nullptr) volume_->add_product(point_, d, product);
  element_terms_.add_product(d, product);
  return product;
}

double AssembledSystem::curvature(const Vector& d) const {
  return d.dot(product_by_elements(d));
}

CgReport AssembledSystem::solve_by_elements(const Vector& right, double forcing, int max_iterations,
                                            Vector& solution) {
  CgReport report;
  solution.setZero(right.size());
  Vector residual = right;
  Vector z = back_solve(residual);
  Vector direction = z;
  double square = residual.dot(z);
  report.first_square = report.last_square = square;
  report.converged = !(square > 0.0);
  while (!report.converged && report.iterations < max_iterations) {
    ++report.iterations;
    const Vector product =
        coordinates_.restrict(product_by_elements(coordinates_.extend(direction)));
    const double curvature = direction.dot(product);
    if (!(curvature > 0.0)) {
      report.negative_curvature = true;
      report.curvature = curvature_ = curvature;
      curved_direction_ = direction;
      return report;
    }
    const double alpha = square / curvature;
    solution += alpha * direction;
    residual -= alpha * product;
    z = back_solve(residual);
    const double next = residual.dot(z);
    report.last_square = next;
    report.converged = next <= forcing * forcing * report.first_square;
    direction = z + (next / square) * direction;
    square = next;
  }
  return report;
}

NegativeCurvature AssembledSystem::negative_curvature() const {
  return {coordinates_.extend(curved_direction_), curvature_};
}

SinglePrecisionFactor& AssembledSystem::single_precision_factor() {
  if (!has_single_) matrix_->cholesky.copy_to(single_);
  has_single_ = true;
  return single_;
}

void AssembledSystem::multiply(const Vector& x, Vector& y) const {
  y.setZero(x.size());
  const std::vector<int>& begin = matrix_->pattern.column_begin();
  const std::vector<int>& rows = matrix_->pattern.rows();
  for (Index j = 0; j < x.size(); ++j) {
    auto k = static_cast<std::size_t>(begin[static_cast<std::size_t>(j)]);
    const auto end = static_cast<std::size_t>(begin[static_cast<std::size_t>(j) + 1]);
    const double xj = x[j];
    double sum = values_[k] * xj;  // the diagonal comes first
    for (++k; k < end; ++k) {
      const int i = rows[k];
      y[i] += values_[k] * xj;
      sum += values_[k] * x[i];
    }
    y[j] += sum;
  }
}

CgReport AssembledSystem::solve(const Vector& right, Preconditioner preconditioner, double forcing,
                                int max_iterations, Vector& solution) {
  Vector inverse_diagonal;
  if (preconditioner == Preconditioner::kDiagonal) {
    inverse_diagonal.resize(right.size());
    for (Index j = 0; j < right.size(); ++j) {
      const double d = values_[static_cast<std::size_t>(
          matrix_->pattern.column_begin()[static_cast<std::size_t>(j)])];
      inverse_diagonal[j] = d > 0.0 ? 1.0 / d : 1.0;
    }
  }
  const auto precondition = [&](const Vector& r, Vector& z) {
    if (preconditioner == Preconditioner::kDiagonal) {
      z = inverse_diagonal.cwiseProduct(r);
    } else if (preconditioner == Preconditioner::kFactor) {
      z = matrix_->cholesky.solve(r);
    } else {
      z.resize(r.size());
      single_precision_factor().solve(r, z);
    }
  };
  solution.setZero(right.size());
  if (residual_.size() != right.size()) residual_ = pseudo_random(right.size());
  const double share = kSeed * forcing * right.norm() / residual_.norm();
  if (std::isfinite(share)) {
    residual_ = right + share * residual_;
  } else {
    residual_ = right;
  }
  PlainVectors vectors(
      solution, residual_, [&](const Vector& p, Vector& ap) { multiply(p, ap); }, precondition);
  const CgReport report = conjugate_gradients(vectors, forcing, max_iterations);
  if (report.negative_curvature) {
    curved_direction_ = vectors.direction();
    curvature_ = report.curvature;
  }
  return report;
}

}  // namespace tetraction
