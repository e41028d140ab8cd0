// Rayleigh damping: two ratios become mass damping and viscosity.
#include "tetraction/dynamics/terms/rayleigh_damping.h"

#include <cmath>

#include "support/bodies.h"
#include "support/messages.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

using namespace testing_support;

TEST(RayleighDamping, HasTheRatiosInShear) {
  const LameParameters lame = lame_from_young(2e6, 0.3);
  for (const DampingRatio& ratio :
       {DampingRatio{{10.0, 80.0}, {0.02, 0.03}}, DampingRatio{{80.0, 10.0}, {0.03, 0.02}},
        DampingRatio{{10.0, 80.0}, {0.01, 0.08}}, DampingRatio{{10.0, 80.0}, {0.08, 0.01}}}) {
    const Damping damping = rayleigh_damping(ratio, lame);
    EXPECT_GE(damping.mass_damping, 0.0);
    EXPECT_GE(damping.viscosity, 0.0);
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_NEAR(damping_ratio(DeformationKind::kShear, damping, lame, ratio.frequency[i]),
                  ratio.value[i], 1e-14);
    }
  }
  // The ratios that one of the two alone has need exactly nothing of the other.
  EXPECT_EQ(rayleigh_damping({{10.0, 80.0}, {0.01, 0.08}}, lame).mass_damping, 0.0);
  EXPECT_EQ(rayleigh_damping({{10.0, 80.0}, {0.08, 0.01}}, lame).viscosity, 0.0);
}

// The dissipated power over the rate at which elastic energy is stored, both at the same strain
// rates, from the forces of a single tetrahedron.
TEST(RayleighDamping, RelaxationTimesAreThoseOfTheForces) {
  constexpr double kViscosity = 40.0;
  const double nu = 0.3;
  const LameParameters lame = lame_from_young(2e6, nu);
  MechanicalSystem system(generate_tetrahedron(1.0), StVenantKirchhoff(lame.mu, lame.lambda),
                          1000.0);
  system.set_damping({0.0, 0.0, kViscosity});
  const Vector q = system.rest_state().position;
  const auto time_of = [&](const Matrix3& strain) {
    Vector u(q.size());
    for (Index v = 0; v < system.vertex_count(); ++v) {
      u.segment<3>(3 * v) = strain * q.segment<3>(3 * v);
    }
    Vector elastic;
    system.elastic().product(q, u, elastic);
    Vector viscous = Vector::Zero(q.size());
    system.add_viscous_force(q, u, viscous);
    return -u.dot(viscous) / u.dot(elastic);
  };
  Matrix3 shear = Matrix3::Zero();
  shear(0, 1) = shear(1, 0) = 1.0;
  const Matrix3 tension = Vector3(1.0, -nu, -nu).asDiagonal();
  const auto expected = [&](DeformationKind kind) { return viscous_time(kind, kViscosity, lame); };
  EXPECT_NEAR(time_of(shear), expected(DeformationKind::kShear), 1e-12);
  EXPECT_NEAR(time_of(tension), expected(DeformationKind::kBending), 1e-12);
  EXPECT_NEAR(time_of(Matrix3::Identity()), expected(DeformationKind::kVolumeChange), 1e-12);
}

TEST(RayleighDamping, RefusesWhatItCannotHave) {
  const LameParameters lame = lame_from_young(2e6, 0.3);
  const auto message = [&](const DampingRatio& ratio) {
    return message_of([&] { rayleigh_damping(ratio, lame); }, "");
  };
  EXPECT_NE(message({{10.0, 80.0}, {0.01, 0.09}}).find("negative mass_damping"), std::string::npos);
  EXPECT_NE(message({{10.0, 80.0}, {0.09, 0.01}}).find("negative viscosity"), std::string::npos);
  EXPECT_NE(message({{10.0, 10.0}, {0.01, 0.02}}).find("twice"), std::string::npos);
  EXPECT_NE(message({{0.0, 10.0}, {0.01, 0.02}}).find("above 0"), std::string::npos);
  EXPECT_NE(message({{5.0, 10.0}, {-0.01, 0.02}}).find("0 or more"), std::string::npos);
  EXPECT_NE(message({{5.0, std::nan("")}, {0.01, 0.02}}).find("above 0"), std::string::npos);
}

}  // namespace
}  // namespace tetraction
