// Newton directions of a body in parts by conjugate gradients with a kept preconditioner.
#pragma once

#include <memory>
#include <string>

#include "linear_strategy.h"
#include "matrix_free_strategy.h"
#include "solver/linear/body_preconditioner.h"
#include "solver/linear/matrix_free_cg.h"

namespace tetraction {

/// Solves Newton's linear systems with the products of MatrixFreeCg and a BodyPreconditioner, which is kept
/// as long as it serves: until the step size changes, or until a system takes more than twice the iterations
/// of the first one with it, plus eight.
///
/// Where ∇²Φ is not positive definite, the direction solves a system with the sum of the elements' matrices without
/// their negative eigenvalues, which the preconditioner is made of. (MatrixFreeCg::convexify() changes strains
/// instead, which gives worse directions where elements are much deformed.)
class PreconditionedStrategy : public LinearStrategy {
 public:
  /// The preconditioner is made by the system's part, which must be a PreconditionerSource. A preconditioner that has
  /// reached the most iterations of its kind is made anew. If it reaches them as a new one, the direction is what
  /// the iterations have come to. Keeps references to all. Collective.
  PreconditionedStrategy(const MechanicalSystem& system, BodyPreconditioner::Kind kind,
                         const LinearSolverChoice& choice, MatrixFreeStrategy& matrix_free);

  bool find(const NewtonSystem& system, MinimizerReport& report,
            NewtonDirection& direction) override;
  /// Without a preconditioner that is known to be positive definite, or where it serves no more, that of
  /// MatrixFreeStrategy.
  NegativeCurvature find_negative_curvature(const MinimizationProblem& problem, const Vector& x,
                                            MinimizerReport& report) override;
  /// To be called before systems that differ strongly from the last ones (another step size).
  void forget() { is_old_ = true; }
  std::string name() const { return preconditioner_->name(); }

 private:
  CgReport solve(const Vector& right, double forcing, MinimizerReport& report, Vector& solution);
  void renew(const MinimizationProblem& problem, const Vector& x, bool convex,
             MinimizerReport& report);

  const MechanicalSystem& system_;
  const LinearSolverChoice& choice_;
  MatrixFreeStrategy& matrix_free_;
  MatrixFreeCg<double> cg_;
  std::unique_ptr<BodyPreconditioner> preconditioner_;
  int most_iterations_;
  BodyPreconditioner::Sign sign_ = BodyPreconditioner::Sign::kUnknown;
  Vector ignored_;
  bool is_new_ = false;       // the preconditioner belongs to the present matrix
  bool is_convex_ = false;    // it was made of a matrix that was made positive definite
  bool is_old_ = true;        // it is to be made anew
  int first_iterations_ = 0;  // of the first system with it
};

}  // namespace tetraction
