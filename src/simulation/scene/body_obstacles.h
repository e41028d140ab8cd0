// The contact of a body with the obstacles of a scene.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tetraction/dynamics/contact/contact.h"
#include "tetraction/dynamics/mechanical_system.h"
#include "tetraction/simulation/run_settings.h"

namespace tetraction {

/// The obstacles of the scene at the time 0.
std::vector<BodyObstacle> initial_obstacles(const Scene& scene, const MechanicalSystem& system);

/// Whether the scene has obstacles, or its events add some.
bool may_touch_obstacles(const Scene& scene);

/// The contact with these obstacles. It shares with `earlier` what has not changed. Throws InputError.
std::shared_ptr<const Contact> make_contact(const std::vector<BodyObstacle>& obstacles,
                                            const std::vector<AmplitudeSettings>& amplitudes,
                                            const MechanicalSystem& system,
                                            const Contact* earlier = nullptr);

/// Adds an obstacle whose motion begins at this time.
void add_obstacle(std::vector<BodyObstacle>& obstacles, const ObstacleSettings& settings,
                  double time, const MechanicalSystem& system);

/// Gives an obstacle other settings from this time on. Throws InputError.
void change_obstacle(BodyObstacle& obstacle, const ObstacleSettings& settings, double time,
                     const std::vector<AmplitudeSettings>& amplitudes);

/// Moves masses of vertices that may touch an obstacle into the body (contact.mass). Throws InputError.
void move_contact_masses(const Scene& scene, MechanicalSystem& system);
/// Throws InputError if a vertex penetrates an obstacle at these positions. The message begins with `what` and has the
/// obstacle, the numbers of some vertices and the depth.
void refuse_penetration(const MechanicalSystem& system, const Vector& position, double time,
                        const std::string& what);

/// Throws InputError if an obstacle has friction, which an equilibrium cannot have.
void refuse_friction(const Scene& scene);

/// A warning where an obstacle is so small that faces of the body may sink into it between their vertices; empty
/// without one.
std::string small_obstacle_warning(const Scene& scene, const MechanicalSystem& system);

}  // namespace tetraction
