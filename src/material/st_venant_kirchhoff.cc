#include "material_parameters.h"
#include "strain_invariants.h"
#include "tetraction/material/material.h"

namespace tetraction {

StVenantKirchhoff::StVenantKirchhoff(double mu, double lambda) : mu_(mu), lambda_(lambda) {
  check_lame(kName, mu, lambda);
}

double StVenantKirchhoff::energy_density(const Matrix3& f) const {
  const Matrix3 e = green_strain(f);
  const double trace = e.trace();
  return mu_ * e.squaredNorm() + 0.5 * lambda_ * trace * trace;
}

// P = F S, S = 2μE + λ tr(E) I.
Matrix3 StVenantKirchhoff::first_piola(const Matrix3& f) const {
  const Matrix3 e = green_strain(f);
  return f * (2.0 * mu_ * e + lambda_ * e.trace() * Matrix3::Identity());
}

// dP = dF S + F (μ (dFᵀF + FᵀdF) + λ (F:dF) I): with f_J the columns of F and B = FFᵀ, block (J, L)
// is S_LJ I + μ f_L f_Jᵀ + λ f_J f_Lᵀ + δ_JL μ B.
Matrix9 StVenantKirchhoff::stiffness(const Matrix3& f) const {
  const Matrix3 e = green_strain(f);
  const Matrix3 s = 2.0 * mu_ * e + lambda_ * e.trace() * Matrix3::Identity();
  const Matrix3 b = f * f.transpose();
  Matrix9 a;
  for (int l = 0; l < 3; ++l) {
    for (int j = 0; j < 3; ++j) {
      Matrix3 block =
          mu_ * f.col(l) * f.col(j).transpose() + lambda_ * f.col(j) * f.col(l).transpose();
      block.diagonal().array() += s(l, j);
      if (j == l) block += mu_ * b;
      a.block<3, 3>(3 * j, 3 * l) = block;
    }
  }
  return a;
}

}  // namespace tetraction
