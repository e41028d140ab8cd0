#include "linear_system.h"

#include <algorithm>
#include <cmath>
#include <unordered_set>

#include "petsc_check.h"
#include "tetraction/core/positive_semidefinite.h"

namespace tetraction::petsc {
namespace {

constexpr Index kRecord = ElementBlocks::kRecordSize;

}  // namespace

LinearSystem::LinearSystem(const MechanicalSystem& system, const MpiPart& part,
                           Preconditioner preconditioner)
    : system_(system),
      part_(part),
      tangent_(system.elastic()),
      records_(static_cast<std::size_t>(kRecord * system.vertex_count()), 0.0),
      is_fixed_(static_cast<std::size_t>(system.dof_count()), 0),
      full_(system.dof_count()),
      product_(system.dof_count()) {
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
  check(MatCreateShell(PETSC_COMM_WORLD, own, own, PETSC_DETERMINE, PETSC_DETERMINE, this,
                       &operator_),
        "MatCreateShell");
  PetscErrorCode (*product)(Mat, Vec, Vec) = &LinearSystem::multiply;
  check(MatShellSetOperation(operator_, MATOP_MULT, reinterpret_cast<void (*)()>(product)),
        "MatShellSetOperation");
  make_pattern();
  check(KSPCreate(PETSC_COMM_WORLD, &solver_), "KSPCreate");
  check(KSPSetType(solver_, KSPCG), "KSPSetType");
  check(KSPSetNormType(solver_, KSP_NORM_UNPRECONDITIONED), "KSPSetNormType");
  PC pc = nullptr;
  check(KSPGetPC(solver_, &pc), "KSPGetPC");
  if (preconditioner == Preconditioner::kMultigrid) {
    name_ = "cg (multigrid)";
    check(PCSetType(pc, PCGAMG), "PCSetType");
  } else {
    name_ = "factor (MUMPS)";
    check(PCSetType(pc, PCCHOLESKY), "PCSetType");
    check(PCFactorSetMatSolverType(pc, MATSOLVERMUMPS), "PCFactorSetMatSolverType");
  }
}

LinearSystem::~LinearSystem() {
  KSPDestroy(&solver_);
  MatDestroy(&assembled_);
  MatDestroy(&operator_);
  VecDestroy(&solution_);
  VecDestroy(&right_);
}

// The matrix with a 3 × 3 block for each pair of vertices of a tetrahedron.
void LinearSystem::make_pattern() {
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
  check(MatCreate(PETSC_COMM_WORLD, &assembled_), "MatCreate");
  const auto rows = static_cast<PetscInt>(3 * own);
  check(MatSetSizes(assembled_, rows, rows, PETSC_DETERMINE, PETSC_DETERMINE), "MatSetSizes");
  check(MatSetType(assembled_, MATAIJ), "MatSetType");
  check(MatSetBlockSize(assembled_, 3), "MatSetBlockSize");
  check(MatXAIJSetPreallocation(assembled_, 3, diagonal.data(), off.data(), nullptr, nullptr),
        "MatXAIJSetPreallocation");
  check(MatSetOption(assembled_, MAT_NEW_NONZERO_ALLOCATION_ERR, PETSC_FALSE), "MatSetOption");
  check(MatSetOption(assembled_, MAT_SYMMETRIC, PETSC_TRUE), "MatSetOption");
  check(MatSetOption(assembled_, MAT_KEEP_NONZERO_PATTERN, PETSC_TRUE), "MatSetOption");
}

void LinearSystem::set(const MinimizationProblem& problem, const Vector& u, bool convex) {
  const MinimizationProblem::HessianParts parts = problem.hessian_parts(u);
  tangent_.set(parts.positions.origin() + u, parts.viscous, parts.step_displacement);
  if (convex) tangent_.convexify();
  diagonal_ = parts.diagonal;
  has_terms_ = problem.has_general_terms();
  if (has_terms_) {
    problem.term_hessian(u, convex ? HessianForm::kConvex : HessianForm::kExact, terms_);
  }
  stiffness_ = sum_over_parts(&part_, diagonal_.head(3 * part_.owned_vertices).sum());
}

bool LinearSystem::is_outdated() const {
  constexpr double kSimilar = 1.5;
  return !has_preconditioner_ || stiffness_ > kSimilar * stiffness_of_preconditioner_ ||
         stiffness_of_preconditioner_ > kSimilar * stiffness_;
}

void LinearSystem::make_preconditioner(const MinimizationProblem& problem, const Vector& u,
                                       bool convex) {
  check(MatZeroEntries(assembled_), "MatZeroEntries");
  MinimizationProblem::TermShares shares;
  if (has_terms_) problem.term_shares(u, true, shares);
  ElasticPotential::ElementTerms terms;
  Eigen::Matrix<double, 12, 12, Eigen::RowMajor> values;
  double trace = 0.0;
  for (Index e = 0; e < system_.rest().element_count(); ++e) {
    problem.element_terms(e, u, has_terms_ ? &shares : nullptr, true, terms);
    Matrix block = terms.hessian;
    if (convex) block = positive_semidefinite_part(block);
    values = block;
    trace += block.trace();
    std::array<PetscInt, 4> nodes{};
    std::size_t a = 0;
    for (const Index v : system_.rest().nodes(e))
      nodes[a++] = numbers_[static_cast<std::size_t>(v)];
    check(MatSetValuesBlocked(assembled_, 4, nodes.data(), 4, nodes.data(), values.data(),
                              ADD_VALUES),
          "MatSetValuesBlocked");
  }
  check(MatAssemblyBegin(assembled_, MAT_FINAL_ASSEMBLY), "MatAssemblyBegin");
  check(MatAssemblyEnd(assembled_, MAT_FINAL_ASSEMBLY), "MatAssemblyEnd");
  // Rows of fixed coordinates have the mean of the diagonal.
  scale_ = sum_over_parts(&part_, trace) / (3.0 * static_cast<double>(part_.whole.vertices));
  check(MatZeroRowsColumns(assembled_, static_cast<PetscInt>(fixed_rows_.size()),
                           fixed_rows_.data(), scale_, nullptr, nullptr),
        "MatZeroRowsColumns");
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
  check(MatSetNearNullSpace(assembled_, motions), "MatSetNearNullSpace");
  check(MatNullSpaceDestroy(&motions), "MatNullSpaceDestroy");
  check(VecDestroy(&coordinates), "VecDestroy");
  check(KSPSetOperators(solver_, operator_, assembled_), "KSPSetOperators");
  check(KSPSetReusePreconditioner(solver_, PETSC_FALSE), "KSPSetReusePreconditioner");
  has_preconditioner_ = true;
  stiffness_of_preconditioner_ = stiffness_;
}

LinearSystem::Report LinearSystem::solve(const Vector& gradient, double forcing,
                                         Vector& direction) {
  constexpr PetscInt kMost = 2000;
  double* place = nullptr;
  check(VecGetArray(right_, &place), "VecGetArray");
  for (Index i = 0; i < 3 * part_.owned_vertices; ++i) {
    place[i] = is_fixed_[static_cast<std::size_t>(i)] != 0 ? 0.0 : -gradient[i];
  }
  check(VecRestoreArray(right_, &place), "VecRestoreArray");
  check(KSPSetTolerances(solver_, forcing, 1e-300, 1e10, kMost), "KSPSetTolerances");
  check(KSPSolve(solver_, right_, solution_), "KSPSolve");
  check(KSPSetReusePreconditioner(solver_, PETSC_TRUE), "KSPSetReusePreconditioner");
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  check(KSPGetConvergedReason(solver_, &reason), "KSPGetConvergedReason");
  PetscInt iterations = 0;
  check(KSPGetIterationNumber(solver_, &iterations), "KSPGetIterationNumber");
  const double* result = nullptr;
  check(VecGetArrayRead(solution_, &result), "VecGetArrayRead");
  take(result, direction);
  check(VecRestoreArrayRead(solution_, &result), "VecRestoreArrayRead");
  return {reason > 0,
          reason == KSP_DIVERGED_INDEFINITE_MAT || reason == KSP_DIVERGED_INDEFINITE_PC ||
              reason == KSP_DIVERGED_PC_FAILED,
          static_cast<int>(iterations)};
}

// full ← the numbers of the owners at all vertices of the part; 0 at fixed coordinates.
void LinearSystem::take(const double* own, Vector& full) const {
  full.resize(system_.dof_count());
  std::copy_n(own, 3 * part_.owned_vertices, full.data());
  part_.copy_from_owners(full.data(), 3);
  for (Index i = 0; i < full.size(); ++i) {
    if (is_fixed_[static_cast<std::size_t>(i)] != 0) full[i] = 0.0;
  }
}

PetscErrorCode LinearSystem::multiply(Mat matrix, Vec in, Vec out) {
  void* context = nullptr;
  PetscErrorCode code = MatShellGetContext(matrix, &context);
  if (code != 0) return code;
  const double* from = nullptr;
  double* to = nullptr;
  code = VecGetArrayRead(in, &from);
  if (code != 0) return code;
  code = VecGetArrayWrite(out, &to);
  if (code != 0) return code;
  static_cast<LinearSystem*>(context)->multiply(from, to);
  code = VecRestoreArrayWrite(out, &to);
  if (code != 0) return code;
  return VecRestoreArrayRead(in, &from);
}

void LinearSystem::multiply(const double* in, double* out) {
  take(in, full_);
  for (Index v = 0; v < system_.vertex_count(); ++v) {
    for (Index i = 0; i < 3; ++i) {
      records_[static_cast<std::size_t>(kRecord * v + i)] = full_[3 * v + i];
    }
  }
  tangent_.multiply(records_.data());
  for (Index v = 0; v < system_.vertex_count(); ++v) {
    vertex_block(product_, v) = tangent_.record_sum(v).head<3>();
  }
  part_.add_shared(product_.data(), 3);
  product_ += diagonal_.cwiseProduct(full_);
  if (has_terms_) terms_.add_product(full_, product_);
  for (Index i = 0; i < 3 * part_.owned_vertices; ++i) {
    out[i] = is_fixed_[static_cast<std::size_t>(i)] != 0 ? scale_ * in[i] : product_[i];
  }
}

}  // namespace tetraction::petsc
