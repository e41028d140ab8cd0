#include "assembled_system.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "tetraction/core/parallel.h"

namespace tetraction {

AssembledSystem::AssembledSystem(const MechanicalSystem& system)
    : pattern_(system.rest(), system.coordinates()),
      cholesky_(pattern_),
      values_(static_cast<std::size_t>(pattern_.nonzeros())) {}

bool AssembledSystem::assemble(const StepProblem& problem, const Vector& x) {
  return problem.hessian(x, pattern_, values_.data()).ok();
}

void AssembledSystem::assemble_projected(const StepProblem& problem, const Vector& x) {
  using Shape = RestState::Shape;
  std::fill(values_.begin(), values_.end(), 0.0);
  for (const std::vector<Index>& color : pattern_.colors()) {
    parallel_for(static_cast<Index>(color.size()), 64, [&](Index begin, Index end) {
      ElasticPotential::ElementTerms terms;
      for (Index i = begin; i < end; ++i) {
        const Index e = color[static_cast<std::size_t>(i)];
        problem.element_terms(e, x, true, terms);
        if (Eigen::LLT<Shape::DofMatrix>(terms.hessian).info() != Eigen::Success) {
          const Eigen::SelfAdjointEigenSolver<Shape::DofMatrix> eigen(terms.hessian);
          terms.hessian = eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).asDiagonal() *
                          eigen.eigenvectors().transpose();
        }
        pattern_.scatter(e, terms.hessian, values_.data());
      }
    });
  }
}

bool AssembledSystem::factorize() {
  has_factor_ = cholesky_.factorize(values_);
  return has_factor_;
}

void AssembledSystem::multiply(const Vector& x, Vector& y) const {
  y.setZero(x.size());
  const std::vector<int>& begin = pattern_.column_begin();
  const std::vector<int>& rows = pattern_.rows();
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

CgReport AssembledSystem::solve(const Vector& right, bool with_factor, double forcing,
                                int max_iterations, Vector& solution) {
  CgReport report;
  Vector inverse_diagonal;
  if (!with_factor) {
    inverse_diagonal.resize(right.size());
    for (Index j = 0; j < right.size(); ++j) {
      const double d =
          values_[static_cast<std::size_t>(pattern_.column_begin()[static_cast<std::size_t>(j)])];
      inverse_diagonal[j] = d > 0.0 ? 1.0 / d : 1.0;
    }
  }
  const auto precondition = [&](const Vector& r) -> Vector {
    return with_factor ? cholesky_.solve(r) : Vector(inverse_diagonal.cwiseProduct(r));
  };
  solution.setZero(right.size());
  Vector r = right;
  Vector z = precondition(r);
  Vector p = z;
  Vector ap;
  double rz = r.dot(z);
  const double start = rz;
  const double target = forcing * forcing * rz;
  while (report.iterations < max_iterations) {
    if (rz <= target) {
      report.converged = true;
      break;
    }
    ++report.iterations;
    multiply(p, ap);
    const double curvature = p.dot(ap);
    if (!(curvature > 0.0)) {
      report.negative_curvature = true;
      if (report.iterations == 1) solution = p;
      break;
    }
    const double alpha = rz / curvature;
    solution += alpha * p;
    r -= alpha * ap;
    if (r.squaredNorm() <= forcing * forcing * right.squaredNorm() && with_factor) {
      // Spares the solve that would only confirm it.
      report.converged = true;
      rz = target;
      break;
    }
    z = precondition(r);
    const double next = r.dot(z);
    p = z + (next / rz) * p;
    rz = next;
  }
  report.reduction = start > 0.0 ? std::sqrt(std::max(rz, 0.0) / start) : 0.0;
  return report;
}

}  // namespace tetraction
