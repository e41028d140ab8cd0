// The present settings of a run: those of its scene until an edit changes them.
#pragma once

#include <optional>
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
struct RunSettings : ChangeableSections {
  std::vector<MaterialSettings> materials;  ///< one for each region
  LoadLists loads;
  BodyConstraints constraints;
};

}  // namespace tetraction
