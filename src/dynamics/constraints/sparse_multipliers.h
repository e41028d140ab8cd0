// The multipliers of many constraints, whose equations share few vertices.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <type_traits>

#include "tetraction/dynamics/constraints/multipliers.h"

namespace tetraction {

/// From so many equations on, they are solved by the functions of this file. With fewer, the dense
/// least squares of multipliers.cc are as fast, and they find redundant equations more sharply.
constexpr Index kLeastSparse = 100;

/// Solves A x = b with A = GᵀSG, which is symmetric and positive semidefinite. It is singular if
/// equations are redundant. Unknowns are measured in units in which the diagonal is of the order of
/// one. A small multiple of the identity makes the matrix definite, and iterations remove its effect
/// from the part of b that A can reach (the proximal point method). Beginning at zero, they lead to
/// the solution of least norm, in which redundant equations share their force.
template <class Factor, class Matrix>
class SharedSolution {
 public:
  SharedSolution(const Matrix& a, const Vector& unit) : a_(a), unit_(unit) {
    Matrix scaled = unit.asDiagonal() * a;
    scaled = Matrix(scaled * unit.asDiagonal());
    const double most = Vector(scaled.diagonal()).maxCoeff();
    for (Index i = 0; i < unit.size(); ++i) {
      scaled.coeffRef(i, i) += most > 0.0 ? kShift * most : 1.0;
    }
    factor_.compute(scaled);
  }

  bool ok() const { return factor_.info() == Eigen::Success; }

  Vector solve(const Vector& b) const {
    constexpr int kRounds = 6;
    const double enough = 1e-15 * unit_.cwiseProduct(b).norm();
    Vector x = Vector::Zero(b.size());
    Vector rest = b;
    double before = std::numeric_limits<double>::infinity();
    for (int i = 0; i < kRounds; ++i) {
      const Vector scaled = unit_.cwiseProduct(rest);
      if (!(scaled.norm() > enough) || !(scaled.norm() < 0.5 * before)) break;
      before = scaled.norm();
      x += unit_.cwiseProduct(Vector(factor_.solve(scaled)));
      rest = b - a_ * x;
    }
    return x;
  }

 private:
  static constexpr double kShift = 1e-9;

  Matrix a_;
  Vector unit_;
  Factor factor_;
};

using SparseSolution =
    SharedSolution<Eigen::SimplicialLDLT<Constraints::SparseMatrix>, Constraints::SparseMatrix>;
using DenseSolution = SharedSolution<Eigen::LLT<Matrix>, Matrix>;

/// The result of solve_multipliers(), for a response that is sparse (of explicit steps) or dense. The
/// rounds neglect the curvature of g beside the stiffness, so that they converge linearly.
template <class Solution, class Response>
MultiplierSolution solve_many(const Constraints& constraints, const Vector& free_end,
                              const Response& response, const Vector& start,
                              ConstraintDirection direction, const Vector& guess) {
  constexpr int kRounds = 60;
  constexpr double kAccepted = 1e-12;   // |g|, relative
  constexpr double kConverged = 1e-11;  // of w, relative to its lengths
  const Vector unit = constraints.units_of(Vector(response.diagonal())).multiplier;
  const Vector lengths = constraints.configuration_lengths();
  const auto directions = [&](const Vector& w) -> Constraints::SparseMatrix {
    switch (direction) {
      case ConstraintDirection::kStart:
        return constraints.sparse_gradients(start);
      case ConstraintDirection::kMiddle:
        return constraints.sparse_gradients(0.5 * (start + w));
      case ConstraintDirection::kEnd:
        break;
    }
    return constraints.sparse_gradients(w);
  };
  MultiplierSolution solution;
  solution.multipliers = guess.size() == constraints.equation_count()
                             ? guess
                             : Vector(Vector::Zero(constraints.equation_count()));
  solution.end =
      direction == ConstraintDirection::kStart ? free_end : constraints.retract(free_end);
  Constraints::SparseMatrix along = directions(solution.end);
  std::optional<Solution> factor;
  double before = std::numeric_limits<double>::infinity();
  for (int round = 0; round < kRounds; ++round) {
    const Vector reached =
        free_end + response * Vector(along * solution.multipliers);  // with the present λ
    if (direction == ConstraintDirection::kStart || round > 0) solution.end = reached;
    if (direction != ConstraintDirection::kStart) along = directions(solution.end);
    const Vector g = constraints.values(solution.end);
    const Vector settled = free_end + response * Vector(along * solution.multipliers);
    const double moved = (settled - solution.end).cwiseQuotient(lengths).cwiseAbs().maxCoeff();
    const double error = std::max(g.cwiseAbs().maxCoeff(), moved);
    if (!std::isfinite(error)) break;
    solution.ok = g.cwiseAbs().maxCoeff() <= kAccepted && moved <= kConverged;
    if (solution.ok && !(error < 0.1 * before)) break;  // as good as round-off allows
    before = error;
    if (!factor || direction != ConstraintDirection::kStart) {
      const Constraints::SparseMatrix across = along.transpose();
      using Square =
          std::conditional_t<std::is_same_v<Response, Matrix>, Matrix, Constraints::SparseMatrix>;
      const Square product = response * along;
      factor.emplace(Square(across * product), unit);
      if (!factor->ok()) break;
    }
    const Constraints::SparseMatrix gradients = constraints.sparse_gradients(solution.end);
    const Vector change = factor->solve(
        -g - Vector(Constraints::SparseMatrix(gradients.transpose()) * (settled - solution.end)));
    if (!change.allFinite()) break;
    solution.multipliers += change;
  }
  solution.forces = along * solution.multipliers;
  if (!solution.ok) constraints.values(solution.end).cwiseAbs().maxCoeff(&solution.worst);
  return solution;
}

}  // namespace tetraction
