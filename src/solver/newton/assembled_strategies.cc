#include "assembled_strategies.h"

#include <algorithm>
#include <utility>

#include "core/pseudo_random.h"

namespace tetraction {
namespace {

using Preconditioner = AssembledSystem::Preconditioner;

constexpr int kMostWithKeptFactor = 30;  // iterations of conjugate gradients with a factor
constexpr double kCurved = 1e-6;

}  // namespace

FactorStrategy::FactorStrategy(const MechanicalSystem& system, bool keep_factor,
                               LinearSolverChoice& choice, MatrixFreeStrategy& matrix_free)
    : system_(system), keep_factor_(keep_factor), choice_(choice), matrix_free_(matrix_free) {}

// Tries a kept factor first. If there is none, or if it is not good enough any more, makes a new
// one.
bool FactorStrategy::find(const NewtonSystem& system, MinimizerReport& report,
                          NewtonDirection& direction) {
  if (!system.problem.has_inertia()) return find_by_elements(system, report, direction);
  if (has_kept() && find_with_kept(system, report, direction)) return true;
  matrix().assemble(system.problem, system.x);
  ++report.factorizations;
  enter_factorization();
  direction.is_definite = matrix().factorize();
  if (!direction.is_definite) {
    NegativeCurvature met;
    if (!find_projected(system, report, direction, met)) return false;
    if (met.found()) direction.curvature = std::move(met);
    direction.is_safe = false;
    return true;
  }
  if (single_precision_suffices_ && has_kept() && find_with_kept(system, report, direction)) {
    matrix().release_double_precision();
    return true;
  }
  // The factor is new but not good enough in single precision. From now on it is used in double.
  if (keep_factor_) single_precision_suffices_ = false;
  direction.is_safe = false;
  const FreeCoordinates& free = system_.coordinates();
  direction.d = free.extend(matrix().back_solve(-free.restrict(system.gradient)));
  return true;
}

bool FactorStrategy::find_exactly(const NewtonSystem& system, MinimizerReport& report,
                                  NewtonDirection& direction) {
  const auto find_with = [&](double forcing) {
    return find({system.problem, system.x, system.gradient, forcing}, report, direction);
  };
  is_stale_ = true;
  if (!system.problem.has_inertia()) return find_with(0.0);
  if (!matrix().assemble(system.problem, system.x)) return false;
  if (!matrix().factorize()) return find_with(0.1);
  ++report.factorizations;
  is_stale_ = false;
  direction.is_definite = true;
  const FreeCoordinates& free = system_.coordinates();
  direction.d = free.extend(matrix().back_solve(-free.restrict(system.gradient)));
  return true;
}

// Conjugate gradients on the system at hand, preconditioned by the factor of an older one.
bool FactorStrategy::find_with_kept(const NewtonSystem& system, MinimizerReport& report,
                                    NewtonDirection& direction) {
  constexpr int kFree = 3;
  CgReport cg;
  if (choice_.supports_matrix_free() && single_precision_suffices_) {
    MatrixFreeCg<float>& free = matrix_free_.single_precision(system);
    cg = free.solve(system.gradient, system.forcing, kMostWithKeptFactor,
                    matrix().single_precision_factor(), direction.d);
    direction.is_safe = free.step_is_safe();
  } else {
    matrix().assemble(system.problem, system.x);
    if (!has_kept()) return false;  // contact couples other vertices, which changes the pattern
    Vector solution;
    cg = matrix().solve(-system_.coordinates().restrict(system.gradient),
                        single_precision_suffices_ ? Preconditioner::kSinglePrecisionFactor
                                                   : Preconditioner::kFactor,
                        system.forcing, kMostWithKeptFactor, solution);
    direction.d = system_.coordinates().extend(solution);
  }
  report.cg_iterations += cg.iterations;
  const LinearSolverCosts costs(static_cast<double>(system_.rest().point_count()), matrix().cost());
  choice_.add_excess_work(std::max(0, cg.iterations - kFree) * (costs.product + costs.back_solve));
  if (choice_.excess_work() > costs.factorization) is_stale_ = true;
  return cg.converged;
}

// The direction of an equilibrium. A kept factor is used as long as it is a good preconditioner.
bool FactorStrategy::find_by_elements(const NewtonSystem& system, MinimizerReport& report,
                                      NewtonDirection& direction) {
  constexpr double kLoosest = 1e-3;
  constexpr double kTightest = 1e-8;
  constexpr int kWithNew = 300;
  matrix().set_elements(system.problem, system.x);
  const Vector right = -system_.coordinates().restrict(system.gradient);
  const double enough = std::clamp(system.forcing, kTightest, kLoosest);
  const auto solve = [&](int most) {
    Vector solution;
    const CgReport cg = matrix().solve_by_elements(right, enough, most, solution);
    report.cg_iterations += cg.iterations;
    direction.d = system_.coordinates().extend(solution);
    return cg;
  };
  if (has_kept() && solve(kMostWithKeptFactor).converged) return true;
  if (!matrix().assemble(system.problem, system.x)) return false;
  ++report.factorizations;
  enter_factorization();
  direction.is_definite = matrix().factorize();
  bool useful = direction.is_definite;
  if (!useful) {
    ++report.factorizations;
    useful = matrix().factorize_shifted();
  }
  if (useful && !solve(kWithNew).negative_curvature) return true;
  if (useful) direction.curvature = matrix().negative_curvature();
  direction.is_definite = false;
  is_stale_ = true;
  NegativeCurvature met;
  if (!find_projected(system, report, direction, met)) return false;
  if (direction.curvature.found() || !met.found()) return true;
  met.curvature = matrix().curvature(met.direction);
  if (met.curvature < 0.0) direction.curvature = std::move(met);  // and not by round-off only
  return true;
}

// Finds a direction with the factor of the projected matrix, and the negative curvature that conjugate gradients
// on the matrix itself meet with that factor.
bool FactorStrategy::find_projected(const NewtonSystem& system, MinimizerReport& report,
                                    NewtonDirection& direction, NegativeCurvature& met) {
  ++report.factorizations;
  if (!matrix().factorize_projected(system.problem, system.x)) return false;
  const Vector right = -system_.coordinates().restrict(system.gradient);
  Vector ignored;
  const CgReport cg =
      matrix().solve(right, Preconditioner::kFactor, kCurved, kMostWithKeptFactor, ignored);
  report.cg_iterations += cg.iterations;
  if (cg.negative_curvature) met = matrix().negative_curvature();
  direction.d = system_.coordinates().extend(matrix().back_solve(right));
  return true;
}

NegativeCurvature FactorStrategy::find_negative_curvature(const MinimizationProblem& problem,
                                                          const Vector& x,
                                                          MinimizerReport& report) {
  enter_factorization();
  return problem.has_inertia() ? matrix().find_negative_curvature(problem, x, report.factorizations)
                               : probe_by_elements(problem, x, report);
}

// Round-off may make the matrix of a slender body indefinite that is definite, so that the products that
// keep their digits decide.
NegativeCurvature FactorStrategy::probe_by_elements(const MinimizationProblem& problem,
                                                    const Vector& x, MinimizerReport& report) {
  constexpr double kCertain = 1e-6;
  constexpr int kProbing = 500;
  ++report.factorizations;
  if (!matrix().assemble(problem, x) || matrix().factorize()) return {};
  matrix().set_elements(problem, x);
  ++report.factorizations;
  if (!matrix().factorize_shifted()) {
    is_stale_ = true;
    return matrix().find_negative_curvature(problem, x, report.factorizations);
  }
  Vector ignored;
  const CgReport cg =
      matrix().solve_by_elements(pseudo_random(matrix().size()), kCertain, kProbing, ignored);
  report.cg_iterations += cg.iterations;
  return cg.negative_curvature ? matrix().negative_curvature() : NegativeCurvature();
}

bool FactorStrategy::solve_exactly(const MinimizationProblem& problem, const Vector& x,
                                   const Matrix& right, Matrix& solution) {
  constexpr double kExact = 1e-12;
  constexpr int kIterations = 200;
  matrix().assemble(problem, x);
  const bool is_static = !problem.has_inertia();
  if (!matrix().factorize() && !(is_static && matrix().factorize_shifted())) return false;
  enter_factorization();
  solution.resize(right.rows(), right.cols());
  if (is_static) {
    matrix().set_elements(problem, x);
    Vector column;
    for (Index i = 0; i < right.cols(); ++i) {
      if (matrix()
              .solve_by_elements(right.col(i), kExact, kIterations, column)
              .negative_curvature) {
        return false;
      }
      solution.col(i) = column;
    }
    return true;
  }
  for (Index i = 0; i < right.cols(); ++i) solution.col(i) = matrix().back_solve(right.col(i));
  return true;
}

// A new factor: what other ones would have saved does not count any more.
void FactorStrategy::enter_factorization() {
  is_stale_ = false;
  choice_.clear_excess_work();
}

AssembledSystem& FactorStrategy::matrix() {
  if (!matrix_) matrix_ = std::make_unique<AssembledSystem>(system_);
  return *matrix_;
}

bool DiagonalStrategy::find(const NewtonSystem& system, MinimizerReport& report,
                            NewtonDirection& direction) {
  AssembledSystem& matrix = factor_.matrix();
  matrix.assemble(system.problem, system.x);
  const Vector right = -system_.coordinates().restrict(system.gradient);
  const double tolerance = choice_.refined_forcing(system.forcing);
  // Round-off delays the iterations of an ill-conditioned matrix.
  const int most = static_cast<int>((choice_.is_refined() ? 20 : 2) * right.size()) + 100;
  Vector solution;
  const auto solve = [&] {
    const CgReport done = matrix.solve(right, Preconditioner::kDiagonal, tolerance, most, solution);
    report.cg_iterations += done.iterations;
    return done.negative_curvature;
  };
  if (solve()) {
    direction.curvature = matrix.negative_curvature();
    matrix.assemble_projected(system.problem, system.x);
    solve();
  }
  direction.d = system_.coordinates().extend(solution);
  return true;
}

NegativeCurvature DiagonalStrategy::find_negative_curvature(const MinimizationProblem& problem,
                                                            const Vector& x,
                                                            MinimizerReport& report) {
  AssembledSystem& matrix = factor_.matrix();
  if (!matrix.assemble(problem, x)) return {};
  const Index count = system_.coordinates().count();
  Vector ignored;
  const CgReport cg =
      matrix.solve(pseudo_random(count), Preconditioner::kDiagonal, probing_forcing(count),
                   static_cast<int>(2 * count) + 100, ignored);
  report.cg_iterations += cg.iterations;
  return cg.negative_curvature ? matrix.negative_curvature() : NegativeCurvature();
}

}  // namespace tetraction
