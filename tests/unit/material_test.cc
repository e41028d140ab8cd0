// One battery for every material, then what is particular to each.
#include "tetraction/material/material.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "support/fibre_rubber.h"
#include "support/messages.h"
#include "tetraction/core/error.h"
#include "tetraction/fem/elastic_potential.h"
#include "tetraction/mesh/generate.h"

namespace tetraction {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// The facts about a material that the tests need: one of ordinary parameters, its name, and how
// far it can be pulled before its energy overflows. This is that of every model of the program that has none
// of its own below.
template <class M>
struct Sample {
  static constexpr const char* kName = M::kName;
  static constexpr double kFar = HasStretchLimit<M> ? 10.0 : 100.0;
  static M make() { return M::like({1.3, 2.1}); }
  // κ = 0 is allowed, for a body whose volumetric energy is taken elsewhere.
  static void make_bad(double mu, double lambda) { M::like({mu, lambda - 1e-9}); }
};
template <class M, int far = 100>
struct Named {
  static constexpr const char* kName = M::kName;
  static constexpr double kFar = far;
};
// Stand for CustomMaterials that hold these.
struct CustomNeoHookean {};
struct CustomFibreRubber {};
// Stand for the laws with another volumetric part.
struct QuadraticNeoHookean {};
struct QuadraticMooneyRivlin {};

template <>
struct Sample<StVenantKirchhoff> : Named<StVenantKirchhoff> {
  static StVenantKirchhoff make() { return {1.3, 2.1}; }
  static void make_bad(double mu, double lambda) { StVenantKirchhoff(mu, lambda); }
};
template <>
struct Sample<NeoHookean> : Named<NeoHookean> {
  static NeoHookean make() { return {1.3, 2.1}; }
  static void make_bad(double mu, double lambda) { NeoHookean(mu, lambda); }
};
template <>
struct Sample<MooneyRivlin> : Named<MooneyRivlin> {
  static MooneyRivlin make() { return {0.8, 0.5, 1.1}; }
  static void make_bad(double mu, double lambda) { MooneyRivlin(mu, 0.0, lambda); }
};
template <>
struct Sample<QuadraticNeoHookean> : Named<NeoHookean> {
  static NeoHookean make() { return {1.3, 2.1, VolumetricPart::kQuadratic}; }
  static void make_bad(double mu, double lambda) {
    NeoHookean(mu, lambda, VolumetricPart::kQuadratic);
  }
};
template <>
struct Sample<QuadraticMooneyRivlin> : Named<MooneyRivlin> {
  static MooneyRivlin make() { return {0.8, 0.5, 1.1, VolumetricPart::kQuadratic}; }
  static void make_bad(double mu, double lambda) {
    MooneyRivlin(mu, 0.0, lambda, VolumetricPart::kQuadratic);
  }
};
template <>
struct Sample<Yeoh> : Named<Yeoh> {
  static Yeoh make() { return {0.65, -0.05, 0.02, 2.9}; }
  // κ = 0 is allowed, for a body whose volumetric energy is taken elsewhere.
  static void make_bad(double mu, double lambda) {
    Yeoh(mu, 0.0, 0.0, lambda + 2.0 / 3.0 * mu - 1e-9);
  }
};
template <>
struct Sample<CustomNeoHookean> {
  static constexpr const char* kName = "mine";
  static constexpr double kFar = 100.0;
  static CustomMaterial make() { return {NeoHookean(1.3, 2.1), kName, {1.3, 2.1}}; }
  static void make_bad(double mu, double lambda) {
    CustomMaterial(NeoHookean(1.3, 2.1), kName, {mu, lambda});
  }
};
template <>
struct Sample<CustomFibreRubber> {
  using Fibre = testing_support::FibreRubber;
  static constexpr const char* kName = Fibre::kName;
  static constexpr double kFar = 3.0;
  static Fibre material() { return {{1.3, 2.1}, 0.7, 0.8, {0.6, 0.48, 0.64}}; }
  static CustomMaterial make() { return CustomMaterial(material()); }
  static void make_bad(double mu, double lambda) {
    CustomMaterial(material(), kName, {mu, lambda});
  }
};

Matrix3 rotation() {
  return Eigen::AngleAxisd(2.3, Vector3(0.3, -0.5, 0.8).normalized()).toRotationMatrix();
}

// Deformations far from rest and from each other, rotated, stretched and sheared; all J > 0.
std::vector<Matrix3> deformations() {
  Matrix3 general;
  general << 1.2, 0.3, -0.1, -0.2, 0.9, 0.25, 0.15, -0.05, 1.1;
  Matrix3 squeezed;
  squeezed << 0.6, 0.1, 0.0, 0.05, 0.8, -0.1, 0.0, 0.2, 1.3;
  return {general, squeezed, rotation() * general, Matrix3(rotation() * squeezed)};
}

Matrix3 direction() {
  Matrix3 d;
  d << 0.4, -0.7, 0.2, 0.9, 0.3, -0.5, -0.6, 0.8, 0.1;
  return d / d.norm();
}

Matrix3 unflatten(const Vector9& v) {
  return Eigen::Map<const Matrix3>(v.data());
}

// Slope of log remainder over log step between the largest and the smallest step.
double slope(const std::vector<double>& steps, const std::vector<double>& remainders) {
  return std::log(remainders.front() / remainders.back()) / std::log(steps.front() / steps.back());
}

const std::vector<double> kSteps{1e-3, 5e-4, 2.5e-4, 1.25e-4};

template <class M>
class MaterialBattery : public ::testing::Test {
 protected:
  const decltype(Sample<M>::make()) material_ = Sample<M>::make();
};

// All models of the program and more.
template <class Models, class... More>
struct Extending;
template <class... M, class... More>
struct Extending<std::variant<M...>, More...> {
  using Types = ::testing::Types<M..., More...>;
};
using AllMaterials = Extending<IsotropicModel, CustomNeoHookean, CustomFibreRubber,
                               QuadraticNeoHookean, QuadraticMooneyRivlin>::Types;
TYPED_TEST_SUITE(MaterialBattery, AllMaterials);

// These properties hold only without a preferred direction.
template <class M>
class IsotropicBattery : public MaterialBattery<M> {};

using IsotropicMaterials =
    Extending<IsotropicModel, CustomNeoHookean, QuadraticNeoHookean, QuadraticMooneyRivlin>::Types;
TYPED_TEST_SUITE(IsotropicBattery, IsotropicMaterials);

TYPED_TEST(MaterialBattery, RefusesBadParameters) {
  for (const double mu : {0.0, -1.0, kNan, kInfinity}) {
    EXPECT_THROW(Sample<TypeParam>::make_bad(mu, 1.0), InputError) << mu;
  }
  for (const double lambda : {-2.0 / 3.0 * 1.5, -1e9, kNan, kInfinity, -kInfinity}) {
    EXPECT_THROW(Sample<TypeParam>::make_bad(1.5, lambda), InputError) << lambda;
  }
  EXPECT_NO_THROW(Sample<TypeParam>::make_bad(1.5, -0.99));  // between -2/3 mu and 0
  testing_support::expect_error([&] { Sample<TypeParam>::make_bad(-1.5, 1.0); },
                                {Sample<TypeParam>::kName, "-1.5"});
}

TYPED_TEST(MaterialBattery, RestStateIsFreeOfEnergyAndStress) {
  const Matrix3 rest = Matrix3::Identity();
  EXPECT_TRUE(this->material_.admissible(rest));
  EXPECT_EQ(this->material_.energy_density(rest), 0.0);
  EXPECT_EQ(this->material_.first_piola(rest).norm(), 0.0);
  EXPECT_LT(this->material_.first_piola(rotation()).norm(), 1e-14);
}

TYPED_TEST(MaterialBattery, IsObjective) {
  const Matrix3 r = rotation();
  for (const Matrix3& f : deformations()) {
    const Matrix3 rf = r * f;
    const double energy = this->material_.energy_density(f);
    EXPECT_NEAR(this->material_.energy_density(rf), energy, 1e-12 * energy);
    const Matrix3 stress = this->material_.first_piola(f);
    EXPECT_LT((this->material_.first_piola(rf) - r * stress).norm(), 1e-12 * stress.norm());
    // The Kirchhoff stress P Fᵀ is symmetric: no torque inside the body.
    const Matrix3 kirchhoff = stress * f.transpose();
    EXPECT_LT((kirchhoff - kirchhoff.transpose()).norm(), 1e-12 * kirchhoff.norm());
  }
}

TYPED_TEST(IsotropicBattery, IsIsotropic) {
  const Matrix3 r = rotation();
  for (const Matrix3& f : deformations()) {
    const double energy = this->material_.energy_density(f);
    EXPECT_NEAR(this->material_.energy_density(f * r), energy, 1e-12 * energy);
  }
}

TYPED_TEST(MaterialBattery, StressIsTheDerivativeOfEnergy) {
  const Matrix3 d = direction();
  for (const Matrix3& f : deformations()) {
    const double energy = this->material_.energy_density(f);
    const double exact = this->material_.first_piola(f).cwiseProduct(d).sum();
    ASSERT_GT(std::abs(exact), 1e-2);
    std::vector<double> remainders;
    remainders.reserve(kSteps.size());
    for (const double h : kSteps) {
      remainders.push_back(
          std::abs(this->material_.energy_density(f + h * d) - energy - h * exact));
    }
    EXPECT_NEAR(slope(kSteps, remainders), 2.0, 0.05);
    const double h = 1e-5;
    const double difference =
        (this->material_.energy_density(f + h * d) - this->material_.energy_density(f - h * d)) /
        (2.0 * h);
    EXPECT_LT(std::abs(difference - exact), 1e-8 * std::abs(exact));
  }
}

TYPED_TEST(MaterialBattery, StiffnessIsTheDerivativeOfStress) {
  const Matrix3 d = direction();
  for (const Matrix3& f : deformations()) {
    const Matrix3 stress = this->material_.first_piola(f);
    const Matrix3 exact = unflatten(this->material_.stiffness(f) * flatten(d));
    ASSERT_GT(exact.norm(), 1e-2);
    std::vector<double> remainders;
    remainders.reserve(kSteps.size());
    for (const double h : kSteps) {
      remainders.push_back((this->material_.first_piola(f + h * d) - stress - h * exact).norm());
    }
    EXPECT_NEAR(slope(kSteps, remainders), 2.0, 0.05);
    // Column by column, so that no entry can hide.
    const Matrix9 stiffness = this->material_.stiffness(f);
    for (int k = 0; k < 9; ++k) {
      const double h = 1e-5;
      const Matrix3 unit = unflatten(Vector9::Unit(k));
      const Vector9 difference = flatten(
          (this->material_.first_piola(f + h * unit) - this->material_.first_piola(f - h * unit)) /
          (2.0 * h));
      EXPECT_LT((difference - stiffness.col(k)).norm(), 1e-8 * stiffness.col(k).norm()) << k;
    }
  }
}

TYPED_TEST(MaterialBattery, StiffnessIsSymmetric) {
  for (const Matrix3& f : deformations()) {
    const Matrix9 stiffness = this->material_.stiffness(f);
    EXPECT_LT((stiffness - stiffness.transpose()).norm(), 1e-14 * stiffness.norm());
  }
}

// At rest A:dF = 2μ sym dF + λ tr(dF) I, so the three rotations are its null space.
TYPED_TEST(IsotropicBattery, SmallStrainsFollowHooke) {
  const LameParameters lame = this->material_.initial_lame();
  const Matrix9 stiffness = this->material_.stiffness(Matrix3::Identity());
  for (int k = 0; k < 9; ++k) {
    const Matrix3 df = unflatten(Vector9::Unit(k));
    const Matrix3 hooke =
        lame.mu * (df + df.transpose()) + lame.lambda * df.trace() * Matrix3::Identity();
    EXPECT_LT((unflatten(stiffness.col(k)) - hooke).norm(), 1e-14 * hooke.norm() + 1e-15) << k;
  }
  const Eigen::SelfAdjointEigenSolver<Matrix9> modes(stiffness);
  EXPECT_LT(std::abs(modes.eigenvalues()[2]), 1e-14);
  EXPECT_GT(modes.eigenvalues()[3], 0.1);
}

// Ψ tends to that of Hooke's law, and keeps its digits on the way: formulas that subtract numbers
// of order one would lose them all. The last direction is a rotation to first order.
TYPED_TEST(IsotropicBattery, EnergyOfTinyStrainsIsHookes) {
  const LameParameters lame = this->material_.initial_lame();
  for (const double size : {1e-3, 1e-6, 1e-9}) {
    for (const Matrix3& d : {direction(), Matrix3(Matrix3::Identity() / std::sqrt(3.0)),
                             Matrix3(direction() - direction().transpose())}) {
      const Matrix3 f = Matrix3::Identity() + size * d;
      // The stored F is not exactly I + size d; the strain must be that of the stored one.
      const Matrix3 s = f - Matrix3::Identity();
      const Matrix3 e = 0.5 * (s + s.transpose() + s.transpose() * s);
      const double hooke = lame.mu * e.squaredNorm() + 0.5 * lame.lambda * e.trace() * e.trace();
      EXPECT_NEAR(this->material_.energy_density(f), hooke, (20.0 * e.norm() + 1e-12) * hooke);
    }
  }
}

TYPED_TEST(MaterialBattery, FarFromRestEnergyIsPositiveAndFinite) {
  for (const double stretch : {0.01, 0.5, 0.9, 1.1, 3.0, Sample<TypeParam>::kFar}) {
    const Matrix3 f = Vector3(stretch, 1.0, 1.0).asDiagonal();
    EXPECT_GT(this->material_.energy_density(f), 0.0) << stretch;
    EXPECT_TRUE(this->material_.first_piola(f).allFinite());
    EXPECT_TRUE(this->material_.stiffness(f).allFinite());
  }
}

TYPED_TEST(MaterialBattery, NamesItselfInTheVariant) {
  const MaterialModel model = this->material_;
  EXPECT_EQ(material_name(model), Sample<TypeParam>::kName);
  EXPECT_EQ(initial_lame(model).mu, this->material_.initial_lame().mu);
  EXPECT_EQ(initial_lame(model).lambda, this->material_.initial_lame().lambda);
}

// Literal energies of F = I + s D computed with 60 digits (mpmath) from the formulas as they stand
// in the header; D = [[4, −7, 2], [9, 3, −5], [−6, 8, 1]] and s a power of two, so that F is exact.
struct TinyStrainCase {
  int exponent;  // s = 2^exponent
  double stvk;
  double neo_hookean;
  double mooney_rivlin;
};

class TinyStrain : public ::testing::TestWithParam<TinyStrainCase> {};

TEST_P(TinyStrain, EnergyAgreesWithManyDigits) {
  Matrix3 d;
  d << 4, -7, 2, 9, 3, -5, -6, 8, 1;
  const Matrix3 f = Matrix3::Identity() + std::ldexp(1.0, GetParam().exponent) * d;
  const auto expect = [](double energy, double exact) {
    EXPECT_NEAR(energy, exact, 1e-12 * exact);
  };
  expect(Sample<StVenantKirchhoff>::make().energy_density(f), GetParam().stvk);
  expect(Sample<NeoHookean>::make().energy_density(f), GetParam().neo_hookean);
  expect(Sample<MooneyRivlin>::make().energy_density(f), GetParam().mooney_rivlin);
}

INSTANTIATE_TEST_SUITE_P(
    Sizes, TinyStrain,
    ::testing::Values(
        TinyStrainCase{-4, 1.8885229110717774, 9.8399935061699683e-1, 1.1645944306683406},
        TinyStrainCase{-10, 1.1769637770839836e-4, 1.1673951147866929e-4, 1.1693440588149071e-4},
        TinyStrainCase{-24, 4.2579349984718357e-13, 4.2579328896380976e-13, 4.257933318802303e-13},
        TinyStrainCase{-34, 4.0606759562658548e-19, 4.0606759543018541e-19,
                       4.0606759547015436e-19}));

TEST(Admissible, FollowsTheSignOfTheJacobian) {
  const Matrix3 inverted = Vector3(-1.0, 1.0, 1.0).asDiagonal();
  const Matrix3 flat = Vector3(0.0, 1.0, 1.0).asDiagonal();
  const Matrix3 undefined = Matrix3::Constant(kNan);
  EXPECT_TRUE(Sample<StVenantKirchhoff>::make().admissible(inverted));
  EXPECT_FALSE(Sample<StVenantKirchhoff>::make().admissible(undefined));
  EXPECT_FALSE(Sample<NeoHookean>::make().admissible(inverted));
  EXPECT_FALSE(Sample<NeoHookean>::make().admissible(flat));
  EXPECT_FALSE(Sample<NeoHookean>::make().admissible(undefined));
  EXPECT_FALSE(Sample<MooneyRivlin>::make().admissible(inverted));
  EXPECT_FALSE(Sample<MooneyRivlin>::make().admissible(flat));
  EXPECT_FALSE(Sample<MooneyRivlin>::make().admissible(undefined));
  EXPECT_FALSE(Sample<CustomNeoHookean>::make().admissible(inverted));
  EXPECT_TRUE(CustomMaterial(StVenantKirchhoff(1.0, 1.0)).admissible(inverted));
}

TEST(MooneyRivlinMaterial, WithoutSecondModulusIsNeoHookean) {
  const NeoHookean neo(1.3, 2.1);
  const MooneyRivlin mooney(1.3, 0.0, 2.1);
  for (const Matrix3& f : deformations()) {
    EXPECT_DOUBLE_EQ(mooney.energy_density(f), neo.energy_density(f));
    EXPECT_LT((mooney.first_piola(f) - neo.first_piola(f)).norm(), 1e-14);
    EXPECT_LT((mooney.stiffness(f) - neo.stiffness(f)).norm(), 1e-14);
  }
}

TEST(MooneyRivlinMaterial, RefusesWhatOnlyItCanGetWrong) {
  EXPECT_THROW(MooneyRivlin(-0.1, 1.0, 1.0), InputError);
  EXPECT_THROW(MooneyRivlin(1.0, -0.1, 1.0), InputError);
  EXPECT_THROW(MooneyRivlin(0.0, 0.0, 1.0), InputError);
  EXPECT_THROW(MooneyRivlin(1.0, kNan, 1.0), InputError);
  // Its small-strain lambda is lambda + 2 mu2: -1.5 alone is below -2/3 (mu1 + mu2), -0.5 is not.
  EXPECT_NO_THROW(MooneyRivlin(0.5, 0.5, -1.5));
  EXPECT_THROW(MooneyRivlin(0.5, 0.5, -1.7), InputError);
}

TEST(YeohMaterial, RefusesWhatOnlyItCanGetWrong) {
  EXPECT_THROW(Yeoh(1.0, kNan, 0.0, 1.0), InputError);
  EXPECT_THROW(Yeoh(1.0, 0.0, kInfinity, 1.0), InputError);
  EXPECT_NO_THROW(Yeoh(1.0, -3.0, -2.0, 1e-3));
}

TEST(YeohMaterial, FromYoungHasTheSmallStrainResponse) {
  const LameParameters lame = lame_from_young(2.6, 0.3);
  const Yeoh material = Yeoh::from_young(lame, -0.1, 0.2);
  EXPECT_NEAR(material.initial_lame().mu, lame.mu, 1e-15);
  EXPECT_NEAR(material.initial_lame().lambda, lame.lambda, 1e-15);
  EXPECT_EQ(material.c20(), -0.1);
  EXPECT_EQ(material.c30(), 0.2);
}

// Far from rest in volume alone, Ψ is κ/2 (J − 1)².
TEST(YeohMaterial, PureChangesOfVolumeMeetTheBulkModulusAlone) {
  const Yeoh material(1.0, 0.5, 0.25, 40.0);
  for (const double j : {0.2, 0.82, 0.84, 0.999, 1.001, 1.2, 1.21, 5.0}) {
    const double expected = 20.0 * (j - 1.0) * (j - 1.0);
    EXPECT_NEAR(material.energy_density(std::cbrt(j) * Matrix3::Identity()), expected,
                1e-11 * expected + 1e-15)
        << j;
  }
}

TEST(VolumetricParts, DifferInTheVolumeAlone) {
  const NeoHookean logarithmic(1.3, 2.1);
  const NeoHookean quadratic(1.3, 2.1, VolumetricPart::kQuadratic);
  for (const Matrix3& f : deformations()) {
    const double j = f.determinant();
    const double expected = 1.05 * ((j - 1.0) * (j - 1.0) - std::log(j) * std::log(j));
    EXPECT_NEAR(quadratic.energy_density(f) - logarithmic.energy_density(f), expected, 1e-14);
  }
  Matrix3 shear = Matrix3::Identity();
  shear(0, 1) = 0.7;
  EXPECT_DOUBLE_EQ(quadratic.energy_density(shear), logarithmic.energy_density(shear));
}

TEST(Conversion, OfYoungAndPoissonIsTheTextbooks) {
  const LameParameters lame = lame_from_young(2.6, 0.3);
  EXPECT_DOUBLE_EQ(lame.mu, 1.0);
  EXPECT_DOUBLE_EQ(lame.lambda, 1.5);
  EXPECT_DOUBLE_EQ(lame_from_young(3.0, 0.0).lambda, 0.0);
  EXPECT_LT(lame_from_young(3.0, -0.5).lambda, 0.0);
}

TEST(Conversion, RefusesWhatNoMaterialHas) {
  for (const double young : {0.0, -1.0, kNan, kInfinity}) {
    EXPECT_THROW(lame_from_young(young, 0.3), InputError) << young;
  }
  for (const double poisson : {-1.0, -2.0, 0.5, 0.7, kNan, kInfinity}) {
    EXPECT_THROW(lame_from_young(1.0, poisson), InputError) << poisson;
  }
  for (const double ratio : {-0.1, kNan, kInfinity}) {
    EXPECT_THROW(mooney_rivlin_from_young(1.0, 0.3, ratio), InputError) << ratio;
  }
  testing_support::expect_error([&] { lame_from_young(1.0, 0.5); }, {"Take 0.49"});
}

TEST(Conversion, OfMooneyRivlinKeepsTheSmallStrainResponse) {
  for (const double ratio : {0.0, 0.25, 1.0, 4.0}) {
    const MooneyRivlin material = mooney_rivlin_from_young(2.6, 0.3, ratio);
    EXPECT_NEAR(material.initial_lame().mu, 1.0, 1e-15);
    EXPECT_NEAR(material.initial_lame().lambda, 1.5, 1e-14);
    // The response itself, not only what the material says of it.
    const Matrix9 stiffness = material.stiffness(Matrix3::Identity());
    EXPECT_NEAR(stiffness(0, 0), 3.5, 1e-14);
    EXPECT_NEAR(stiffness(0, 4), 1.5, 1e-14);
    EXPECT_NEAR(stiffness(1, 3), 1.0, 1e-14);
  }
  EXPECT_NEAR(mooney_rivlin_from_young(2.6, 0.3, 3.0).energy_density(Vector3(2, 1, 1).asDiagonal()),
              MooneyRivlin(0.25, 0.75, 0.0).energy_density(Vector3(2, 1, 1).asDiagonal()), 1e-14);
}

TEST(WaveSpeed, IsThatOfCompressionWaves) {
  EXPECT_DOUBLE_EQ(wave_speed({2.0, 5.0}, 4.0), 1.5);
}

// I₂ = λ₁²λ₂² + λ₂²λ₃² + λ₃²λ₁², without cancellation, in the material and in the element loop.
TEST(MooneyRivlinEnergy, IsRightAtLargeStretches) {
  const MooneyRivlin material(1e3, 1e3, 1e4);
  for (const Vector3& stretch : {Vector3(1e3, 1, 1), Vector3(1e6, 1, 1), Vector3(1e8, 1e-4, 1e-4),
                                 Vector3(1e10, 1e-5, 1e-5)}) {
    const Vector3 squares = stretch.cwiseAbs2();
    const double i2 = squares[0] * squares[1] + squares[1] * squares[2] + squares[2] * squares[0];
    const double log_j = std::log(stretch.prod());
    const double expected = 500.0 * (squares.sum() - 3.0 - 2.0 * log_j) +
                            500.0 * (i2 - 3.0 - 4.0 * log_j) + 5e3 * log_j * log_j;
    EXPECT_NEAR(material.energy_density(stretch.asDiagonal()), expected, 1e-12 * expected);
    const TetMesh mesh = generate_box({1, 1, 1}, {1, 1, 1});
    const RestState rest(mesh);
    const ElasticPotential potential(rest, material);
    Vector q = mesh.rest_positions();
    for (Index i = 0; i < q.size(); ++i) q[i] *= stretch[i % 3];
    double energy = 0.0;
    ASSERT_TRUE(potential.value(q, energy).ok());
    EXPECT_NEAR(energy, expected, 1e-12 * expected) << stretch.transpose();
  }
}

}  // namespace
}  // namespace tetraction
