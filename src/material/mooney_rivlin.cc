#include <fmt/format.h>

#include <Eigen/LU>

#include "material_parameters.h"
#include "strain_invariants.h"
#include "tetraction/core/error.h"
#include "tetraction/material/material.h"

namespace tetraction {

MooneyRivlin::MooneyRivlin(double mu1, double mu2, double lambda)
    : mu1_(mu1), mu2_(mu2), lambda_(lambda) {
  if (!(mu1 >= 0.0) || !(mu2 >= 0.0)) {
    throw InputError(fmt::format(
        "mooney-rivlin: mu1 = {} Pa and mu2 = {} Pa must both be zero or positive.", mu1, mu2));
  }
  check_lame("mooney-rivlin (small strain: mu = mu1 + mu2, lambda + 2 mu2)", mu1 + mu2,
             lambda + 2.0 * mu2);
}

double MooneyRivlin::energy_density(const Matrix3& f) const {
  const StrainInvariants strain(f);
  return 0.5 * mu1_ * strain.first + 0.5 * mu2_ * strain.second +
         0.5 * lambda_ * strain.log_j * strain.log_j;
}

// ∂I₁/∂F = 2F, ∂I₂/∂F = 2 (I₁ F − F C), ∂ ln J/∂F = G = F⁻ᵀ, so
// P = μ₁ (F − G) + μ₂ (I₁ F − F C − 2 G) + λ ln J G.
Matrix3 MooneyRivlin::first_piola(const Matrix3& f) const {
  const Matrix3 g = f.inverse().transpose();
  const Matrix3 c = f.transpose() * f;
  const double log_j = std::log(f.determinant());
  return mu1_ * (f - g) + mu2_ * (c.trace() * f - f * c - 2.0 * g) + lambda_ * log_j * g;
}

// d(I₁F) = 2 (F:dF) F + I₁ dF and d(F C) = dF C + F dFᵀ F + B dF with B = FFᵀ; dG = −G dFᵀ G. With
// f_J, g_J the columns of F and G, block (J, L) of the stiffness is
// δ_JL (μ₁ + μ₂ I₁) I + μ₂ (2 f_J f_Lᵀ − f_L f_Jᵀ − C_LJ I − δ_JL B)
// + (μ₁ + 2μ₂ − λ ln J) g_L g_Jᵀ + λ g_J g_Lᵀ.
Matrix9 MooneyRivlin::stiffness(const Matrix3& f) const {
  const Matrix3 g = f.inverse().transpose();
  const Matrix3 c = f.transpose() * f;
  const Matrix3 b = f * f.transpose();
  const double factor = mu1_ + 2.0 * mu2_ - lambda_ * std::log(f.determinant());
  const double diagonal = mu1_ + mu2_ * c.trace();
  Matrix9 a;
  for (int l = 0; l < 3; ++l) {
    for (int j = 0; j < 3; ++j) {
      Matrix3 block =
          mu2_ * (2.0 * f.col(j) * f.col(l).transpose() - f.col(l) * f.col(j).transpose()) +
          factor * g.col(l) * g.col(j).transpose() + lambda_ * g.col(j) * g.col(l).transpose();
      block.diagonal().array() -= mu2_ * c(l, j);
      if (j == l) {
        block -= mu2_ * b;
        block.diagonal().array() += diagonal;
      }
      a.block<3, 3>(3 * j, 3 * l) = block;
    }
  }
  return a;
}

}  // namespace tetraction
