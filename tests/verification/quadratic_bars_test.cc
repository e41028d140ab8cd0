// Bars of quadratic elements: Saint-Venant's torsion, and the impact on a wall.
#include <cmath>
#include <vector>

#include "support/runs.h"
#include "tetraction/mesh/edge_vertices.h"
#include "tetraction/solver/normal_modes.h"

namespace tetraction {
namespace {

using namespace testing_support;

// A free square bar of the side a turns about its axis with f = √(G J/(ρ I_p))/2L, where J = 0.140577 a⁴
// (Saint-Venant; Timoshenko & Goodier, Theory of Elasticity, §109) and I_p = a⁴/6. Waves along the bar are
// dispersed: that lowers f by about (a/L)²/10.
TEST(QuadraticBars, TorsionIsThatOfSaintVenant) {
  constexpr double kYoung = 1e9;
  const double shear = kYoung / 2.6;
  const double exact = 0.5 * std::sqrt(shear / 1000.0 * 6.0 * 0.140577);
  std::vector<double> errors;
  for (const int cells : {2, 4}) {
    const TetMesh mesh = with_edge_vertices(generate_box({1.0, 0.1, 0.1}, {10, cells, cells}));
    const LameParameters lame = lame_from_young(kYoung, 0.3);
    const MechanicalSystem system(mesh, NeoHookean(lame.mu, lame.lambda), 1000.0);
    NormalModeOptions options;
    options.count = 11;
    const NormalModes modes = normal_modes(system, mesh.rest_positions(), options);
    // The nearest modes of bending are 9 % away.
    double best = 1.0;
    for (const NormalMode& mode : modes.modes) {
      if (mode.kind != ModeKind::kElastic) continue;
      best = std::min(best, std::abs(mode.frequency() / exact - 1.0));
    }
    errors.push_back(best);
  }
  EXPECT_LT(errors[0], 0.025);
  EXPECT_LT(errors[1], 0.2 * errors[0]);
}

// A bar that meets a wall with the velocity v presses on it with ρ c v A until the wave comes back from its free
// end at t = 2L/c (Saint-Venant 1867).
TEST(QuadraticBars, ImpactOnAWall) {
  Scene scene = scene_of({GeneratorKind::kBox, {1.0, 0.05, 0.05}, {40, 1, 1}}, elastic(1e9, 0.0));
  FixSettings wall = fix(SelectPlane{0, 0.0, {}}, {true, false, false});
  scene.fix = {wall};
  scene.initial.velocity = {-0.1, 0.0, 0.0};
  scene.time = {Integrator::kVerlet, 2e-6, false, 2.4e-3};
  Session session{scene, with_edge_vertices(generate_mesh(*scene.mesh.generate))};
  double early = 0.0;
  double late = 0.0;
  Index of_early = 0;
  Index of_late = 0;
  while (session.step()) {
    const double t = session.state().time;
    double force = 0.0;
    for (Index i = 0; i < session.reaction_force().size(); i += 3) {
      force += session.reaction_force()[i];
    }
    if (t > 2e-4 && t < 1.8e-3) {
      early += force;
      ++of_early;
    } else if (t > 2.2e-3) {
      late += force;
      ++of_late;
    }
  }
  ASSERT_EQ(session.status(), RunStatus::kFinished) << session.message();
  const double expected = 1000.0 * 1000.0 * 0.1 * 0.0025;
  EXPECT_NEAR(early / static_cast<double>(of_early), expected, 0.005 * expected);
  // The wall would have to pull now: in this model it does.
  EXPECT_NEAR(late / static_cast<double>(of_late), -expected, 0.1 * expected);
}

}  // namespace
}  // namespace tetraction
