#include "tetraction/simulation/scene_modes.h"

#include <utility>

#include "simulation/scene/body_constraints.h"
#include "simulation/scene/initial_state.h"
#include "tetraction/simulation/equilibrium.h"
#include "tetraction/simulation/scene_objects.h"

namespace tetraction {

PositionsOfModes positions_of_modes(const Scene& scene, MechanicalSystem& system, bool loaded,
                                    Index count) {
  PositionsOfModes result;
  result.options.count = count;
  if (!loaded) {
    make_initial_state(scene, system);  // it sets the constraints
    result.position = system.mesh().rest_positions();
    return result;
  }
  use_consistent_weights(scene, system);
  BodyConstraints constraints;
  set_constraints_of_equilibrium(scene, system, constraints);
  Equilibrium equilibrium = find_equilibrium(system, scene.solver);
  result.found = equilibrium.found;
  result.message = std::move(equilibrium.message);
  if (!result.found) return result;
  result.options.with_loads = true;
  result.options.multipliers =
      balancing_multipliers(system, equilibrium.position, equilibrium.load);
  result.position = std::move(equilibrium.position);
  return result;
}

}  // namespace tetraction
