#include <Eigen/LU>

#include "material_parameters.h"
#include "strain_invariants.h"
#include "tetraction/material/material.h"

namespace tetraction {

NeoHookean::NeoHookean(double mu, double lambda) : mu_(mu), lambda_(lambda) {
  check_lame(kName, mu, lambda);
}

double NeoHookean::energy_density(const Matrix3& f) const {
  const StrainInvariants strain(f);
  return 0.5 * mu_ * strain.first + 0.5 * lambda_ * strain.log_j * strain.log_j;
}

// P = μ (F − G) + λ ln J G with G = F⁻ᵀ.
Matrix3 NeoHookean::first_piola(const Matrix3& f) const {
  const Matrix3 g = f.inverse().transpose();
  const double log_j = std::log(f.determinant());
  return mu_ * (f - g) + lambda_ * log_j * g;
}

// dG = −G dFᵀ G: with g_J the columns of G, block (J, L) of the stiffness is
// δ_JL μ I + (μ − λ ln J) g_L g_Jᵀ + λ g_J g_Lᵀ.
Matrix9 NeoHookean::stiffness(const Matrix3& f) const {
  const Matrix3 g = f.inverse().transpose();
  const double c = mu_ - lambda_ * std::log(f.determinant());
  Matrix9 a;
  for (int l = 0; l < 3; ++l) {
    for (int j = 0; j < 3; ++j) {
      a.block<3, 3>(3 * j, 3 * l) =
          c * g.col(l) * g.col(j).transpose() + lambda_ * g.col(j) * g.col(l).transpose();
    }
  }
  a.diagonal().array() += mu_;
  return a;
}

}  // namespace tetraction
