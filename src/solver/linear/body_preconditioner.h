// Preconditioners of a body that several processes hold together.
#pragma once

#include <memory>
#include <string>

#include "tetraction/core/types.h"

namespace tetraction {

class MechanicalSystem;
class MinimizationProblem;

/// A preconditioner M⁻¹ of conjugate gradients on ∇²Φ of the whole body, made of an assembled matrix. Its
/// functions are collective.
class BodyPreconditioner {
 public:
  enum class Kind {
    kMultigrid,  ///< algebraic multigrid
    kFactor      ///< a Cholesky factor
  };
  virtual ~BodyPreconditioner() = default;
  /// Knowledge about its eigenvalues.
  enum class Sign { kDefinite, kIndefinite, kUnknown };

  /// Makes it of ∇²Φ(u). With `convex` the matrix is made positive definite first.
  virtual Sign make(const MinimizationProblem& problem, const Vector& u, bool convex) = 0;
  /// z = M⁻¹ r. Both have 3 numbers for each vertex of the part. Copies of a vertex have the same numbers.
  virtual void apply(const Vector& r, Vector& z) = 0;
  /// z = A⁻¹ r to a relative residual of `tolerance`, where A is the matrix that M⁻¹ was made of, by conjugate gradients
  /// with M⁻¹ or, where it does not serve, with the blocks of the diagonal. A must be positive definite. Returns the
  /// number of iterations.
  virtual int solve(const Vector& r, double tolerance, Vector& z) = 0;
  /// How linear systems are solved with it, for reports.
  virtual std::string name() const = 0;
};

/// Makes such preconditioners. A MeshPart may be one, too.
class PreconditionerSource {
 public:
  virtual ~PreconditionerSource() = default;
  /// The preconditioner of the body of which `system` is a part. Keeps a reference to the
  /// system. Collective.
  virtual std::unique_ptr<BodyPreconditioner> make_preconditioner(
      const MechanicalSystem& system, BodyPreconditioner::Kind kind) const = 0;

 protected:
  PreconditionerSource() = default;
  PreconditionerSource(const PreconditionerSource&) = default;
  PreconditionerSource& operator=(const PreconditionerSource&) = default;
};

}  // namespace tetraction
