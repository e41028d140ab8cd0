#include "mixed_newton.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "line_search.h"
#include "solver/linear/assembled_system.h"
#include "solver_checks.h"
#include "tetraction/dynamics/problems/static_problem.h"
#include "volumetric_pressure.h"

namespace tetraction {
namespace {

Vector positions_at(const MinimizationProblem& problem, const Vector& u) {
  const Positions x = problem.hessian_parts(u).positions;
  return x.displacement() == nullptr ? x.origin() : Vector(x.origin() + *x.displacement());
}

bool is_divisible(const MinimizationProblem& problem) {
  const auto* load_step = dynamic_cast<const StaticProblem*>(&problem);
  return load_step != nullptr && load_step->is_divisible();
}

class MixedNewtonMinimizer : public Minimizer {
 public:
  MixedNewtonMinimizer(const MechanicalSystem& system, const MinimizerOptions& options,
                       std::unique_ptr<Minimizer> inner)
      : options_(options), inner_(std::move(inner)), volume_(system), matrix_(system) {}

  MinimizerReport minimize(const MinimizationProblem& problem, Vector& u) override {
    MinimizerReport mixed;
    const bool is_near = approach(problem, u, mixed);
    if (matrix_.has_factor()) matrix_.release_double_precision();
    if (is_near) {
      u = here_.at.u;
    } else if (is_divisible(problem)) {
      mixed.termination = Termination::kIterationLimit;
      mixed.message = "Newton's method for displacements and pressures makes no progress";
      return mixed;
    }
    MinimizerReport report = inner_->minimize(problem, u);
    report.iterations += mixed.iterations;
    report.factorizations += mixed.factorizations;
    if (report.converged()) {
      here_.at.u = u;
      set_volumes(problem, here_);
      pressure_ = here_.first;
    }
    return report;
  }

  bool solve_linearized(const MinimizationProblem& problem, const Vector& u, const Matrix& right,
                        Matrix& solution) override {
    return inner_->solve_linearized(problem, u, right, solution);
  }

 private:
  // A point of the iteration.
  struct Point {
    Iterate at;
    Vector pressure;
    // Positions, U' and U'' at at.u.
    Vector x;
    Vector first;
    Vector second;
  };

  void set_volumes(const MinimizationProblem& problem, Point& point) const {
    point.x = positions_at(problem, point.at.u);
    volume_.derivatives(point.x, point.first, point.second);
  }

  // Moves here_ from u to where the equations hold. Returns false if it does not get there.
  bool approach(const MinimizationProblem& problem, const Vector& u, MinimizerReport& report) {
    constexpr int kMost = 40;
    constexpr double kShort = 1e-9;  // of the body's size: what is left is for the inner minimiser
    constexpr double kRoundOff = 1e-9;
    here_.at.u = u;
    if (!begin_minimization(problem, options_.tolerance, here_.at, report)) return false;
    set_volumes(problem, here_);
    if (pressure_.size() != here_.first.size()) pressure_.setZero(here_.first.size());
    here_.pressure = pressure_;
    const double highest = here_.at.phi;
    const int most = std::min(kMost, options_.max_iterations);
    while (here_.at.residual > report.residual_limit) {
      if (report.iterations >= most || !find_direction(problem, report)) return false;
      const bool is_short = problem.largest(direction_) <= kShort * problem.length_scale();
      if (!move(problem) && !is_short) return false;
      if (is_short) break;
    }
    return here_.at.phi <= highest + kRoundOff * std::abs(highest);
  }

  bool find_direction(const MinimizationProblem& problem, MinimizerReport& report) {
    ++report.iterations;
    ++report.factorizations;
    if (!matrix_.assemble(problem, here_.at.u)) return false;
    add_curvature(here_.pressure - here_.first);
    if (!matrix_.factorize()) {
      ++report.factorizations;
      add_curvature(-here_.pressure);
      if (!matrix_.factorize()) return false;
    }
    direction_ = solve(problem, here_.at.force);
    return direction_.allFinite();
  }

  void add_curvature(const Vector& pressure) {
    matrix_.add([&](const SparsityPattern& pattern, double* values) {
      volume_.add_curvature(here_.x, pressure, pattern, values);
    });
  }

  Vector solve(const MinimizationProblem& problem, const Vector& force) {
    const FreeCoordinates& free = problem.coordinates();
    return free.extend(matrix_.back_solve(-free.restrict(force)));
  }

  // Moves here_ along direction_. Returns false if no step is good.
  bool move(const MinimizationProblem& problem) {
    constexpr double kShortest = 1.0 / 64;
    const Vector change = here_.first +
                          here_.second.cwiseProduct(volume_.rates(here_.x, direction_)) -
                          here_.pressure;
    const double longest = problem.longest_step(here_.at.u, direction_, false);
    for (double t = longest; t > kShortest * longest; t *= 0.5) {
      next_.at.u = here_.at.u + t * direction_;
      if (!evaluate(problem, next_.at)) continue;
      next_.pressure = here_.pressure + t * change;
      set_volumes(problem, next_);
      const double length = next_correction(problem).norm();
      if (!(length <= (1.0 - 0.25 * t) * direction_.norm())) continue;
      std::swap(here_, next_);
      return true;
    }
    return false;
  }

  // The correction at next_ with the derivatives at here_: what is left of p = U' acts on volumes as they
  // change here.
  Vector next_correction(const MinimizationProblem& problem) {
    const Vector left = next_.first - next_.pressure;
    Vector force = next_.at.force;
    volume_.add_forces(next_.x, -left, force);
    volume_.add_forces(here_.x, left, force);
    return solve(problem, force);
  }

  MinimizerOptions options_;
  std::unique_ptr<Minimizer> inner_;
  VolumetricPressure volume_;
  AssembledSystem matrix_;
  Point here_;
  Point next_;
  Vector direction_;
  Vector pressure_;  // at the last minimiser; empty: none
};

}  // namespace

bool nearly_keeps_volume(const MechanicalSystem& system) {
  constexpr double kRatio = 20.0;  // λ/μ of ν = 0.476
  return system.part() == nullptr && VolumetricPressure::dominates(system, kRatio);
}

std::unique_ptr<Minimizer> make_mixed_newton_minimizer(const MechanicalSystem& system,
                                                       const MinimizerOptions& options,
                                                       std::unique_ptr<Minimizer> inner) {
  return std::make_unique<MixedNewtonMinimizer>(system, options, std::move(inner));
}

}  // namespace tetraction
