// Homogeneous states of the three materials against closed forms and literal numbers.
//
// ℓ is the stretch along the load, t the one across it, P the nominal stress (force over undeformed
// area). Every material here is a function of the principal stretches whose stress along axis i is
//
//   neo-Hookean      P_i = μ (ℓ_i − 1/ℓ_i) + λ ln J/ℓ_i
//   StVK             P_i = ℓ_i (μ (ℓ_i² − 1) + λ/2 Σ (ℓ_j² − 1))
//   Mooney–Rivlin    P_i = μ₁ (ℓ_i − 1/ℓ_i) + μ₂ (ℓ_i Σ_{j≠i} ℓ_j² − 2/ℓ_i) + λ ln J/ℓ_i
//
// (the last from I₁ = Σ ℓ_i², I₂ = ℓ₁²ℓ₂² + ℓ₂²ℓ₃² + ℓ₃²ℓ₁²). Free sides, P_t = 0, fix t:
//
//   uniaxial      neo-Hookean    μ (t² − 1) + λ ln(ℓt²) = 0
//                 StVK           t² = 1 − ν (ℓ² − 1)
//                 Mooney–Rivlin  μ₁ (t² − 1) + μ₂ (t²(ℓ² + t²) − 2) + λ ln(ℓt²) = 0
//   equibiaxial   neo-Hookean    μ (t² − 1) + λ ln(ℓ²t) = 0
//                 StVK           t² = 1 − 2λ (ℓ² − 1)/(2μ + λ)
//                 Mooney–Rivlin  μ₁ (t² − 1) + μ₂ (2t²ℓ² − 2) + λ ln(ℓ²t) = 0
//
// The numbers are for μ = 1, λ = 1.5, and for Mooney–Rivlin μ₁ = 0.7, μ₂ = 0.3, λ = 1.5 (so that
// its small-strain parameters are μ = 1 and λ + 2μ₂ = 2.1), solved with 30 digits by another
// program.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "tetraction/material/material.h"

