// The text of check about a scene's loads, supports, free motions and inertia.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "dynamics/mass_properties.h"
#include "simulation/facts/free_motions.h"
#include "simulation/facts/load_facts.h"
#include "simulation/facts/support_facts.h"

namespace tetraction {

struct SceneFacts {
  std::vector<LoadFacts> loads;
  std::optional<ForceFacts> environment;
  double environment_factor = 1.0;  ///< at t = 0
  std::optional<ForceFacts> pull;
  std::vector<SupportFacts> supports;
  std::vector<double> gaps;  ///< to each obstacle in whose layer the body begins, m; else infinite
  FreeMotions motions;
  MassProperties mass;
  MassProperties lumped_mass;
  std::vector<std::string> warnings;
};

/// `system`: with the loads and the constraints of the scene. `positions`: at t = 0, 3 per vertex, m.
SceneFacts scene_facts(const Scene& scene, const MechanicalSystem& system,
                       const BodyConstraints& constraints, const Vector& positions);

/// Adds "inertia", "loads", "environment", "pull", "supports", "obstacles", "free_motions", "mechanisms", "parts" and
/// "pieces".
void enter_facts(const SceneFacts& facts, const MechanicalSystem& system,
                 nlohmann::ordered_json& json);
/// The centre of mass and the inertia, on stdout.
void print_inertia(const SceneFacts& facts);
/// One line for each load and support, and the free motions, on stdout.
void print_loads_and_supports(const SceneFacts& facts, const Scene& scene,
                              const MechanicalSystem& system);

}  // namespace tetraction
