#include "tetraction/dynamics/constraints/multipliers.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>

#include "sparse_multipliers.h"

namespace tetraction {
namespace {

constexpr double kAccepted = 1e-12;  // |g|, relative
constexpr int kIterations = 60;

// The least-squares solution, with minimum norm if equations are redundant. Rows are multiplied by
// their factors and unknowns are measured in their units, because the decision which equations are
// redundant must not depend on the size of a constraint or the masses at its ends.
Vector solve_redundant(const Matrix& a, const Vector& b, const Vector& row_factors,
                       const Vector& units) {
  Eigen::CompleteOrthogonalDecomposition<Matrix> qr;
  qr.setThreshold(1e-11);
  qr.compute(row_factors.asDiagonal() * a * units.asDiagonal());
  return units.cwiseProduct(qr.solve(row_factors.cwiseProduct(b)));
}

bool is_many(const Constraints& constraints) {
  return constraints.equation_count() >= kLeastSparse;
}

double largest(const Vector& g) {
  const double value = g.cwiseAbs().maxCoeff();
  return std::isfinite(value) ? value : std::numeric_limits<double>::infinity();
}

// Makes the rate of every g zero. The momenta have what the linear constraints allow already.
// Returns the generalised impulses on the configuration.
Vector stop_rates(const Constraints& constraints, const Vector& mass, const Vector& q,
                  Vector& momentum) {
  if (!constraints.has_equations()) return {};
  Vector velocity = momentum;
  for (Index i = 0; i < velocity.size(); ++i) velocity[i] /= mass[i / 3];
  const Constraints::SparseMatrix& response = constraints.sparse_inverse_mass();
  const Constraints::SparseMatrix gradients =
      constraints.sparse_gradients(constraints.configuration(q));
  const Vector unit = constraints.units_of(Vector(response.diagonal())).multiplier;
  const Constraints::SparseMatrix across = gradients.transpose();
  const Constraints::SparseMatrix moved = response * gradients;
  const Constraints::SparseMatrix matrix = across * moved;
  const Vector rates = across * constraints.configuration(velocity);
  const Vector multipliers = is_many(constraints) ? SparseSolution(matrix, unit).solve(-rates)
                                                  : solve_redundant(matrix, -rates, unit, unit);
  Vector u = gradients * multipliers;
  Vector impulse = constraints.vertex_forces(u);
  constraints.coordinates().project_momentum(mass, impulse);
  momentum += impulse;
  return u;
}

void finish(const Constraints& constraints, MultiplierSolution& solution) {
  const Vector g = constraints.values(solution.end);
  solution.ok = largest(g) <= kAccepted;
  if (!solution.ok) g.cwiseAbs().maxCoeff(&solution.worst);
}

MultiplierSolution solve_along_start(const Constraints& constraints, const Vector& free_end,
                                     const Matrix& response, const Vector& start,
                                     const Vector& guess) {
  const Vector unit = constraints.units(response).multiplier;
  const Matrix directions = constraints.gradients(start);
  const Matrix moved = response * directions;  // ∂w/∂λ
  MultiplierSolution solution;
  solution.multipliers =
      guess.size() == directions.cols() ? guess : Vector::Zero(directions.cols());
  solution.end = free_end + moved * solution.multipliers;
  double error = largest(constraints.values(solution.end));
  if (guess.size() > 0 && !(error < largest(constraints.values(free_end)))) {
    solution.multipliers.setZero();
    solution.end = free_end;
    error = largest(constraints.values(solution.end));
  }
  for (int i = 0; i < kIterations && error > 0.0; ++i) {
    const Vector step = solve_redundant(constraints.gradients(solution.end).transpose() * moved,
                                        -constraints.values(solution.end), unit, unit);
    if (!step.allFinite()) break;
    double length = 1.0;
    bool better = false;
    for (int halving = 0; halving < 12 && !better; ++halving, length *= 0.5) {
      const Vector multipliers = solution.multipliers + length * step;
      const Vector end = free_end + moved * multipliers;
      const double now = largest(constraints.values(end));
      if (now < error) {
        solution.multipliers = multipliers;
        solution.end = end;
        error = now;
        better = true;
      }
    }
    if (!better) break;  // as good as round-off allows, or stuck
  }
  solution.forces = directions * solution.multipliers;
  finish(constraints, solution);
  return solution;
}

// Newton on w − ŵ − S G(w + (1 − share)(w_k − w)) λ = 0, g(w) = 0.
MultiplierSolution solve_along_end(const Constraints& constraints, const Vector& free_end,
                                   const Matrix& response, const Vector& start, double share,
                                   const Vector& guess) {
  const Index n = free_end.size();
  const Index m = constraints.equation_count();
  const Constraints::Units units = constraints.units(response);
  const Vector lengths = constraints.configuration_lengths();
  // Columns have the units of w and λ. Rows have the units of w and of the conjugate of λ.
  Vector column_unit(n + m);
  column_unit << units.displacement, units.multiplier;
  Vector row_factor(n + m);
  row_factor << units.displacement.cwiseInverse(), units.multiplier;
  const auto directions = [&](const Vector& w) {
    return constraints.gradients(share == 1.0 ? w : Vector(w + (1.0 - share) * (start - w)));
  };
  MultiplierSolution solution;
  solution.end = constraints.retract(free_end);
  solution.multipliers = guess.size() == m ? guess
                                           : solve_redundant(response * directions(solution.end),
                                                             solution.end - free_end,
                                                             row_factor.head(n), units.multiplier);
  const auto residual = [&](const Vector& w, const Vector& multipliers) {
    Vector r(n + m);
    r.head(n) = w - free_end - response * (directions(w) * multipliers);
    r.tail(m) = constraints.values(w);
    return r;
  };
  // The deviation of every constraint is relative to its own length.
  const auto size_of = [&](const Vector& r) {
    return std::hypot(r.head(n).cwiseQuotient(lengths).norm(), r.tail(m).norm());
  };
  Vector r = residual(solution.end, solution.multipliers);
  for (int i = 0; i < kIterations && size_of(r) > 0.0; ++i) {
    Matrix jacobian = Matrix::Zero(n + m, n + m);
    const Matrix gradients = constraints.gradients(solution.end);
    jacobian.topLeftCorner(n, n) =
        Matrix::Identity(n, n) - share * response * constraints.curvature(solution.multipliers);
    jacobian.topRightCorner(n, m) = -response * directions(solution.end);
    jacobian.bottomLeftCorner(m, n) = gradients.transpose();
    const Vector step = solve_redundant(jacobian, -r, row_factor, column_unit);
    if (!step.allFinite()) break;
    double length = 1.0;
    bool better = false;
    for (int halving = 0; halving < 20 && !better; ++halving, length *= 0.5) {
      const Vector end = solution.end + length * step.head(n);
      const Vector multipliers = solution.multipliers + length * step.tail(m);
      const Vector now = residual(end, multipliers);
      if (size_of(now) < size_of(r)) {
        solution.end = end;
        solution.multipliers = multipliers;
        r = now;
        better = true;
      }
    }
    if (!better) break;
  }
  solution.forces = directions(solution.end) * solution.multipliers;
  finish(constraints, solution);
  solution.ok = solution.ok && r.head(n).cwiseQuotient(lengths).norm() <= 1e-10;
  if (!solution.ok && solution.worst < 0) solution.worst = 0;
  return solution;
}

// Newton's method with dense matrices takes longer than a user waits beyond this number of equations.
constexpr Index kDense = 1000;

}  // namespace

MultiplierSolution solve_multipliers(const Constraints& constraints, const Vector& free_end,
                                     const Constraints::SparseMatrix& response, const Vector& start,
                                     ConstraintDirection direction, const Vector& guess) {
  if (is_many(constraints) && free_end.allFinite()) {
    MultiplierSolution solution =
        solve_many<SparseSolution>(constraints, free_end, response, start, direction, guess);
    if (solution.ok || constraints.equation_count() > kDense) return solution;
  }
  return solve_multipliers(constraints, free_end, Matrix(response), start, direction, guess);
}

MultiplierSolution solve_multipliers(const Constraints& constraints, const Vector& free_end,
                                     const Matrix& response, const Vector& start,
                                     ConstraintDirection direction, const Vector& guess) {
  if (!free_end.allFinite() || !response.allFinite()) {
    MultiplierSolution failed;
    failed.worst = 0;
    return failed;
  }
  if (is_many(constraints)) {
    MultiplierSolution solution =
        solve_many<DenseSolution>(constraints, free_end, response, start, direction, guess);
    if (solution.ok || constraints.equation_count() > kDense) return solution;
  }
  if (direction == ConstraintDirection::kStart) {
    return solve_along_start(constraints, free_end, response, start, guess);
  }
  const double share = direction == ConstraintDirection::kMiddle ? 0.5 : 1.0;
  MultiplierSolution solution =
      solve_along_end(constraints, free_end, response, start, share, guess);
  if (!solution.ok && guess.size() > 0) {
    solution = solve_along_end(constraints, free_end, response, start, share, {});
  }
  return solution;
}

Vector solve_for_multipliers(const Matrix& a, const Vector& b) {
  Vector unit = a.diagonal();
  for (double& each : unit) each = each > 0.0 ? 1.0 / std::sqrt(each) : 0.0;
  return solve_redundant(a, b, unit, unit);
}

std::string cannot_be_met(const Constraints& constraints, Index equation) {
  return constraints.name_of_equation(std::max<Index>(0, equation)) +
         " cannot be met: it turns by too much within the step, contradicts other constraints, or "
         "is one of several distances in a plane or on a line that hold each other: let one "
         "constraint of kind \"rigid\" take their place";
}

Vector project_to_constraints(const Constraints& constraints, const Vector& mass, const Vector& q,
                              double time, Vector& momentum) {
  constraints.coordinates().project_momentum(mass, momentum);
  constraints.prescribe_momentum(time, momentum);
  return stop_rates(constraints, mass, q, momentum);
}

void project_impulse(const Constraints& constraints, const Vector& mass, const Vector& q,
                     Vector& impulse) {
  constraints.coordinates().project_momentum(mass, impulse);
  stop_rates(constraints, mass, q, impulse);
}

std::string project_positions(const Constraints& constraints, double time, Vector& q) {
  constraints.prescribe(time, q);
  if (!constraints.has_equations()) return {};
  const Vector w = constraints.configuration(q);
  if (largest(constraints.values(w)) <= kAccepted) return {};
  const MultiplierSolution solution = solve_multipliers(
      constraints, w, constraints.sparse_inverse_mass(), w, ConstraintDirection::kEnd);
  if (!solution.ok) {
    Index worst = solution.worst;
    // The first equation that is violated tells the user more than the one where Newton's method
    // stopped.
    const Vector g = constraints.values(solution.end);
    for (Index i = 0; i < g.size(); ++i) {
      if (std::abs(g[i]) > kAccepted) worst = std::max<Index>(worst, i);
    }
    return constraints.name_of_equation(std::max<Index>(0, worst));
  }
  const FreeCoordinates& free = constraints.coordinates();
  Vector moved = free.restrict(constraints.vertex_forces(solution.forces));
  // S is given by the masses: δy = (TᵀMT)⁻¹ TᵀB u.
  moved = free.extend(moved.cwiseQuotient(constraints.reduced_mass()));
  q += moved;
  constraints.prescribe(time, q);
  return {};
}

}  // namespace tetraction
