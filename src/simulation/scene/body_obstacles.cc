#include "body_obstacles.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <set>
#include <utility>

#include "body_constraints.h"
#include "body_loads.h"
#include "setting_keys.h"
#include "tetraction/core/error.h"
#include "tetraction/dynamics/contact/contact.h"
#include "tetraction/dynamics/contact/moved_masses.h"

namespace tetraction {
namespace {

// The surface that was read from a file, in the file's unit.
const MeshShape& surface_of(const ObstacleSettings& settings) {
  if (settings.surface) return *settings.surface;
  throw InputError(
      fmt::format("The obstacle \"{}\" has no surface: only the reader of scene "
                  "files reads \"{}\". Set ObstacleSettings::surface.",
                  settings.name, settings.file));
}

double metres_of(const ObstacleSettings& settings) {
  MeshSettings file;
  file.unit = settings.unit;
  return coordinate_scale(file);
}

MeshShape mesh_of(const ObstacleSettings& settings) {
  MeshShape mesh = surface_of(settings);
  const double metres = metres_of(settings);
  for (Vector3& point : mesh.points) point *= metres;
  return mesh;
}

ObstacleShape shape_of(const ObstacleSettings& settings) {
  switch (settings.kind) {
    case ObstacleKind::kPlane:
      return PlaneShape{settings.point, settings.normal};
    case ObstacleKind::kSphere:
      return SphereShape{settings.center, settings.radius, settings.inside};
    case ObstacleKind::kCylinder:
      return CylinderShape{settings.point, settings.axis, settings.radius, settings.inside};
    case ObstacleKind::kMesh:
      return mesh_of(settings);
    case ObstacleKind::kBox:
      break;
  }
  if (!settings.inside) return box_surface(settings.min, settings.max);
  return RoomShape{settings.min, settings.max};
}

// The point about which an obstacle turns if none is given.
Vector3 center_of(const ObstacleSettings& settings) {
  switch (settings.kind) {
    case ObstacleKind::kPlane:
    case ObstacleKind::kCylinder:
      return settings.point;
    case ObstacleKind::kSphere:
      return settings.center;
    case ObstacleKind::kMesh: {
      const std::vector<Vector3>& points = surface_of(settings).points;
      const double metres = metres_of(settings);
      Vector3 sum = Vector3::Zero();
      for (const Vector3& point : points) sum += metres * point;
      return sum / static_cast<double>(points.size());
    }
    case ObstacleKind::kBox:
      break;
  }
  return 0.5 * (settings.min + settings.max);
}

ObstacleMotion motion_of(const ObstacleSettings& settings, const ObstacleStart& start,
                         const std::vector<AmplitudeSettings>& amplitudes) {
  ObstacleMotion motion;
  motion.velocity = settings.velocity;
  motion.angular_velocity = settings.angular_velocity;
  motion.about = settings.about ? Vector3(*settings.about + start.way)
                                : start.frame.to_world(center_of(settings));
  motion.history = {settings.from, settings.until,
                    find_amplitude(amplitudes, settings.amplitude, settings.where)};
  motion.begin = start.time;
  motion.start = start.frame;
  motion.offset = settings.offset;
  return motion;
}

// Whether both settings move an obstacle in the same way.
bool has_same_motion(const ObstacleSettings& a, const ObstacleSettings& b) {
  return a.velocity == b.velocity && a.angular_velocity == b.angular_velocity &&
         a.about == b.about && a.amplitude == b.amplitude && a.from == b.from && a.until == b.until;
}

std::vector<std::array<Index, 3>> faces_of(const TetMesh& mesh, const Selection& select) {
  return std::holds_alternative<SelectAll>(without_name(select)) ? boundary_faces(mesh)
                                                                 : select_triangles(mesh, select);
}

// The default thickness of a layer, as a share of the mean edge. The middles of the edges of quadratic tetrahedra are
// vertices of the surface, too.
double share_of_edge(const TetMesh& mesh) {
  return mesh.is_quadratic() ? 0.05 : 0.1;
}

// `present` is the same obstacle with the same selection, if there is one.
Obstacle make_obstacle(const ObstacleSettings& settings, const ObstacleStart& start,
                       const std::vector<AmplitudeSettings>& amplitudes,
                       const MechanicalSystem& system, const Obstacle* present) {
  const TetMesh& mesh = system.mesh();
  Obstacle obstacle;
  obstacle.name = settings.name;
  obstacle.shape = shape_of(settings);
  obstacle.motion = motion_of(settings, start, amplitudes);
  obstacle.friction = settings.friction;
  obstacle.slip_speed = settings.slip_speed;
  obstacle.surface = present != nullptr ? present->surface : faces_of(mesh, settings.select);
  obstacle.thickness =
      settings.thickness.value_or(share_of_edge(mesh) * mean_edge(mesh, obstacle.surface));
  obstacle.stiffness = settings.stiffness.value_or(start.stiffness);
  return obstacle;
}

}  // namespace

double mean_edge(const TetMesh& mesh, const std::vector<std::array<Index, 3>>& faces) {
  std::set<std::array<Index, 2>> edges;
  for (const std::array<Index, 3>& face : faces) {
    for (std::size_t i = 0; i < 3; ++i) {
      const Index a = face.at(i);
      const Index b = face.at((i + 1) % 3);
      edges.insert({std::min(a, b), std::max(a, b)});
    }
  }
  const Vector rest = mesh.rest_positions();
  double sum = 0.0;
  for (const auto& [a, b] : edges) sum += (vertex_block(rest, b) - vertex_block(rest, a)).norm();
  return sum / static_cast<double>(edges.size());
}

double least_modulus(const MechanicalSystem& system) {
  double least = std::numeric_limits<double>::infinity();
  for (Index e = 0; e < system.rest().element_count(); ++e) {
    const LameParameters lame = system.lame(e);
    const double modulus = lame.mu * (3.0 * lame.lambda + 2.0 * lame.mu) / (lame.lambda + lame.mu);
    if (modulus > 0.0) least = std::min(least, modulus);
  }
  return least;
}

void refuse_name(const ObstacleSettings& settings) {
  throw InputError(
      fmt::format("{}{}the name \"{}\" belongs to another obstacle already; each needs its own.",
                  settings.where, settings.where.empty() ? "" : ": ", settings.name));
}

std::vector<BodyObstacle> initial_obstacles(const Scene& scene, const MechanicalSystem& system) {
  std::vector<BodyObstacle> obstacles;
  if (scene.obstacle.empty()) return obstacles;
  const double modulus = least_modulus(system);
  for (const ObstacleSettings& settings : scene.obstacle) {
    obstacles.push_back(begun_obstacle(settings, 0.0, modulus));
  }
  return obstacles;
}

bool may_touch_obstacles(const Scene& scene) {
  const auto adds = [](const EventSettings& event) {
    return std::any_of(event.edits.begin(), event.edits.end(),
                       [](const Edit& edit) { return std::holds_alternative<SetObstacle>(edit); });
  };
  return !scene.obstacle.empty() || std::any_of(scene.event.begin(), scene.event.end(), adds);
}

std::optional<BodyContact> body_contact(const ContactSettings& settings,
                                        const MechanicalSystem& system) {
  constexpr double kLeastShare = 0.01;
  check_settings(settings);
  const bool selects = !std::holds_alternative<SelectAll>(without_name(settings.select));
  if (settings.between == ContactBetween::kNone) {
    const char* given = settings.thickness         ? "thickness"
                        : settings.stiffness       ? "stiffness"
                        : settings.friction != 0.0 ? "friction"
                        : selects                  ? "select"
                                                   : nullptr;
    if (given == nullptr) return std::nullopt;
    throw InputError(fmt::format(
        "contact.{} is for contact between bodies, but contact.between is \"none\": set it to "
        "\"bodies\" or \"all\", or give an [[obstacle]] its own {}.",
        given, given));
  }
  const TetMesh& mesh = system.mesh();
  BodyContact contact;
  contact.within_bodies = settings.between == ContactBetween::kAll;
  try {
    contact.surface = faces_of(mesh, settings.select);
  } catch (const InputError& error) {
    throw InputError(fmt::format("contact.select: {}", error.what()));
  }
  contact.stiffness = settings.stiffness.value_or(least_modulus(system));
  contact.friction = settings.friction;
  contact.slip_speed = settings.slip_speed;
  if (settings.thickness) {
    contact.thickness = *settings.thickness;
    return contact;
  }
  const double usual = share_of_edge(mesh) * mean_edge(mesh, contact.surface);
  contact.thickness = usual;
  const Contact at_rest(mesh, {}, nullptr, contact);
  const Vector rest = mesh.rest_positions();
  // What touches is refused, or the initial state moves it away.
  if (!at_rest.penetrations(system.force_point(rest, 0.0)).empty()) return contact;
  const double gap = at_rest.smallest_gap(system.force_point(rest, 0.0));
  contact.thickness = std::clamp(gap, kLeastShare * usual, usual);
  return contact;
}

BodyObstacle begun_obstacle(const ObstacleSettings& settings, double time, double modulus) {
  BodyObstacle begun{settings};
  begun.start.time = time;
  begun.start.stiffness = modulus;
  return begun;
}

void change_obstacle(BodyObstacle& obstacle, const ObstacleSettings& settings, double time,
                     const std::vector<AmplitudeSettings>& amplitudes) {
  if (!has_same_motion(obstacle.settings, settings)) {
    ObstacleStart& start = obstacle.start;
    const ObstacleMotion motion = motion_of(obstacle.settings, start, amplitudes);
    start.way += path_at(motion, time) * motion.velocity;
    start.frame = frame_at(motion, time, 0.0);
    start.time = time;
  }
  obstacle.settings = settings;
  obstacle.removed = false;
}

std::shared_ptr<const Contact> make_contact(const std::vector<BodyObstacle>& all,
                                            const std::vector<AmplitudeSettings>& amplitudes,
                                            const MechanicalSystem& system, const Contact* earlier,
                                            std::optional<BodyContact> between,
                                            std::optional<std::size_t> reselected) {
  std::set<std::string> names;
  std::vector<Obstacle> obstacles;
  for (const BodyObstacle& each : all) {
    const ObstacleSettings& settings = each.settings;
    const std::string place = settings.where.empty() ? "" : settings.where + ": ";
    if (!each.removed && !names.insert(settings.name).second) refuse_name(settings);
    const std::size_t number = obstacles.size();
    const bool keeps_faces = reselected && number != *reselected && number < earlier->size();
    try {
      obstacles.push_back(make_obstacle(settings, each.start, amplitudes, system,
                                        keeps_faces ? &earlier->obstacle(number) : nullptr));
      obstacles.back().removed = each.removed;
    } catch (const InputError& error) {
      const std::string message = error.what();
      throw InputError(message.rfind(place, 0) == 0 ? message : place + message);
    }
  }
  if (earlier != nullptr && earlier->between() != nullptr) between = *earlier->between();
  return std::make_shared<const Contact>(system.mesh(), std::move(obstacles), earlier,
                                         std::move(between));
}

void move_contact_masses(const Scene& scene, MechanicalSystem& system) {
  check_settings(scene.contact);
  if (scene.contact.mass == 1.0) return;
  if (system.contact() == nullptr) {
    throw InputError(fmt::format(
        "contact.mass = {} is a share of the mass of vertices that may touch something, but the "
        "scene has neither an [[obstacle]] nor contact.between: leave it out.",
        scene.contact.mass));
  }
  system.set_masses(moved_masses(system, system.contact()->vertices(), scene.contact.mass));
}

}  // namespace tetraction
