// The linear systems of Newton's method over all processes.
#pragma once

#include <petscksp.h>

#include <string>
#include <vector>

#include "fem/tangent_operator.h"
#include "mpi_part.h"
#include "tetraction/dynamics/mechanical_system.h"
#include "tetraction/dynamics/nonlinear_problem.h"

namespace tetraction::petsc {

/// ∇²Φ(u) d = −∇Φ(u). All three coordinates of every vertex are unknowns; those that are prescribed have a
/// row and a column of their own with d = 0.
class LinearSystem {
 public:
  /// What the preconditioner consists of.
  enum class Preconditioner {
    kMultigrid,  ///< smoothed aggregation (GAMG) with the six rigid motions
    kFactor      ///< a Cholesky factor (MUMPS)
  };
  LinearSystem(const MechanicalSystem& system, const MpiPart& part, Preconditioner preconditioner);
  ~LinearSystem();
  LinearSystem(const LinearSystem&) = delete;
  LinearSystem& operator=(const LinearSystem&) = delete;

  /// How a solve ended.
  struct Report {
    bool converged = false;
    bool indefinite = false;  ///< matrix or preconditioner are not positive definite
    int iterations = 0;
  };
  /// Linearises at u. With `convex` the matrix is made positive semidefinite.
  void set(const MinimizationProblem& problem, const Vector& u, bool convex);
  /// Makes the preconditioner anew for the last set().
  void make_preconditioner(const MinimizationProblem& problem, const Vector& u, bool convex);
  bool has_preconditioner() const { return has_preconditioner_; }
  /// Whether steps have changed so much that a preconditioner of theirs serves no more.
  bool is_outdated() const;
  /// Solves to a relative residual. `gradient` and `direction`: 3 per vertex of the part.
  Report solve(const Vector& gradient, double forcing, Vector& direction);
  /// How systems are solved, for reports.
  const std::string& name() const { return name_; }

 private:
  static PetscErrorCode multiply(Mat matrix, Vec in, Vec out);
  void multiply(const double* in, double* out);
  void make_pattern();
  void take(const double* own, Vector& full) const;

  const MechanicalSystem& system_;
  const MpiPart& part_;
  std::string name_;
  TangentOperator<double> tangent_;
  AlignedVector<double> records_;
  std::vector<char> is_fixed_;     // per coordinate of the part
  std::vector<PetscInt> numbers_;  // of the vertices, over all processes
  std::vector<PetscInt> fixed_rows_;
  Vector diagonal_;  // of what belongs to single vertices
  HessianBlocks terms_;
  bool has_terms_ = false;
  double scale_ = 1.0;  // of the rows of fixed coordinates
  double stiffness_of_preconditioner_ = 0.0;
  double stiffness_ = 0.0;
  bool has_preconditioner_ = false;
  Vector full_;
  Vector product_;
  Mat operator_ = nullptr;
  Mat assembled_ = nullptr;
  KSP solver_ = nullptr;
  Vec right_ = nullptr;
  Vec solution_ = nullptr;
};

}  // namespace tetraction::petsc
