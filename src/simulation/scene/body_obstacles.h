// The contact of a body with the obstacles of a scene, and of bodies with each other.
#pragma once

#include <memory>
#include <optional>
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

/// The contact of bodies with each other that the settings ask for; nothing with between = "none". The default of the
/// thickness is a tenth of the mean edge of the faces (half of it with quadratic tetrahedra), but at most the smallest
/// gap at rest of what may touch, so that nothing presses at rest; of this no less than a hundredth of the tenth. Throws
/// InputError.
std::optional<BodyContact> body_contact(const ContactSettings& settings,
                                        const MechanicalSystem& system);

/// The contact with these obstacles, and between bodies that of `earlier`, or if there is none, of `between`. It shares
/// with `earlier` what has not changed. Throws InputError.
std::shared_ptr<const Contact> make_contact(const std::vector<BodyObstacle>& obstacles,
                                            const std::vector<AmplitudeSettings>& amplitudes,
                                            const MechanicalSystem& system,
                                            const Contact* earlier = nullptr,
                                            std::optional<BodyContact> between = std::nullopt);

/// Adds an obstacle whose motion begins at this time.
void add_obstacle(std::vector<BodyObstacle>& obstacles, const ObstacleSettings& settings,
                  double time, const MechanicalSystem& system);

/// Gives an obstacle other settings from this time on. Throws InputError.
void change_obstacle(BodyObstacle& obstacle, const ObstacleSettings& settings, double time,
                     const std::vector<AmplitudeSettings>& amplitudes);

/// Moves masses of vertices that may touch something into the body (contact.mass). Throws InputError.
void move_contact_masses(const Scene& scene, MechanicalSystem& system);
/// Throws InputError if a vertex penetrates an obstacle or another body at these positions. The message begins with
/// `what` and has the obstacle, the numbers of some vertices and the depth.
void refuse_penetration(const MechanicalSystem& system, const Vector& position, double time,
                        const std::string& what);

/// Throws InputError if an obstacle has friction, which an equilibrium cannot have.
void refuse_friction(const Scene& scene);

/// A warning where an obstacle is so small that faces of the body may sink into it between their vertices; empty
/// without one.
std::string small_obstacle_warning(const Scene& scene, const MechanicalSystem& system);

}  // namespace tetraction
