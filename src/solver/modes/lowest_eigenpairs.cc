#include "lowest_eigenpairs.h"

#include <Spectra/SymEigsSolver.h>
#include <Eigen/Cholesky>
#include <Eigen/LU>

#include <algorithm>
#include <optional>

#include "core/decompositions.h"
#include "core/pseudo_random.h"
#include "solver/linear/sparse_cholesky.h"
#include "tetraction/core/error.h"
#include "tetraction/core/interruption.h"

namespace tetraction {
namespace {

// z ↦ s P (S + Q D Qᵀ − σ)⁻¹ P z with the unit s, 1/s², in the space that the equations allow, where P removes the modes that
// are known already. It has the interface that Spectra's solvers expect of an operation.
class InverseOperation {
 public:
  using Scalar = double;

  // The unit should be of the order of the largest ω², since Spectra takes values below 1e-11 for
  // zero.
  InverseOperation(const ScaledStiffness& stiffness, SparseCholesky& cholesky,
                   const LinearisedEquations& equations, double unit)
      : stiffness_(stiffness),
        cholesky_(cholesky),
        equations_(equations),
        unit_(unit),
        known_(equations.q.rows(), 0) {
    const Index n = equations.q.cols();
    if (n == 0) return;
    // x = A⁻¹(b − Q s) with s = D w + H μ and w = Qᵀx = N ν, so that HᵀQᵀx = 0. This gives
    // ((1 + G D) N, G H) (ν, μ) = Qᵀ A⁻¹ b with G = Qᵀ A⁻¹ Q. The unit of G is s², that of the first columns
    // is one: pivots must not be compared between columns.
    response_.resize(equations.q.rows(), n);
    for (Index j = 0; j < n; ++j) response_.col(j) = stiffness.solve(cholesky, equations.q.col(j));
    const Matrix g = equations.q.transpose() * response_;
    Matrix matrix(n, n);
    matrix << (Matrix::Identity(n, n) + g * equations.curvature) * equations.allowed,
        g * equations.h;
    solver_.compute(matrix);
    forces_.resize(n, n);
    forces_ << equations.curvature * equations.allowed, equations.h;
  }

  Index rows() const { return known_.rows(); }
  Index cols() const { return rows(); }
  void perform_op(const double* in, double* out) const {
    Eigen::Map<Vector>(out, rows()) = apply(Eigen::Map<const Vector>(in, rows()));
  }
  Vector apply(const Vector& z) const {
    throw_if_interrupted();
    Vector x = stiffness_.solve(cholesky_, without_known(z));
    if (equations_.q.cols() > 0) {
      const Vector w = equations_.q.transpose() * x;
      x -= response_ * (forces_ * solver_.solve(w));
      x = equations_.project(x);
    }
    return unit_ * without_known(x);
  }
  // Spectra must not see these directions.
  void exclude(const Vector& z) {
    known_.conservativeResize(Eigen::NoChange, known_.cols() + 1);
    known_.rightCols<1>() = z;
  }
  Index excluded() const { return known_.cols(); }
  Vector without_known(Vector z) const {
    for (int pass = 0; pass < 2; ++pass) z -= known_ * (known_.transpose() * z);
    return z;
  }
  Vector start() const { return without_known(equations_.project(pseudo_random(rows()))); }

