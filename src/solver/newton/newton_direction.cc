#include "newton_direction.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include "core/pseudo_random.h"
#include "tetraction/core/error.h"
#include "tetraction/dynamics/whole_body.h"

namespace tetraction {

// Prices of the linear solvers in nanoseconds on one core (docs/performance.md has the
// measurements). Only their ratios matter, and only for kAuto and for the time at which a factor is
// renewed: results do not depend on how fast the machine happens to be.
struct NewtonDirection::Prices {
  double product;   // an iteration of matrix-free CG
  double newton;    // an iteration of Newton's method without the linear solve
  double assembly;  // of the matrix
  double factorization;
  double back_solve;  // in single precision

  Prices(double tetrahedra, const CholeskyCost& cost) {
    constexpr double kInCache = 1e5;  // tetrahedra whose states the last-level cache holds
    product = (tetrahedra > kInCache ? 9.0 : 7.0) * tetrahedra;
    newton = 50.0 * tetrahedra;
    assembly = 100.0 * tetrahedra;
    factorization = cost.flops / 30.0;
    back_solve = (cost.nonzeros > 1e7 ? 0.4 : 0.2) * cost.nonzeros;
  }
};

namespace {

constexpr int kPatience = 8;  // iterations of a step that met negative curvature or gained little
constexpr int kVisits = 3;    // steps with a factor for their sake, until it stays
constexpr int kMost = 30;     // iterations of conjugate gradients with a factor, …
constexpr int kMostWithMultigrid = 2000;  // … and with multigrid in several processes
constexpr double kCurved = 1e-6;
constexpr double kRefined = 1e-8;  // tolerance of refined directions by conjugate gradients
// A random vector is assumed to have a component of at least this part of its expected size.
constexpr double kAcross = 0.01;

// The cost of a factorisation with nested dissection as a function of the number of unknowns. It
// was fitted to blocks and beams of 10³ to 10⁵ unknowns. It is correct to a factor of two, which is
// enough to decide whether to analyse the pattern.
CholeskyCost expected_cost(double unknowns) {
  return {12.0 * unknowns * unknowns, 18.0 * std::pow(unknowns, 4.0 / 3.0)};
}

LinearSolver first_choice(bool can_do_without_matrix, LinearSolver asked) {
  if (asked == LinearSolver::kAuto) {
    return can_do_without_matrix ? LinearSolver::kMatrixFree : LinearSolver::kFactor;
  }
  if (asked == LinearSolver::kMatrixFree && !can_do_without_matrix) {
    throw InputError(
        "solver.linear = \"matrix-free\" knows neither materials of a program's own nor free rigid "
        "handles: take \"auto\", \"cg\" or \"factor\".");
  }
  return asked;
}

}  // namespace

NewtonDirection::NewtonDirection(const MechanicalSystem& system, const NewtonOptions& options)
    : system_(system),
      options_(options),
      can_do_without_matrix_(MatrixFreeCg<float>::supports(system)),
      current_(first_choice(can_do_without_matrix_, options.linear)),
      unknowns_(whole_freedom_count(system)) {
  if (system.part() != nullptr) prepare_parts();
}

void NewtonDirection::prepare_parts() {
  if (!can_do_without_matrix_) {
    throw InputError(
        "Implicit steps in several processes need a built-in material: take integrator = "
        "\"verlet\" or \"explicit\", or run the scene in one process.");
  }
  if (dynamic_cast<const PreconditionerSource*>(system_.part()) != nullptr) return;
  if (options_.linear == LinearSolver::kAuto) options_.linear = LinearSolver::kMatrixFree;
  if (options_.linear == LinearSolver::kMatrixFree) return;
  throw InputError(
      "This engine has no matrix of a body in several processes: take solver.linear = \"auto\" "
      "or \"matrix-free\".");
}

void NewtonDirection::begin_step(const MinimizationProblem& problem, const Vector& x) {
  cost_of_step_ = 0.0;
  refined_ = false;
  slow_ = 0;
  last_residual_ = std::numeric_limits<double>::infinity();
  if (for_this_step_) current_ = LinearSolver::kMatrixFree;
  for_this_step_ = false;
  // A factor or coarse space for another step size belongs to a very different matrix.
  const Vector& diagonal = problem.hessian_parts(x).diagonal;
  const double sum =
      sum_over_parts(system_.part(), diagonal.head(3 * system_.owned_vertex_count()).sum());
  if (std::abs(sum - coefficient_sum_) > 0.01 * std::abs(sum)) {
    stale_ = true;
    if (single_) single_->forget();
    if (double_) double_->forget();
    if (preconditioned_) preconditioned_->forget();
    coefficient_sum_ = sum;
  }
}

bool NewtonDirection::find(const MinimizationProblem& problem, const Vector& x,
                           const Vector& gradient, double forcing, MinimizerReport& report,
                           Vector& direction) {
  safe_ = false;
  definite_ = false;
  curvature_ = {};
  // If Newton's method makes slow progress with approximate directions, this step uses exact ones.
  // If that happens several times, all later steps use them.
  if (report.residual > 0.5 * last_residual_) ++slow_;
  last_residual_ = report.residual;
  if (options_.linear == LinearSolver::kAuto && current_ == LinearSolver::kMatrixFree &&
      slow_ > kPatience) {
    current_ = LinearSolver::kFactor;
    stale_ = true;
    for_this_step_ = ++visits_ < kVisits;
  }
  bool found = false;
  const bool takes_factor =
      options_.linear != LinearSolver::kMatrixFree && options_.linear != LinearSolver::kCg;
  const bool is_exact = refined_ && takes_factor && !prefers_double_cg();
  if (system_.part() != nullptr && (is_exact || current_ != LinearSolver::kMatrixFree)) {
    found = with_preconditioner(problem, x, gradient, forcing, report, direction);
  } else if (is_exact) {
    found = with_exact_factor(problem, x, gradient, report, direction);
  } else if (current_ == LinearSolver::kMatrixFree) {
    found = without_matrix(problem, x, gradient, forcing, report, direction);
  } else if (current_ == LinearSolver::kCg) {
    found = with_diagonal(problem, x, gradient, forcing, report, direction);
  } else {
    found = with_factor(problem, x, gradient, forcing, report, direction);
  }
  return everywhere(system_.part(), found && direction.allFinite());
}

// Whether kAuto weighs the costs of the methods. The prices are those of one process: MUMPS's factor in several
// is often slower than many iterations without a matrix, and its bits differ from run to run.
bool NewtonDirection::counts_costs() const {
  return options_.linear == LinearSolver::kAuto && system_.part() == nullptr;
}

// Whether directions in double precision are cheaper by conjugate gradients than by a factor.
bool NewtonDirection::prefers_double_cg() const {
  constexpr double kIterations = 1000.0;  // of conjugate gradients, more than a direction needs
  if (current_ != LinearSolver::kMatrixFree) return false;
  const Prices p = rough_prices();
  return p.factorization > kIterations * p.product;
}

bool NewtonDirection::refine() {
  if (refined_) return false;
  refined_ = true;
  return true;
}

bool NewtonDirection::without_matrix(const MinimizationProblem& problem, const Vector& x,
                                     const Vector& gradient, double forcing,
                                     MinimizerReport& report, Vector& direction) {
  const Prices p = rough_prices();
  // With kAuto the iterations may not cost more, in this step and before, than a factor would have.
  int most = std::max(2000, static_cast<int>(unknowns_));
  if (counts_costs()) {
    const double worth = p.assembly + p.factorization + 4.0 * p.back_solve;
    most = std::max(50, static_cast<int>((worth - regret_ - cost_of_step_) / p.product));
  }
  const auto solve_in = [&](auto& cg) {
    const CgReport done = solve_without_matrix(cg, problem, x, gradient, forcing, most, direction);
    safe_ = cg.step_is_safe();
    report.cg_iterations += done.iterations;
    cost_of_step_ += p.product * (done.iterations + CoarseChoice::kPrice * done.coarse_spaces);
    return done;
  };
  CgReport cg = single_precision_ && !refined_ ? solve_in(single_precision_cg())
                                               : solve_in(double_precision_cg());
  const auto failed = [&] { return !cg.converged && !cg.negative_curvature; };
  if (single_precision_ && !refined_ && failed() && !counts_costs()) {
    // The round-off of single precision is too large. From now on the solver uses double precision.
    single_precision_ = false;
    single_.reset();
    cg = solve_in(double_precision_cg());
  }
  cost_of_step_ += p.newton;
  // Without inertia the lowest mode shows the way from a saddle, and a factor finds it.
  if (curvature_.found()) slow_ += problem.has_inertia() ? 1 : kPatience + 1;
  if (failed() && options_.linear == LinearSolver::kAuto) {
    current_ = LinearSolver::kFactor;
    regret_ = 0.0;
    return system_.part() != nullptr
               ? with_preconditioner(problem, x, gradient, forcing, report, direction)
               : with_factor(problem, x, gradient, forcing, report, direction);
  }
  return true;
}

// The way of a body in parts.
bool NewtonDirection::with_preconditioner(const MinimizationProblem& problem, const Vector& x,
                                          const Vector& gradient, double forcing,
                                          MinimizerReport& report, Vector& direction) {
  using Kind = BodyPreconditioner::Kind;
  if (!preconditioned_) {
    const auto& source = dynamic_cast<const PreconditionerSource&>(*system_.part());
    const bool has_factor = options_.linear != LinearSolver::kCg;
    preconditioned_ = std::make_unique<PreconditionedDirection>(
        system_, source.make_preconditioner(system_, has_factor ? Kind::kFactor : Kind::kMultigrid),
        has_factor ? kMost : kMostWithMultigrid);
  }
  preconditioned_->find(problem, x, gradient, refined_ ? std::min(forcing, kRefined) : forcing,
                        report, direction);
  curvature_ = preconditioned_->negative_curvature();
  safe_ = preconditioned_->step_is_safe();
  return true;
}

// If the matrix is not positive definite, finds the Newton direction of a modified matrix that
// nearly is.
template <class Cg>
CgReport NewtonDirection::solve_without_matrix(Cg& cg, const MinimizationProblem& problem,
                                               const Vector& x, const Vector& gradient,
                                               double forcing, int most, Vector& direction) {
  cg.set(problem, x);
  CgReport exact = cg.solve(gradient, forcing, most, direction);
  if (!exact.negative_curvature) return exact;
  curvature_ = cg.negative_curvature();
  if (std::is_same_v<Cg, MatrixFreeCg<float>> && !is_true_curvature(problem, x)) {
    exact.negative_curvature = false;  // round-off, so that single precision has failed
    curvature_ = {};
    return exact;
  }
  cg.convexify();
  CgReport convex = cg.solve(gradient, forcing, most, direction);
  convex.iterations += exact.iterations;
  convex.coarse_spaces += exact.coarse_spaces;
  return convex;
}

// Whether a direction that was found in single precision has negative curvature in double
// precision, too.
bool NewtonDirection::is_true_curvature(const MinimizationProblem& problem, const Vector& x) {
  double_precision_cg().set(problem, x);
  curvature_.curvature = double_precision_cg().curvature(curvature_.direction);
  return curvature_.curvature < 0.0;
}

bool NewtonDirection::find_negative_curvature(const MinimizationProblem& problem, const Vector& x,
                                              MinimizerReport& report) {
  curvature_ = {};
  return current_ == LinearSolver::kMatrixFree || system_.part() != nullptr
             ? probe_without_matrix(problem, x, report)
             : probe_matrix(problem, x, report);
}

bool NewtonDirection::probe_without_matrix(const MinimizationProblem& problem, const Vector& x,
                                           MinimizerReport& report) {
  const double enough = kAcross / std::sqrt(static_cast<double>(unknowns_));
  const int most = std::max(2000, static_cast<int>(unknowns_));
  if (right_.size() != x.size()) {
    right_ = pseudo_random(x.size());
    copy_from_owners(system_.part(), right_, 3);
  }
  if (preconditioned_ && current_ != LinearSolver::kMatrixFree &&
      preconditioned_->probe(problem, x, right_, enough, report)) {
    curvature_ = preconditioned_->negative_curvature();
    return curvature_.found();
  }
  const auto probe = [&](auto& cg) {
    cg.set(problem, x);
    const CgReport done = cg.solve(right_, enough, most, ignored_);
    report.cg_iterations += done.iterations;
    if (done.negative_curvature) curvature_ = cg.negative_curvature();
    return done;
  };
  if (single_precision_) {
    const CgReport done = probe(single_precision_cg());
    if (done.converged) return false;
    if (done.negative_curvature && is_true_curvature(problem, x)) return true;
    curvature_ = {};
  }
  probe(double_precision_cg());
  return curvature_.found();
}

bool NewtonDirection::probe_matrix(const MinimizationProblem& problem, const Vector& x,
                                   MinimizerReport& report) {
  AssembledSystem& matrix = assembled();
  if (current_ == LinearSolver::kFactor) {
    stale_ = false;
    regret_ = 0.0;
    if (!problem.has_inertia()) return probe_by_elements(problem, x, report);
    curvature_ = matrix.find_negative_curvature(problem, x, report.factorizations);
    return curvature_.found();
  }
  if (!matrix.assemble(problem, x)) return false;
  const Index count = system_.coordinates().count();
  Vector ignored;
  const CgReport cg = matrix.solve(pseudo_random(count), AssembledSystem::Preconditioner::kDiagonal,
                                   kAcross / std::sqrt(static_cast<double>(count)),
                                   static_cast<int>(2 * count) + 100, ignored);
  report.cg_iterations += cg.iterations;
  if (cg.negative_curvature) curvature_ = matrix.negative_curvature();
  return curvature_.found();
}

// Round-off may make the matrix of a slender body indefinite that is definite, so that the products that
// keep their digits decide.
bool NewtonDirection::probe_by_elements(const MinimizationProblem& problem, const Vector& x,
                                        MinimizerReport& report) {
  constexpr double kCertain = 1e-6;
  constexpr int kProbing = 500;
  AssembledSystem& matrix = assembled();
  ++report.factorizations;
  if (!matrix.assemble(problem, x) || matrix.factorize()) return false;
  matrix.set_elements(problem, x);
  ++report.factorizations;
  if (matrix.factorize_shifted()) {
    Vector ignored;
    const CgReport cg =
        matrix.solve_by_elements(pseudo_random(matrix.size()), kCertain, kProbing, ignored);
    report.cg_iterations += cg.iterations;
    if (cg.negative_curvature) curvature_ = matrix.negative_curvature();
    return curvature_.found();
  }
  stale_ = true;
  curvature_ = matrix.find_negative_curvature(problem, x, report.factorizations);
  return curvature_.found();
}

bool NewtonDirection::with_diagonal(const MinimizationProblem& problem, const Vector& x,
                                    const Vector& gradient, double forcing, MinimizerReport& report,
                                    Vector& direction) {
  AssembledSystem& matrix = assembled();
  matrix.assemble(problem, x);
  const Vector right = -system_.coordinates().restrict(gradient);
  const double tolerance = refined_ ? std::min(forcing, kRefined) : forcing;
  // Round-off delays the iterations of an ill-conditioned matrix.
  const int most = static_cast<int>((refined_ ? 20 : 2) * right.size()) + 100;
  Vector solution;
  const auto solve = [&] {
    const CgReport done =
        matrix.solve(right, AssembledSystem::Preconditioner::kDiagonal, tolerance, most, solution);
    report.cg_iterations += done.iterations;
    return done.negative_curvature;
  };
  if (solve()) {
    curvature_ = matrix.negative_curvature();
    matrix.assemble_projected(problem, x);
    solve();
  }
  direction = system_.coordinates().extend(solution);
  return true;
}

// Tries a kept factor first. If there is none, or if it is not good enough any more, makes a new
// one.
bool NewtonDirection::with_factor(const MinimizationProblem& problem, const Vector& x,
                                  const Vector& gradient, double forcing, MinimizerReport& report,
                                  Vector& direction) {
  if (!problem.has_inertia()) {
    return by_elements(problem, x, gradient, forcing, report, direction);
  }
  AssembledSystem& matrix = assembled();
  const auto try_kept = [&] {
    return options_.keep_factor && matrix.has_factor() && !stale_ &&
           with_kept_factor(problem, x, gradient, forcing, report, direction);
  };
  if (try_kept()) return true;
  matrix.assemble(problem, x);
  ++report.factorizations;
  stale_ = false;
  regret_ = 0.0;
  definite_ = matrix.factorize();
  if (!definite_) {
    ++report.factorizations;
    if (!matrix.factorize_projected(problem, x)) return false;
    Vector solution;
    const CgReport cg =
        matrix.solve(-system_.coordinates().restrict(gradient),
                     AssembledSystem::Preconditioner::kFactor, kCurved, kMost, solution);
    report.cg_iterations += cg.iterations;
    if (cg.negative_curvature) curvature_ = matrix.negative_curvature();
  } else if (single_precision_factor_ && try_kept()) {
    matrix.release_double_precision();
    return true;
  } else if (options_.keep_factor) {
    // The factor is new but not good enough in single precision. From now on it is used in double.
    single_precision_factor_ = false;
  }
  safe_ = false;
  direction =
      system_.coordinates().extend(matrix.back_solve(-system_.coordinates().restrict(gradient)));
  return true;
}

bool NewtonDirection::with_exact_factor(const MinimizationProblem& problem, const Vector& x,
                                        const Vector& gradient, MinimizerReport& report,
                                        Vector& direction) {
  AssembledSystem& matrix = assembled();
  stale_ = true;
  if (!problem.has_inertia()) return by_elements(problem, x, gradient, 0.0, report, direction);
  if (!matrix.assemble(problem, x)) return false;
  if (!matrix.factorize()) return with_factor(problem, x, gradient, 0.1, report, direction);
  ++report.factorizations;
  stale_ = false;
  definite_ = true;
  direction =
      system_.coordinates().extend(matrix.back_solve(-system_.coordinates().restrict(gradient)));
  return true;
}

// The direction of an equilibrium. A kept factor is used as long as it is a good preconditioner.
bool NewtonDirection::by_elements(const MinimizationProblem& problem, const Vector& x,
                                  const Vector& gradient, double forcing, MinimizerReport& report,
                                  Vector& direction) {
  constexpr double kLoosest = 1e-3;
  constexpr double kTightest = 1e-8;
  constexpr int kWithNew = 300;
  AssembledSystem& matrix = assembled();
  matrix.set_elements(problem, x);
  const Vector right = -system_.coordinates().restrict(gradient);
  const double enough = std::clamp(forcing, kTightest, kLoosest);
  Vector solution;
  const auto solve = [&](int most) {
    const CgReport cg = matrix.solve_by_elements(right, enough, most, solution);
    report.cg_iterations += cg.iterations;
    direction = system_.coordinates().extend(solution);
    return cg;
  };
  if (options_.keep_factor && matrix.has_factor() && !stale_ && solve(kMost).converged) return true;
  if (!matrix.assemble(problem, x)) return false;
  ++report.factorizations;
  stale_ = false;
  regret_ = 0.0;
  definite_ = matrix.factorize();
  bool useful = definite_;
  if (!useful) {
    ++report.factorizations;
    useful = matrix.factorize_shifted();
  }
  if (useful && !solve(kWithNew).negative_curvature) return true;
  if (useful) curvature_ = matrix.negative_curvature();
  definite_ = false;
  stale_ = true;
  ++report.factorizations;
  if (!matrix.factorize_projected(problem, x)) return false;
  const CgReport cg =
      matrix.solve(right, AssembledSystem::Preconditioner::kFactor, kCurved, kMost, solution);
  report.cg_iterations += cg.iterations;
  if (!curvature_.found() && cg.negative_curvature) take_true_curvature();
  direction = system_.coordinates().extend(matrix.back_solve(right));
  return true;
}

// Takes the direction of negative curvature that the matrix has found, if it is none of round-off.
void NewtonDirection::take_true_curvature() {
  curvature_ = assembled().negative_curvature();
  curvature_.curvature = assembled().curvature(curvature_.direction);
  if (!(curvature_.curvature < 0.0)) curvature_ = {};
}

// Conjugate gradients on the system at hand, preconditioned by the factor of an older one.
bool NewtonDirection::with_kept_factor(const MinimizationProblem& problem, const Vector& x,
                                       const Vector& gradient, double forcing,
                                       MinimizerReport& report, Vector& direction) {
  constexpr int kFree = 3;
  AssembledSystem& matrix = assembled();
  CgReport cg;
  if (can_do_without_matrix_ && single_precision_factor_) {
    MatrixFreeCg<float>& free = single_precision_cg();
    free.set(problem, x);
    cg = free.solve(gradient, forcing, kMost, matrix.single_precision_factor(), direction);
    safe_ = free.step_is_safe();
  } else {
    using Preconditioner = AssembledSystem::Preconditioner;
    matrix.assemble(problem, x);
    Vector solution;
    cg = matrix.solve(
        -system_.coordinates().restrict(gradient),
        single_precision_factor_ ? Preconditioner::kSinglePrecisionFactor : Preconditioner::kFactor,
        forcing, kMost, solution);
    direction = system_.coordinates().extend(solution);
  }
  report.cg_iterations += cg.iterations;
  const Prices p(static_cast<double>(system_.rest().point_count()), matrix.cost());
  regret_ += std::max(0, cg.iterations - kFree) * (p.product + p.back_solve);
  if (regret_ > p.factorization) stale_ = true;
  return cg.converged;
}

// The rule of kAuto. The matrix-free method is used until its additional cost, compared with a
// factor that lasts for twenty steps, would have paid for the factor.
void NewtonDirection::end_step(int newton_iterations) {
  constexpr double kLife = 20.0;
  if (!counts_costs() || current_ != LinearSolver::kMatrixFree) return;
  const Prices p = rough_prices();
  const double factor = newton_iterations * (p.newton + 3.0 * (p.product + p.back_solve)) +
                        (p.assembly + p.factorization) / kLife;
  regret_ = std::max(0.0, regret_ + cost_of_step_ - factor);
  if (regret_ > p.factorization) {
    current_ = LinearSolver::kFactor;
    regret_ = 0.0;
  }
}

void NewtonDirection::leave_factor() {
  if (options_.linear != LinearSolver::kAuto || !can_do_without_matrix_) return;
  options_.linear = current_ = LinearSolver::kMatrixFree;
}

std::string NewtonDirection::name() const {
  if (current_ == LinearSolver::kMatrixFree) return "matrix-free";
  if (preconditioned_) return preconditioned_->name();
  return current_ == LinearSolver::kCg ? "cg" : "factor";
}

bool NewtonDirection::solve_exactly(const MinimizationProblem& problem, const Vector& x,
                                    const Matrix& right, Matrix& solution) {
  constexpr double kExact = 1e-12;
  constexpr int kIterations = 200;
  AssembledSystem& matrix = assembled();
  matrix.assemble(problem, x);
  const bool is_static = !problem.has_inertia();
  if (!matrix.factorize() && !(is_static && matrix.factorize_shifted())) return false;
  stale_ = false;
  regret_ = 0.0;
  solution.resize(right.rows(), right.cols());
  if (is_static) {
    matrix.set_elements(problem, x);
    Vector column;
    for (Index i = 0; i < right.cols(); ++i) {
      if (matrix.solve_by_elements(right.col(i), kExact, kIterations, column).negative_curvature) {
        return false;
      }
      solution.col(i) = column;
    }
    return true;
  }
  for (Index i = 0; i < right.cols(); ++i) solution.col(i) = matrix.back_solve(right.col(i));
  return true;
}

AssembledSystem& NewtonDirection::assembled() {
  if (!assembled_) assembled_ = std::make_unique<AssembledSystem>(system_);
  return *assembled_;
}

MatrixFreeCg<float>& NewtonDirection::single_precision_cg() {
  if (!single_) single_ = std::make_unique<MatrixFreeCg<float>>(system_);
  return *single_;
}

MatrixFreeCg<double>& NewtonDirection::double_precision_cg() {
  if (!double_) double_ = std::make_unique<MatrixFreeCg<double>>(system_);
  return *double_;
}

NewtonDirection::Prices NewtonDirection::rough_prices() const {
  // Several processes share all of this work.
  const Index points =
      system_.part() == nullptr ? system_.rest().point_count() : whole_tetrahedron_count(system_);
  return {static_cast<double>(points), expected_cost(static_cast<double>(unknowns_))};
}

}  // namespace tetraction