namespace tetraction {
namespace {

constexpr double kMu = 1.0;
constexpr double kLambda = 1.5;
constexpr double kMu1 = 0.7;
constexpr double kMu2 = 0.3;

const NeoHookean kNeoHookean(kMu, kLambda);
const StVenantKirchhoff kStVenantKirchhoff(kMu, kLambda);
const MooneyRivlin kMooneyRivlin(kMu1, kMu2, kLambda);

// The root of a function that rises through zero between 0.1 and 10.
double root_of(const std::function<double(double)>& rising) {
  double low = 0.1;
  double high = 10.0;
  EXPECT_LT(rising(low), 0.0);
  EXPECT_GT(rising(high), 0.0);
  for (int i = 0; i < 200; ++i) {
    const double middle = 0.5 * (low + high);
    (rising(middle) < 0.0 ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

struct Expected {
  double lateral;
  double stress;
};

// The code's stress at the stretches must be `stress` on the loaded axes, zero on the free ones,
// and have no shear; the closed form's lateral stretch must be the expected one.
template <class M>
void expect_state(const M& material, const Vector3& stretches, double lateral, int loaded_axes,
                  const Expected& expected) {
  EXPECT_NEAR(lateral, expected.lateral, 1e-13);
  const Matrix3 stress = material.first_piola(Matrix3(stretches.asDiagonal()));
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const double value = i == j && i < loaded_axes ? expected.stress : 0.0;
      EXPECT_NEAR(stress(i, j), value, 5e-13) << i << "," << j;
    }
  }
}

template <class M>
void expect_uniaxial(const M& material, double l, double t, const Expected& expected) {
  expect_state(material, {l, t, t}, t, 1, expected);
}

template <class M>
void expect_equibiaxial(const M& material, double l, double t, const Expected& expected) {
  expect_state(material, {l, l, t}, t, 2, expected);
}

TEST(HomogeneousStates, UniaxialNeoHookean) {
  const auto lateral = [](double l) {
    return root_of([l](double t) { return kMu * (t * t - 1.0) + kLambda * std::log(l * t * t); });
  };
  expect_uniaxial(kNeoHookean, 1.5, lateral(1.5), {0.880174591806738, 0.983528458625228});
  expect_uniaxial(kNeoHookean, 0.7, lateral(0.7), {1.10793473284848, -1.05359910321718});
}

TEST(HomogeneousStates, UniaxialStVenantKirchhoff) {
  const double nu = kLambda / (2.0 * (kLambda + kMu));
  const double young = 2.0 * kMu * (1.0 + nu);
  const auto lateral = [nu](double l) { return std::sqrt(1.0 - nu * (l * l - 1.0)); };
  expect_uniaxial(kStVenantKirchhoff, 1.5, lateral(1.5), {0.790569415042095, 2.4375});
  expect_uniaxial(kStVenantKirchhoff, 0.7, lateral(0.7), {1.07377837564369, -0.4641});

  // P = E ℓ (ℓ² − 1)/2 has its minimum −0.19245 E at ℓ = 1/√3: no smaller stress can be carried.
  const auto stress = [&](double l) {
    const double t = lateral(l);
    return kStVenantKirchhoff.first_piola(Matrix3(Vector3(l, t, t).asDiagonal()))(0, 0);
  };
  const double limit = 1.0 / std::sqrt(3.0);
  EXPECT_NEAR(stress(limit), -young / (3.0 * std::sqrt(3.0)), 1e-14);
  EXPECT_NEAR(stress(limit) / young, -0.19245, 5e-6);
  EXPECT_GT(stress(limit - 0.01), stress(limit));
  EXPECT_GT(stress(limit + 0.01), stress(limit));
}

TEST(HomogeneousStates, UniaxialMooneyRivlin) {
  const auto lateral = [](double l) {
    return root_of([l](double t) {
      return kMu1 * (t * t - 1.0) + kMu2 * (t * t * (l * l + t * t) - 2.0) +
             kLambda * std::log(l * t * t);
    });
  };
  expect_uniaxial(kMooneyRivlin, 1.5, lateral(1.5), {0.854437966193552, 0.93123350435617});
  expect_uniaxial(kMooneyRivlin, 0.7, lateral(0.7), {1.11367877698861, -1.14909103734953});
}

TEST(HomogeneousStates, EquibiaxialNeoHookean) {
  const double l = 1.2;
  const double t =
      root_of([l](double x) { return kMu * (x * x - 1.0) + kLambda * std::log(l * l * x); });
  expect_equibiaxial(kNeoHookean, l, t, {0.842587004050662, 0.608372617170774});
}

TEST(HomogeneousStates, EquibiaxialStVenantKirchhoff) {
  const double l = 1.2;
  const double t = std::sqrt(1.0 - 2.0 * kLambda * (l * l - 1.0) / (2.0 * kMu + kLambda));
  expect_equibiaxial(kStVenantKirchhoff, l, t, {0.789212989539036, 0.980571428571429});
}

TEST(HomogeneousStates, EquibiaxialMooneyRivlin) {
  const double l = 1.2;
  const double t = root_of([l](double x) {
    return kMu1 * (x * x - 1.0) + kMu2 * (2.0 * x * x * l * l - 2.0) +
           kLambda * std::log(l * l * x);
  });
  expect_equibiaxial(kMooneyRivlin, l, t, {0.819790206158981, 0.72442719020562});
}

class SimpleShear : public ::testing::TestWithParam<double> {
 protected:
  // The stress at F = I + γ e₁e₂ᵀ less the expected one.
  template <class M>
  void expect_stress(const M& material, const Matrix3& expected) const {
    Matrix3 f = Matrix3::Identity();
    f(0, 1) = GetParam();
    const Matrix3 stress = material.first_piola(f);
    EXPECT_LT((stress - expected).norm(), 1e-14 * (1.0 + expected.norm())) << stress;
  }
};

TEST_P(SimpleShear, NeoHookean) {
  // J = 1 and F − F⁻ᵀ = γ (e₁e₂ᵀ + e₂e₁ᵀ): P₁₂ = P₂₁ = μγ, no normal stress.
  Matrix3 expected = Matrix3::Zero();
  expected(0, 1) = expected(1, 0) = kMu * GetParam();
  expect_stress(kNeoHookean, expected);
}

TEST_P(SimpleShear, StVenantKirchhoff) {
  const double g = GetParam();
  const double factor = 0.5 * kLambda + kMu;
  Matrix3 expected = Matrix3::Zero();
  expected(0, 1) = kMu * g + factor * g * g * g;
  expected(1, 0) = kMu * g;
  expected(0, 0) = expected(1, 1) = factor * g * g;
  expected(2, 2) = 0.5 * kLambda * g * g;
  expect_stress(kStVenantKirchhoff, expected);
}

TEST_P(SimpleShear, MooneyRivlin) {
  // I₁F − FC − 2F⁻ᵀ = γ (e₁e₂ᵀ + e₂e₁ᵀ) + γ² e₃e₃ᵀ: the second invariant pushes along the axis that
  // is not sheared.
  const double g = GetParam();
  Matrix3 expected = Matrix3::Zero();
  expected(0, 1) = expected(1, 0) = (kMu1 + kMu2) * g;
  expected(2, 2) = kMu2 * g * g;
  expect_stress(kMooneyRivlin, expected);
}

INSTANTIATE_TEST_SUITE_P(Shears, SimpleShear, ::testing::Values(-2.0, -0.1, 0.5, 3.0));

}  // namespace
}  // namespace tetraction
