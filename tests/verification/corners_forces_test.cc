// Corners of user forces: windows that do not fit the steps.
#include <algorithm>
#include <cmath>

#include "support/runs.h"

namespace tetraction {
namespace {

using namespace testing_support;

class ForceWindow : public testing::TestWithParam<Integrator> {
 protected:
  Scene pushed(double step, double from, double until) const {
    Scene scene = scene_of({GeneratorKind::kBox, {2, 1, 1}, {2, 1, 1}}, elastic(1e4, 0.3));
    scene.time = {GetParam(), step, false, 0.2};
    ForceSettings push = load(SelectPlane{0, 2.0, {}}, {270.0, -100.0, 30.0});
    push.from = from;
    push.until = until;
    scene.force = {push};
    return scene;
  }
};

INSTANTIATE_TEST_SUITE_P(Rules, ForceWindow, testing::ValuesIn(all_rules()), name_of_rule);

// The impulse of a force is its vector times the time that it acts, at whatever steps: in one of
// them, across several, up to the end of one.
TEST_P(ForceWindow, TheImpulseIsTheIntegralOfTheForce) {
  struct Window {
    double from;
    double until;
  };
  for (const Window window : {Window{0.012, 0.013}, Window{0.017, 0.0391}, Window{-1.0, 0.0123},
                              Window{0.04, 0.06}, Window{0.1999, 5.0}}) {
    for (const double step : {0.0004, 0.002, 0.01}) {
      Scene scene = pushed(step, window.from, window.until);
      scene.solver.tolerance = 1e-10;
      const TetMesh mesh = generate_mesh(*scene.mesh.generate);
      FinishedRun session(scene, mesh);
      const double acting = std::min(window.until, 0.2) - std::max(window.from, 0.0);
      const auto vertices =
          static_cast<double>(select_vertices(mesh, scene.force[0].select).size());
      const Vector3 impulse = acting * vertices * scene.force[0].vector;
      const double tolerance = GetParam() == Integrator::kBackwardEuler ? 1e-8 : 1e-12;
      EXPECT_LT((session.balance().momenta().linear - impulse).norm(), tolerance * impulse.norm())
          << "step " << step << ", from " << window.from << " until " << window.until;
      EXPECT_LT(session.balance().linear_momentum_drift(), tolerance);
    }
  }
}

// The step and its work use the mean of the force over the step.
TEST_P(ForceWindow, TheWorkIsTheMeanForceTimesTheWay) {
  Scene scene = pushed(0.01, 0.012, 0.013);
  const TetMesh mesh = generate_mesh(*scene.mesh.generate);
  Session session(scene, mesh);
  double work = 0.0;
  while (true) {
    const Vector before = session.state().position;
    if (!session.step()) break;
    work += session.external_force().dot(session.state().position - before);
    const double share = session.state().step == 2 ? 0.1 : 0.0;
    const Vector3 force = session.external_force().segment<3>(3 * 2);
    EXPECT_LT((force - share * scene.force[0].vector).norm(), 1e-11);
    EXPECT_NEAR(session.balance().external_work(), work, 1e-9 * std::abs(work));
  }
  EXPECT_GT(work, 0.0);
}

// Steps at multiples of 0.1 are not where a window in decimal numbers ends, but for round-off.
TEST_P(ForceWindow, AnEndAtAStepIsOneInSpiteOfRoundOff) {
  Scene scene = pushed(0.1, 0.3, 0.7);
  scene.time.end = 1.0;
  scene.material.youngs_modulus = 1e2;
  scene.force[0].vector *= 1e-3;
  Session session(scene, generate_mesh(*scene.mesh.generate));
  while (session.step()) {
    const Index step = session.state().step;
    const Vector3 expected =
        step >= 4 && step <= 7 ? scene.force[0].vector : Vector3(Vector3::Zero());
    EXPECT_EQ(Vector3(session.external_force().segment<3>(3 * 2)), expected) << "step " << step;
  }
}

}  // namespace
}  // namespace tetraction
