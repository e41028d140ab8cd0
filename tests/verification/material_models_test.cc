// Every model of material with every rule and minimiser, and with nodal volumes.

#include <algorithm>
#include <string>
#include <tuple>

#include "support/corner_scenes.h"

namespace tetraction {
namespace {

using namespace testing_support;

std::string word(std::string name) {
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

constexpr Integrator kRules[] = {Integrator::kExplicit, Integrator::kVerlet, Integrator::kMidpoint,
                                 Integrator::kBackwardEuler, Integrator::kEnergyMomentum};

class ModelAndRule : public testing::TestWithParam<std::tuple<std::size_t, Integrator>> {
 protected:
  Scene scene() const {
    const MaterialChoice& choice = material_choices()[std::get<0>(GetParam())];
    const Integrator rule = std::get<1>(GetParam());
    Scene scene = spinning_block(rule, is_implicit(rule) ? 0.01 : 0.002, 0.2);
    scene.material.model = choice.name;
    choice.set_like(scene.material, lame_from_young(1e5, 0.3));
    return scene;
  }
  static void expect_good(const Scene& scene) {
    FinishedRun session(scene);
    const Integrator rule = std::get<1>(GetParam());
    // Backward Euler takes angular momentum away. Its residual leaves some linear momentum.
    const bool is_dissipative = rule == Integrator::kBackwardEuler;
    EXPECT_LT(session.balance().linear_momentum_drift(), is_dissipative ? 1e-7 : 1e-11);
    EXPECT_LT(session.balance().angular_momentum_drift(), is_dissipative ? 0.05 : 1e-9);
    const double drift = session.balance().max_relative_energy_drift();
    EXPECT_LT(drift, rule == Integrator::kEnergyMomentum ? 1e-10 : is_dissipative ? 1.0 : 0.05);
  }
};

TEST_P(ModelAndRule, KeepsMomentaAndEnergy) {
  expect_good(scene());
}

TEST_P(ModelAndRule, AndTheOtherMinimizer) {
  if (!is_implicit(std::get<1>(GetParam())) ||
      std::get<1>(GetParam()) == Integrator::kEnergyMomentum) {
    GTEST_SKIP() << "The rule has no minimiser.";
  }
  Scene other = scene();
  other.solver.kind = "ceres";
  expect_good(other);
}

TEST_P(ModelAndRule, WithNodalVolumes) {
  const MaterialChoice& choice = material_choices()[std::get<0>(GetParam())];
  if (choice.defined_for_any_jacobian) GTEST_SKIP() << "The energy has no volumetric part.";
  Scene nodal = scene();
  nodal.mesh.volume = VolumeRule::kNodal;
  expect_good(nodal);
}

INSTANTIATE_TEST_SUITE_P(All, ModelAndRule,
                         testing::Combine(testing::Range<std::size_t>(0, material_choices().size()),
                                          testing::ValuesIn(kRules)),
                         [](const auto& test) {
                           return word(material_choices()[std::get<0>(test.param)].name) + "_" +
                                  word(to_string(std::get<1>(test.param)));
                         });

}  // namespace
}  // namespace tetraction
