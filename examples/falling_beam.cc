//                       Tetraction example: a falling beam
//
// Sample runs:  falling_beam                    20 steps
//               falling_beam 100 out/beam       100 steps, results in out/beam
//
// Description:  A neo-Hookean beam of 4 × 1 × 1 m is clamped at x = 0 and let go under gravity. Each
//               step of the implicit midpoint rule is one minimisation of the incremental potential,
//               solved by Ceres with CHOLMOD. The example shows how to put a body together from its
//               parts (mesh, material, constraints, environment), how to step it, and how to write
//               frames for ParaView; Session does all of this from a scene.
#include <cstdio>
#include <cstdlib>

#include "tetraction/dynamics/body_sums.h"
#include "tetraction/dynamics/steppers/stepper.h"
#include "tetraction/io/frame_writer.h"
#include "tetraction/io/run_recorder.h"
#include "tetraction/mesh/generate.h"
#include "tetraction/mesh/selection.h"
#include "tetraction/solver/ceres_minimizer.h"

using namespace tetraction;

int main(int argc, char** argv) {
  // 1. What to do: number of steps, where to write.
  const int steps = argc > 1 ? std::atoi(argv[1]) : 20;
  const std::string directory = argc > 2 ? argv[2] : "out/falling_beam";
  const double h = 0.01;

  // 2. The mesh: 20 × 4 × 4 cells of six tetrahedra.
  const TetMesh mesh = generate_box({4.0, 1.0, 1.0}, {20, 4, 4});

  // 3. The material, from Young's modulus and Poisson's ratio.
  const LameParameters lame = lame_from_young(1.0e6, 0.4);
  MechanicalSystem beam(mesh, NeoHookean(lame.mu, lame.lambda), 1000.0);

  // 4. The clamp: every vertex at x = 0, where it rests. Its coordinates are eliminated.
  ConstraintList clamp;
  clamp.held.push_back(prescribe_at_rest(mesh, select_vertices(mesh, SelectPlane{0, 0.0, {}})));
  beam.set_constraints(Constraints(clamp, mesh, beam.mass()));

  // 5. Gravity.
  beam.set_environment(Environment::uniform({0.0, -9.81, 0.0}));

  // 6. The integrator and its solver.
  const auto stepper = make_midpoint_stepper(beam, make_ceres_minimizer(beam, {}));

  // 7. Time: the state goes from node to node.
  make_output_directory(directory);
  FrameWriter frames(mesh, directory);
  State state = beam.rest_state();
  std::printf("%6s %14s %14s %14s %14s %5s\n", "time", "elastic [J]", "kinetic [J]", "gravity [J]",
              "total [J]", "iter");
  for (int k = 0; k < steps; ++k) {
    const StepOutcome outcome = stepper->step(state, h);
    if (!outcome.ok()) {
      std::fprintf(stderr, "step %d failed: %s\n", k + 1, outcome.message.c_str());
      return 1;
    }
    // 8. Energies of the new state.
    Energies energies;
    evaluate_energies(beam, state, energies);
    std::printf("%6.2f %14.6f %14.6f %14.6f %14.6f %5d\n", state.time, energies.elastic(),
                energies.kinetic(), energies.environment(), energies.total(),
                outcome.minimizer.iterations);
    // 9. A frame for ParaView: Warp By Vector on `displacement`.
    const Vector u = state.position - mesh.rest_positions();
    frames.write({state.time, state.step, {{"displacement", u.reshaped(3, u.size() / 3)}}, {}});
  }

  // 10. Where the free end is now.
  double tip = 0.0;
  const std::vector<Index> end = select_vertices(mesh, SelectPlane{0, 4.0, {}});
  for (const Index v : end) {
    tip += state.position[3 * v + 1] - mesh.vertices[static_cast<std::size_t>(v)].y();
  }
  std::printf("tip displacement after %g s: %.10f m\nframes: %s/frames.pvd\n", state.time,
              tip / static_cast<double>(end.size()), directory.c_str());
  return 0;
}
