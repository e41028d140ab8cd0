// The beam of beam.py with this library, as its users call it: tetraction_beam FILE
#include <cstdio>
#include <exception>

#include "beam.h"
#include "tetraction/core/error.h"
#include "tetraction/core/parallel.h"
#include "tetraction/core/version.h"
#include "tetraction/dynamics/steppers/stepper.h"
#include "tetraction/solver/newton_minimizer.h"

namespace {

using namespace tetraction;

void run(const std::string& path) {
  set_thread_count(1);
  const long before = peers::peak_bytes();
  const peers::Beam beam = peers::read_beam(path);

  MechanicalSystem system(view_mesh(beam.vertices, beam.tetrahedra),
                          NeoHookean(beam.mu(), beam.lambda()), beam.density);
  ConstraintList wall;
  wall.held.push_back(prescribe_at_rest(system.mesh(), {beam.held.begin(), beam.held.end()}));
  system.set_constraints(Constraints(wall, system.mesh(), system.mass()));
  system.set_environment(Environment::uniform({0.0, -beam.gravity, 0.0}));

  NewtonOptions options;
  options.tolerance = beam.tolerance;
  const auto stepper = make_backward_euler_stepper(system, make_newton_minimizer(system, options));
  State state = system.rest_state();
  peers::Report report;
  report.program = "tetraction";
  report.version = version();
  for (int k = 0; k < beam.steps; ++k) {
    const double start = peers::now();
    const StepOutcome outcome = stepper->step(state, beam.step);
    report.seconds.push_back(peers::now() - start);
    if (!outcome.ok()) throw Error("A step failed. " + outcome.message);
    report.newton += outcome.minimizer.iterations;
    report.iterations += outcome.minimizer.cg_iterations;
    report.solver = outcome.minimizer.linear;
  }
  const Vector displacement = state.position - system.mesh().rest_positions();
  for (const std::int32_t v : beam.tip) report.tip += displacement[3 * Index{v} + 1];
  report.tip /= static_cast<double>(beam.tip.size());
  report.bytes = peers::peak_bytes() - before;
  peers::print(report);
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 2) {
    std::fprintf(stderr, "Usage: tetraction_beam FILE\n");
    return 2;
  }
  try {
    run(arguments[1]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
