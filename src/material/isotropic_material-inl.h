// Energy, stress and stiffness of isotropic materials at one F, computed from their laws. With
// G = F⁻ᵀ, C = FᵀF and the derivatives Ψ₁, Ψ₂, Ψ_L of Ψ with respect to I₁, I₂ and ln J,
//
//     P = 2 (Ψ₁ + I₁ Ψ₂) F − 2 Ψ₂ F C + Ψ_L G
//       = 2 Ψ₁ (F − G) + 2 Ψ₂ (I₁ F − F C − 2 G) + (Ψ_L + 2 Ψ₁ + 4 Ψ₂) G.
//
// Every term of the second form is zero at rest, so that it loses no digits there. Laws that are
// defined for any J depend on A = C − I alone, and P = F (2 (Ψ₁ + (I₁ − 1) Ψ₂) I − 2 Ψ₂ A).
#pragma once

#include "tetraction/material/isotropic_material.h"

#include <Eigen/LU>
#include <cmath>

#include "material/laws/laws-inl.h"
#include "strain_invariants.h"

namespace tetraction {
namespace isotropic {

using HWY_NAMESPACE::Law;  // compiled for the instruction set that every processor has
using HWY_NAMESPACE::PrincipalTangent;
using HWY_NAMESPACE::Stretches;
using HWY_NAMESPACE::TermsOf;
using HWY_NAMESPACE::Volumetric;

/// The principal stretches of F.
inline Stretches<double> stretches_of(const Matrix3& f) {
  const Matrix3 a = 2.0 * green_strain(f);
  const double entries[6] = {a(0, 0), a(0, 1), a(0, 2), a(1, 1), a(1, 2), a(2, 2)};
  Stretches<double> stretches(entries);
  if (stretches.is_uneven()) {
    double columns[3][3];
    for (int i = 0; i < 9; ++i) columns[i / 3][i % 3] = f(i % 3, i / 3);
    stretches.refine(columns);
  }
  return stretches;
}
/// The derivatives of U/κ.
inline Volumetric<double> volumetric_of(double volume_change) {
  Invariants<double> s{};
  s.volume_change = volume_change;
  s.j = 1.0 + volume_change;
  return {VolumetricPart::kQuadratic, s};
}
/// Σ sᵢ nᵢ ⊗ nᵢ.
template <class L, class P>
Matrix3 isochoric_stress(const P& material, const Stretches<double>& stretches) {
  double s[3];
  stretches.stress<L>(material, s);
  Matrix3 sum = Matrix3::Zero();
  for (int i = 0; i < 3; ++i) {
    const Eigen::Map<const Vector3> n(stretches.axes[i]);
    sum += s[i] * n * n.transpose();
  }
  return sum;
}

// The invariants for derivatives. The plain formulas suffice, because stress and stiffness need no
// more digits than F has.
inline Invariants<double> plain_invariants(const Matrix3& f, const Matrix3& c) {
  Invariants<double> s{};
  s.j = f.determinant();
  s.volume_change = s.j - 1.0;
  s.log_j = std::log(s.j);
  s.i1 = c.trace();
  s.i1_term = s.i1 - 3.0 - 2.0 * s.log_j;
  s.i2_term = 0.5 * (s.i1 * s.i1 - c.squaredNorm()) - 3.0 - 4.0 * s.log_j;
  return s;
}

inline StrainMeasures<double> strain_measures(const Matrix3& a) {
  return {a.trace(), a.squaredNorm()};
}

// m += factor (a ⊗ b + b ⊗ a). A factor of type Zero adds nothing.
inline void add_coupling(Matrix9& m, double factor, const Matrix3& a, const Matrix3& b) {
  const Vector9 u = flatten(a);
  const Vector9 v = flatten(b);
  m += factor * (u * v.transpose() + v * u.transpose());
}
inline void add_coupling(Matrix9&, Zero, const Matrix3&, const Matrix3&) {}

/// The value of a derivative, which is 0 for the type Zero.
inline double number(double x) {
  return x;
}
inline double number(Zero) {
  return 0.0;
}
template <class T>
auto times(double factor, T x) {
  if constexpr (kIsZero<T>) {
    return Zero();
  } else {
    return factor * x;
  }
}

}  // namespace isotropic

template <class M>
double IsotropicMaterial<M>::energy_density(const Matrix3& f) const {
  const auto& material = static_cast<const M&>(*this).parameters();
  if constexpr (M::kDefinedForAnyJacobian) {
    return isotropic::Law<M>::energy(material, isotropic::strain_measures(2.0 * green_strain(f)));
  } else if constexpr (M::kPrincipalStretches) {
    const double volumetric = isotropic::volumetric_of(StrainInvariants(f).volume_change).energy;
    return isotropic::stretches_of(f).template energy<isotropic::Law<M>>(material) +
           material.kappa * volumetric;
  } else {
    const StrainInvariants strain(f);
    Invariants<double> s{};
    s.i1 = strain.trace + 3.0;
    s.i1_term = strain.i1_term;
    s.i2_term = strain.i2_term;
    s.log_j = strain.log_j;
    s.volume_change = strain.volume_change;
    s.j = 1.0 + strain.volume_change;
    return isotropic::Law<M>::energy(material, s);
  }
}

template <class M>
Matrix3 IsotropicMaterial<M>::first_piola(const Matrix3& f) const {
  const auto& material = static_cast<const M&>(*this).parameters();
  if constexpr (M::kDefinedForAnyJacobian) {
    const Matrix3 a = 2.0 * green_strain(f);
    const StrainMeasures<double> s = isotropic::strain_measures(a);
    Matrix3 stress = -2.0 * isotropic::Law<M>::first_derivatives(material, s).i2 * a;
    stress.diagonal().array() += 2.0 * isotropic::Law<M>::spherical(material, s);
    return f * stress;
  } else if constexpr (M::kPrincipalStretches) {
    const double slope = isotropic::volumetric_of(f.determinant() - 1.0).first_derivative;
    return f * isotropic::isochoric_stress<isotropic::Law<M>>(material,
                                                              isotropic::stretches_of(f)) +
           material.kappa * slope * f.inverse().transpose();
  } else {
    const Matrix3 g = f.inverse().transpose();
    const Matrix3 c = f.transpose() * f;
    const Invariants<double> s = isotropic::plain_invariants(f, c);
    const auto first = isotropic::Law<M>::first_derivatives(material, s);
    if constexpr (isotropic::TermsOf<M>::kI2) {
      const double pressure = first.log_j + (2.0 * first.i1 + 4.0 * first.i2);
      return 2.0 * first.i1 * (f - g) + 2.0 * first.i2 * (s.i1 * f - f * c - 2.0 * g) +
             pressure * g;
    } else {
      return 2.0 * first.i1 * (f - g) + (first.log_j + 2.0 * first.i1) * g;
    }
  }
}

// With f_J, g_J the columns of F and G and B = FFᵀ, block (J, L) of the stiffness is
//
//     δ_JL 2 (Ψ₁ + I₁ Ψ₂) I − 2 Ψ₂ (C_LJ I + f_L f_Jᵀ + δ_JL B − 2 f_J f_Lᵀ) − Ψ_L g_L g_Jᵀ
//
// Each second derivative Ψ_ab adds Ψ_ab (∂a ⊗ ∂b + ∂b ⊗ ∂a) with ∂I₁ = 2F, ∂I₂ = 2 (I₁ F − F C) and
// ∂ ln J = G; for a = b it adds Ψ_aa ∂a ⊗ ∂a.
template <class M>
Matrix9 IsotropicMaterial<M>::stiffness(const Matrix3& f) const {
  using Terms = isotropic::TermsOf<M>;
  using L = isotropic::Law<M>;
  const auto& material = static_cast<const M&>(*this).parameters();
  Matrix9 result;
  // Calls body(J, L, block) for all blocks.
  const auto for_blocks = [&](const auto& body) {
    for (int l = 0; l < 3; ++l) {
      for (int j = 0; j < 3; ++j) body(j, l, result.template block<3, 3>(3 * j, 3 * l));
    }
  };
  // Adds the terms of Ψ₂: F S with S = `stress` varies by dF S + F dS. `square` is the factor of
  // F ⊗ F.
  const auto add_second_invariant = [&](double i2, const Matrix3& stress, double square) {
    const Matrix3 b = 2.0 * i2 * f * f.transpose();
    for_blocks([&](int j, int l, auto block) {
      block +=
          square * f.col(j) * f.col(l).transpose() - 2.0 * i2 * f.col(l) * f.col(j).transpose();
      block.diagonal().array() += stress(l, j);
      if (j == l) block -= b;
    });
  };
  if constexpr (Terms::kStrain) {
    const Matrix3 a = 2.0 * green_strain(f);
    const StrainMeasures<double> s = isotropic::strain_measures(a);
    const double i2 = L::first_derivatives(material, s).i2;
    Matrix3 stress = -2.0 * i2 * a;
    stress.diagonal().array() += 2.0 * L::spherical(material, s);
    result.setZero();
    add_second_invariant(i2, stress, 4.0 * (i2 + L::second_derivatives(material, s).i1_i1));
  } else if constexpr (M::kPrincipalStretches) {
    // The principal terms of src/fem/kernels/tangent_kernels.h with unit vectors in place of the γ.
    const Matrix3 g = f.inverse().transpose();
    const auto volumetric = isotropic::volumetric_of(f.determinant() - 1.0);
    const auto stretches = isotropic::stretches_of(f);
    const Matrix3 stress = isotropic::isochoric_stress<L>(material, stretches);
    const auto tangent = isotropic::PrincipalTangent<double>::of<L>(material, stretches);
    Matrix3 axes;  // nᵢ
    for (int i = 0; i < 3; ++i) axes.col(i) = Eigen::Map<const Vector3>(stretches.axes[i]);
    const Matrix3 y = f * axes;
    for_blocks([&](int j, int l, auto block) {
      block = material.kappa * (volumetric.second_derivative * g.col(j) * g.col(l).transpose() -
                                volumetric.first_derivative * g.col(l) * g.col(j).transpose());
      block.diagonal().array() += stress(j, l);
      const Vector3 at_j = axes.row(j).transpose();
      const Vector3 at_l = axes.row(l).transpose();
      double factors[3][3];
      tangent.factors(at_j.data(), at_l.data(), factors);
      block += y * Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(&factors[0][0]) *
               y.transpose();
    });
  } else {
    const Matrix3 g = f.inverse().transpose();
    const Matrix3 c = f.transpose() * f;
    const Invariants<double> s = isotropic::plain_invariants(f, c);
    const auto first = L::first_derivatives(material, s);
    const auto second = L::second_derivatives(material, s);
    const double log_j_log_j = isotropic::number(second.log_j_log_j);
    for_blocks([&](int j, int l, auto block) {
      block = log_j_log_j * g.col(j) * g.col(l).transpose() -
              first.log_j * g.col(l) * g.col(j).transpose();
    });
    Matrix3 half_i2_gradient = Matrix3::Zero();  // ½ ∂I₂/∂F
    if constexpr (Terms::kI2) {
      Matrix3 stress = -2.0 * first.i2 * c;
      stress.diagonal().array() += 2.0 * (first.i1 + s.i1 * first.i2);
      add_second_invariant(first.i2, stress, 4.0 * first.i2);
      if constexpr (Terms::kI2Coupled) half_i2_gradient = s.i1 * f - f * c;
    } else {
      result.diagonal().array() += 2.0 * first.i1;
    }
    using isotropic::add_coupling;
    using isotropic::times;
    add_coupling(result, times(2.0, second.i1_i1), f, f);
    add_coupling(result, times(2.0, second.i1_log_j), f, g);
    add_coupling(result, times(4.0, second.i1_i2), f, half_i2_gradient);
    add_coupling(result, times(2.0, second.i2_i2), half_i2_gradient, half_i2_gradient);
    add_coupling(result, times(2.0, second.i2_log_j), half_i2_gradient, g);
  }
  return result;
}

}  // namespace tetraction
