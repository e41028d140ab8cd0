#include "matrix_free_strategy.h"

#include <algorithm>
#include <type_traits>

#include "core/pseudo_random.h"

namespace tetraction {

bool MatrixFreeStrategy::find(const NewtonSystem& system, MinimizerReport& report,
                              NewtonDirection& direction) {
  const int most = choice_.iteration_limit();
  const auto solve_in = [&](auto& cg) {
    const CgReport done = solve(cg, system, most, direction);
    direction.is_safe = cg.step_is_safe();
    report.cg_iterations += done.iterations;
    choice_.add_solve(done);
    return !done.converged && !done.negative_curvature;
  };
  const bool is_single = single_precision_suffices_ && !choice_.is_refined();
  bool failed = is_single ? solve_in(single_precision()) : solve_in(double_precision());
  if (is_single && failed && !choice_.counts_costs()) {
    // The round-off of single precision is too large. From now on the solver uses double precision.
    single_precision_suffices_ = false;
    single_.reset();
    leave_matrix();
    failed = solve_in(double_precision());
  }
  if (system.begins_iteration) {
    choice_.end_iteration(direction.curvature.found(), system.problem.has_inertia());
  }
  return !failed || !choice_.is_automatic();
}

template <class Cg>
CgReport MatrixFreeStrategy::solve(Cg& cg, const NewtonSystem& system, int most,
                                   NewtonDirection& direction) {
  linearize(cg, system);
  CgReport exact = cg.solve(system.gradient, system.forcing, most, direction.d);
  if (!exact.negative_curvature) return exact;
  direction.curvature = cg.negative_curvature();
  if (std::is_same_v<Cg, MatrixFreeCg<float>> &&
      !is_true(system.problem, system.x, direction.curvature)) {
    exact.negative_curvature = false;  // round-off, so that single precision has failed
    direction.curvature = {};
    return exact;
  }
  cg.convexify();
  leave_matrix();
  CgReport convex = cg.solve(system.gradient, system.forcing, most, direction.d);
  convex.iterations += exact.iterations;
  convex.coarse_spaces += exact.coarse_spaces;
  return convex;
}

// Whether a direction that was found in single precision has negative curvature in double
// precision, too.
bool MatrixFreeStrategy::is_true(const MinimizationProblem& problem, const Vector& x,
                                 NegativeCurvature& curvature) {
  leave_matrix();
  double_precision().set(problem, x);
  curvature.curvature = double_precision().curvature(curvature.direction);
  return curvature.curvature < 0.0;
}

NegativeCurvature MatrixFreeStrategy::find_negative_curvature(const MinimizationProblem& problem,
                                                              const Vector& x,
                                                              MinimizerReport& report) {
  const double forcing = probing_forcing(choice_.unknowns());
  const int most = std::max(2000, static_cast<int>(choice_.unknowns()));
  const Vector& right = probing_vector(x.size());
  NegativeCurvature curvature;
  leave_matrix();
  const auto probe = [&](auto& cg) {
    cg.set(problem, x);
    const CgReport done = cg.solve(right, forcing, most, ignored_);
    report.cg_iterations += done.iterations;
    if (done.negative_curvature) curvature = cg.negative_curvature();
    return done;
  };
  if (single_precision_suffices_) {
    const CgReport done = probe(single_precision());
    if (done.converged) return {};
    if (done.negative_curvature && is_true(problem, x, curvature)) return curvature;
    curvature = {};
  }
  probe(double_precision());
  return curvature;
}

const Vector& MatrixFreeStrategy::probing_vector(Index size) {
  if (probing_vector_.size() != size) {
    probing_vector_ = pseudo_random(size);
    copy_from_owners(system_.part(), probing_vector_, 3);
  }
  return probing_vector_;
}

void MatrixFreeStrategy::forget() {
  if (single_) single_->forget();
  if (double_) double_->forget();
}

MatrixFreeCg<float>& MatrixFreeStrategy::single_precision() {
  if (!single_) single_ = std::make_unique<MatrixFreeCg<float>>(system_);
  return *single_;
}

MatrixFreeCg<double>& MatrixFreeStrategy::double_precision() {
  if (!double_) double_ = std::make_unique<MatrixFreeCg<double>>(system_);
  return *double_;
}

}  // namespace tetraction
