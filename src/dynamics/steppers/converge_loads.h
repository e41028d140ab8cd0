// Loads that depend on the positions that they lead to.
#pragma once

#include <algorithm>
#include <vector>

#include "core/decompositions.h"
#include "tetraction/core/types.h"

namespace tetraction {

/// Anderson's method (Walker & Ni 2011): the next point is the combination of the last ones whose
/// residuals g(x) − x have the smallest combination. It converges for many iterations that diverge
/// without it, if only a few of their eigenvalues are large.
class AndersonMixing {
 public:
  /// The next point after g(x) was found at x.
  Vector next(const Vector& x, const Vector& g) {
    const Vector residual = g - x;
    if (last_point_.size() > 0) {
      if (points_.size() == kDepth) {
        points_.erase(points_.begin());
        residuals_.erase(residuals_.begin());
      }
      points_.push_back(x - last_point_);
      residuals_.push_back(residual - last_residual_);
    }
    last_point_ = x;
    last_residual_ = residual;
    const auto count = static_cast<Index>(points_.size());
    Vector next = g;
    if (count == 0) return next;
    Matrix products(count, count);
    Vector right(count);
    for (Index i = 0; i < count; ++i) {
      const Vector& r = residuals_[static_cast<std::size_t>(i)];
      right[i] = r.dot(residual);
      for (Index j = 0; j <= i; ++j) {
        products(i, j) = products(j, i) = r.dot(residuals_[static_cast<std::size_t>(j)]);
      }
    }
    const SymmetricEigen eigen = symmetric_eigen(products);
    const double least = kSingular * eigen.values[count - 1];
    for (Index k = 0; k < count; ++k) {
      if (!(eigen.values[k] > least)) continue;
      const Vector weights =
          eigen.vectors.col(k).dot(right) / eigen.values[k] * eigen.vectors.col(k);
      for (Index i = 0; i < count; ++i) {
        const auto place = static_cast<std::size_t>(i);
        next -= weights[i] * (points_[place] + residuals_[place]);
      }
    }
    return next;
  }

 private:
  static constexpr std::size_t kDepth = 8;
  static constexpr double kSingular = 1e-14;

  std::vector<Vector> points_;     // differences of successive points
  std::vector<Vector> residuals_;  // of their residuals
  Vector last_point_;
  Vector last_residual_;
};

enum class LoadConvergence {
  kConverged,
  kNotConverged,  ///< the loads still changed after the last round, or became infinite
  kNotSolved      ///< a solution with given loads failed
};

/// Replaces `load` by that of the solution until both agree. Anderson's acceleration chooses the loads
/// of each round. `load_of_solution(Vector&)` returns the loads at the last solution,
/// `is_small(change, load)` says whether they are those of the solution, and `solve_with(load)` finds the
/// solution with given loads and returns whether there is one.
template <class LoadOfSolution, class IsSmall, class SolveWith>
LoadConvergence converge_loads(Vector& load, LoadOfSolution&& load_of_solution, IsSmall&& is_small,
                               SolveWith&& solve_with) {
  constexpr int kRounds = 60;
  AndersonMixing mixing;
  Vector present;
  Vector change;
  for (int round = 0; round < kRounds; ++round) {
    load_of_solution(present);
    change = present - load;
    if (is_small(change, present)) return LoadConvergence::kConverged;
    if (!change.allFinite()) break;
    load = mixing.next(load, present);
    if (!solve_with(load)) return LoadConvergence::kNotSolved;
  }
  return LoadConvergence::kNotConverged;
}

}  // namespace tetraction
