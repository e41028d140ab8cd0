#include "tetraction/solver/normal_modes.h"

#include <Spectra/SymEigsSolver.h>
#include <fmt/format.h>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/QR>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/decompositions.h"
#include "core/pseudo_random.h"
#include "fem/connected_parts.h"
#include "sparse_cholesky.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

constexpr double kRoundOff = std::numeric_limits<double>::epsilon();
// ω² below this part of the largest diagonal entry of M^(−½)KM^(−½) cannot be told from zero.
constexpr double kZero = 64.0 * kRoundOff;

// An orthonormal basis of the columns' span. Columns below `tolerance`, relative to the largest one,
// count as dependent.
Matrix orthonormal_basis(const Matrix& columns, double tolerance) {
  if (columns.cols() == 0 || columns.isZero(0.0)) return Matrix(columns.rows(), 0);
  Eigen::ColPivHouseholderQR<Matrix> qr;
  qr.setThreshold(tolerance);
  qr.compute(columns);
  return qr.householderQ() * Matrix::Identity(columns.rows(), qr.rank());
}

// An orthonormal basis of the coefficients c with |columns c| ≤ limit |c|.
Matrix null_space(const Matrix& columns, double limit) {
  const Index n = columns.cols();
  if (n == 0) return Matrix(0, 0);
  const Eigen::HouseholderQR<Matrix> qr(columns);
  const Index rows = std::min(n, columns.rows());
  const Matrix r = qr.matrixQR().topRows(rows).triangularView<Eigen::Upper>();
  // All right singular vectors, as the left ones of the transpose.
  const Matrix v = singular_vectors(r.transpose()).u;
  Matrix null(n, 0);
  for (Index j = 0; j < n; ++j) {
    if ((r * v.col(j)).norm() > limit) continue;
    null.conservativeResize(Eigen::NoChange, null.cols() + 1);
    null.rightCols<1>() = v.col(j);
  }
  return null;
}

// Another orthonormal basis of the same span, along the axes as far as possible.
Matrix along_axes(const Matrix& basis) {
  Matrix left = basis * basis.transpose();
  Matrix aligned(basis.rows(), basis.cols());
  for (Index j = 0; j < basis.cols(); ++j) {
    Index longest = 0;
    for (Index i = 1; i < left.cols(); ++i) {
      if (left.col(i).norm() > 1.001 * left.col(longest).norm()) longest = i;
    }
    aligned.col(j) = left.col(longest).normalized();
    left -= aligned.col(j) * (aligned.col(j).transpose() * left);
  }
  return aligned;
}

// The rigid motions of every part: three translations and three rotations about its centre of mass.
struct RigidMotions {
  Matrix fields;     // 3n × 6 parts, orthonormal with respect to the mass
  Matrix rotations;  // 3 × 6 parts: the angular velocities
};

RigidMotions rigid_motions(const MechanicalSystem& system, const Vector& q,
                           const std::vector<std::vector<Index>>& parts) {
  const Vector& mass = system.mass();
  const auto count = static_cast<Index>(parts.size());
  RigidMotions motions{Matrix::Zero(q.size(), 6 * count), Matrix::Zero(3, 6 * count)};
  for (Index k = 0; k < count; ++k) {
    const std::vector<Index>& vertices = parts[static_cast<std::size_t>(k)];
    double total = 0.0;
    Vector3 center = Vector3::Zero();
    for (const Index v : vertices) {
      total += mass[v];
      center += mass[v] * vertex_block(q, v);
    }
    center /= total;
    Matrix3 inertia = Matrix3::Zero();
    for (const Index v : vertices) {
      const Vector3 arm = vertex_block(q, v) - center;
      inertia += mass[v] * (arm.squaredNorm() * Matrix3::Identity() - arm * arm.transpose());
    }
    // Fields of the angular velocities U⁻¹ with inertia = UᵀU are orthonormal.
    const Matrix3 upper = inertia.llt().matrixU();
    const Matrix3 rates = upper.triangularView<Eigen::Upper>().solve(Matrix3::Identity());
    motions.rotations.middleCols<3>(6 * k + 3) = rates;
    for (const Index v : vertices) {
      const Vector3 arm = vertex_block(q, v) - center;
      for (int i = 0; i < 3; ++i) {
        motions.fields(3 * v + i, 6 * k + i) = 1.0 / std::sqrt(total);
        motions.fields.block<3, 1>(3 * v, 6 * k + 3 + i) = rates.col(i).cross(arm);
      }
    }
  }
  return motions;
}

