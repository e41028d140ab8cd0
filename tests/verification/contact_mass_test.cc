// Light contact vertices: the force of an impact without chatter, and what they leave as it is.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "support/obstacles.h"
#include "support/rules.h"
#include "tetraction/simulation/probe.h"
#include "tetraction/solver/normal_modes.h"

namespace tetraction {
namespace {

using namespace testing_support;

constexpr double kBarLength = 1.0;
constexpr double kBarWidth = 0.05;
constexpr double kBarModulus = 1e6;
constexpr double kBarDensity = 1e3;

struct Impact {
  double error = 0.0;    // L² norm of the force's error over that of the force
  double rebound = 0.0;  // momentum after the impact over that before it
  double drift = 0.0;    // of the energy
};

// A bar of 40 cells with ν = 0 that hits a wall with v₀ = c/1000, of vertices that move along its axis only. The wall
// presses with ρ c v₀ A for 2 L/c, and then the bar leaves it with v₀. The layer is so thin and soft that it is pressed
// together by a fifth in a tenth of the time that a wave needs for a cell. The force is that of a probe, as its mean
// over the time of a wave through a cell.
Impact impact_of_bar(Integrator rule, double mass) {
  constexpr int kCells = 40;
  constexpr double kEdge = kBarLength / kCells;
  constexpr int kStepsPerCell = 5;
  const double c = std::sqrt(kBarModulus / kBarDensity);
  const double v0 = 1e-3 * c;
  const double crossing = kEdge / c;
  Scene scene = scene_of({GeneratorKind::kBox, {kBarLength, kBarWidth, kBarWidth}, {kCells, 1, 1}},
                         elastic(kBarModulus, 0.0, kBarDensity));
  scene.time = {rule, crossing / kStepsPerCell, false, 3.0 * kBarLength / c};
  scene.solver.tolerance = 1e-10;
  scene.initial.velocity = {-v0, 0.0, 0.0};
  scene.fix.push_back(fix(SelectAll{}, {false, true, true}));
  ObstacleSettings wall = plane_obstacle("wall", {-0.003 * kEdge, 0.0, 0.0}, {1.0, 0.0, 0.0});
  wall.thickness = 0.0029 * kEdge;
  wall.stiffness = 0.03 * kBarModulus;
  wall.select = SelectFaces{{-1.0, 0.0, 0.0}, {}};
  scene.obstacle = {wall};
  scene.contact.mass = mass;
  scene.probe = {probe_on("wall", "wall")};
  Session session(scene, mesh_of(scene));
  const double force = kBarDensity * c * v0 * kBarWidth * kBarWidth;
  const double touch = 1e-4 * kEdge / v0;  // when the bar reaches the layer
  std::vector<double> values(3);
  std::vector<double> forces;
  std::vector<double> exact;
  while (session.step()) {
    session.probes().evaluate(session, values.data());
    const double middle = session.time() - 0.5 * scene.time.step;
    forces.push_back(values[0] / force);
    exact.push_back(middle > touch && middle < touch + 2.0 * kBarLength / c ? 1.0 : 0.0);
  }
  EXPECT_EQ(session.status(), RunStatus::kFinished) << session.message();
  double square = 0.0;
  double whole = 0.0;
  for (std::size_t i = 0; i + kStepsPerCell <= forces.size(); ++i) {
    double mean = 0.0;
    double mean_exact = 0.0;
    for (std::size_t k = i; k < i + kStepsPerCell; ++k) {
      mean += forces[k] / kStepsPerCell;
      mean_exact += exact[k] / kStepsPerCell;
    }
    square += (mean - mean_exact) * (mean - mean_exact);
    whole += mean_exact * mean_exact;
  }
  Impact impact;
  impact.error = std::sqrt(square / whole);
  impact.rebound = session.balance().momenta().linear.x() /
                   (kBarDensity * kBarLength * kBarWidth * kBarWidth * v0);
  impact.drift = session.balance().max_relative_energy_drift();
  return impact;
}

TEST(ContactMass, MakesTheForceOfAnImpactSmooth) {
  for (const Integrator rule : {Integrator::kEnergyMomentum, Integrator::kMidpoint}) {
    const Impact whole = impact_of_bar(rule, 1.0);
    const Impact light = impact_of_bar(rule, 0.01);
    RecordProperty(std::string("error_whole_") + to_string(rule), std::to_string(whole.error));
    RecordProperty(std::string("error_light_") + to_string(rule), std::to_string(light.error));
    RecordProperty(std::string("rebound_light_") + to_string(rule), std::to_string(light.rebound));
    EXPECT_GT(whole.error, 0.25);
    EXPECT_LT(light.error, 0.10);
    EXPECT_GT(light.rebound, 0.98);
    EXPECT_LT(light.rebound, 1.0);
    if (rule == Integrator::kEnergyMomentum) {
      EXPECT_LT(light.drift, 1e-10);  // the solver's tolerance
    }
  }
}

// The frequencies of a bar with one light end: the first six are those of the bar with all its mass up to 0.2 %.
TEST(ContactMass, ChangesLowFrequenciesLittle) {
  std::vector<std::vector<double>> frequencies;
  for (const double mass : {1.0, 0.01}) {
    Scene scene = scene_of({GeneratorKind::kBox, {kBarLength, kBarWidth, kBarWidth}, {40, 1, 1}},
                           elastic(kBarModulus, 0.0, kBarDensity));
    scene.fix.push_back(fix(SelectAll{}, {false, true, true}));
    ObstacleSettings wall = plane_obstacle("wall", {-0.1, 0.0, 0.0}, {1.0, 0.0, 0.0});
    wall.select = SelectFaces{{-1.0, 0.0, 0.0}, {}};
    scene.obstacle = {wall};
    scene.contact.mass = mass;
    const auto system = make_system(scene, mesh_of(scene));
    make_initial_state(scene, *system);
    NormalModeOptions options;
    options.count = 7;
    const NormalModes modes = normal_modes(*system, system->mesh().rest_positions(), options);
    frequencies.emplace_back();
    for (const NormalMode& mode : modes.modes) {
      frequencies.back().push_back(std::sqrt(mode.omega_squared) / (2.0 * std::numbers::pi));
    }
  }
  const double c = std::sqrt(kBarModulus / kBarDensity);
  for (std::size_t k = 1; k <= 6; ++k) {
    const double exact = 0.5 * static_cast<double>(k) * c / kBarLength;
    // Lumped masses have ω²ℓ²/(24c²) of dispersion: 0.9 % at the sixth.
    EXPECT_NEAR(frequencies[0][k], exact, 0.012 * exact) << k;
    EXPECT_NEAR(frequencies[1][k], frequencies[0][k], 0.002 * exact) << k;
    EXPECT_NE(frequencies[1][k], frequencies[0][k]);
  }
}

}  // namespace
}  // namespace tetraction
