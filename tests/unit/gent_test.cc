// Gent's law: closed forms, the neo-Hookean limit, and the limit of the stretch.
#include <gtest/gtest.h>

#include <cmath>

#include "support/homogeneous_stretches.h"
#include "tetraction/core/error.h"
#include "tetraction/dynamics/mechanical_system.h"
#include "tetraction/dynamics/steppers/stability.h"
#include "tetraction/dynamics/steppers/stepper.h"
#include "tetraction/fem/elastic_potential.h"
#include "tetraction/fem/step_length.h"
#include "tetraction/material/material.h"
#include "tetraction/mesh/generate.h"
#include "tetraction/solver/newton_minimizer.h"
#include "tetraction/solver/newton_root_finder.h"

namespace tetraction {
namespace {

using namespace testing_support;

// Published: σ₁ − σ₃ = μ Jm/(Jm − Ī₁ + 3) (λ₁² − λ₃²).
TEST(Gent, NominalStressesAreThePublishedOnes) {
  constexpr double kMu = 0.27;
  constexpr double kJm = 86.0;
  const Gent material(kMu, kJm, 1e3);
  for (const double stretch : {0.4, 1.0 + 1e-6, 1.5, 3.0, 6.0, 8.5}) {
    for (const Deformation& state : deformations()) {
      const Vector3 stretches = state.stretches(stretch);
      const Vector3 rates = state.rates(stretch);
      const double x = stretches.squaredNorm() - 3.0;
      if (x >= kJm) continue;
      const double exact = kMu * kJm / (kJm - x) * stretches.dot(rates);
      EXPECT_NEAR(nominal_stress(material, state, stretch), exact,
                  1e-12 * kMu * stretches.squaredNorm() * kJm / (kJm - x))
          << state.name << " " << stretch;
    }
  }
}

TEST(Gent, IsTheNeoHookeanLimitForAnUnreachableLimit) {
  const Gent gent(1.3, 1e12, 4.0);
  const Yeoh neo(0.65, 0.0, 0.0, 4.0);
  Matrix3 d;
  d << 0.4, -0.7, 0.2, 0.9, 0.3, -0.5, -0.6, 0.8, 0.1;
  for (const double size : {1e-8, 1e-6, 1e-3, 0.1, 0.5}) {
    const Matrix3 f = Matrix3::Identity() + size * d;
    const double energy = neo.energy_density(f);
    EXPECT_NEAR(gent.energy_density(f), energy, 1e-7 * energy) << size;
    EXPECT_LT((gent.first_piola(f) - neo.first_piola(f)).norm(), 1e-7 * neo.first_piola(f).norm());
    EXPECT_LT((gent.stiffness(f) - neo.stiffness(f)).norm(), 1e-7 * neo.stiffness(f).norm());
  }
}

TEST(Gent, IsDefinedBelowItsLimitOnly) {
  const Gent material(1.0, 2.0, 5.0);
  const auto shear = [](double gamma) {
    Matrix3 f = Matrix3::Identity();
    f(0, 1) = gamma;
    return f;
  };
  EXPECT_TRUE(material.admissible(shear(1.41)));  // Ī₁ − 3 = γ²
  EXPECT_FALSE(material.admissible(shear(1.415)));
  EXPECT_FALSE(material.admissible(Vector3(-1.0, 1.0, 1.0).asDiagonal()));
  EXPECT_NEAR(material.stretch_margin(shear(1.0)), 0.5, 1e-15);
  EXPECT_THROW(Gent(1.0, 0.0, 1.0), InputError);
  EXPECT_THROW(Gent(1.0, -3.0, 1.0), InputError);
  EXPECT_THROW(Gent(1.0, 0.99e-8, 1.0), InputError);
  EXPECT_NO_THROW(Gent(1.0, 1e-8, 1.0));
  EXPECT_THROW(Gent(-1.0, 3.0, 1.0), InputError);
  // The kernels say so, too.
  const TetMesh mesh = generate_box({1, 1, 1}, {2, 2, 2});
  const RestState rest(mesh);
  const ElasticPotential potential(rest, MaterialField(material));
  double energy = 0.0;
  for (const double gamma : {1.41, 1.415}) {
    Vector q = mesh.rest_positions();
    for (Index v = 0; v < mesh.vertex_count(); ++v) q[3 * v] += gamma * q[3 * v + 1];
    EXPECT_EQ(potential.value(q, energy).ok(), gamma < 1.412);
    EXPECT_EQ(potential.admissible(q).ok(), gamma < 1.412);
  }
}

// At rest the stiffness does not depend on Jm.
TEST(Gent, TheStabilityLimitAtRestIsThatOfAnyLimit) {
  const TetMesh mesh = generate_box({2, 1, 1}, {2, 1, 1});
  const auto limit = [&](double jm) {
    const MechanicalSystem system(mesh, MaterialField(Gent(4e5, jm, 1e6)), 1000.0);
    return stability_limit(system, system.rest_state().position).critical_step;
  };
  const double expected = limit(1e3);
  for (const double jm : {Gent::kLeastLimit, 1e-6, 1e-3, 1.0}) {
    EXPECT_NEAR(limit(jm), expected, 1e-6 * expected) << jm;
  }
}

TEST(Gent, StepsStopBeforeTheLimit) {
  const TetMesh mesh = generate_box({1, 1, 1}, {2, 2, 2});
  const RestState rest(mesh);
  const Gent material(1.0, 2.0, 5.0);
  const ElasticPotential potential(rest, MaterialField(material));
  const Vector q = mesh.rest_positions();
  Vector d = Vector::Zero(q.size());
  for (Index v = 0; v < mesh.vertex_count(); ++v) d[3 * v] = q[3 * v + 1];
  EXPECT_TRUE(has_stretch_limit(potential));
  EXPECT_EQ(stretch_limited_step(potential, q, d, 1.0), 1.0);
  for (const double size : {1.3, 3.0, 1e3}) {
    const double t = stretch_limited_step(potential, q, size * d, 1.0);
    const double margin = 1.0 - 0.5 * t * t * size * size;
    EXPECT_GT(margin, 0.1) << size;
    EXPECT_LT(margin, size < 1.4 ? 0.2 : 0.3) << size;
  }
  EXPECT_FALSE(has_stretch_limit(ElasticPotential(rest, MaterialField(NeoHookean(1.0, 1.0)))));
  // Ī₁ − 3 = γ² of a shear γ.
  EXPECT_NEAR(least_stretch_margin(potential, q + d), 0.5, 1e-14);
  EXPECT_LT(least_stretch_margin(potential, q + 2.0 * d), 0.0);
}

// The shear γ of the body grows by 1 in each second: γ² is 2 at the limit.
TEST(Gent, EnergyMomentumSaysWhyAStepToTheLimitFails) {
  const TetMesh mesh = generate_box({1, 1, 1}, {1, 1, 1});
  MechanicalSystem system(mesh, MaterialField(Gent(1e-6, 2.0, 5e-6)), 1.0);
  State state = system.rest_state();
  for (Index v = 0; v < system.vertex_count(); ++v) {
    state.momentum[3 * v] = 1e3 * system.mass()[v] * state.position[3 * v + 1];
  }
  const auto stepper = make_energy_momentum_stepper(system, make_newton_minimizer(system, {}),
                                                    make_newton_root_finder(system, {}));
  const StepOutcome outcome = stepper->step(state, 1.0);
  ASSERT_FALSE(outcome.ok());
  EXPECT_NE(outcome.message.find("-ln(margin)"), std::string::npos) << outcome.message;
  EXPECT_NE(outcome.message.find("smaller step"), std::string::npos) << outcome.message;
}

}  // namespace
}  // namespace tetraction
