// The present settings of a run: those of its scene until an edit changes them.
#pragma once

#include <optional>
#include <variant>
#include <vector>

#include "tetraction/dynamics/constraints/constraints.h"
#include "tetraction/dynamics/contact/obstacle.h"
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

/// What an obstacle keeps when an edit changes its settings.
struct ObstacleStart {
  double time = 0.0;              ///< when its present motion began, s
  ObstacleFrame frame;            ///< its place then, without its offset
  Vector3 way = Vector3::Zero();  ///< by which earlier motions have moved the point `about`, m
  double stiffness = 0.0;         ///< κ where its settings have none, Pa: that of its first moment
};

/// One [[obstacle]]. Edits add obstacles, change and remove them. One that was removed keeps its number, and its name is free.
struct BodyObstacle {
  ObstacleSettings settings;
  bool removed = false;
  ObstacleStart start{};
};

/// All settings that edits may change.
struct RunSettings : ChangeableSections {
  std::vector<MaterialSettings> materials;  ///< one for each region
  LoadLists loads;
  BodyConstraints constraints;
  std::vector<BodyObstacle> obstacles;  ///< by their numbers in the scene
};

}  // namespace tetraction
