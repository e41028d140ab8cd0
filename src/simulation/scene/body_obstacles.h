// The contact of a body with the obstacles of a scene, and of bodies with each other.
#pragma once

#include <array>
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
/// with `earlier` what has not changed. With `reselected` all obstacles but that number have the selections that they
/// have in `earlier`, whose faces are not looked for again. Throws InputError.
std::shared_ptr<const Contact> make_contact(const std::vector<BodyObstacle>& obstacles,
                                            const std::vector<AmplitudeSettings>& amplitudes,
                                            const MechanicalSystem& system,
                                            const Contact* earlier = nullptr,
                                            std::optional<BodyContact> between = std::nullopt,
                                            std::optional<std::size_t> reselected = std::nullopt);

/// An obstacle whose motion begins at this time, of a body whose softest element has this Young's modulus, Pa.
BodyObstacle begun_obstacle(const ObstacleSettings& settings, double time, double modulus);

/// Gives an obstacle other settings from this time on. Throws InputError.
void change_obstacle(BodyObstacle& obstacle, const ObstacleSettings& settings, double time,
                     const std::vector<AmplitudeSettings>& amplitudes);

/// Moves masses of vertices that may touch something into the body (contact.mass). Throws InputError.
void move_contact_masses(const Scene& scene, MechanicalSystem& system);

/// The mean length of the edges of some faces at rest, m.
double mean_edge(const TetMesh& mesh, const std::vector<std::array<Index, 3>>& faces);
/// Young's modulus of the softest element, Pa.
double least_modulus(const MechanicalSystem& system);
/// Throws InputError: the name of the obstacle belongs to another one.
[[noreturn]] void refuse_name(const ObstacleSettings& settings);

}  // namespace tetraction