 private:
  const ScaledStiffness& stiffness_;
  SparseCholesky& cholesky_;
  const LinearisedEquations& equations_;
  double unit_;
  Matrix known_;
  Matrix response_;
  Matrix forces_;
  Eigen::PartialPivLU<Matrix> solver_;
};

// The largest eigenpairs of a small operation, descending.
std::vector<Eigenpair> dense_pairs(const InverseOperation& operation, Index count) {
  const Index n = operation.rows();
  Matrix matrix(n, n);
  for (Index j = 0; j < n; ++j) matrix.col(j) = operation.apply(Vector::Unit(n, j));
  const SymmetricEigen eigen = symmetric_eigen(Matrix(0.5 * (matrix + matrix.transpose())));
  std::vector<Eigenpair> pairs;
  for (Index i = 0; i < count; ++i) {
    pairs.push_back({eigen.values[n - 1 - i], eigen.vectors.col(n - 1 - i)});
  }
  return pairs;
}

std::vector<Eigenpair> lanczos_pairs(InverseOperation& operation, Index count, Index subspace) {
  constexpr Index kRestarts = 1000;
  constexpr double kTolerance = 1e-13;
  Spectra::SymEigsSolver<InverseOperation> solver(operation, count, subspace);
  const Vector start = operation.start();
  solver.init(start.data());
  solver.compute(Spectra::SortRule::LargestAlge, kRestarts, kTolerance);
  if (solver.info() != Spectra::CompInfo::Successful) {
    throw Error(
        "The Lanczos iterations for the modes did not converge. The lowest frequencies may lie too "
        "far below the highest one of the mesh: take fewer elements across a thin body, or a "
        "thicker one.");
  }
  const Vector values = solver.eigenvalues();
  const Matrix vectors = solver.eigenvectors();
  std::vector<Eigenpair> pairs;
  for (Index i = 0; i < values.size(); ++i) {
    pairs.push_back({values[i], operation.without_known(vectors.col(i)).normalized()});
  }
  return pairs;
}

// The `count` largest eigenpairs, descending, of which there are at least so many.
std::vector<Eigenpair> largest_pairs(InverseOperation& operation, Index count, Index available) {
  constexpr Index kDense = 200;
  constexpr Index kSpare = 2;
  constexpr Index kSubspace = 24;
  if (count <= 0) return {};
  const auto subspace = [](Index wanted) { return 2 * wanted + kSubspace; };
  if (operation.rows() <= kDense || 2 * subspace(count + kSpare) >= available) {
    return dense_pairs(operation, count);
  }
  const auto larger = [](const Eigenpair& a, const Eigenpair& b) { return a.value > b.value; };
  std::vector<Eigenpair> pairs;
  // Lanczos iterations from one vector find only one eigenvector of a multiple eigenvalue. They are
  // repeated in the remaining space until all that comes is smaller than what is there.
  for (Index wanted = count + kSpare;; wanted = kSpare) {
    if (wanted + operation.excluded() >= available) break;
    const std::vector<Eigenpair> next = lanczos_pairs(operation, wanted, subspace(wanted));
    const double least = pairs.empty() ? 0.0 : pairs[static_cast<std::size_t>(count - 1)].value;
    for (const Eigenpair& pair : next) operation.exclude(pair.vector);
    pairs.insert(pairs.end(), next.begin(), next.end());
    std::stable_sort(pairs.begin(), pairs.end(), larger);
    if (next.front().value <= least) break;
  }
  pairs.resize(static_cast<std::size_t>(count));
  return pairs;
}

// The `count` lowest eigenvalues ω², ascending, beside the known modes, of which there are at least
// so many.
std::vector<Eigenpair> lowest_pairs(const ScaledStiffness& stiffness,
                                    const LinearisedEquations& equations, const Matrix& known,
                                    SparseCholesky& cholesky, double sigma, Index count,
                                    Index available) {
  InverseOperation operation(stiffness, cholesky, equations, stiffness.unit());
  for (Index j = 0; j < known.cols(); ++j) operation.exclude(known.col(j));
  std::vector<Eigenpair> pairs = largest_pairs(operation, count, available);
  for (Eigenpair& pair : pairs) pair.value = sigma + stiffness.unit() / pair.value;
  return pairs;
}

// Whether S + Q D Qᵀ − σ is positive definite in the space that the equations allow, with the factor
// of S − σ. The least zᵀ(S − σ)z for Qᵀz = w is wᵀG⁻¹w with G = Qᵀ(S − σ)⁻¹Q.
bool is_positive(const ScaledStiffness& stiffness, SparseCholesky& cholesky,
                 const LinearisedEquations& equations) {
  if (equations.curvature.isZero(0.0) || equations.allowed.cols() == 0) return true;
  const Index n = equations.q.cols();
  Matrix g(n, n);
  for (Index j = 0; j < n; ++j) {
    g.col(j) = equations.q.transpose() * stiffness.solve(cholesky, equations.q.col(j));
  }
  const Matrix least = g.llt().solve(Matrix::Identity(n, n)) + equations.curvature;
  const Matrix allowed = equations.allowed.transpose() * least * equations.allowed;
  return allowed.llt().info() == Eigen::Success;
}

// Factorises S − σ with the smallest −σ for which no ω² is below σ. Returns σ.
double factorize_shifted(const ScaledStiffness& stiffness, const LinearisedEquations& equations,
                         SparseCholesky& cholesky) {
  // Iterations tell ω² from each other that are not far below −σ. With equations, modes that they
  // do not allow have an inverse of up to 1/σ, whose round-off must not spoil the others.
  const double smallest = equations.count() > 0 ? 1e-11 : 1e-14;
  constexpr double kLargest = 1e3;
  for (double part = smallest; part <= kLargest; part *= 10.0) {
    const double sigma = -part * stiffness.unit();
    if (cholesky.factorize(stiffness.shifted(sigma)) &&
        is_positive(stiffness, cholesky, equations)) {
      return sigma;
    }
  }
  throw InputError("The modes cannot be computed: the stiffness matrix cannot be factorised.");
}

}  // namespace

class ModeSearch::Implementation {
 public:
  Implementation(const ScaledStiffness& stiffness, const LinearisedEquations& equations,
                 const Matrix& known)
      : stiffness_(stiffness),
        equations_(equations),
        known_(known),
        cholesky_(stiffness.pattern()),
        sigma_(factorize_shifted(stiffness, equations, cholesky_)) {
    if (equations.count() == 0) return;
    // Without the equations the body may have more rigid motions, in which the inverse has the
    // round-off of 1/σ. A σ of the order of the lowest ω² avoids it.
    constexpr Index kFew = 4;
    for (const Eigenpair& pair : lowest(kFew)) {
      if (pair.value < -10.0 * sigma_) continue;
      if (cholesky_.factorize(stiffness.shifted(-pair.value))) sigma_ = -pair.value;
      break;
    }
  }

