// A thin steel beam that spins: the residual of its steps is soon round-off, and its steps must cost no more for that.
#include <cmath>

#include "support/runs.h"

namespace tetraction {
namespace {

using namespace testing_support;

class ThinSpinningBeam : public testing::TestWithParam<double> {
 protected:
  static constexpr int kSteps = 20;

  // The energy and the angular momentum stay, in few iterations a step. Returns all those of the linear solvers.
  static Index linear_iterations(int cells, double tolerance) {
    Scene scene = scene_of({GeneratorKind::kBeam, {1.0, 0.02, 0.01}, {cells, 1, 1}},
                           elastic(2e11, 0.3, 7850.0));
    scene.initial.angular_velocity = {0, 0, 10};
    scene.time = {Integrator::kEnergyMomentum, 1e-3, false, kSteps * 1e-3};
    scene.solver.tolerance = tolerance;
    Session session(scene, generate_mesh(*scene.mesh.generate));
    const double energy = session.balance().energies().total();
    EXPECT_EQ(session.run(), RunStatus::kFinished) << session.message();
    EXPECT_EQ(session.state().step, kSteps);
    EXPECT_LT(std::abs(session.balance().energies().total() - energy), 1e-10 * energy);
    EXPECT_LT(session.balance().angular_momentum_drift(), 1e-10);
    EXPECT_LE(session.total_iterations(), 8 * kSteps);
    return session.total_cg_iterations();
  }
};

TEST_P(ThinSpinningBeam, CostsInProportionToItsElements) {
  const Index coarse = linear_iterations(80, GetParam());
  const Index fine = linear_iterations(160, GetParam());
  EXPECT_LT(coarse, 60 * kSteps);
  EXPECT_LT(fine, 3 * coarse);
}

INSTANTIATE_TEST_SUITE_P(Tolerances, ThinSpinningBeam, testing::Values(1e-6, 1e-8, 1e-12));

}  // namespace
}  // namespace tetraction
