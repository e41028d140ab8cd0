// Makes the constraint objects of a body from the settings of a scene or an edit.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "tetraction/dynamics/mechanical_system.h"
#include "tetraction/simulation/run_settings.h"

namespace tetraction {

/// The selected vertices. Messages about the selection begin with its place in the scene.
std::vector<Index> select_at(const TetMesh& mesh, const Selection& selection,
                             const std::string& where);

/// Distances of the same length between the same vertices are one constraint of the body, whose force
/// they share. `number`: its place among the distances of BodyConstraints::list(); `count`: how many
/// share it.
struct SharedDistance {
  std::size_t number = 0;
  std::size_t count = 1;
};
/// For each of constraints.others; those that are no distances have a count of 0.
std::vector<SharedDistance> shared_distances(const std::vector<ConstraintObject>& constraints);

/// The object of a [[fix]] for positions q at `time`. Throws InputError.
PrescribedVertices make_held(const FixSettings& fix, const TetMesh& mesh, const Vector& q,
                             double time, const std::vector<AmplitudeSettings>& amplitudes);

/// Whether a [[fix]] whose settings change so goes on with the vertices and targets that it has.
bool keeps_place(const FixSettings& before, const FixSettings& after);

/// The object of a [[fix]] whose settings change from `before` to `after` at `time`. If vertices,
/// components, target, offset and amplitude stay the same, the targets continue from their present positions.
/// A [[fix]] that has released all of its vertices fixes them again.
PrescribedVertices changed_held(const PrescribedVertices& held, const FixSettings& before,
                                const FixSettings& after, const TetMesh& mesh, const Vector& q,
                                double time, const std::vector<AmplitudeSettings>& amplitudes);

/// The object of a [[constraint]] for positions q at `time`. Throws InputError for a distance of
/// zero, for a normal or direction of zero, and for a driven rotation of fewer than three vertices
/// that are not on a line.
ConstraintObject make_constraint(const ConstraintSettings& constraint,
                                 const MechanicalSystem& system, const Vector& q, double time,
                                 const std::vector<AmplitudeSettings>& amplitudes);

/// The settings, with the length that the object keeps if they had none.
ConstraintSettings with_length(ConstraintSettings settings, const ConstraintObject& object);

/// All constraints of a scene at the start. First, positions q are moved to the targets of [[fix]].
BodyConstraints make_body_constraints(const Scene& scene, const MechanicalSystem& system, Vector q);

/// Follows the targets that the scene's [[fix]] and those of its events give in numbers, and their
/// velocities. Throws InputError, which names both, if a vertex has two different ones at the same time, or if one of
/// a free rigid handle has another constraint. Targets that depend on where the vertices are then are known only
/// in the run, and are left to it.
void refuse_contradicting_targets(const Scene& scene, const MechanicalSystem& system);

}  // namespace tetraction