// The matrix S = m^(−½) TᵀKT m^(−½) with m = TᵀMT, without the curvature of the equations.
class ScaledStiffness {
 public:
  ScaledStiffness(const MechanicalSystem& system, const Vector& q, double time, bool with_loads)
      : coordinates_(system.coordinates()),
        inverse_root_mass_(coordinates_.reduced_mass(system.mass()).cwiseSqrt().cwiseInverse()) {
    const ForcePoint at = system.force_point(q, time);
    terms_.reset(system.vertex_count());
    for (const ForceTerm* term : system.force_terms()) {
      if (!term->has_potential() || term->uniform_acceleration()) continue;
      if (term->account() == EnergyAccount::kExternalWork && !with_loads) continue;
      term->add_hessian(at, HessianForm::kExact, terms_);
    }
    std::vector<std::pair<Index, Index>> pairs;
    for (const HessianBlocks::Pair& pair : terms_.pairs())
      pairs.emplace_back(pair.row, pair.column);
    std::sort(pairs.begin(), pairs.end());
    pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
    pattern_ = std::make_unique<SparsityPattern>(system.rest(), coordinates_, pairs);
    values_.assign(static_cast<std::size_t>(pattern_->nonzeros()), 0.0);
    const EvaluationStatus status = system.elastic().add_hessian(q, *pattern_, values_.data());
    if (!status.ok()) {
      throw InputError(fmt::format(
          "The modes cannot be computed: the elastic energy of element {} is not defined.",
          system.mesh().tetrahedron_id(status.failed_element)));
    }
    pattern_->add_vertex_blocks(terms_.diagonal(), values_.data());
    for (const HessianBlocks::Pair& pair : terms_.pairs()) {
      pattern_->add_pair_block(pair.row, pair.column, pair.block, values_.data());
    }
    for_each_entry([&](std::size_t k, Index i, Index j) {
      values_[k] *= inverse_root_mass_[i] * inverse_root_mass_[j];
      if (i == j) largest_ = std::max(largest_, std::abs(values_[k]));
    });
    if (!std::all_of(values_.begin(), values_.end(), [](double x) { return std::isfinite(x); })) {
      throw InputError(
          "The modes cannot be computed, as the stiffness over the mass overflows: choose other "
          "units, or moduli, density and penalties that are less far apart in size.");
    }
  }

  Index size() const { return pattern_->size(); }
  const SparsityPattern& pattern() const { return *pattern_; }
  /// The largest entry on the diagonal, 1/s².
  double largest() const { return largest_; }
  /// The same, or 1 if there is no stiffness.
  double unit() const { return largest_ > 0.0 ? largest_ : 1.0; }
  /// The entries of S − σ in the pattern's order.
  std::vector<double> shifted(double sigma) const {
    std::vector<double> values = values_;
    for_each_entry([&](std::size_t k, Index i, Index j) {
      if (i == j) values[k] -= sigma;
    });
    return values;
  }
  /// m^(−½) Tᵀ f: forces in the coordinates of S.
  Vector scaled(const Vector& forces) const {
    return inverse_root_mass_.cwiseProduct(coordinates_.restrict(forces));
  }
  /// m^(−½) y for every column.
  Matrix scaled_columns(const Matrix& columns) const {
    return inverse_root_mass_.asDiagonal() * columns;
  }
  /// The displacements of all vertices for a vector in the coordinates of S.
  Vector displacements(const Vector& z) const {
    return coordinates_.extend(inverse_root_mass_.cwiseProduct(z));
  }
  /// The product of the Hessians of all force terms with displacements, N.
  Vector terms_product(const Vector& displacements) const {
    Vector product = Vector::Zero(displacements.size());
    terms_.add_product(displacements, product);
    return product;
  }

 private:
  template <class Visit>
  void for_each_entry(const Visit& visit) const {
    const std::vector<int>& begin = pattern_->column_begin();
    for (Index j = 0; j < pattern_->size(); ++j) {
      const auto end = static_cast<std::size_t>(begin[static_cast<std::size_t>(j) + 1]);
      for (auto k = static_cast<std::size_t>(begin[static_cast<std::size_t>(j)]); k < end; ++k) {
        visit(k, Index{pattern_->rows()[k]}, j);
      }
    }
  }

  const FreeCoordinates& coordinates_;
  Vector inverse_root_mass_;
  HessianBlocks terms_;
  std::unique_ptr<SparsityPattern> pattern_;
  std::vector<double> values_;
  double largest_ = 0.0;
};

