#include "tetraction/dynamics/stability.h"

#include <Spectra/SymEigsSolver.h>
#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <random>
#include <stdexcept>

#include "fem/tangent_operator.h"
#include "tetraction/core/error.h"
#include "tetraction/core/parallel.h"

namespace tetraction {
namespace {

// y = m^(−½) Tᵀ A T m^(−½) x over the free coordinates with m = TᵀMT: symmetric, with the
// eigenvalues of M⁻¹A. A is the stiffness or the viscous damping matrix at q.
class ScaledMatrix {
 public:
  using Scalar = double;
  enum class Kind { kStiffness, kViscosity };

  ScaledMatrix(const MechanicalSystem& system, const Vector& q, Kind kind)
      : system_(system),
        q_(q),
        kind_(kind),
        inverse_root_mass_(
            system.coordinates().reduced_mass(system.mass()).cwiseSqrt().cwiseInverse()) {
    if (kind == Kind::kStiffness && TangentOperator<float>::supports(system.elastic())) {
      tangent_ = std::make_unique<TangentOperator<float>>(system.elastic());
      tangent_->set(q);
      rows_.resize(static_cast<std::size_t>(ElementBlocks::kRowSize * system.vertex_count()));
    }
  }

  Index rows() const { return inverse_root_mass_.size(); }
  Index cols() const { return rows(); }

  void perform_op(const double* in, double* out) const {
    const Vector u = displacement(Eigen::Map<const Vector>(in, rows()));
    if (kind_ == Kind::kViscosity) {
      product_.setZero(system_.dof_count());
      system_.add_viscous_force(q_, u, product_);
      product_ *= -1.0;
    } else {
      if (tangent_) {
        multiply_fast(u);
      } else {
        system_.elastic().product(q_, u, product_);
      }
      add_vertex_terms(u);
    }
    Eigen::Map<Vector>(out, rows()) =
        inverse_root_mass_.cwiseProduct(system_.coordinates().restrict(product_));
  }

  Vector displacement(const Vector& eigenvector) const {
    return system_.coordinates().extend(inverse_root_mass_.cwiseProduct(eigenvector));
  }

 private:
  // Single precision is far beyond the accuracy that is asked for.
  void multiply_fast(const Vector& u) const {
    constexpr Index kGrain = 2048;
    const float scale = static_cast<float>(u.cwiseAbs().maxCoeff());
    parallel_for(system_.vertex_count(), kGrain, [&](Index begin, Index end) {
      for (Index v = begin; v < end; ++v) {
        float* row = rows_.data() + ElementBlocks::kRowSize * v;
        for (Index i = 0; i < 3; ++i) row[i] = static_cast<float>(u[3 * v + i]) / scale;
        row[3] = 0.0F;
      }
    });
    tangent_->multiply(rows_.data());
    product_.resize(system_.dof_count());
    parallel_for(system_.vertex_count(), kGrain, [&](Index begin, Index end) {
      for (Index v = begin; v < end; ++v) {
        vertex_block(product_, v) =
            static_cast<double>(scale) * tangent_->row_sum(v).head<3>().cast<double>();
      }
    });
  }

  void add_vertex_terms(const Vector& u) const {
    if (!system_.environment().is_uniform()) {
      for (Index v = 0; v < system_.vertex_count(); ++v) {
        vertex_block(product_, v) +=
            system_.environment().hessian(system_.mass()[v], vertex_block(q_, v)) *
            vertex_block(u, v);
      }
    }
    if (system_.constraints().has_springs()) {
      product_ += system_.constraints().spring_stiffness().cwiseProduct(u);
    }
  }

