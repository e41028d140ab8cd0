#include "tetraction/simulation/equilibrium.h"

#include <fmt/format.h>

#include <utility>

#include "load_stepping.h"

namespace tetraction {

Equilibrium find_equilibrium(const MechanicalSystem& system, const SolverSettings& solver,
                             double time, double largest_increment) {
  refuse_free_motions(system, time);
  const std::unique_ptr<StaticStepper> stepper = make_static_stepper(system, solver, time);
  LoadStepping loading(*stepper, largest_increment);
  State from = system.rest_state();
  State to;
  Equilibrium result;
  StepOutcome outcome;
  while (from.time < 1.0) {
    outcome = loading.advance(from, to);
    result.iterations += outcome.minimizer.iterations;
    result.factorizations += outcome.minimizer.factorizations;
    result.cg_iterations += outcome.minimizer.cg_iterations;
    if (!outcome.ok()) break;
    std::swap(from, to);
  }
  result.found = from.time == 1.0;
  result.path = loading.path();
  result.position = from.position;
  result.load = stepper->problem().applied_force(from.time, from.position);
  result.reaction = stepper->reactions().force;
  result.message = loading.message(outcome);
  return result;
}

}  // namespace tetraction