// The linearised equations of constraints, in the coordinates of S. Motions z satisfy HᵀQᵀz = 0, and
// S has the further part Q D Qᵀ.
struct LinearisedEquations {
  Matrix q;          // orthonormal basis of the coordinates that the equations depend on
  Matrix h;          // orthonormal basis of the gradients, in terms of q
  Matrix allowed;    // orthonormal complement of h
  Matrix curvature;  // D

  LinearisedEquations(const MechanicalSystem& system, const ScaledStiffness& stiffness,
                      const Vector& position, const Vector& multipliers)
      : q(stiffness.size(), 0), h(0, 0), allowed(0, 0), curvature(0, 0) {
    const Constraints& constraints = system.constraints();
    if (!constraints.has_equations()) return;
    constexpr double kDependent = 1e-11;
    const Matrix selector = stiffness.scaled_columns(constraints.selector());
    // Columns of the same length, because constraints may differ much in mass.
    Vector length = selector.colwise().norm().transpose();
    length = (length.array() > 0.0).select(length, 1.0);
    q = orthonormal_basis(selector * length.cwiseInverse().asDiagonal(), kDependent);
    const Matrix reduced = q.transpose() * selector;
    Matrix gradients = reduced * constraints.gradients(constraints.configuration(position));
    for (Index j = 0; j < gradients.cols(); ++j) gradients.col(j).stableNormalize();
    h = orthonormal_basis(gradients, kDependent);
    allowed = Matrix(q.cols(), q.cols() - h.cols());
    if (allowed.cols() > 0) {
      const Matrix complement = Matrix::Identity(q.cols(), q.cols()) - Matrix(h * h.transpose());
      allowed = orthonormal_basis(complement, 1e-8);
    }
    curvature = Matrix::Zero(q.cols(), q.cols());
    if (multipliers.size() > 0) {
      curvature = reduced * constraints.curvature(multipliers) * reduced.transpose();
    }
  }

  Index count() const { return h.cols(); }
  // The part of z that the equations allow.
  Vector project(const Vector& z) const {
    if (count() == 0) return z;
    return z - q * (h * (h.transpose() * (q.transpose() * z)));
  }
};

// z ↦ s P (S + Q D Qᵀ − σ)⁻¹ P z with the unit s, 1/s², in the space that the equations allow, where P removes the modes that
// are known already. It has the interface that Spectra's solvers expect of an operation.
class InverseOperation {
 public:
  using Scalar = double;

