// The present settings of a run: those of its scene until an edit changes them.
#pragma once

#include <optional>
#include <type_traits>
#include <variant>
#include <vector>

#include "tetraction/dynamics/constraints/constraints.h"
#include "tetraction/simulation/scene.h"

namespace tetraction {

/// One [[constraint]]: a driven handle is held.
using ConstraintObject =
    std::variant<PrescribedVertices, GuidedVertices, FixedDistance, RigidHandle>;

/// The constraints of a body by their numbers in the scene. Edits add constraints and change them.
struct BodyConstraints {
  std::vector<PrescribedVertices> fixes;
  std::vector<FixSettings> fix_settings;  ///< of the same numbers
  std::vector<ConstraintObject> others;
  std::vector<std::optional<ConstraintSettings>> other_settings;  ///< of the same numbers

  ConstraintList list() const;
};

/// All settings that edits may change.
struct RunSettings {
  TimeSettings time;
  SolverSettings solver;
  std::vector<MaterialSettings> materials;  ///< one for each region
  EnvironmentSettings environment;
  Damping damping;
  LoadLists loads;
  BodyConstraints constraints;
};

/// The settings of a type in a scene, in the settings of a run or in any other class with members of these names.
template <class Section, class Holder>
auto& section_in(Holder& holder) {
  if constexpr (std::is_same_v<Section, TimeSettings>) {
    return (holder.time);
  } else if constexpr (std::is_same_v<Section, SolverSettings>) {
    return (holder.solver);
  } else if constexpr (std::is_same_v<Section, Damping>) {
    return (holder.damping);
  } else {
    static_assert(std::is_same_v<Section, EnvironmentSettings>);
    return (holder.environment);
  }
}

}  // namespace tetraction