  const MechanicalSystem& system_;
  const Vector& q_;
  Kind kind_;
  Vector inverse_root_mass_;
  mutable Vector product_;
  std::unique_ptr<TangentOperator<float>> tangent_;  // where the materials allow it
  mutable AlignedVector<float> rows_;
};

struct Eigenpair {
  double value = 0.0;
  Vector vector;
};

// Small systems: all eigenvalues of the dense matrix.
Eigenpair dense_largest(const ScaledMatrix& op) {
  const Index n = op.rows();
  Matrix k(n, n);
  for (Index j = 0; j < n; ++j) {
    const Vector unit = Vector::Unit(n, j);
    op.perform_op(unit.data(), k.col(j).data());
  }
  const Eigen::SelfAdjointEigenSolver<Matrix> solver(k);
  return {solver.eigenvalues()[n - 1], solver.eigenvectors().col(n - 1)};
}

Eigenpair lanczos_largest(ScaledMatrix& op) {
  constexpr double kTolerance = 1e-4;
  constexpr Index kSubspace = 24;
  constexpr Index kRestarts = 300;
  Spectra::SymEigsSolver<ScaledMatrix> solver(op, 1, kSubspace);
  solver.init();
  solver.compute(Spectra::SortRule::LargestAlge, kRestarts, kTolerance);
  if (solver.info() != Spectra::CompInfo::Successful) return {};
  return {solver.eigenvalues()[0], solver.eigenvectors().col(0)};
}

// The same at every call, whatever the rest of the program does with random numbers.
Vector start_vector(Index size) {
  std::mt19937 random;  // always the same seed
  Vector x(size);
  for (double& xi : x) xi = 2.0 * static_cast<double>(random()) / std::mt19937::max() - 1.0;
  return x.normalized();
}

// Power iteration with the Rayleigh quotient: the fall-back, should Lanczos not converge.
Eigenpair power_largest(const ScaledMatrix& op) {
  Vector x = start_vector(op.rows());
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

Eigenpair largest_eigenpair(ScaledMatrix& op) {
  constexpr Index kDense = 60;
  Eigenpair largest = op.rows() <= kDense ? dense_largest(op) : lanczos_largest(op);
  if (largest.vector.size() == 0) largest = power_largest(op);
  return largest;
}

// The same, or InputError: Spectra gives up on a matrix that holds infinity or nothing but zeros.
Eigenpair finite_largest_eigenpair(ScaledMatrix& op) {
  Eigenpair largest;
  largest.value = std::numeric_limits<double>::quiet_NaN();
  try {
    largest = largest_eigenpair(op);
  } catch (const std::runtime_error&) {
  } catch (const std::invalid_argument&) {
  }
  if (std::isfinite(largest.value)) return largest;
  throw InputError(
      "The stability limit cannot be worked out, as the highest frequency of the body overflows: "
      "material.youngs_modulus (or mu, lambda), material.density, mesh.generate.size or "
      "mesh.scale, "
      "fix.penalty, damping.viscosity and environment.strength are too far apart in size, or one "
      "is "
      "too large or too small. Choose other units or values.");
}

double largest_damping_rate(const MechanicalSystem& system, const Vector& q) {
  const Damping& damping = system.damping();
  double rate = damping.mass_damping;
  if (damping.drag > 0.0) rate += damping.drag / system.mass().minCoeff();
  if (damping.viscosity > 0.0) {
    ScaledMatrix op(system, q, ScaledMatrix::Kind::kViscosity);
    rate += std::max(0.0, finite_largest_eigenpair(op).value);
  }
  return rate;
}

}  // namespace

StabilityLimit stability_limit(const MechanicalSystem& system, const Vector& q) {
  StabilityLimit limit;
  limit.critical_step = std::numeric_limits<double>::infinity();
  if (system.coordinates().count() == 0) return limit;  // nothing that could oscillate
  ScaledMatrix op(system, q, ScaledMatrix::Kind::kStiffness);
  const Eigenpair largest = finite_largest_eigenpair(op);
  if (largest.value > 0.0) {
    limit.omega_max = std::sqrt(largest.value);
    limit.critical_step = 2.0 / limit.omega_max;
  }
  limit.damping_rate = largest_damping_rate(system, q);
  if (const double c = limit.damping_rate; c > 0.0) {
    limit.critical_step = 4.0 / (c + std::hypot(c, 2.0 * limit.omega_max));
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
