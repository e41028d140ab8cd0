#include "tetraction/simulation/scene.h"

#include <string>

#include "support/messages.h"

namespace tetraction {
namespace {

std::string refusal(const MaterialSettings& settings) {
  return testing_support::message_of([&] { make_material(settings); });
}

MaterialSettings settings_of(const std::string& model) {
  MaterialSettings settings;
  settings.model = model;
  return settings;
}

bool mentions(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(IntegratorNames, AreInvertible) {
  for (const Integrator integrator :
       {Integrator::kExplicit, Integrator::kVerlet, Integrator::kMidpoint,
        Integrator::kBackwardEuler, Integrator::kEnergyMomentum}) {
    EXPECT_EQ(integrator_from_string(to_string(integrator)), integrator);
  }
  EXPECT_EQ(to_string(Integrator::kBackwardEuler), "backward-euler");
}

TEST(IntegratorNames, UnknownOnesAreRefusedWithTheKnown) {
  for (const char* name : {"", "Explicit", "rk4", "energy momentum"}) {
    testing_support::expect_error(
        [&] { integrator_from_string(name); },
        {"explicit", "verlet", "midpoint", "backward-euler", "energy-momentum"});
  }
}

TEST(LinearSolverNames, AreInvertible) {
  for (const LinearSolver linear :
       {LinearSolver::kAuto, LinearSolver::kMatrixFree, LinearSolver::kCg, LinearSolver::kFactor}) {
    EXPECT_EQ(from_string<LinearSolver>(to_string(linear)), linear);
  }
  EXPECT_EQ(to_string(LinearSolver::kMatrixFree), "matrix-free");
}

TEST(LinearSolverNames, UnknownOnesAreRefusedWithTheKnown) {
  for (const char* name : {"", "CG", "cholesky"}) {
    testing_support::expect_error([&] { from_string<LinearSolver>(name); },
                                  {"auto", "matrix-free", "cg", "factor"});
  }
}

TEST(IntegratorKinds, AreAsThePhysicsSays) {
  EXPECT_FALSE(is_implicit(Integrator::kExplicit));
  EXPECT_FALSE(is_implicit(Integrator::kVerlet));
  EXPECT_TRUE(is_implicit(Integrator::kMidpoint));
  EXPECT_TRUE(is_implicit(Integrator::kBackwardEuler));
  EXPECT_TRUE(is_implicit(Integrator::kEnergyMomentum));
  EXPECT_TRUE(needs_root_finder(Integrator::kEnergyMomentum));
  EXPECT_FALSE(needs_root_finder(Integrator::kMidpoint));
  EXPECT_EQ(order(Integrator::kEnergyMomentum), 2);
  EXPECT_TRUE(is_variational(Integrator::kExplicit));
  EXPECT_TRUE(is_variational(Integrator::kVerlet));
  EXPECT_TRUE(is_variational(Integrator::kMidpoint));
  EXPECT_FALSE(is_variational(Integrator::kBackwardEuler));
  EXPECT_FALSE(is_variational(Integrator::kEnergyMomentum));
}

TEST(MakeMaterial, TakesYoungAndPoisson) {
  for (const char* model : {"stvk", "neo-hookean"}) {
    MaterialSettings settings = settings_of(model);
    settings.youngs_modulus = 2.6;
    settings.poissons_ratio = 0.3;
    const MaterialModel material = make_material(settings);
    EXPECT_EQ(material_name(material), model);
    EXPECT_DOUBLE_EQ(initial_lame(material).mu, 1.0);
    EXPECT_DOUBLE_EQ(initial_lame(material).lambda, 1.5);
  }
}

TEST(MakeMaterial, TakesLameParameters) {
  for (const char* model : {"stvk", "neo-hookean"}) {
    MaterialSettings settings = settings_of(model);
    settings.numbers["mu"] = 3.0;
    settings.numbers["lambda"] = 4.0;
    const MaterialModel material = make_material(settings);
    EXPECT_EQ(material_name(material), model);
    EXPECT_EQ(initial_lame(material).mu, 3.0);
    EXPECT_EQ(initial_lame(material).lambda, 4.0);
  }
}

TEST(MakeMaterial, TakesMooneyRivlinEitherWay) {
  MaterialSettings moduli = settings_of("mooney-rivlin");
  moduli.numbers["mu1"] = 0.75;
  moduli.numbers["mu2"] = 0.25;
  moduli.numbers["lambda"] = 1.0;
  EXPECT_EQ(material_name(make_material(moduli)), "mooney-rivlin");
  EXPECT_EQ(initial_lame(make_material(moduli)).lambda, 1.5);

  MaterialSettings young = settings_of("mooney-rivlin");
  young.youngs_modulus = 2.6;
  young.poissons_ratio = 0.3;
  young.numbers["ratio"] = 1.0 / 3.0;
  const Matrix3 f = Vector3(1.5, 0.8, 1.0).asDiagonal();
  const auto energy = [&f](const MaterialSettings& settings) {
    return std::get<MooneyRivlin>(make_material(settings)).energy_density(f);
  };
  EXPECT_NEAR(energy(young), energy(moduli), 1e-14);
}

TEST(MakeMaterial, SaysWhichParameterIsMissing) {
  MaterialSettings settings = settings_of("neo-hookean");
  settings.youngs_modulus = 1e6;
  EXPECT_TRUE(mentions(refusal(settings), "material.poissons_ratio is missing"))
      << refusal(settings);
  settings.youngs_modulus.reset();
  settings.numbers["mu"] = 1e6;
  EXPECT_TRUE(mentions(refusal(settings), "material.lambda is missing")) << refusal(settings);
  settings = settings_of("mooney-rivlin");
  settings.youngs_modulus = 1e6;
  settings.poissons_ratio = 0.3;
  EXPECT_TRUE(mentions(refusal(settings), "material.ratio is missing")) << refusal(settings);
  settings = settings_of("mooney-rivlin");
  settings.numbers["mu1"] = 1.0;
  settings.numbers["lambda"] = 1.0;
  EXPECT_TRUE(mentions(refusal(settings), "material.mu2 is missing")) << refusal(settings);
  EXPECT_TRUE(mentions(refusal(settings_of("stvk")), "is missing"));
}

TEST(MakeMaterial, RefusesMixtures) {
  MaterialSettings settings = settings_of("stvk");
  settings.youngs_modulus = 1e6;
  settings.poissons_ratio = 0.3;
  settings.numbers["mu"] = 1e5;
  EXPECT_TRUE(mentions(refusal(settings), "material.mu cannot be combined")) << refusal(settings);
  settings = settings_of("stvk");
  settings.numbers["mu"] = 1e6;
  settings.numbers["lambda"] = 1e6;
  settings.numbers["ratio"] = 1.0;
  EXPECT_TRUE(mentions(refusal(settings), "material.ratio cannot be combined"))
      << refusal(settings);
  settings = settings_of("mooney-rivlin");
  settings.numbers["mu"] = 1e6;
  settings.numbers["lambda"] = 1e6;
  EXPECT_TRUE(mentions(refusal(settings), "material.mu cannot be combined")) << refusal(settings);
}

TEST(MakeMaterial, ACustomOneIsTakenWhateverElseIsSet) {
  MaterialSettings settings = settings_of("steel");
  settings.numbers["ratio"] = -1.0;
  settings.custom = CustomMaterial(NeoHookean(3.0, 4.0), "mine", {3.0, 4.0});
  EXPECT_EQ(material_name(make_material(settings)), "mine");
  settings.custom = StVenantKirchhoff(5.0, 6.0);  // any model will do
  EXPECT_EQ(initial_lame(make_material(settings)).mu, 5.0);
  settings.custom.reset();
  EXPECT_TRUE(mentions(refusal(settings), "\"steel\""));
}

TEST(MakeMaterial, ChecksTheValues) {
  MaterialSettings settings = settings_of("neo-hookean");
  settings.numbers["mu"] = 1.0;
  settings.numbers["lambda"] = -0.7;
  EXPECT_TRUE(mentions(refusal(settings), "lambda")) << refusal(settings);
  settings.numbers["lambda"] = -0.6;
  EXPECT_EQ(refusal(settings), "accepted");
  EXPECT_TRUE(mentions(refusal(settings_of("steel")), "\"steel\""));
}

}  // namespace
}  // namespace tetraction
