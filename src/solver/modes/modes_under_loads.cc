#include "modes_under_loads.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>

#include "unsymmetric_modes.h"

namespace tetraction {
namespace {

// A mode of a complex ω², if it is one, has the frequency and the rate of growth of e^(iωt).
NormalMode make_complex_mode(const MechanicalSystem& system, const ScaledStiffness& stiffness,
                             const RoundOff& round_off, std::complex<double> omega_squared,
                             const Vector& z) {
  // Two equal frequencies may become conjugates by round-off.
  constexpr double kReal = 1e-6;
  NormalMode mode = make_mode(system, stiffness, round_off, omega_squared.real(), z.normalized());
  if (std::abs(omega_squared.imag()) <= kReal * std::abs(omega_squared)) return mode;
  const std::complex<double> omega = std::sqrt(omega_squared);
  mode.kind = ModeKind::kFlutter;
  mode.omega_squared = omega.real() * omega.real();
  mode.growth_rate = std::abs(omega.imag());
  return mode;
}

// Eigenvectors of a matrix and of its transpose, ψᵢᵀφⱼ = δᵢⱼ, for numbers of modes in ascending order.
struct BothEigenvectors {
  std::vector<std::size_t> modes;
  Eigen::VectorXcd values;
  Eigen::MatrixXcd right;
  Eigen::MatrixXcd left;
};

// Finds the left eigenvectors of the modes that are not rigid. There are fewer modes if the last ones have
// no partner, because their multiple eigenvalue was cut.
BothEigenvectors find_left(const std::vector<ComplexEigenpair>& pairs,
                           const std::vector<NormalMode>& modes,
                           const std::vector<ComplexEigenpair>& transposed) {
  constexpr double kSame = 1e-4;
  constexpr double kRegular = 1e-9;
  BothEigenvectors both;
  std::vector<std::size_t> partners;
  std::vector<bool> taken(transposed.size());
  for (std::size_t j = 0; j < pairs.size(); ++j) {
    if (modes[j].kind == ModeKind::kRigid) continue;
    std::size_t best = transposed.size();
    double least = kSame * std::abs(pairs[j].value);
    for (std::size_t k = 0; k < transposed.size(); ++k) {
      const double distance = std::abs(transposed[k].value - pairs[j].value);
      if (taken[k] || !(distance <= least)) continue;
      least = distance;
      best = k;
    }
    if (best == transposed.size()) continue;
    taken[best] = true;
    both.modes.push_back(j);
    partners.push_back(best);
  }
  for (auto count = static_cast<Index>(partners.size()); count > 0; --count) {
    both.modes.resize(static_cast<std::size_t>(count));
    both.values.resize(count);
    both.right.resize(pairs.front().vector.size(), count);
    both.left.resize(both.right.rows(), count);
    for (Index i = 0; i < count; ++i) {
      const ComplexEigenpair& pair = pairs[both.modes[static_cast<std::size_t>(i)]];
      both.values[i] = pair.value;
      both.right.col(i) = pair.vector;
      both.left.col(i) = transposed[partners[static_cast<std::size_t>(i)]].vector;
    }
    const Eigen::MatrixXcd products = both.left.transpose() * both.right;
    const Eigen::PartialPivLU<Eigen::MatrixXcd> lu(products);
    if (!(lu.rcond() > kRegular)) continue;
    both.left = both.left * lu.inverse().transpose();
    return both;
  }
  return {};
}

// The damped motions Σ cⱼ φⱼ e^(λt) are those of formula (34) of docs/theory.md. Each mode has the one that
// consists of it more than of any other mode.
void enter_damping(const DampingMatrix& damping, const ScaledStiffness& stiffness,
                   const BothEigenvectors& both, std::vector<NormalMode>& modes) {
  constexpr double kRoundOffOfRate = 1e-9;  // of |λ|
  const Index count = both.values.size();
  Eigen::MatrixXcd images(both.right.rows(), count);
  const auto image = [&](const Vector& z) {
    return stiffness.scaled(damping.product(stiffness.displacements(z)));
  };
  for (Index j = 0; j < count; ++j) {
    images.col(j).real() = image(both.right.col(j).real());
    images.col(j).imag() = image(both.right.col(j).imag());
  }
  const Eigen::MatrixXcd reduced = both.left.transpose() * images;
  // With c = E⁻¹ x and λ c = y the diagonal matrix E of the √|ω²| makes the two halves of the matrix
  // [0 E; −Ω² E⁻¹ −ΨᵀCΦ] comparable, whatever the unit of time.
  Vector scale = both.values.cwiseAbs().cwiseSqrt();
  const double unit = scale.maxCoeff() > 0.0 ? scale.maxCoeff() : 1.0;
  scale = (scale / unit).cwiseMax(kEpsilon);
  Eigen::MatrixXcd matrix = Eigen::MatrixXcd::Zero(2 * count, 2 * count);
  matrix.topRightCorner(count, count).diagonal() = scale.cast<std::complex<double>>();
  matrix.bottomLeftCorner(count, count).diagonal() =
      -(both.values / (unit * unit)).cwiseQuotient(scale.cast<std::complex<double>>());
  matrix.bottomRightCorner(count, count) = -reduced / unit;
  const Eigen::ComplexEigenSolver<Eigen::MatrixXcd> solver(matrix);
  struct Match {
    double part;
    Index eigenvalue;
    Index mode;
  };
  std::vector<Match> matches;
  for (Index k = 0; k < 2 * count; ++k) {
    if (!(solver.eigenvalues()[k].imag() > 0.0)) continue;
    const Eigen::VectorXcd amounts = solver.eigenvectors().col(k).tail(count).normalized();
    for (Index j = 0; j < count; ++j) matches.push_back({std::abs(amounts[j]), k, j});
  }
  std::stable_sort(matches.begin(), matches.end(),
                   [](const Match& a, const Match& b) { return a.part > b.part; });
  std::vector<bool> is_taken(static_cast<std::size_t>(2 * count));
  std::vector<bool> is_done(static_cast<std::size_t>(count));
  for (const Match& match : matches) {
    const auto j = static_cast<std::size_t>(match.mode);
    if (is_done[j] || is_taken[static_cast<std::size_t>(match.eigenvalue)]) continue;
    is_done[j] = is_taken[static_cast<std::size_t>(match.eigenvalue)] = true;
    NormalMode& mode = modes[both.modes[j]];
    if (!is_vibration(mode.kind)) continue;
    const std::complex<double> lambda = unit * solver.eigenvalues()[match.eigenvalue];
    const bool grows = lambda.real() > kRoundOffOfRate * std::abs(lambda);
    mode.damping_ratio = -lambda.real() / std::abs(lambda);
    mode.kind = grows ? ModeKind::kFlutter : ModeKind::kElastic;
    mode.growth_rate = grows ? lambda.real() : 0.0;
  }
}

}  // namespace

std::vector<NormalMode> modes_under_loads(const MechanicalSystem& system, const Vector& q,
                                          const NormalModeOptions& options,
                                          const ScaledStiffness& stiffness,
                                          const LinearisedEquations& equations,
                                          const RoundOff& round_off, const ModeSearch& search,
                                          const Matrix& start, Index rigid, const Matrix& units,
                                          Index count) {
  constexpr double kSame = 0.5;
  const SkewLoadStiffness skew(system, q, options.time, options.load_factor);
  // The transposed matrix has the opposite skew part.
  const auto find = [&](double sign) {
    return lowest_unsymmetric(
        [&](const Vector& z) {
          const Vector forces = stiffness.product(z) + equations.curvature_product(z) +
                                sign * stiffness.scaled(skew.product(stiffness.displacements(z)));
          return equations.project(forces);
        },
        [&](const Vector& r) { return search.solve(r); }, start, count);
  };
  std::vector<NormalMode> modes;
  const std::vector<ComplexEigenpair> pairs = find(1.0);
  for (const ComplexEigenpair& pair : pairs) {
    // The two conjugates have the same plane of motion: one gives the first of its axes, the other
    // one the second.
    const bool second = pair.value.imag() < 0.0;
    const Vector z = second ? Vector(pair.vector.imag()) : Vector(pair.vector.real());
    const bool is_rigid = (start.leftCols(rigid).transpose() * pair.vector).squaredNorm() > kSame;
    modes.push_back(is_rigid ? make_rigid_mode(system, stiffness, z.normalized())
                             : make_complex_mode(system, stiffness, round_off, pair.value, z));
  }
  const BothEigenvectors both = find_left(pairs, modes, find(-1.0));
  for (std::size_t i = 0; i < both.modes.size(); ++i) {
    const auto j = static_cast<Index>(i);
    for (Index d = 0; d < 3; ++d) {
      const Eigen::VectorXcd unit = units.col(d).cast<std::complex<double>>();
      const std::complex<double> product =
          both.left.col(j).cwiseProduct(unit).sum() * both.right.col(j).cwiseProduct(unit).sum();
      modes[both.modes[i]].effective_mass[d] = product.real();
    }
  }
  if (!system.is_dissipative()) return modes;
  const DampingMatrix damping(system, q, options.time);
  for (NormalMode& mode : modes) enter_damping(damping, mode);
  if (!both.modes.empty()) enter_damping(damping, stiffness, both, modes);
  return modes;
}

}  // namespace tetraction
