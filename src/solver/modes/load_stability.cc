#include "load_stability.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/SparseCore>

#include <algorithm>
#include <cmath>
#include <complex>
#include <optional>
#include <utility>
#include <vector>

#include "core/decompositions.h"
#include "core/pseudo_random.h"
#include "lowest_eigenpairs.h"
#include "small_motions.h"
#include "tetraction/dynamics/consistent_mass.h"

namespace tetraction {
namespace {

using Complex = std::complex<double>;
using ComplexVector = Eigen::VectorXcd;

using SparseMatrix = Eigen::SparseMatrix<double>;

// The consistent mass of all vertices, of which the momentum of each coordinate follows.
SparseMatrix consistent_mass(const MechanicalSystem& system) {
  const RestState& rest = system.rest();
  std::vector<Eigen::Triplet<double>> entries;
  for (Index e = 0; e < rest.element_count(); ++e) {
    const Matrix mass = system.density(e) * element_mass_matrix(rest, e);
    const ElementNodes nodes = rest.nodes(e);
    for (std::size_t a = 0; a < nodes.size(); ++a) {
      for (std::size_t b = 0; b < nodes.size(); ++b) {
        entries.emplace_back(static_cast<int>(nodes[a]), static_cast<int>(nodes[b]),
                             mass(static_cast<Index>(a), static_cast<Index>(b)));
      }
    }
  }
  SparseMatrix matrix(system.vertex_count(), system.vertex_count());
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

// S, R, C and M of the body, in the coordinates of S. They need a mass: the lumped one serves for any.
class LoadedBody {
 public:
  LoadedBody(const MechanicalSystem& system, const Vector& q, const NormalModeOptions& options)
      : system_(system),
        stiffness_(system, q, options.time, true, options.load_factor,
                   ScaledStiffness::Mass::kLumped),
        equations_(system, stiffness_, q, options.multipliers),
        inverse_(stiffness_, equations_),
        skew_(system, q, options.time, options.load_factor) {
    if (system.is_dissipative()) damping_.emplace(system, q, options.time);
  }

  Index size() const { return stiffness_.size(); }
  // A = S − σ is positive definite. σ is 0 if S is.
  double sigma() const { return inverse_.sigma(); }
  Vector solve(const Vector& z) const { return inverse_.solve(z); }
  // Whether a stiffness, 1/s², is above what may be round-off.
  bool is_stiff(double value) const {
    constexpr double kKnown = 1e-10;
    return value >= kKnown * std::max(stiffness_.unit(), std::abs(sigma()));
  }
  // The same of y with A y = z.
  bool is_stiff(const Vector& y, const Vector& z) const {
    return is_stiff(y.dot(z) / y.squaredNorm());
  }
  Vector random_force(Index number) const {
    const Index n = size();
    return equations_.project(pseudo_random((number + 1) * n).tail(n));
  }
  Vector skew(const Vector& z) const { return forces(skew_.product(stiffness_.displacements(z))); }
  Vector mass(const Vector& z) const {
    const Vector u = stiffness_.displacements(z);
    if (!system_.rest().is_quadratic()) return forces(system_.momentum_of(u));
    if (mass_.size() == 0) mass_ = consistent_mass(system_);  // the bound needs none
    const Matrix momentum = mass_ * u.reshaped(3, system_.vertex_count()).transpose();
    return forces(momentum.transpose().reshaped());
  }
  bool is_damped() const { return damping_.has_value(); }
  Vector damping(const Vector& z) const {
    return forces(damping_->product(stiffness_.displacements(z)));
  }

 private:
  Vector forces(const Vector& f) const { return equations_.project(stiffness_.scaled(f)); }

  const MechanicalSystem& system_;
  ScaledStiffness stiffness_;
  LinearisedEquations equations_;
  ShiftedInverse inverse_;
  SkewLoadStiffness skew_;
  std::optional<DampingMatrix> damping_;
  mutable SparseMatrix mass_;
};

// A growing space with a basis V, orthonormal in the product xᵀAy.
class SpaceOfMotions {
 public:
  SpaceOfMotions(const LoadedBody& body, Index most)
      : v_(body.size(), most), a_(body.size(), most) {}

  Index count() const { return count_; }
  bool is_full() const { return count_ == v_.cols(); }
  // Adds y with A y = z unless it is in the space already.
  bool add(Vector y, Vector z);
  auto basis() const { return v_.leftCols(count_); }
  auto last() const { return v_.col(count_ - 1); }
  // A V.
  auto image() const { return a_.leftCols(count_); }

 private:
  Matrix v_;
  Matrix a_;
  Index count_ = 0;
};

bool SpaceOfMotions::add(Vector y, Vector z) {
  constexpr double kInside = 1e-20;
  const double before = y.dot(z);
  for (int pass = 0; pass < 2; ++pass) {
    const Vector amounts = image().transpose() * y;
    y -= basis() * amounts;
    z -= image() * amounts;
  }
  const double after = y.dot(z);
  if (!(after > kInside * before)) return false;
  v_.col(count_) = y / std::sqrt(after);
  a_.col(count_) = z / std::sqrt(after);
  ++count_;
  return true;
}

// The motions of the body in a growing space.
class Motions {
 public:
  explicit Motions(const LoadedBody& body, Index most)
      : body_(body),
        space_(body, most),
        stiffness_(most, most),
        mass_(most, most),
        damping_(Matrix::Zero(most, most)) {}

  bool is_full() const { return space_.is_full(); }
  // Adds y with A y = z unless it is in the space already.
  bool add(Vector y, Vector z);
  // M times the last vector that was added.
  const Vector& last_momentum() const { return momentum_; }

  // A motion V c e^(λt) with |c| = 1.
  struct Motion {
    Complex rate;
    ComplexVector amounts;
  };
  // Those that grow by more than this in a radian, and the `count` lowest other vibrations; none if the
  // eigenvalue problem cannot be solved.
  std::vector<Motion> lowest(Index count, double growth) const;
  // (λ²M + λC + S + R) V c.
  ComplexVector residual(const Motion& motion) const;

 private:
  std::vector<Motion> all() const;

  const LoadedBody& body_;
  SpaceOfMotions space_;
  Matrix stiffness_;  // Vᵀ(S + R)V
  Matrix mass_;
  Matrix damping_;
  Vector momentum_;
};

bool grows(Complex rate, double growth) {
  return rate.real() > growth * std::abs(rate);
}

bool Motions::add(Vector y, Vector z) {
  if (!space_.add(std::move(y), std::move(z))) return false;
  const Index n = space_.count();
  const Vector last = space_.last();
  const auto enter = [&](Matrix& matrix, const Vector& image, double sign) {
    const Vector column = space_.basis().transpose() * image;
    matrix.row(n - 1).head(n) = sign * column.transpose();
    matrix.col(n - 1).head(n) = column;
  };
  enter(stiffness_, body_.skew(last), -1.0);
  const Vector identity = Vector::Unit(n, n - 1);
  const Vector symmetric = identity + body_.sigma() * (space_.basis().transpose() * last);
  stiffness_(n - 1, n - 1) = symmetric[n - 1];
  stiffness_.row(n - 1).head(n - 1) += symmetric.head(n - 1).transpose();
  stiffness_.col(n - 1).head(n - 1) += symmetric.head(n - 1);
  momentum_ = body_.mass(last);
  enter(mass_, momentum_, 1.0);
  if (body_.is_damped()) enter(damping_, body_.damping(last), 1.0);
  return true;
}

// With θ = 1/λ: θ² Vᵀ(S + R)V c + θ VᵀCV c + VᵀMV c = 0. The lowest motions have the largest θ. The unit of θ makes
// the blocks of the companion matrix comparable, whatever the unit of time.
std::vector<Motions::Motion> Motions::all() const {
  const Index n = space_.count();
  const Matrix mass = mass_.topLeftCorner(n, n);
  const double unit = std::sqrt(mass.trace());
  const Eigen::PartialPivLU<Matrix> stiffness(stiffness_.topLeftCorner(n, n));
  Matrix companion = Matrix::Zero(2 * n, 2 * n);
  companion.topRightCorner(n, n).setIdentity();
  companion.bottomLeftCorner(n, n) = -stiffness.solve(mass / (unit * unit));
  companion.bottomRightCorner(n, n) = -stiffness.solve(damping_.topLeftCorner(n, n) / unit);
  if (!companion.allFinite()) return {};
  const Eigen::EigenSolver<Matrix> solver(companion);
  if (solver.info() != Eigen::Success) return {};
  std::vector<Motion> motions;
  for (Index k = 0; k < 2 * n; ++k) {
    const Complex theta = solver.eigenvalues()[k];
    // One of two conjugates, and what diverges.
    if (!(theta.imag() < 0.0 || (theta.imag() == 0.0 && theta.real() > 0.0))) continue;
    ComplexVector amounts = solver.eigenvectors().col(k).head(n).normalized();
    Index largest = 0;
    amounts.cwiseAbs().maxCoeff(&largest);
    // Motions without damping become real.
    amounts *= std::conj(amounts[largest]) / std::abs(amounts[largest]);
    motions.push_back({1.0 / (unit * theta), std::move(amounts)});
  }
  return motions;
}

std::vector<Motions::Motion> Motions::lowest(Index count, double growth) const {
  std::vector<Motion> motions = all();
  std::stable_sort(motions.begin(), motions.end(), [&](const Motion& a, const Motion& b) {
    const bool first = grows(a.rate, growth);
    return first != grows(b.rate, growth) ? first : std::abs(a.rate) < std::abs(b.rate);
  });
  const auto unstable = std::count_if(motions.begin(), motions.end(),
                                      [&](const Motion& m) { return grows(m.rate, growth); });
  motions.resize(std::min(motions.size(), static_cast<std::size_t>(unstable + count)));
  return motions;
}

ComplexVector Motions::residual(const Motion& motion) const {
  const Index n = motion.amounts.size();  // more may have come since
  const auto v = space_.basis().leftCols(n);
  const Vector real = v * motion.amounts.real();
  const Vector imaginary = v * motion.amounts.imag();
  const auto times = [&](auto&& product) {
    ComplexVector result(real.size());
    result.real() = product(real);
    result.imag() = product(imaginary);
    return result;
  };
  ComplexVector sum = space_.image().leftCols(n) * motion.amounts;
  sum += times([&](const Vector& z) { return Vector(body_.sigma() * z + body_.skew(z)); });
  sum += motion.rate * motion.rate * times([&](const Vector& z) { return body_.mass(z); });
  if (body_.is_damped()) {
    sum += motion.rate * times([&](const Vector& z) { return body_.damping(z); });
  }
  return sum;
}

// A bound of the probability that ϱ² of all motions is above 1/(1 − ε) times what was found, after k steps for
// the symmetric operation −(S⁻¹R)² from a random vector of n numbers (J. Kuczyński and H. Woźniakowski, SIAM J.
// Matrix Anal. Appl. 13, 1992).
double chance_of_more(double epsilon, Index n, Index k) {
  const auto steps = static_cast<double>(2 * k - 1);
  return 1.648 * std::sqrt(static_cast<double>(n)) * std::exp(-std::sqrt(epsilon) * steps);
}

// Whether no motion can grow by more than `growth` in a radian, by Lanczos iterations for S⁻¹R, which is skew in the
// product xᵀSy. `false`: this is not known.
bool is_bounded(const LoadedBody& body, double growth) {
  constexpr Index kMost = 40;
  constexpr double kUnlikely = 1e-4;
  if (body.sigma() != 0.0) return false;
  const double limit = 4.0 * growth * growth;
  const Index most = std::min(body.size(), kMost);
  SpaceOfMotions space(body, most);
  Matrix skew = Matrix::Zero(most, most);  // VᵀRV
  Vector z = body.random_force(0);
  while (!space.is_full()) {
    const Vector y = body.solve(z);
    if (!body.is_stiff(y, z)) return false;
    if (!space.add(y, z)) return true;
    const Index n = space.count();
    z = body.skew(space.last());
    if (z.isZero(0.0)) return true;
    skew.col(n - 1).head(n - 1) = space.basis().leftCols(n - 1).transpose() * z;
    skew.row(n - 1).head(n - 1) = -skew.col(n - 1).head(n - 1).transpose();
    const Matrix t = skew.topLeftCorner(n, n);
    const double square = symmetric_eigen(Matrix(t.transpose() * t)).values[n - 1];  // ϱ²
    if (!(square < limit)) return false;
    if (n > 1 && chance_of_more(1.0 - square / limit, body.size(), n / 2) < kUnlikely) return true;
  }
  return false;
}

// Adds vectors of the Krylov space of A⁻¹M from a few random vectors, which have all of a multiple eigenvalue.
bool add_low_motions(const LoadedBody& body, Motions& motions) {
  constexpr Index kBlock = 4;
  constexpr int kSteps = 7;
  std::vector<Vector> block;
  for (Index i = 0; i < kBlock; ++i) block.push_back(body.random_force(i));
  for (int step = 0; step < kSteps; ++step) {
    std::vector<Vector> next;
    for (const Vector& z : block) {
      if (motions.is_full()) return true;
      const Vector y = body.solve(z);
      if (!body.is_stiff(y, z)) return false;
      if (motions.add(y, z)) next.push_back(motions.last_momentum());
    }
    block = std::move(next);
  }
  return true;
}

// The motions that grow and the lowest others by Davidson's method; none if they are not found.
std::vector<Motions::Motion> lowest_motions(const LoadedBody& body, Index count, double growth) {
  constexpr double kTolerance = 1e-7;
  constexpr Index kMost = 160;
  Motions motions(body, std::min(body.size(), kMost));
  if (!add_low_motions(body, motions)) return {};
  while (true) {
    std::vector<Motions::Motion> lowest = motions.lowest(count, growth);
    bool grown = false;
    bool settled = true;
    for (const Motions::Motion& motion : lowest) {
      if (!body.is_stiff(std::norm(motion.rate))) return {};
      const ComplexVector residual = motions.residual(motion);
      for (const Vector& z : {Vector(residual.real()), Vector(residual.imag())}) {
        if (z.isZero(0.0)) continue;
        const Vector y = body.solve(z);
        if (!(y.dot(z) > kTolerance * kTolerance)) continue;
        settled = false;
        if (motions.is_full()) return {};
        grown = motions.add(y, z) || grown;
      }
    }
    if (settled) return lowest;
    if (!grown) return {};
  }
}

}  // namespace

LoadStability examine_loads(const MechanicalSystem& system, const Vector& q,
                            const NormalModeOptions& options, double growth) {
  const LoadedBody body(system, q, options);
  LoadStability result;
  result.is_known = result.is_bounded = is_bounded(body, growth);
  if (result.is_bounded) return result;
  const std::vector<Motions::Motion> motions = lowest_motions(body, options.count, growth);
  result.is_known = !motions.empty();
  for (const Motions::Motion& motion : motions) {
    if (!(grows(motion.rate, growth) && motion.rate.real() > result.growth_rate)) continue;
    result.growth_rate = motion.rate.real();
    result.is_flutter = motion.rate.imag() != 0.0;
    result.ratio = motion.rate.real() / std::abs(motion.rate);
  }
  return result;
}

}  // namespace tetraction
