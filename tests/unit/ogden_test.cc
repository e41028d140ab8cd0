// Ogden's law: closed forms, equal and nearly equal stretches.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

#include "support/homogeneous_stretches.h"
#include "tetraction/core/error.h"
#include "tetraction/fem/elastic_potential.h"
#include "tetraction/material/material.h"
#include "tetraction/mesh/generate.h"

namespace tetraction {
namespace {

using namespace testing_support;
using Long = long double;

// R. W. Ogden, Proc. R. Soc. A 326, 1972: the three terms for Treloar's rubber, MPa.
Ogden treloar(double kappa) {
  return {{0.63, 0.0012, -0.01}, {1.3, 5.0, -2.0}, kappa};
}

Matrix3 turn(double angle, const Vector3& axis) {
  return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
}

// Published: P = Σ μₚ (λ^(αₚ − 1) − λ^(−mαₚ − 1)) with m = ½, 2 and 1; per loaded direction if there are two.
TEST(Ogden, NominalStressesAreThePublishedOnes) {
  const Ogden material = treloar(1e3);
  const double exponents[] = {0.5, 2.0, 1.0};
  const double directions[] = {1.0, 2.0, 1.0};
  for (const double stretch : {0.4, 0.9, 1.0 + 1e-6, 1.5, 3.0, 5.0, 7.0}) {
    for (std::size_t k = 0; k < 3; ++k) {
      double exact = 0.0;
      double scale = 0.0;
      for (int p = 0; p < material.term_count(); ++p) {
        const double alpha = material.alpha()[static_cast<std::size_t>(p)];
        const double mu = material.mu()[static_cast<std::size_t>(p)];
        const double log = std::log(stretch);
        exact += mu / stretch * (std::expm1(alpha * log) - std::expm1(-exponents[k] * alpha * log));
        scale += std::abs(mu) / stretch *
                 (std::pow(stretch, alpha) + std::pow(stretch, -exponents[k] * alpha));
      }
      const double found = nominal_stress(material, deformations()[k], stretch) / directions[k];
      EXPECT_NEAR(found, exact, 1e-12 * scale + 1e-12) << deformations()[k].name << " " << stretch;
    }
  }
  // The published formula at the stretch 5 of simple tension, computed by hand.
  EXPECT_NEAR(nominal_stress(material, deformations()[0], 5.0), 1.73667, 1e-5);
}

TEST(Ogden, OfOneTermWithTheExponentTwoIsTheNeoHookeanLimit) {
  const Ogden one({1.3}, {2.0}, 4.0);
  const Yeoh neo(0.65, 0.0, 0.0, 4.0);
  Matrix3 d;
  d << 0.4, -0.7, 0.2, 0.9, 0.3, -0.5, -0.6, 0.8, 0.1;
  for (const double size : {1e-6, 1e-3, 0.1, 0.5}) {
    const Matrix3 f = Matrix3::Identity() + size * d;
    const double energy = neo.energy_density(f);
    EXPECT_NEAR(one.energy_density(f), energy, 1e-13 * energy) << size;
    EXPECT_LT((one.first_piola(f) - neo.first_piola(f)).norm(), 1e-14) << size;
    EXPECT_LT((one.stiffness(f) - neo.stiffness(f)).norm(), 1e-13) << size;
  }
}

// Energy and stress of diag(stretches) in extended precision.
void reference(const Ogden& m, const Vector3& stretches, Long& energy, Vector3& stress) {
  Long l[3];
  for (int i = 0; i < 3; ++i) l[i] = stretches[i];
  const Long j = l[0] * l[1] * l[2];
  const Long kappa = m.kappa();
  energy = kappa / 2 * (j - 1) * (j - 1);
  Long tau[3] = {0, 0, 0};
  Long logs[3];
  for (int i = 0; i < 3; ++i) logs[i] = l[i] > 0.5L ? std::log1p(l[i] - 1) : std::log(l[i]);
  for (std::size_t p = 0; p < m.mu().size(); ++p) {
    const Long mu = m.mu()[p];
    const Long alpha = m.alpha()[p];
    Long power[3];
    Long sum = 0;
    Long excess = 0;
    for (int i = 0; i < 3; ++i) {
      const Long log = logs[i] - (logs[0] + logs[1] + logs[2]) / 3;
      power[i] = std::expm1(alpha * log);
      excess += power[i] - alpha * log;
      sum += power[i];
    }
    energy += mu / alpha * excess;
    for (int i = 0; i < 3; ++i) tau[i] += mu * (power[i] - sum / 3);
  }
  for (int i = 0; i < 3; ++i) {
    stress[i] = static_cast<double>((tau[i] + kappa * (j - 1) * j) / l[i]);
  }
}

// Two or three stretches at any distance from 0 to 1, with turned axes.
TEST(Ogden, IsRightForEqualAndNearlyEqualStretches) {
  const Ogden material = treloar(2.0);
  const double mu = material.initial_lame().mu;
  const Matrix3 left = turn(0.7, {1.0, 2.0, -1.0});
  const Matrix3 right = turn(-1.9, {0.3, -1.0, 0.4});
  double worst = 0.0;
  for (int exponent = -54; exponent <= 0; ++exponent) {
    for (const double distance : {std::ldexp(1.0, exponent), 0.0}) {
      for (const double base : {1.0, 1.001953125, 1.5, 0.625}) {
        for (const Vector3& stretches :
             {Vector3(base, base + distance, 1.25), Vector3(base, base + distance, base + distance),
              Vector3(base, base + distance, base + 0.5 * distance)}) {
          Long energy = 0;
          Vector3 stress;
          reference(material, stretches, energy, stress);
          const Matrix3 f = stretches.asDiagonal();
          if ((stretches.array() - 1.0).abs().maxCoeff() > 1e-3) {
            const auto exact = static_cast<double>(energy);
            EXPECT_NEAR(material.energy_density(f), exact, 1e-12 * exact) << distance;
          }
          const Matrix3 expected = stress.asDiagonal();
          EXPECT_LT((material.first_piola(f) - expected).norm(), 1e-12 * mu) << distance;
          const Matrix3 turned = material.first_piola(left * f * right);
          worst = std::max(worst, (turned - left * expected * right).norm() / mu);
        }
      }
    }
  }
  EXPECT_LT(worst, 1e-12);
}

// Also where the divided differences change their formula.
TEST(Ogden, StiffnessIsTheDerivativeForAllDistancesOfStretches) {
  const Ogden material = treloar(2.0);
  const Matrix3 right = turn(-1.9, {0.3, -1.0, 0.4});
  Matrix3 d;
  d << 0.4, -0.7, 0.2, 0.9, 0.3, -0.5, -0.6, 0.8, 0.1;
  for (const double distance : {0.0, 1e-14, 1e-10, 1e-8, 1e-5, 0.01, 0.09, 0.11, 0.2, 0.25, 0.7}) {
    const Matrix3 f =
        Matrix3(Vector3(1.1, 1.1 + distance, 1.1 - 0.5 * distance).asDiagonal()) * right;
    const Vector9 exact = material.stiffness(f) * flatten(d);
    const double h = 1e-5;
    const Matrix3 difference =
        (material.first_piola(f + h * d) - material.first_piola(f - h * d)) / (2.0 * h);
    EXPECT_LT((flatten(difference) - exact).norm(), 1e-8 * exact.norm()) << distance;
  }
}

// Squares of stretches would lose half of the digits of small ones, or all.
TEST(Ogden, KeepsTheDigitsOfVeryUnequalStretches) {
  const Ogden material = treloar(2.0);
  const Matrix3 left = turn(0.7, {1.0, 2.0, -1.0});
  const Matrix3 right = turn(-1.9, {0.3, -1.0, 0.4});
  for (const Vector3& stretches :
       {Vector3(1e-3, 1.0, 1.0), Vector3(1.0, 1e-3, 1.0), Vector3(1.0, 1.0, 1e-3),
        Vector3(1e-3, 1e-3, 1.0), Vector3(1e-3, 1.05e-3, 1.0), Vector3(1e-3, 1.3, 1.3 + 1e-9),
        Vector3(1e-6, 1.0, 1.0), Vector3(1e-9, 1.0, 1.0), Vector3(1e-9, 1e3, 1e6)}) {
    Long energy = 0;
    Vector3 stress;
    reference(material, stretches, energy, stress);
    const Matrix3 f = stretches.asDiagonal();
    const Matrix3 expected = stress.asDiagonal();
    const auto exact = static_cast<double>(energy);
    EXPECT_NEAR(material.energy_density(f), exact, 1e-12 * exact) << stretches.transpose();
    EXPECT_LT((material.first_piola(f) - expected).norm(), 1e-12 * expected.norm())
        << stretches.transpose();
    // The entries of the turned matrix have round-off of the order of the largest stretch.
    const double lost = 1e-15 * stretches.maxCoeff() / stretches.minCoeff();
    const Matrix3 turned = material.first_piola(left * f * right);
    EXPECT_LT((turned - left * expected * right).norm(), std::max(1e-12, lost) * expected.norm())
        << stretches.transpose();
  }
}

TEST(Ogden, StiffnessIsTheDerivativeForVeryUnequalStretches) {
  const Ogden material = treloar(2.0);
  Matrix3 d;
  d << 0.4, -0.7, 0.2, 0.9, 0.3, -0.5, -0.6, 0.8, 0.1;
  for (const Vector3& stretches :
       {Vector3(1e-3, 1.0, 1.0), Vector3(1e-3, 1.05e-3, 1.0), Vector3(1e-3, 1.0, 30.0)}) {
    const Matrix3 f = stretches.asDiagonal();
    const Matrix3 direction = stretches.minCoeff() * d;
    const double h = 1e-4;
    const Vector9 exact = material.stiffness(f) * flatten(direction);
    const Matrix3 difference =
        (material.first_piola(f + h * direction) - material.first_piola(f - h * direction)) /
        (2.0 * h);
    EXPECT_LT((flatten(difference) - exact).norm(), 1e-7 * exact.norm()) << stretches.transpose();
  }
}

// The resultant on the face at X = 1 of a stretched cube.
TEST(Ogden, TheKernelsKeepTheDigitsOfVeryUnequalStretches) {
  const Ogden material = treloar(2.0);
  const TetMesh mesh = generate_box({1, 1, 1}, {2, 2, 2});
  const RestState rest(mesh);
  const ElasticPotential potential(rest, MaterialField(material));
  for (const Vector3& stretches :
       {Vector3(1e-3, 1.0, 1.0), Vector3(1e-3, 1e-3, 1.0), Vector3(1e-3, 1.0, 30.0)}) {
    Long density = 0;
    Vector3 stress;
    reference(material, stretches, density, stress);
    Vector q = mesh.rest_positions();
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
      vertex_block(q, v) = stretches.cwiseProduct(vertex_block(q, v)).eval();
    }
    double energy = 0.0;
    Vector gradient(q.size());
    ASSERT_TRUE(potential.value_and_gradient(q, energy, gradient).ok());
    Vector3 resultant = Vector3::Zero();
    for (Index v = 0; v < mesh.vertex_count(); ++v) {
      if (mesh.vertices[static_cast<std::size_t>(v)].x() > 0.9)
        resultant += vertex_block(gradient, v);
    }
    const auto exact = static_cast<double>(density);
    EXPECT_NEAR(energy, exact, 1e-12 * exact) << stretches.transpose();
    EXPECT_LT((resultant - stress[0] * Vector3::UnitX()).norm(), 1e-12 * stress.norm())
        << stretches.transpose();
  }
}

TEST(Ogden, RefusesParametersWithTheirReason) {
  const auto refusal = [](const std::function<void()>& make) -> std::string {
    try {
      make();
    } catch (const InputError& error) {
      return error.what();
    }
    return "nothing refused";
  };
  EXPECT_NE(refusal([] {
              Ogden({1.0, 2.0}, {2.0}, 1.0);
            }).find("2 and alpha 1"),
            std::string::npos);
  EXPECT_NE(refusal([] { Ogden({}, {}, 1.0); }).find("1 to 8"), std::string::npos);
  const std::vector<double> nine(9, 1.0);
  EXPECT_NE(refusal([&] { Ogden(nine, nine, 1.0); }).find("1 to 8"), std::string::npos);
  EXPECT_NE(refusal([] { Ogden({1.0}, {-2.0}, 1.0); }).find("must be positive"), std::string::npos);
  EXPECT_NE(refusal([] { Ogden({1.0}, {0.0}, 1.0); }).find("alpha.0"), std::string::npos);
  EXPECT_NE(refusal([] { Ogden({1.0}, {2.0}, -1.0); }).find("kappa"), std::string::npos);
  EXPECT_NE(refusal([] { Ogden::instead({1.0}, {2.0}, 0.5); }).find("poissons_ratio"),
            std::string::npos);
  EXPECT_NO_THROW(Ogden(std::vector<double>(8, 1.0), std::vector<double>(8, 2.0), 1.0));
}

TEST(Ogden, PoissonsRatioGivesTheBulkModulus) {
  const LameParameters lame = Ogden::instead({1.3, 0.2}, {2.0, 4.0}, 0.45).initial_lame();
  EXPECT_NEAR(lame.mu, 1.7, 1e-15);
  EXPECT_NEAR(lame.lambda / (2.0 * (lame.lambda + lame.mu)), 0.45, 1e-14);
}

TEST(Ogden, WarnsOfParametersThatSetEnergyFree) {
  EXPECT_EQ(treloar(1.0).instability(), "");
  EXPECT_NE(Ogden({1.0, -0.2}, {2.0, 4.0}, 10.0).instability(), "");
  // Terms that overflow do not count as unstable.
  EXPECT_EQ(Ogden({1e5, -1e3}, {400.0, 350.0}, 1e6).instability(), "");
}

// The exponentials of the kernels have a limit, beyond which numbers must not be taken for an energy.
TEST(Ogden, AnEnergyThatOverflowsIsNotFinite) {
  const TetMesh mesh = generate_box({1, 1, 1}, {2, 2, 2});
  const RestState rest(mesh);
  Vector q = mesh.rest_positions();
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    vertex_block(q, v) = Vector3(3.0, 0.1, 0.1).cwiseProduct(vertex_block(q, v)).eval();
  }
  for (const double exponent : {1000.0, 3000.0, -3000.0, 1e5, -1e5}) {
    const ElasticPotential potential(rest, MaterialField(Ogden({0.5 * exponent}, {exponent}, 2.0)));
    double energy = 0.0;
    Vector gradient(q.size());
    EXPECT_FALSE(potential.value(q, energy).ok() && std::isfinite(energy)) << exponent;
    EXPECT_FALSE(potential.value_and_gradient(q, energy, gradient).ok() && std::isfinite(energy))
        << exponent;
    EXPECT_FALSE(gradient.allFinite()) << exponent;
  }
}

}  // namespace
}  // namespace tetraction
