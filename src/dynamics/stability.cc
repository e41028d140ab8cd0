#include "tetraction/dynamics/stability.h"

#include <Spectra/SymEigsSolver.h>
#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <limits>

namespace tetraction {
namespace {

// y = M^(−½) K M^(−½) x over the free DOFs: symmetric, same eigenvalues as M⁻¹K.
class ScaledStiffness {
 public:
  using Scalar = double;

  ScaledStiffness(const MechanicalSystem& system, const Vector& q)
      : system_(system), q_(q), inverse_root_mass_(system.constraints().free_count()) {
    const DofConstraints& constraints = system.constraints();
    for (Index i = 0; i < constraints.dof_count(); ++i) {
      if (!constraints.is_fixed(i)) {
        inverse_root_mass_[constraints.reduced(i)] = 1.0 / std::sqrt(system.mass()[i / 3]);
      }
    }
  }

  Index rows() const { return inverse_root_mass_.size(); }
  Index cols() const { return rows(); }

  void perform_op(const double* in, double* out) const {
    const Eigen::Map<const Vector> x(in, rows());
    system_.elastic().product(
        q_, system_.constraints().extend_by_zero(inverse_root_mass_.cwiseProduct(x)), product_);
    Eigen::Map<Vector>(out, rows()) =
        inverse_root_mass_.cwiseProduct(system_.constraints().restrict_to_free(product_));
  }

  Vector displacement(const Vector& eigenvector) const {
    return system_.constraints().extend_by_zero(inverse_root_mass_.cwiseProduct(eigenvector));
  }

 private:
  const MechanicalSystem& system_;
  const Vector& q_;
  Vector inverse_root_mass_;
  mutable Vector product_;
};

struct Eigenpair {
  double value = 0.0;
  Vector vector;
};

// Small systems: all eigenvalues of the dense matrix.
Eigenpair dense_largest(const ScaledStiffness& op) {
  const Index n = op.rows();
  Matrix k(n, n);
  for (Index j = 0; j < n; ++j) {
    const Vector unit = Vector::Unit(n, j);
    op.perform_op(unit.data(), k.col(j).data());
  }
  const Eigen::SelfAdjointEigenSolver<Matrix> solver(k);
  return {solver.eigenvalues()[n - 1], solver.eigenvectors().col(n - 1)};
}

Eigenpair lanczos_largest(ScaledStiffness& op) {
  constexpr double kTolerance = 1e-4;
  constexpr Index kSubspace = 24;
  constexpr Index kRestarts = 300;
  Spectra::SymEigsSolver<ScaledStiffness> solver(op, 1, kSubspace);
  solver.init();
  solver.compute(Spectra::SortRule::LargestAlge, kRestarts, kTolerance);
  if (solver.info() != Spectra::CompInfo::Successful) return {};
  return {solver.eigenvalues()[0], solver.eigenvectors().col(0)};
}

// Power iteration with the Rayleigh quotient: the fall-back, should Lanczos not converge.
Eigenpair power_largest(const ScaledStiffness& op) {
  Vector x = Vector::Random(op.rows()).normalized();
  Vector y(op.rows());
  double value = 0.0;
  for (int i = 0; i < 2000; ++i) {
    op.perform_op(x.data(), y.data());
    const double next = x.dot(y);
    const double norm = y.norm();
    if (norm == 0.0) break;
    x = y / norm;
    if (i > 10 && std::abs(next - value) <= 1e-6 * std::abs(next)) return {next, x};
    value = next;
  }
  return {value, x};
}

}  // namespace

StabilityLimit stability_limit(const MechanicalSystem& system, const Vector& q) {
  constexpr Index kDense = 60;
  ScaledStiffness op(system, q);
  Eigenpair largest = op.rows() <= kDense ? dense_largest(op) : lanczos_largest(op);
  if (largest.vector.size() == 0) largest = power_largest(op);

  StabilityLimit limit;
  limit.critical_step = std::numeric_limits<double>::infinity();
  if (largest.value > 0.0) {
    limit.omega_max = std::sqrt(largest.value);
    limit.critical_step = 2.0 / limit.omega_max;
  }
  const Vector mode = op.displacement(largest.vector);
  double most = -1.0;
  for (Index e = 0; e < system.rest().element_count(); ++e) {
    const double motion = system.rest().gather(mode, e).squaredNorm();
    if (motion > most) {
      most = motion;
      limit.element = e;
    }
  }
  return limit;
}

}  // namespace tetraction
