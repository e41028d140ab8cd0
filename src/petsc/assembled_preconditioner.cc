#include "assembled_preconditioner.h"

#include <algorithm>
#include <cmath>
#include <unordered_set>

#include "fem/allowed_directions.h"
#include "petsc_check.h"
#include "tetraction/core/positive_semidefinite.h"

namespace tetraction::petsc {

AssembledPreconditioner::AssembledPreconditioner(const MechanicalSystem& system,
                                                 const MpiPart& part, Kind kind)
    : system_(system), part_(part), kind_(kind) {
  const FreeCoordinates& coordinates = system.coordinates();
  for (Index v = 0; v < system.vertex_count(); ++v) {
    if (!coordinates.is_free(v)) allowed_.emplace(v, allowed_directions(coordinates.map(v)));
  }
  const auto own = static_cast<PetscInt>(3 * part.owned_vertices);
  check(VecCreateMPI(PETSC_COMM_WORLD, own, PETSC_DETERMINE, &right_), "VecCreateMPI");
  check(VecDuplicate(right_, &solution_), "VecDuplicate");
  make_pattern();
  make_solver(solver_, kind == Kind::kMultigrid ? PCGAMG : PCCHOLESKY);
  check(KSPGetPC(solver_, &preconditioner_), "KSPGetPC");
  if (kind == Kind::kMultigrid) {
    set_rigid_motions();
  } else {
    check(PCFactorSetMatSolverType(preconditioner_, MATSOLVERMUMPS), "PCFactorSetMatSolverType");
  }
}

AssembledPreconditioner::~AssembledPreconditioner() {
  KSPDestroy(&block_solver_);
  KSPDestroy(&solver_);
  MatDestroy(&matrix_);
  VecDestroy(&solution_);
  VecDestroy(&right_);
}

void AssembledPreconditioner::make_solver(KSP& solver, PCType preconditioner) {
  check(KSPCreate(PETSC_COMM_WORLD, &solver), "KSPCreate");
  check(KSPSetType(solver, KSPCG), "KSPSetType");
  check(KSPSetNormType(solver, KSP_NORM_UNPRECONDITIONED), "KSPSetNormType");
  PC of_solver = nullptr;
  check(KSPGetPC(solver, &of_solver), "KSPGetPC");
  check(PCSetType(of_solver, preconditioner), "PCSetType");
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
  // Multigrid would keep the aggregates of the first matrix.
  if (kind_ == Kind::kMultigrid) check(PCReset(preconditioner_), "PCReset");
  check(KSPSetOperators(solver_, matrix_, matrix_), "KSPSetOperators");
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
  const auto add = [&](const auto& vertices, const auto& block) {
    std::array<PetscInt, 4> numbers{};
    PetscInt count = 0;
    for (const Index v : vertices) {
      numbers[static_cast<std::size_t>(count++)] = numbers_[static_cast<std::size_t>(v)];
    }
    check(MatSetValuesBlocked(matrix_, count, numbers.data(), count, numbers.data(), block.data(),
                              ADD_VALUES),
          "MatSetValuesBlocked");
  };
  double trace = 0.0;
  for (Index e = 0; e < system_.rest().element_count(); ++e) {
    problem.element_terms(e, u, has_terms ? &shares : nullptr, true, terms);
    Matrix block = terms.hessian;
    if (convex) block = positive_semidefinite_part(block);
    trace += block.trace();
    const ElementNodes nodes = system_.rest().nodes(e);
    for (Index a = 0; a < 4; ++a) {
      const auto found = allowed_.find(nodes[static_cast<std::size_t>(a)]);
      if (found == allowed_.end()) continue;
      block.middleRows<3>(3 * a) = found->second * block.middleRows<3>(3 * a).eval();
      block.middleCols<3>(3 * a) = block.middleCols<3>(3 * a).eval() * found->second;
    }
    values = block;
    add(nodes, values);
  }
  // Directions in which a vertex cannot move have the mean of the diagonal.
  const double scale =
      sum_over_parts(&part_, trace) / (3.0 * static_cast<double>(part_.whole.vertices));
  for (const auto& [v, allowed] : allowed_) {
    if (v >= part_.owned_vertices) continue;
    const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> across =
        scale * (Matrix3::Identity() - allowed);
    add(std::array{v}, across);
  }
  check(MatAssemblyBegin(matrix_, MAT_FINAL_ASSEMBLY), "MatAssemblyBegin");
  check(MatAssemblyEnd(matrix_, MAT_FINAL_ASSEMBLY), "MatAssemblyEnd");
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

void AssembledPreconditioner::set_right(const Vector& r) {
  double* place = nullptr;
  check(VecGetArray(right_, &place), "VecGetArray");
  Eigen::Map<Vector> right(place, 3 * part_.owned_vertices);
  right = r.head(right.size());
  for (const auto& [v, allowed] : allowed_) {
    if (v < part_.owned_vertices) right.segment<3>(3 * v) = allowed * vertex_block(r, v);
  }
  check(VecRestoreArray(right_, &place), "VecRestoreArray");
}

void AssembledPreconditioner::get_solution(Vector& z) const {
  const double* place = nullptr;
  check(VecGetArrayRead(solution_, &place), "VecGetArrayRead");
  z.resize(system_.dof_count());
  std::copy_n(place, 3 * part_.owned_vertices, z.data());
  check(VecRestoreArrayRead(solution_, &place), "VecRestoreArrayRead");
  part_.copy_from_owners(z.data(), 3);
  for (const auto& [v, allowed] : allowed_) {
    vertex_block(z, v) = (allowed * vertex_block(z, v)).eval();
  }
}

void AssembledPreconditioner::apply(const Vector& r, Vector& z) {
  set_right(r);
  check(PCApply(preconditioner_, right_, solution_), "PCApply");
  get_solution(z);
}

// Multigrid may be indefinite or slow where elements are much deformed. The blocks of the diagonal always serve.
int AssembledPreconditioner::solve(const Vector& r, double tolerance, Vector& z) {
  constexpr int kMost = 100;
  constexpr int kMostWithBlocks = 2000;
  set_right(r);
  PetscInt all = 0;
  const auto solve_with = [&](KSP solver, int most) {
    check(KSPSetTolerances(solver, tolerance, PETSC_DEFAULT, PETSC_DEFAULT, most),
          "KSPSetTolerances");
    check(KSPSolve(solver, right_, solution_), "KSPSolve");
    PetscInt iterations = 0;
    check(KSPGetIterationNumber(solver, &iterations), "KSPGetIterationNumber");
    all += iterations;
    KSPConvergedReason reason{};
    check(KSPGetConvergedReason(solver, &reason), "KSPGetConvergedReason");
    return reason > 0;
  };
  if (!solve_with(solver_, kMost)) {
    if (block_solver_ == nullptr) make_solver(block_solver_, PCPBJACOBI);
    check(KSPSetOperators(block_solver_, matrix_, matrix_), "KSPSetOperators");
    solve_with(block_solver_, kMostWithBlocks);
  }
  get_solution(z);
  return static_cast<int>(all);
}

}  // namespace tetraction::petsc
