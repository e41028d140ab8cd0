// The mean stress of an energy-momentum step for one element and any material.
//
// The scalar counterpart of kernels/discrete_gradient_kernels.h, which has the formulas. It is used
// for materials of programs and for elements of poor shape. A material gives Ψ(F) and P(F) only, so
// the second Piola–Kirchhoff stress of C is S(C) = U⁻¹P(U) with the right stretch U = √C.
#pragma once

#include <Eigen/LU>
#include <cmath>

#include "core/decompositions.h"
#include "tetraction/material/material.h"

namespace tetraction {

/// The deformation of an element in a step: from F − D to F + D.
struct DeformationStep {
  Matrix3 middle;  ///< F, the mean of the deformation gradients at the two ends
  Matrix3 half;    ///< D, half of their difference
  double viscous;  ///< η/s with half of the step size s, Pa

  Matrix3 end() const { return middle + half; }
  /// C̄, the mean of C at the two ends.
  Matrix3 mean_metric() const { return middle.transpose() * middle + half.transpose() * half; }
  /// ΔE, the change of Green's strain, which is half of that of C. It does not cancel.
  Matrix3 strain_change() const {
    const Matrix3 product = middle.transpose() * half;
    return product + product.transpose();
  }
};

/// Where tr(Z²), Z = C̄⁻¹ΔE, is below its square, the difference of energies is integrated.
constexpr double kSmallStep = 0.03;
/// Gauss's rule with five points on [−1, 1]: the positive points and their weights. The middle one
/// is not needed.
constexpr double kGaussPoints[2] = {0.538469310105683091, 0.906179845938663993};
constexpr double kGaussWeights[2] = {0.478628670499366468, 0.236926885056189088};
/// Below this |ΔE|² the derivative of the correction is left out: it would be round-off.
constexpr double kLeastStrainChange = 1e-12;

/// S(C) of a material, with what its derivative needs.
template <Material M>
class StressOfMetric {
 public:
  StressOfMetric(const M& material, const Matrix3& c) : material_(material) {
    const SymmetricEigen3 eigen = symmetric_eigen(c);
    axes_ = eigen.vectors;
    stretches_ = eigen.values.cwiseMax(0.0).cwiseSqrt();
    u_ = axes_ * stretches_.asDiagonal() * axes_.transpose();
    inverse_ = axes_ * stretches_.cwiseInverse().asDiagonal() * axes_.transpose();
    const Matrix3 s = inverse_ * material.first_piola(u_);
    stress_ = 0.5 * (s + s.transpose());
  }

  const Matrix3& stress() const { return stress_; }
  const Matrix3& stretch() const { return u_; }
  /// The derivative of S in the direction dc.
  Matrix3 derivative(const Matrix3& dc) const {
    Matrix3 du = axes_.transpose() * dc * axes_;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) du(i, j) /= stretches_[i] + stretches_[j];
    }
    du = axes_ * du * axes_.transpose();
    const Vector9 dp = material_.stiffness(u_) * flatten(du);
    const Matrix3 ds = inverse_ * (Eigen::Map<const Matrix3>(dp.data()) - du * stress_);
    return 0.5 * (ds + ds.transpose());
  }

 private:
  const M& material_;
  Matrix3 axes_;
  Vector3 stretches_;
  Matrix3 u_;
  Matrix3 inverse_;
  Matrix3 stress_;
};

inline double contract(const Matrix3& a, const Matrix3& b) {
  return a.cwiseProduct(b).sum();
}

/// The mean second Piola–Kirchhoff stress S̄ of a step, viscous stress included, and its derivative.
template <Material M>
class MeanStress {
 public:
  MeanStress(const M& material, const DeformationStep& step)
      : material_(material),
        step_(step),
        mean_(step.mean_metric()),
        change_(step.strain_change()),
        at_mean_(material, mean_) {
    square_ = change_.squaredNorm();
    if constexpr (!has_quadratic_energy()) {
      if (square_ > 0.0) factor_ = correction() / square_;
    }
    stress_ = at_mean_.stress() + (factor_ + step.viscous) * change_;
  }

  const Matrix3& stress() const { return stress_; }
  /// P = F S̄.
  Matrix3 first_piola() const { return step_.middle * stress_; }
  /// The derivative of P if both the mean deformation and half of the change move by `d`.
  Matrix3 derivative(const Matrix3& d) const {
    const Matrix3 product = d.transpose() * step_.end();
    const Matrix3 b = product + product.transpose();  // of C̄ and of ΔE
    Matrix3 ds = at_mean_.derivative(b) + (factor_ + step_.viscous) * b;
    if constexpr (!has_quadratic_energy()) {
      if (square_ > kLeastStrainChange) {
        const StressOfMetric<M> at_end(material_, mean_ + change_);
        const Matrix3 y = at_end.stress() - at_mean_.stress() - at_mean_.derivative(change_) -
                          2.0 * factor_ * change_;
        ds += contract(y, b) / square_ * change_;
      }
    }
    return d * stress_ + step_.middle * ds;
  }

 private:
  // Ψ is a quadratic function of C, so that there is no correction.
  static constexpr bool has_quadratic_energy() {
    if constexpr (requires { M::kDefinedForAnyJacobian; }) {
      return M::kDefinedForAnyJacobian;
    } else {
      return false;
    }
  }

  // N = Ψ(C̄ + ΔE) − Ψ(C̄ − ΔE) − S(C̄):ΔE.
  double correction() const {
    const double middle = contract(at_mean_.stress(), change_);
    const Matrix3 z = mean_.inverse() * change_;
    if ((z * z).trace() < kSmallStep * kSmallStep) {
      double sum = 0.0;
      for (int i = 0; i < 2; ++i) {
        const Matrix3 change = kGaussPoints[i] * change_;
        const double pair =
            contract(StressOfMetric<M>(material_, mean_ + change).stress(), change_) +
            contract(StressOfMetric<M>(material_, mean_ - change).stress(), change_);
        sum += 0.5 * kGaussWeights[i] * (pair - 2.0 * middle);
      }
      return sum;
    }
    return material_.energy_density(step_.middle + step_.half) -
           material_.energy_density(step_.middle - step_.half) - middle;
  }

  const M& material_;
  const DeformationStep& step_;
  Matrix3 mean_;    // C̄
  Matrix3 change_;  // ΔE
  StressOfMetric<M> at_mean_;
  double square_ = 0.0;  // |ΔE|²
  double factor_ = 0.0;  // N/|ΔE|²
  Matrix3 stress_;
};

}  // namespace tetraction
