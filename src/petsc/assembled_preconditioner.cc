#include "assembled_preconditioner.h"

#include <algorithm>
#include <cmath>
#include <unordered_set>

#include "petsc_check.h"
#include "tetraction/core/positive_semidefinite.h"

namespace tetraction::petsc {

AssembledPreconditioner::AssembledPreconditioner(const MechanicalSystem& system,
                                                 const MpiPart& part, Kind kind)
    : system_(system),
      part_(part),
      kind_(kind),
      is_fixed_(static_cast<std::size_t>(system.dof_count()), 0) {
  const FreeCoordinates& coordinates = system.coordinates();
  for (Index v = 0; v < system.vertex_count(); ++v) {
    if (coordinates.is_free(v)) continue;
    const FreeCoordinates::VertexMap map = coordinates.map(v);
    for (Index i = 0; i < 3; ++i) {
      if (map.columns.row(i).squaredNorm() < 0.5)
        is_fixed_[static_cast<std::size_t>(3 * v + i)] = 1;
    }
  }
  const auto own = static_cast<PetscInt>(3 * part.owned_vertices);
  check(VecCreateMPI(PETSC_COMM_WORLD, own, PETSC_DETERMINE, &right_), "VecCreateMPI");
  check(VecDuplicate(right_, &solution_), "VecDuplicate");
  make_pattern();
  check(PCCreate(PETSC_COMM_WORLD, &preconditioner_), "PCCreate");
  if (kind == Kind::kMultigrid) {
    check(PCSetType(preconditioner_, PCGAMG), "PCSetType");
    set_rigid_motions();
  } else {
    check(PCSetType(preconditioner_, PCCHOLESKY), "PCSetType");
    check(PCFactorSetMatSolverType(preconditioner_, MATSOLVERMUMPS), "PCFactorSetMatSolverType");
  }
}

AssembledPreconditioner::~AssembledPreconditioner() {
  PCDestroy(&preconditioner_);
  MatDestroy(&matrix_);
  VecDestroy(&solution_);
  VecDestroy(&right_);
}

std::string AssembledPreconditioner::name() const {
  return kind_ == Kind::kMultigrid ? "cg (multigrid)" : "factor (MUMPS)";
}

// The matrix with a 3 × 3 block for each pair of vertices of a tetrahedron.
void AssembledPreconditioner::make_pattern() {
  const Index own = part_.owned_vertices;
  PetscInt begin = 0;
  check(VecGetOwnershipRange(right_, &begin, nullptr), "VecGetOwnershipRange");
  Vector numbers = Vector::Zero(system_.vertex_count());
  for (Index v = 0; v < own; ++v) numbers[v] = static_cast<double>(begin / 3 + v);
  part_.copy_from_owners(numbers.data(), 1);
  numbers_.resize(static_cast<std::size_t>(numbers.size()));
  for (Index v = 0; v < numbers.size(); ++v) {
    numbers_[static_cast<std::size_t>(v)] = static_cast<PetscInt>(numbers[v]);
  }
  for (Index i = 0; i < 3 * own; ++i) {
    if (is_fixed_[static_cast<std::size_t>(i)] != 0) {
      fixed_rows_.push_back(begin + static_cast<PetscInt>(i));
    }
  }
  // The numbers of neighbours; those of a shared vertex are at most the sum over its copies.
  std::vector<std::unordered_set<Index>> neighbors(
      static_cast<std::size_t>(system_.vertex_count()));
  for (Index e = 0; e < system_.rest().element_count(); ++e) {
    const ElementNodes nodes = system_.rest().nodes(e);
    for (const Index v : nodes) {
      neighbors[static_cast<std::size_t>(v)].insert(nodes.begin(), nodes.end());
    }
  }
  Matrix counts(2, system_.vertex_count());
  for (Index v = 0; v < counts.cols(); ++v) {
    const auto& list = neighbors[static_cast<std::size_t>(v)];
    counts(0, v) = static_cast<double>(list.size());
    counts(1, v) = static_cast<double>(
        std::count_if(list.begin(), list.end(), [&](Index other) { return other >= own; }));
  }
  neighbors = {};
  Matrix total = counts;
  part_.add_shared(total.data(), 2);
  std::vector<PetscInt> diagonal(static_cast<std::size_t>(own));
  std::vector<PetscInt> off(static_cast<std::size_t>(own));
  for (Index v = 0; v < own; ++v) {
    const bool is_shared = total(0, v) != counts(0, v);
    diagonal[static_cast<std::size_t>(v)] =
        static_cast<PetscInt>(std::min(total(0, v), static_cast<double>(own)));
    off[static_cast<std::size_t>(v)] =
        static_cast<PetscInt>(is_shared ? total(0, v) : counts(1, v));
  }
  check(MatCreate(PETSC_COMM_WORLD, &matrix_), "MatCreate");
  const auto rows = static_cast<PetscInt>(3 * own);
  check(MatSetSizes(matrix_, rows, rows, PETSC_DETERMINE, PETSC_DETERMINE), "MatSetSizes");
  check(MatSetType(matrix_, MATAIJ), "MatSetType");
  check(MatSetBlockSize(matrix_, 3), "MatSetBlockSize");
  check(MatXAIJSetPreallocation(matrix_, 3, diagonal.data(), off.data(), nullptr, nullptr),
        "MatXAIJSetPreallocation");
  check(MatSetOption(matrix_, MAT_NEW_NONZERO_ALLOCATION_ERR, PETSC_FALSE), "MatSetOption");
  check(MatSetOption(matrix_, MAT_SYMMETRIC, PETSC_TRUE), "MatSetOption");
  check(MatSetOption(matrix_, MAT_KEEP_NONZERO_PATTERN, PETSC_TRUE), "MatSetOption");
}

BodyPreconditioner::Sign AssembledPreconditioner::make(const MinimizationProblem& problem,
                                                       const Vector& u, bool convex) {
  assemble(problem, u, convex);
  check(PCSetOperators(preconditioner_, matrix_, matrix_), "PCSetOperators");
  if (kind_ == Kind::kFactor) return factorize(convex);
  check(PCSetUp(preconditioner_), "PCSetUp");
  return convex ? Sign::kDefinite : Sign::kUnknown;
}

void AssembledPreconditioner::assemble(const MinimizationProblem& problem, const Vector& u,
                                       bool convex) {
  check(MatZeroEntries(matrix_), "MatZeroEntries");
  const bool has_terms = problem.has_general_terms();
  MinimizationProblem::TermShares shares;
  if (has_terms) problem.term_shares(u, true, shares);
  ElasticPotential::ElementTerms terms;
  Eigen::Matrix<double, 12, 12, Eigen::RowMajor> values;
  double trace = 0.0;
  for (Index e = 0; e < system_.rest().element_count(); ++e) {
    problem.element_terms(e, u, has_terms ? &shares : nullptr, true, terms);
    Matrix block = terms.hessian;
    if (convex) block = positive_semidefinite_part(block);
    values = block;
    trace += block.trace();
    std::array<PetscInt, 4> nodes{};
    std::size_t a = 0;
    for (const Index v : system_.rest().nodes(e))
      nodes[a++] = numbers_[static_cast<std::size_t>(v)];
    check(MatSetValuesBlocked(matrix_, 4, nodes.data(), 4, nodes.data(), values.data(), ADD_VALUES),
          "MatSetValuesBlocked");
  }
  check(MatAssemblyBegin(matrix_, MAT_FINAL_ASSEMBLY), "MatAssemblyBegin");
  check(MatAssemblyEnd(matrix_, MAT_FINAL_ASSEMBLY), "MatAssemblyEnd");
  // Rows of fixed coordinates have the mean of the diagonal.
  const double scale =
      sum_over_parts(&part_, trace) / (3.0 * static_cast<double>(part_.whole.vertices));
  check(MatZeroRowsColumns(matrix_, static_cast<PetscInt>(fixed_rows_.size()), fixed_rows_.data(),
                           scale, nullptr, nullptr),
        "MatZeroRowsColumns");
}

void AssembledPreconditioner::set_rigid_motions() {
  Vec coordinates = nullptr;
  check(VecDuplicate(right_, &coordinates), "VecDuplicate");
  check(VecSetBlockSize(coordinates, 3), "VecSetBlockSize");
  double* place = nullptr;
  check(VecGetArray(coordinates, &place), "VecGetArray");
  const Vector rest = system_.mesh().rest_positions();
  std::copy_n(rest.data(), 3 * part_.owned_vertices, place);
  check(VecRestoreArray(coordinates, &place), "VecRestoreArray");
  MatNullSpace motions = nullptr;
  check(MatNullSpaceCreateRigidBody(coordinates, &motions), "MatNullSpaceCreateRigidBody");
  check(MatSetNearNullSpace(matrix_, motions), "MatSetNearNullSpace");
  check(MatNullSpaceDestroy(&motions), "MatNullSpaceDestroy");
  check(VecDestroy(&coordinates), "VecDestroy");
}

BodyPreconditioner::Sign AssembledPreconditioner::factorize(bool convex) {
  constexpr PetscInt kRootInParts = 13;  // MUMPS counts pivots only if the root is not divided
  constexpr PetscInt kError = 1;
  constexpr PetscInt kNegativePivots = 12;
  constexpr PetscInt kSingular = -10;
  Mat factor = nullptr;
  check(PCFactorSetUpMatSolverType(preconditioner_), "PCFactorSetUpMatSolverType");
  check(PCFactorGetMatrix(preconditioner_, &factor), "PCFactorGetMatrix");
  check(MatMumpsSetIcntl(factor, kRootInParts, 1), "MatMumpsSetIcntl");
  check(PCSetUp(preconditioner_), "PCSetUp");
  check(PCFactorGetMatrix(preconditioner_, &factor), "PCFactorGetMatrix");
  PetscInt error = 0;
  PetscInt negative = 0;
  check(MatMumpsGetInfog(factor, kError, &error), "MatMumpsGetInfog");
  check(MatMumpsGetInfog(factor, kNegativePivots, &negative), "MatMumpsGetInfog");
  if (error < 0 && (convex || error != kSingular)) {
    throw NumericalError(fmt::format(
        "MUMPS could not factorise the matrix of the whole body (its INFOG(1) is {}): take "
        "solver.linear = \"matrix-free\" or \"cg\", which need less memory.",
        error));
  }
  return error < 0 || negative > 0 ? Sign::kIndefinite : Sign::kDefinite;
}

void AssembledPreconditioner::apply(const Vector& r, Vector& z) {
  const Index own = 3 * part_.owned_vertices;
  double* place = nullptr;
  check(VecGetArray(right_, &place), "VecGetArray");
  for (Index i = 0; i < own; ++i) {
    place[i] = is_fixed_[static_cast<std::size_t>(i)] != 0 ? 0.0 : r[i];
  }
  check(VecRestoreArray(right_, &place), "VecRestoreArray");
  check(PCApply(preconditioner_, right_, solution_), "PCApply");
  const double* result = nullptr;
  check(VecGetArrayRead(solution_, &result), "VecGetArrayRead");
  z.resize(system_.dof_count());
  std::copy_n(result, own, z.data());
  check(VecRestoreArrayRead(solution_, &result), "VecRestoreArrayRead");
  part_.copy_from_owners(z.data(), 3);
  for (Index i = 0; i < z.size(); ++i) {
    if (is_fixed_[static_cast<std::size_t>(i)] != 0) z[i] = 0.0;
  }
}

}  // namespace tetraction::petsc
