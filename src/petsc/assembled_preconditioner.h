// Preconditioners made of a matrix that all processes hold together.
#pragma once

#include <petscksp.h>

#include <map>
#include <string>
#include <vector>

#include "mpi_part.h"
#include "solver/linear/body_preconditioner.h"
#include "tetraction/dynamics/mechanical_system.h"
#include "tetraction/dynamics/problems/nonlinear_problem.h"

namespace tetraction::petsc {

/// A preconditioner made of ∇²Φ(u) with all three coordinates of every vertex. Directions in which a vertex
/// cannot move have no part in r and z; the matrix has a multiple of the unit matrix there.
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
  int solve(const Vector& r, double tolerance, Vector& z) override;
  std::string name() const override;

 private:
  static void make_solver(KSP& solver, PCType preconditioner);
  void make_pattern();
  void assemble(const MinimizationProblem& problem, const Vector& u, bool convex);
  void set_rigid_motions();
  Sign factorize(bool convex);
  void set_right(const Vector& r);
  void get_solution(Vector& z) const;

  const MechanicalSystem& system_;
  const MpiPart& part_;
  Kind kind_;
  std::vector<PetscInt> numbers_;     // of the vertices, over all processes
  std::map<Index, Matrix3> allowed_;  // projections of the vertices that are not free
  Mat matrix_ = nullptr;
  KSP solver_ = nullptr;
  KSP block_solver_ = nullptr;   // made when it is first needed
  PC preconditioner_ = nullptr;  // of the solver
  Vec right_ = nullptr;
  Vec solution_ = nullptr;
};

}  // namespace tetraction::petsc
