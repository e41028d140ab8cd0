// Warnings about materials that are unstable or that lock, against the energies of these materials.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <tuple>
#include <variant>

#include "tetraction/core/error.h"
#include "tetraction/mesh/edge_vertices.h"
#include "tetraction/mesh/generate.h"
#include "tetraction/simulation/session.h"
#include "tetraction/simulation/warnings.h"

namespace tetraction {
namespace {

MechanicalSystem body_of(const MaterialModel& material) {
  return MechanicalSystem(generate_box({1, 1, 1}, {1, 1, 1}), material, 1000.0);
}

std::string warning_for(const MaterialModel& material) {
  return instability_warning(body_of(material));
}

// The number after the first `words` in a text.
double number_after(const std::string& text, const std::string& words) {
  const auto found = text.find(words);
  if (found == std::string::npos) return std::numeric_limits<double>::quiet_NaN();
  return std::stod(text.substr(found + words.size()));
}

// Whether C₁₀ + 2 C₂₀ x + 3 C₃₀ x² > 0 at many points up to `most`.
bool rises_up_to(const Yeoh& m, double most) {
  for (int i = 0; i <= 10000; ++i) {
    const double x = most * i / 10000.0;
    if (!(m.c10() + 2.0 * m.c20() * x + 3.0 * m.c30() * x * x > 0.0)) return false;
  }
  return true;
}

TEST(YeohStability, HoldsUpToTheLeastRoot) {
  for (const Yeoh& material :
       {Yeoh(1.0, 0.0, -0.1, 10.0), Yeoh(1.0, 2.0, -0.1, 10.0), Yeoh(1.0, -2.0, -0.1, 10.0),
        Yeoh(1.0, -0.5, 0.0, 10.0), Yeoh(1.0, -0.2, 0.01, 10.0), Yeoh(2e5, -4e4, 2e3, 1e7),
        Yeoh(1.0, 1e6, -1e-6, 10.0)}) {
    const double x = material.unstable_from();
    ASSERT_TRUE(std::isfinite(x));
    EXPECT_GT(x, 0.0);
    EXPECT_TRUE(rises_up_to(material, x * (1.0 - 1e-9)));
    EXPECT_FALSE(rises_up_to(material, x * (1.0 + 1e-3)));
  }
  // A double root: C₂₀² = 3 C₁₀ C₃₀.
  EXPECT_DOUBLE_EQ(Yeoh(3.0, -3.0, 1.0, 10.0).unstable_from(), 1.0);
  for (const Yeoh& material :
       {Yeoh(1.0, 0.0, 0.0, 10.0), Yeoh(1.0, 5.0, 0.0, 10.0), Yeoh(1.0, 0.0, 5.0, 10.0),
        Yeoh(3.0, -2.999, 1.0, 10.0), Yeoh(1.0, 100.0, 1.0, 10.0)}) {
    EXPECT_TRUE(std::isinf(material.unstable_from()));
    EXPECT_TRUE(rises_up_to(material, 1e3));
    EXPECT_EQ(warning_for(material), "");
  }
}

// In incompressible uniaxial tension the difference of the principal Cauchy stresses changes its
// sign at the stretch that the warning names.
TEST(InstabilityWarning, NamesTheStretchAtWhichYeohGivesWay) {
  for (const Yeoh& material : {Yeoh(1.0, -0.5, 0.0, 10.0), Yeoh(1.0, 0.5, -0.01, 10.0),
                               Yeoh(2e5, -4e4, 2e3, 1e7), Yeoh(1.0, -300.0, 0.0, 10.0)}) {
    const std::string warning = warning_for(material);
    const double stretch = number_after(warning, "at a stretch of ");
    ASSERT_GT(stretch, 1.0) << warning;
    const auto tension = [&](double s) {
      const Matrix3 f = Vector3(s, 1.0 / std::sqrt(s), 1.0 / std::sqrt(s)).asDiagonal();
      const Matrix3 cauchy = material.first_piola(f) * f.transpose();
      return cauchy(0, 0) - cauchy(1, 1);
    };
    const double margin = 0.01 * (stretch - 1.0) + 0.005 * stretch;  // three digits are printed
    EXPECT_GT(tension(stretch - std::min(margin, 0.5 * (stretch - 1.0))), 0.0) << warning;
    EXPECT_LT(tension(stretch + margin), 0.0) << warning;
  }
}

// The stress of this material at the stretches λ, 1/√λ, 1/√λ vanishes where λ⁴ − λ⁻² = 20 (λ² − 1/λ): at 4.4469.
TEST(InstabilityWarning, NamesTheStretchBeforeOgdenGivesWay) {
  const Ogden material({1.0, -0.05}, {2.0, 4.0}, 10.0);
  const auto stress = [](double s) {
    return s * s - 1.0 / s - 0.05 * (std::pow(s, 4.0) - std::pow(s, -2.0));
  };
  const double stretch = number_after(warning_for(material), "at a stretch of ");
  EXPECT_GT(stress(stretch), 0.0) << stretch;
  EXPECT_LT(stress(stretch + 1e-3), 0.0) << stretch;
}

MaterialModel with_volumetric(double mu1, double mu2, double lambda, VolumetricPart part) {
  if (mu2 == 0.0) return NeoHookean(mu1, lambda, part);
  return MooneyRivlin(mu1, mu2, lambda, part);
}

double energy_at(const MaterialModel& material, double stretch) {
  return std::visit([&](const auto& m) { return m.energy_density(stretch * Matrix3::Identity()); },
                    material);
}

// The energy is largest at the stretch that the warning names, and falls without bound beyond it.
TEST(InstabilityWarning, NamesTheStretchAtWhichAVolumetricPartGivesWay) {
  for (const auto& [mu1, mu2, lambda] :
       {std::tuple{1.0, 0.0, -0.5}, {1.0, 0.0, -0.45}, {0.8, 0.2, -0.75}, {0.5, 0.5, -1.4}}) {
    for (const auto part : {VolumetricPart::kQuadratic, VolumetricPart::kLogarithmic}) {
      const bool expands = part == VolumetricPart::kQuadratic;
      const MaterialModel material = with_volumetric(mu1, mu2, lambda, part);
      const std::string warning = warning_for(material);
      const double stretch =
          number_after(warning, expands ? "stretched beyond " : "compressed below ");
      ASSERT_TRUE(expands ? stretch > 1.0 : stretch < 1.0) << warning;
      EXPECT_GT(energy_at(material, stretch), energy_at(material, 1.02 * stretch)) << warning;
      EXPECT_GT(energy_at(material, stretch), energy_at(material, 0.98 * stretch)) << warning;
      EXPECT_LT(energy_at(material, expands ? 100.0 : 1e-30), 0.0);
      // The other part has a lower bound there.
      const auto other = expands ? VolumetricPart::kLogarithmic : VolumetricPart::kQuadratic;
      const MaterialModel bounded = with_volumetric(mu1, mu2, lambda, other);
      EXPECT_GT(energy_at(bounded, expands ? 100.0 : 1e-30), 0.0);
    }
  }
}

// The other part is advised only where it is stable itself.
TEST(InstabilityWarning, AdvisesTheOtherVolumetricPartWhereThatHelps) {
  const NeoHookean little(1.0, -0.25, VolumetricPart::kQuadratic);
  EXPECT_NE(warning_for(little).find("Take volumetric = \"log\""), std::string::npos);
  EXPECT_EQ(warning_for(NeoHookean(1.0, -0.25)), "");
  for (const auto part : {VolumetricPart::kQuadratic, VolumetricPart::kLogarithmic}) {
    const std::string much = warning_for(NeoHookean(1.0, -0.5, part));
    EXPECT_NE(much.find("Take parameters"), std::string::npos) << much;
  }
}

TEST(InstabilityWarning, IsNotGivenForMaterialsWithALowerBound) {
  for (const auto part : {VolumetricPart::kQuadratic, VolumetricPart::kLogarithmic}) {
    EXPECT_EQ(warning_for(NeoHookean(1.0, 0.0, part)), "");
    EXPECT_EQ(warning_for(NeoHookean(1.0, 3.0, part)), "");
    EXPECT_EQ(warning_for(MooneyRivlin(0.5, 0.5, 0.1, part)), "");
    EXPECT_EQ(warning_for(NeoHookean(1.0, -1e-5, part)), "");  // out of reach
  }
  EXPECT_EQ(warning_for(StVenantKirchhoff(1.0, -0.5)), "");
}

// λ of Mooney–Rivlin's formula can be negative although Poisson's ratio is positive.
TEST(InstabilityWarning, LooksAtTheLambdaOfTheFormula) {
  const LameParameters lame = lame_from_young(1e6, 0.1);
  const auto material = MooneyRivlin::from_young(lame, 1.0, VolumetricPart::kQuadratic);
  ASSERT_LT(material.lambda(), 0.0);
  EXPECT_NE(warning_for(material), "");
  EXPECT_EQ(warning_for(NeoHookean::from_young(lame, VolumetricPart::kQuadratic)), "");
}

Scene rubber_scene(double c20) {
  Scene scene;
  scene.material.model = "yeoh";
  scene.material.numbers["c10"] = 1e5;
  scene.material.numbers["c20"] = c20;
  scene.material.numbers["c30"] = 0.0;
  scene.material.numbers["kappa"] = 1e6;
  scene.time = {Integrator::kVerlet, 1e-4, false, 1.0};
  return scene;
}

bool warns(const Session& session) {
  for (const std::string& warning : session.warnings()) {
    if (warning.find("unstable") != std::string::npos) return true;
  }
  return false;
}

TEST(InstabilityWarning, ComesAtTheStartOrWithTheEditThatCausesIt) {
  const TetMesh mesh = generate_box({1, 1, 1}, {1, 1, 1});
  EXPECT_TRUE(warns(Session(rubber_scene(-1e4), mesh)));
  Session session(rubber_scene(1e4), mesh);
  EXPECT_FALSE(warns(session));
  session.apply(SetMaterial{0, rubber_scene(-1e4).material});
  EXPECT_NE(session.edits().back().warning.find("unstable"), std::string::npos);
  session.apply(SetMaterial{0, rubber_scene(-2e4).material});  // it has been said already
  EXPECT_EQ(session.edits().back().warning, "");
}

// The advice for a wrong ratio must not be one that is warned of.
TEST(LockingWarning, IsNotGivenForTheRatioThatTheMessagesAdvise) {
  std::string refusal;
  try {
    lame_from_young(1e6, 0.5);
  } catch (const InputError& error) {
    refusal = error.what();
  }
  for (const std::string& text : {refusal, kPoissonsRatio.range.refusal(0.5)}) {
    const double advised = number_after(text, "ake ");
    ASSERT_TRUE(advised > 0.4 && advised < 0.5) << text;
    const LameParameters lame = lame_from_young(1e6, advised);
    const MechanicalSystem body(generate_box({1, 1, 1}, {1, 1, 1}),
                                {BodyRegion{NeoHookean(lame.mu, lame.lambda)}}, {},
                                VolumeRule::kNodal);
    EXPECT_EQ(locking_warning(body), "") << text;
    EXPECT_NE(text.find("nodal"), std::string::npos) << text;
    EXPECT_NE(text.find("quadratic"), std::string::npos) << text;
  }
  const LameParameters locking = lame_from_young(1e6, kLockingRatio);
  EXPECT_NE(locking_warning(body_of(NeoHookean(locking.mu, locking.lambda))), "");
  const MechanicalSystem nodal(generate_box({1, 1, 1}, {1, 1, 1}),
                               {BodyRegion{NeoHookean(locking.mu, locking.lambda)}}, {},
                               VolumeRule::kNodal);
  EXPECT_EQ(locking_warning(nodal), "");
  const MechanicalSystem quadratic(with_edge_vertices(generate_box({1, 1, 1}, {1, 1, 1})),
                                   NeoHookean(locking.mu, locking.lambda), 1000.0);
  EXPECT_EQ(locking_warning(quadratic), "");
}

}  // namespace
}  // namespace tetraction
