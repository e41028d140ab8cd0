// Newton directions of a body in parts by conjugate gradients with a kept preconditioner.
#pragma once

#include <memory>
#include <string>

#include "solver/linear/body_preconditioner.h"
#include "solver/linear/matrix_free_cg.h"
#include "solver/linear/negative_curvature.h"
#include "tetraction/dynamics/mechanical_system.h"
#include "tetraction/dynamics/problems/minimizer.h"
#include "tetraction/dynamics/problems/nonlinear_problem.h"

namespace tetraction {

/// Solves Newton's linear systems with the products of MatrixFreeCg and a BodyPreconditioner, which is kept
/// as long as it serves: until the step size changes, or until a system takes more than twice the iterations
/// of the first one with it, plus eight.
///
/// Where ∇²Φ is not positive definite, the direction solves a system with the sum of the elements' matrices without
/// their negative eigenvalues, which the preconditioner is made of. (MatrixFreeCg::convexify() changes strains
/// instead, which gives worse directions where elements are much deformed.)
class PreconditionedDirection {
 public:
  /// A system takes at most so many iterations. A preconditioner that has reached them is made anew. If it
  /// reaches them as a new one, the direction is what the iterations have come to.
  PreconditionedDirection(const MechanicalSystem& system,
                          std::unique_ptr<BodyPreconditioner> preconditioner, int most_iterations);

  /// To be called before systems that differ strongly from the last ones (another step size).
  void forget() { is_old_ = true; }
  /// direction ≈ −(∇²Φ(x))⁻¹ gradient to a relative residual of `forcing`.
  void find(const MinimizationProblem& problem, const Vector& x, const Vector& gradient,
            double forcing, MinimizerReport& report, Vector& direction);
  /// What the last find() or probe() met. Mostly there is none.
  const NegativeCurvature& negative_curvature() const { return curvature_; }
  /// Solves ∇²Φ(x) y = `right` to a relative residual of `forcing`, only to meet negative curvature on the
  /// way. Returns false if nothing is known afterwards: there is no preconditioner that is known to be
  /// positive definite, or it serves no more.
  bool probe(const MinimizationProblem& problem, const Vector& x, const Vector& right,
             double forcing, MinimizerReport& report);
  /// Whether it is known that no element is inverted on the way along the last direction.
  bool step_is_safe() const { return is_safe_; }
  std::string name() const { return preconditioner_->name(); }

 private:
  CgReport solve(const Vector& right, double forcing, MinimizerReport& report, Vector& solution);
  void renew(const MinimizationProblem& problem, const Vector& x, bool convex,
             MinimizerReport& report);

  MatrixFreeCg<double> cg_;
  std::unique_ptr<BodyPreconditioner> preconditioner_;
  int most_iterations_;
  BodyPreconditioner::Sign sign_ = BodyPreconditioner::Sign::kUnknown;
  NegativeCurvature curvature_;
  Vector ignored_;
  bool is_safe_ = false;
  bool is_new_ = false;       // the preconditioner belongs to the present matrix
  bool is_convex_ = false;    // it was made of a matrix that was made positive definite
  bool is_old_ = true;        // it is to be made anew
  int first_iterations_ = 0;  // of the first system with it
};

}  // namespace tetraction