  std::vector<Eigenpair> lowest(Index count) {
    const Index total = stiffness_.size() - equations_.count();
    return lowest_pairs(stiffness_, equations_, known_, cholesky_, sigma_,
                        std::min(count, total - known_.cols()), total);
  }

  Vector solve(const Vector& r) {
    if (!inverse_) {
      inverse_ = std::make_unique<InverseOperation>(stiffness_, cholesky_, equations_, 1.0);
    }
    return inverse_->apply(equations_.project(r));
  }

 private:
  const ScaledStiffness& stiffness_;
  const LinearisedEquations& equations_;
  const Matrix& known_;
  SparseCholesky cholesky_;
  double sigma_;
  std::unique_ptr<InverseOperation> inverse_;  // made when first needed
};

ModeSearch::ModeSearch(const ScaledStiffness& stiffness, const LinearisedEquations& equations,
                       const Matrix& known)
    : implementation_(std::make_unique<Implementation>(stiffness, equations, known)) {}

ModeSearch::~ModeSearch() = default;

std::vector<Eigenpair> ModeSearch::lowest(Index count) {
  return implementation_->lowest(count);
}

Vector ModeSearch::solve(const Vector& r) const {
  return implementation_->solve(r);
}

class ShiftedInverse::Implementation {
 public:
  Implementation(const ScaledStiffness& stiffness, const LinearisedEquations& equations)
      : equations_(equations), cholesky_(stiffness.pattern()) {
    if (!cholesky_.factorize(stiffness.shifted(0.0)) ||
        !is_positive(stiffness, cholesky_, equations)) {
      sigma_ = factorize_shifted(stiffness, equations, cholesky_);
    }
    inverse_.emplace(stiffness, cholesky_, equations, 1.0);
  }

  double sigma() const { return sigma_; }
  Vector solve(const Vector& r) const { return inverse_->apply(equations_.project(r)); }

 private:
  const LinearisedEquations& equations_;
  SparseCholesky cholesky_;
  double sigma_ = 0.0;
  std::optional<InverseOperation> inverse_;
};

ShiftedInverse::ShiftedInverse(const ScaledStiffness& stiffness,
                               const LinearisedEquations& equations)
    : implementation_(std::make_unique<Implementation>(stiffness, equations)) {}

ShiftedInverse::~ShiftedInverse() = default;

double ShiftedInverse::sigma() const {
  return implementation_->sigma();
}

Vector ShiftedInverse::solve(const Vector& r) const {
  return implementation_->solve(r);
}

}  // namespace tetraction
