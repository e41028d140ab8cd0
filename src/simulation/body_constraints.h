// The constraints of a scene or an edit as objects of one body at one time.
#pragma once

#include <optional>
#include <variant>
#include <vector>

#include "tetraction/dynamics/mechanical_system.h"
#include "tetraction/simulation/scene.h"

namespace tetraction {

/// Selected vertices, with the place in the scene in front of what may be wrong with the selection.
std::vector<Index> select_at(const TetMesh& mesh, const Selection& selection,
                             const std::string& where);

/// One [[constraint]]: a driven handle is held.
using ConstraintObject =
    std::variant<PrescribedVertices, GuidedVertices, FixedDistance, RigidHandle>;

/// The constraints of a body by their numbers in the scene; edits add to them and change them.
struct BodyConstraints {
  std::vector<PrescribedVertices> fixes;
  std::vector<FixSettings> fix_settings;  // of the same numbers
  std::vector<ConstraintObject> others;
  std::vector<std::optional<ConstraintSettings>> other_settings;  // of the same numbers

  ConstraintList list() const;
};

/// The object of a [[fix]] for positions q at `time`. Throws InputError.
PrescribedVertices make_held(const FixSettings& fix, const TetMesh& mesh, const Vector& q,
                             double time);

/// The object of a [[fix]] whose settings change from `before` to `after` at `time`. As long as
/// vertices, components, target and offset stay the same, the targets go on from where they are;
/// but one that has let go of all its vertices holds them anew.
PrescribedVertices changed_held(const PrescribedVertices& held, const FixSettings& before,
                                const FixSettings& after, const TetMesh& mesh, const Vector& q,
                                double time);

/// The object of a [[constraint]] for positions q at `time`. Throws InputError for a distance of
/// zero, a normal or direction of zero, a driven rotation of fewer than three vertices that are not
/// on a line.
ConstraintObject make_constraint(const ConstraintSettings& constraint,
                                 const MechanicalSystem& system, const Vector& q, double time);

/// The settings with the length that the object keeps.
ConstraintSettings with_length(ConstraintSettings settings, const ConstraintObject& object);

/// All constraints of a scene at the start; positions q are moved to the targets of [[fix]] first.
BodyConstraints make_body_constraints(const Scene& scene, const MechanicalSystem& system, Vector q);

}  // namespace tetraction
