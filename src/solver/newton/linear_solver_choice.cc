#include "linear_solver_choice.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "solver/linear/body_preconditioner.h"
#include "solver/linear/matrix_free_cg.h"
#include "tetraction/core/error.h"
#include "tetraction/dynamics/body_sums.h"

namespace tetraction {
namespace {

constexpr int kSlowIterations = 8;  // of a step, after which it takes a factor
constexpr int kSlowSteps = 3;       // with a factor for their sake, until it stays

// The cost of a factorisation with nested dissection as a function of the number of unknowns. It
// was fitted to blocks and beams of 10³ to 10⁵ unknowns. It is correct to a factor of two, which is
// enough to decide whether to analyse the pattern.
CholeskyCost expected_cost(double unknowns) {
  return {12.0 * unknowns * unknowns, 18.0 * std::pow(unknowns, 4.0 / 3.0)};
}

// The quadrature points of the whole body: several processes share the work of all of them.
double point_count(const MechanicalSystem& system) {
  return static_cast<double>(system.part() == nullptr ? system.rest().point_count()
                                                      : global_tetrahedron_count(system));
}

LinearSolver first_choice(bool supports_matrix_free, LinearSolver asked) {
  if (asked == LinearSolver::kAuto) {
    return supports_matrix_free ? LinearSolver::kMatrixFree : LinearSolver::kFactor;
  }
  if (asked == LinearSolver::kMatrixFree && !supports_matrix_free) {
    throw InputError(
        "solver.linear = \"matrix-free\" knows neither materials of a program's own nor free rigid "
        "handles: take \"auto\", \"cg\" or \"factor\".");
  }
  return asked;
}

// The method asked for, of a body in parts, for which some do not exist.
LinearSolver choice_in_parts(const MechanicalSystem& system, bool supports_matrix_free,
                             LinearSolver asked) {
  if (!supports_matrix_free) {
    throw InputError(
        "Implicit steps in several processes need a built-in material: take integrator = "
        "\"verlet\" or \"explicit\", or run the scene in one process.");
  }
  if (dynamic_cast<const PreconditionerSource*>(system.part()) != nullptr) return asked;
  if (asked == LinearSolver::kAuto || asked == LinearSolver::kMatrixFree) {
    return LinearSolver::kMatrixFree;
  }
  throw InputError(
      "This engine has no matrix of a body in several processes: take solver.linear = \"auto\" "
      "or \"matrix-free\".");
}

}  // namespace

LinearSolverCosts::LinearSolverCosts(double tetrahedra, const CholeskyCost& cost) {
  constexpr double kInCache = 1e5;  // tetrahedra whose states the last-level cache holds
  product = (tetrahedra > kInCache ? 9.0 : 7.0) * tetrahedra;
  newton = 50.0 * tetrahedra;
  assembly = 100.0 * tetrahedra;
  factorization = cost.flops / 30.0;
  back_solve = (cost.nonzeros > 1e7 ? 0.4 : 0.2) * cost.nonzeros;
}

LinearSolverChoice::LinearSolverChoice(const MechanicalSystem& system, const NewtonOptions& options)
    : in_parts_(system.part() != nullptr),
      supports_matrix_free_(MatrixFreeCg<float>::supports(system)),
      asked_(options.linear),
      current_(first_choice(supports_matrix_free_, asked_)),
      unknowns_(global_freedom_count(system)),
      costs_(point_count(system), expected_cost(static_cast<double>(unknowns_))) {
  if (in_parts_) asked_ = choice_in_parts(system, supports_matrix_free_, asked_);
}

void LinearSolverChoice::begin_step() {
  step_work_ = 0.0;
  is_refined_ = false;
  slow_iterations_ = 0;
  last_residual_ = std::numeric_limits<double>::infinity();
  if (is_for_this_step_) current_ = LinearSolver::kMatrixFree;
  is_for_this_step_ = false;
}

bool LinearSolverChoice::begin_iteration(double residual) {
  if (residual > 0.5 * last_residual_) ++slow_iterations_;
  last_residual_ = residual;
  if (!is_automatic() || current_ != LinearSolver::kMatrixFree ||
      slow_iterations_ <= kSlowIterations) {
    return false;
  }
  current_ = LinearSolver::kFactor;
  is_for_this_step_ = ++slow_steps_ < kSlowSteps;
  return true;
}

bool LinearSolverChoice::refine() {
  if (is_refined_) return false;
  is_refined_ = true;
  return true;
}

double LinearSolverChoice::refined_forcing(double forcing) const {
  constexpr double kRefined = 1e-8;
  return is_refined_ ? std::min(forcing, kRefined) : forcing;
}

bool LinearSolverChoice::takes_exact_factor() const {
  const bool takes_factor = asked_ != LinearSolver::kMatrixFree && asked_ != LinearSolver::kCg;
  return is_refined_ && takes_factor && !prefers_double_precision();
}

// Whether directions in double precision are cheaper by conjugate gradients than by a factor.
bool LinearSolverChoice::prefers_double_precision() const {
  constexpr double kIterations = 1000.0;  // of conjugate gradients, more than a direction needs
  return current_ == LinearSolver::kMatrixFree &&
         costs_.factorization > kIterations * costs_.product;
}

int LinearSolverChoice::iteration_limit() const {
  if (!counts_costs()) return std::max(2000, static_cast<int>(unknowns_));
  const double worth = costs_.assembly + costs_.factorization + 4.0 * costs_.back_solve;
  return std::max(50, static_cast<int>((worth - excess_work_ - step_work_) / costs_.product));
}

void LinearSolverChoice::add_solve(const CgReport& cg) {
  step_work_ += costs_.product * (cg.iterations + CoarseChoice::kPrice * cg.coarse_spaces);
}

void LinearSolverChoice::end_iteration(bool met_negative_curvature, bool has_inertia) {
  step_work_ += costs_.newton;
  // Without inertia the lowest mode shows the way from a saddle, and a factor finds it.
  if (met_negative_curvature) slow_iterations_ += has_inertia ? 1 : kSlowIterations + 1;
}

void LinearSolverChoice::end_step(int newton_iterations) {
  constexpr double kLife = 20.0;
  if (!counts_costs() || current_ != LinearSolver::kMatrixFree) return;
  const double factor =
      newton_iterations * (costs_.newton + 3.0 * (costs_.product + costs_.back_solve)) +
      (costs_.assembly + costs_.factorization) / kLife;
  excess_work_ = std::max(0.0, excess_work_ + step_work_ - factor);
  if (excess_work_ > costs_.factorization) take_factor();
}

void LinearSolverChoice::take_factor() {
  current_ = LinearSolver::kFactor;
  clear_excess_work();
}

void LinearSolverChoice::leave_factor() {
  if (is_automatic() && supports_matrix_free_) asked_ = current_ = LinearSolver::kMatrixFree;
}

}  // namespace tetraction
