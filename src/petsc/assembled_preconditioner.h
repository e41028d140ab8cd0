// Preconditioners made of a matrix that all processes hold together.
#pragma once

#include <petscksp.h>

#include <string>
#include <vector>

#include "mpi_part.h"
#include "solver/body_preconditioner.h"
#include "tetraction/dynamics/mechanical_system.h"
#include "tetraction/dynamics/nonlinear_problem.h"

namespace tetraction::petsc {

/// A preconditioner made of ∇²Φ(u) with all three coordinates of every vertex. Those that are prescribed have a
/// row and a column of their own, and z = 0.
class AssembledPreconditioner : public BodyPreconditioner {
 public:
  /// Multigrid is smoothed aggregation (GAMG) with the six rigid motions; MUMPS makes the Cholesky factor.
  /// Keeps references to both.
  AssembledPreconditioner(const MechanicalSystem& system, const MpiPart& part, Kind kind);
  ~AssembledPreconditioner() override;
  AssembledPreconditioner(const AssembledPreconditioner&) = delete;
  AssembledPreconditioner& operator=(const AssembledPreconditioner&) = delete;

  /// With `convex` the matrix of each element is projected. The sign is known of a convex matrix, and of a
  /// factor, which counts negative pivots. Throws NumericalError if the factorisation fails otherwise.
  Sign make(const MinimizationProblem& problem, const Vector& u, bool convex) override;
  void apply(const Vector& r, Vector& z) override;
  std::string name() const override;

 private:
  void make_pattern();
  void assemble(const MinimizationProblem& problem, const Vector& u, bool convex);
  void set_rigid_motions();
  Sign factorize(bool convex);

  const MechanicalSystem& system_;
  const MpiPart& part_;
  Kind kind_;
  std::vector<char> is_fixed_;     // per coordinate of the part
  std::vector<PetscInt> numbers_;  // of the vertices, over all processes
  std::vector<PetscInt> fixed_rows_;
  Mat matrix_ = nullptr;
  PC preconditioner_ = nullptr;
  Vec right_ = nullptr;
  Vec solution_ = nullptr;
};

}  // namespace tetraction::petsc
