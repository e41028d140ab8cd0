//                       Tetraction example: a spinning free block
//
// Sample runs:  spinning_block              2000 steps
//               spinning_block 100000
//
// Description:  A stretched block of 2 × 1 × 1 m spins freely in space. The verlet rule, derived from
//               a discrete action, keeps linear and angular momentum to round-off and its energy
//               error bounded. The example shows Balance, which records both, and
//               stability_limit, from which the step is chosen.
#include <cstdio>
#include <cstdlib>

#include "tetraction/dynamics/balance.h"
#include "tetraction/dynamics/body_sums.h"
#include "tetraction/dynamics/steppers/stability.h"
#include "tetraction/mesh/generate.h"

using namespace tetraction;

int main(int argc, char** argv) {
  // 1. The body: nothing holds it, nothing acts on it.
  const int steps = argc > 1 ? std::atoi(argv[1]) : 2000;
  const TetMesh mesh = generate_box({2.0, 1.0, 1.0}, {4, 2, 2});
  const LameParameters lame = lame_from_young(1.0e5, 0.3);
  const MechanicalSystem block(mesh, NeoHookean(lame.mu, lame.lambda), 1000.0);

  // 2. Initial state: stretched by 10 % about the centre of mass.
  State state = block.rest_state();
  const Vector3 center = center_of_mass(block, state.position);
  for (Index v = 0; v < block.vertex_count(); ++v) {
    state.position[3 * v] = center.x() + 1.1 * (state.position[3 * v] - center.x());
  }

  // 3. Angular velocity ω = (1, 2, 0.5) rad/s: v = ω × (q − centre).
  const Vector3 w(1.0, 2.0, 0.5);
  Vector velocity(block.dof_count());
  for (Index v = 0; v < block.vertex_count(); ++v) {
    const Vector3 r = state.position.segment<3>(3 * v) - center;
    velocity.segment<3>(3 * v) << w.y() * r.z() - w.z() * r.y(), w.z() * r.x() - w.x() * r.z(),
        w.x() * r.y() - w.y() * r.x();
  }
  block.set_velocity(state, velocity);

  // 4. The step: a quarter of what is stable.
  const StabilityLimit limit = stability_limit(block, state.position);
  const double h = 0.25 * limit.critical_step;
  std::printf("stability limit %.4g s, step %.4g s\n", limit.critical_step, h);

  // 5. Run, and keep the balance.
  Balance balance(block, state);
  const auto stepper = make_verlet_stepper(block);
  std::printf("%8s %16s %16s %16s %16s\n", "time", "energy [J]", "Lx", "Ly", "Lz");
  for (int k = 0; k < steps; ++k) {
    const StepOutcome outcome = stepper->step(state, h);
    if (!outcome.ok()) {
      std::fprintf(stderr, "step %d failed\n", k + 1);
      return 1;
    }
    balance.enter(state, outcome);
    if ((k + 1) % (steps / 10 > 0 ? steps / 10 : 1) == 0) {
      const Vector3 l = balance.momenta().angular;
      std::printf("%8.3f %16.9f %16.9f %16.9f %16.9f\n", state.time, balance.energies().total(),
                  l.x(), l.y(), l.z());
    }
  }

  // 6. What was promised, measured.
  std::printf(
      "energy kept within %.2g of itself\nlinear momentum kept to %.2e\n"
      "angular momentum kept to %.2e\n",
      balance.max_relative_energy_drift(), balance.linear_momentum_drift(),
      balance.angular_momentum_drift());
  return 0;
}