  // The unit should be of the order of the largest ω², since Spectra takes values below 1e-11 for
  // zero.
  InverseOperation(SparseCholesky& cholesky, const LinearisedEquations& equations, double unit)
      : cholesky_(cholesky), equations_(equations), unit_(unit), known_(equations.q.rows(), 0) {
    const Index n = equations.q.cols();
    if (n == 0) return;
    // x = A⁻¹(b − Q s) with s = D w + H μ and w = Qᵀx = N ν, so that HᵀQᵀx = 0. This gives
    // ((1 + G D) N, G H) (ν, μ) = Qᵀ A⁻¹ b with G = Qᵀ A⁻¹ Q.
    response_.resize(equations.q.rows(), n);
    for (Index j = 0; j < n; ++j) response_.col(j) = cholesky.solve(equations.q.col(j));
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
    Vector x = cholesky_.solve(without_known(z));
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
  SparseCholesky& cholesky_;
  const LinearisedEquations& equations_;
  double unit_;
  Matrix known_;
  Matrix response_;
  Matrix forces_;
  Eigen::FullPivLU<Matrix> solver_;
};

struct Eigenpair {
  double value = 0.0;
  Vector vector;
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
    throw Error("The Lanczos iterations for the modes did not converge.");
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

// Rigid motions that the constraints allow and that meet no stiffness, in the coordinates of S,
// orthonormal.
Matrix free_rigid_motions(const MechanicalSystem& system, const Vector& q,
                          const ScaledStiffness& stiffness, const LinearisedEquations& equations) {
  constexpr double kAllowed = 1e-11;
  constexpr std::size_t kMostParts = 32;
  const std::vector<std::vector<Index>> parts = connected_parts(system.rest());
  if (parts.size() > kMostParts) {
    throw InputError(fmt::format(
        "The mesh consists of {} parts that do not touch each other; modes are computed for up to "
        "{} of them. Take them one at a time.",
        parts.size(), kMostParts));
  }
  const RigidMotions motions = rigid_motions(system, q, parts);
  // What the constraints keep from moving, weighted by the mass.
  Matrix z(stiffness.size(), motions.fields.cols());
  Matrix missing(motions.fields.rows() + equations.count(), motions.fields.cols());
  for (Index j = 0; j < motions.fields.cols(); ++j) {
    z.col(j) = stiffness.scaled(system.momentum_of(motions.fields.col(j)));
    Vector rest = motions.fields.col(j) - stiffness.displacements(z.col(j));
    for (Index i = 0; i < rest.size(); ++i) rest[i] *= std::sqrt(system.mass()[i / 3]);
    missing.col(j).head(rest.size()) = rest;
    missing.col(j).tail(equations.count()) =
        equations.h.transpose() * (equations.q.transpose() * z.col(j));
  }
  const Matrix allowed = null_space(missing, kAllowed);
  // K times a rotation ω × (q − c) is ω × f with the elastic forces f = ∇W(q), because W does not
  // change in a rotation. This has much less round-off than a product with K.
  double energy = 0.0;
  Vector force;
  system.elastic().value_and_gradient(q, energy, force);
  Matrix resistance(stiffness.size(), allowed.cols());
  for (Index j = 0; j < allowed.cols(); ++j) {
    const Vector field = motions.fields * allowed.col(j);
    Vector product = stiffness.terms_product(field);
    for (std::size_t k = 0; k < parts.size(); ++k) {
      const Index first = 6 * static_cast<Index>(k);
      const Vector3 rotation =
          motions.rotations.middleCols<6>(first) * allowed.col(j).segment<6>(first);
      for (const Index v : parts[k]) {
        vertex_block(product, v) += rotation.cross(Vector3(vertex_block(std::as_const(force), v)));
      }
    }
    Vector scaled = stiffness.scaled(product);
    if (equations.count() > 0) {
      scaled +=
          equations.q * (equations.curvature * (equations.q.transpose() * (z * allowed.col(j))));
    }
    resistance.col(j) = equations.project(scaled);
  }
  const Matrix coefficients =
      along_axes(allowed * null_space(resistance, kZero * stiffness.largest()));
  return z * coefficients;
}

// The `count` lowest eigenvalues ω², ascending, beside the known modes, of which there are at least
// so many.
std::vector<Eigenpair> lowest_pairs(const ScaledStiffness& stiffness,
                                    const LinearisedEquations& equations, const Matrix& known,
                                    SparseCholesky& cholesky, double sigma, Index count,
                                    Index available) {
  InverseOperation operation(cholesky, equations, stiffness.unit());
  for (Index j = 0; j < known.cols(); ++j) operation.exclude(known.col(j));
  std::vector<Eigenpair> pairs = largest_pairs(operation, count, available);
  for (Eigenpair& pair : pairs) pair.value = sigma + stiffness.unit() / pair.value;
  return pairs;
}

// Whether S + Q D Qᵀ − σ is positive definite in the space that the equations allow, with the factor
// of S − σ. The least zᵀ(S − σ)z for Qᵀz = w is wᵀG⁻¹w with G = Qᵀ(S − σ)⁻¹Q.
bool is_positive(SparseCholesky& cholesky, const LinearisedEquations& equations) {
  if (equations.curvature.isZero(0.0) || equations.allowed.cols() == 0) return true;
  const Index n = equations.q.cols();
  Matrix g(n, n);
  for (Index j = 0; j < n; ++j) {
    g.col(j) = equations.q.transpose() * cholesky.solve(equations.q.col(j));
  }
  const Matrix least = g.llt().solve(Matrix::Identity(n, n)) + equations.curvature;
  const Matrix allowed = equations.allowed.transpose() * least * equations.allowed;
  return allowed.llt().info() == Eigen::Success;
}

// Factorises S − σ with the smallest −σ for which no ω² is below σ. Returns σ.
double factorize_shifted(const ScaledStiffness& stiffness, const LinearisedEquations& equations,
                         SparseCholesky& cholesky) {
  constexpr double kSmallest = 1e-11;
  constexpr double kLargest = 1e3;
  for (double part = kSmallest; part <= kLargest; part *= 10.0) {
    const double sigma = -part * stiffness.unit();
    if (cholesky.factorize(stiffness.shifted(sigma)) && is_positive(cholesky, equations)) {
      return sigma;
    }
  }
  throw InputError("The modes cannot be computed: the stiffness matrix cannot be factorised.");
}

NormalMode make_mode(const MechanicalSystem& system, const ScaledStiffness& stiffness,
                     double omega_squared, const Vector& z) {
  NormalMode mode;
  const double zero = kZero * stiffness.largest();
  mode.kind = omega_squared > zero    ? ModeKind::kElastic
              : omega_squared < -zero ? ModeKind::kUnstable
                                      : ModeKind::kRigid;
  mode.omega_squared = mode.kind == ModeKind::kRigid ? 0.0 : omega_squared;
  mode.shape = stiffness.displacements(z);
  Index largest = 0;
  mode.shape.cwiseAbs().maxCoeff(&largest);
  if (mode.shape[largest] < 0.0) mode.shape = -mode.shape;
  const Vector momentum = system.momentum_of(mode.shape);
  mode.effective_mass = momentum.reshaped(3, system.vertex_count()).rowwise().sum().cwiseAbs2();
  return mode;
}

}  // namespace

const char* to_string(ModeKind kind) {
  switch (kind) {
    case ModeKind::kRigid:
      return "rigid";
    case ModeKind::kElastic:
      return "elastic";
    case ModeKind::kUnstable:
      break;
  }
  return "unstable";
}

double NormalMode::frequency() const {
  return std::sqrt(std::abs(omega_squared)) / (2.0 * std::numbers::pi);
}

Vector balancing_multipliers(const MechanicalSystem& system, const Vector& q, const Vector& load,
                             double time) {
  const Constraints& constraints = system.constraints();
  if (!constraints.has_equations()) return {};
  double energy = 0.0;
  Vector force;
  if (!system.elastic().value_and_gradient(q, energy, force).ok()) {
    throw InputError("The multipliers cannot be computed: the elastic energy is not defined.");
  }
  for (const ForceTerm* term : system.force_terms()) {
    if (!term->has_potential() || term->account() == EnergyAccount::kExternalWork) continue;
    term->add_gradient(system.force_point(q, time), force);
  }
  force -= load;
  const Matrix gradients =
      constraints.selector() * constraints.gradients(constraints.configuration(q));
  return -Eigen::CompleteOrthogonalDecomposition<Matrix>(gradients).solve(
      system.coordinates().restrict(force));
}

NormalModes normal_modes(const MechanicalSystem& system, const Vector& q,
                         const NormalModeOptions& options) {
  if (options.count < 1) throw InputError("The number of modes must be 1 or more.");
  if (system.coordinates().count() == 0) {
    throw InputError("The body has no modes, because every vertex is held.");
  }
  Index vertex = -1;
  if (const ForceTerm* term = system.undefined_term(q, options.time, vertex); term != nullptr) {
    throw InputError(fmt::format(
        "The modes cannot be computed: the potential of the force term \"{}\" is not defined.",
        term->name()));
  }
  const ScaledStiffness stiffness(system, q, options.time, options.with_loads);
  const LinearisedEquations equations(system, stiffness, q, options.multipliers);
  const Matrix rigid = free_rigid_motions(system, q, stiffness, equations);

  NormalModes result;
  result.total = stiffness.size() - equations.count();
  for (int d = 0; d < 3; ++d) {
    Vector unit = Vector::Zero(system.dof_count());
    for (Index v = 0; v < system.vertex_count(); ++v) unit[3 * v + d] = 1.0;
    result.moved_mass[d] =
        equations.project(stiffness.scaled(system.momentum_of(unit))).squaredNorm();
  }
  for (Index j = 0; j < rigid.cols(); ++j) {
    result.modes.push_back(make_mode(system, stiffness, 0.0, rigid.col(j)));
  }
  const Index others = result.total - rigid.cols();
  if (others > 0) {
    SparseCholesky cholesky(stiffness.pattern());
    double sigma = factorize_shifted(stiffness, equations, cholesky);
    // There may be unstable modes, which come before the rigid ones.
    const auto find = [&](Index count) {
      return lowest_pairs(stiffness, equations, rigid, cholesky, sigma, std::min(count, others),
                          result.total);
    };
    if (equations.count() > 0) {
      // Without the equations the body may have more rigid motions, in which the inverse has the
      // round-off of 1/σ. A σ of the order of the lowest ω² avoids it.
      constexpr Index kFew = 4;
      for (const Eigenpair& pair : find(kFew)) {
        if (pair.value < -10.0 * sigma) continue;
        if (cholesky.factorize(stiffness.shifted(-pair.value))) sigma = -pair.value;
        break;
      }
    }
    for (const Eigenpair& pair : find(options.count)) {
      result.modes.push_back(make_mode(system, stiffness, pair.value, pair.vector));
    }
  }
  std::stable_sort(
      result.modes.begin(), result.modes.end(),
      [](const NormalMode& a, const NormalMode& b) { return a.omega_squared < b.omega_squared; });
  if (static_cast<Index>(result.modes.size()) > options.count) {
    result.modes.resize(static_cast<std::size_t>(options.count));
  }
  return result;
}

}  // namespace tetraction
