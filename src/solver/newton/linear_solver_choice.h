// The choice of how Newton's method solves its linear systems.
#pragma once

#include "core/conjugate_gradients.h"
#include "solver/linear/sparse_cholesky.h"
#include "tetraction/solver/newton_minimizer.h"

namespace tetraction {

/// Costs of the linear solvers in nanoseconds on one core (docs/performance.md has the measurements). Only
/// their ratios matter, and only for kAuto and for the time at which a factor is renewed: results do not
/// depend on how fast the machine happens to be.
struct LinearSolverCosts {
  double product;   ///< an iteration of matrix-free conjugate gradients
  double newton;    ///< an iteration of Newton's method without the linear solve
  double assembly;  ///< of the matrix
  double factorization;
  double back_solve;  ///< in single precision

  LinearSolverCosts(double tetrahedra, const CholeskyCost& cost);
};

/// The method of LinearSolver that is in use. With kAuto it changes by rules that count work at fixed costs.
class LinearSolverChoice {
 public:
  /// Throws InputError for a method that cannot be used for the body. Collective.
  LinearSolverChoice(const MechanicalSystem& system, const NewtonOptions& options);

  LinearSolver current() const { return current_; }
  bool is_automatic() const { return asked_ == LinearSolver::kAuto; }
  /// Whether kAuto weighs the costs of the methods. They are those of one process: MUMPS's factor in several
  /// is often slower than many iterations without a matrix, and its bits differ from run to run.
  bool counts_costs() const { return is_automatic() && !in_parts_; }
  bool supports_matrix_free() const { return supports_matrix_free_; }
  Index unknowns() const { return unknowns_; }  ///< of the whole body
  /// Whether the body is small enough for a further factor of the size of its matrix, or uses one anyway.
  bool affords_factor() const { return !in_parts_ && !prefers_double_precision(); }

  /// To be called before the first direction of a step.
  void begin_step();
  /// To be called before each direction, with the residual. If Newton's method makes slow progress with
  /// approximate directions, this step takes a factor. If that happens several times, all later steps do.
  /// Returns whether the factor is taken from now on.
  bool begin_iteration(double residual);
  /// Asks for directions of more digits to the end of the step. Returns false if they are asked for already.
  bool refine();
  bool is_refined() const { return is_refined_; }
  /// The tolerance of iterations in double precision, where `forcing` is asked for.
  double refined_forcing(double forcing) const;
  /// Whether refined directions come from a factor of their own matrix.
  bool takes_exact_factor() const;
  /// The most iterations of a solve without a matrix. With kAuto they may not cost more, in this step and before,
  /// than a factor would have.
  int iteration_limit() const;
  /// To be called after such a solve, …
  void add_solve(const CgReport& cg);
  /// … and after a direction without a matrix that met negative curvature or did not.
  void end_iteration(bool met_negative_curvature, bool has_inertia);
  /// To be called after a step that converged in this number of iterations. The method without a matrix
  /// is used until its additional cost, compared with a factor that lasts for twenty steps, would have paid for
  /// the factor.
  void end_step(int newton_iterations);
  /// Takes the factor from now on.
  void take_factor();
  /// Takes the method without a matrix from now on, if the choice is free and the body allows it.
  void leave_factor();

  /// Work that a new factor would have saved, since the last factorisation: of iterations with an older factor
  /// or without any.
  double excess_work() const { return excess_work_; }
  void add_excess_work(double work) { excess_work_ += work; }
  void clear_excess_work() { excess_work_ = 0.0; }

 private:
  bool prefers_double_precision() const;

  bool in_parts_;
  bool supports_matrix_free_;
  LinearSolver asked_;
  LinearSolver current_;
  Index unknowns_;
  LinearSolverCosts costs_;  // of the body, with an estimate of the factor's
  bool is_refined_ = false;
  double step_work_ = 0.0;  // of the present step, without a matrix
  double excess_work_ = 0.0;
  // The change of kAuto to the factor where Newton's method makes slow progress.
  int slow_iterations_ = 0;  // of this step: they met negative curvature or gained little
  double last_residual_ = 0.0;
  bool is_for_this_step_ = false;  // the factor
  int slow_steps_ = 0;             // that took the factor
};

}  // namespace tetraction
