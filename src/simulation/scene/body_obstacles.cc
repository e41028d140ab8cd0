#include "body_obstacles.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "body_constraints.h"
#include "body_loads.h"
#include "dynamics/contact/touch_share.h"
#include "setting_keys.h"
#include "tetraction/core/error.h"
#include "tetraction/dynamics/contact/contact.h"
#include "tetraction/dynamics/contact/moved_masses.h"

namespace tetraction {
namespace {

// The surface of a file in m.
MeshShape mesh_of(const ObstacleSettings& settings) {
  if (!settings.surface) {
    throw InputError(
        fmt::format("The obstacle \"{}\" has no surface: only the reader of scene "
                    "files reads \"{}\". Set ObstacleSettings::surface.",
                    settings.name, settings.file));
  }
  MeshShape mesh = *settings.surface;
  MeshSettings file;
  file.unit = settings.unit;
  const double metres = coordinate_scale(file);
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
Vector3 center_of(const ObstacleSettings& settings, const ObstacleShape& shape) {
  switch (settings.kind) {
    case ObstacleKind::kPlane:
    case ObstacleKind::kCylinder:
      return settings.point;
    case ObstacleKind::kSphere:
      return settings.center;
    case ObstacleKind::kMesh: {
      const std::vector<Vector3>& points = std::get<MeshShape>(shape).points;
      Vector3 sum = Vector3::Zero();
      for (const Vector3& point : points) sum += point;
      return sum / static_cast<double>(points.size());
    }
    case ObstacleKind::kBox:
      break;
  }
  return 0.5 * (settings.min + settings.max);
}

// The mean length of the edges of some faces at rest, m.
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

// Young's modulus of the softest element, Pa.
double least_modulus(const MechanicalSystem& system) {
  double least = std::numeric_limits<double>::infinity();
  for (Index e = 0; e < system.rest().element_count(); ++e) {
    const LameParameters lame = system.lame(e);
    const double modulus = lame.mu * (3.0 * lame.lambda + 2.0 * lame.mu) / (lame.lambda + lame.mu);
    if (modulus > 0.0) least = std::min(least, modulus);
  }
  return least;
}

ObstacleMotion motion_of(const ObstacleSettings& settings, const ObstacleStart& start,
                         const ObstacleShape& shape,
                         const std::vector<AmplitudeSettings>& amplitudes) {
  ObstacleMotion motion;
  motion.velocity = settings.velocity;
  motion.angular_velocity = settings.angular_velocity;
  motion.about = settings.about ? Vector3(*settings.about + start.way)
                                : start.frame.to_world(center_of(settings, shape));
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

Obstacle make_obstacle(const ObstacleSettings& settings, const ObstacleStart& start,
                       const std::vector<AmplitudeSettings>& amplitudes,
                       const MechanicalSystem& system) {
  const TetMesh& mesh = system.mesh();
  Obstacle obstacle;
  obstacle.name = settings.name;
  obstacle.shape = shape_of(settings);
  obstacle.motion = motion_of(settings, start, obstacle.shape, amplitudes);
  obstacle.friction = settings.friction;
  obstacle.slip_speed = settings.slip_speed;
  obstacle.surface = faces_of(mesh, settings.select);
  obstacle.thickness =
      settings.thickness.value_or(share_of_edge(mesh) * mean_edge(mesh, obstacle.surface));
  obstacle.stiffness = settings.stiffness.value_or(start.stiffness);
  return obstacle;
}

}  // namespace

std::vector<BodyObstacle> initial_obstacles(const Scene& scene, const MechanicalSystem& system) {
  std::vector<BodyObstacle> obstacles;
  for (const ObstacleSettings& settings : scene.obstacle) {
    add_obstacle(obstacles, settings, 0.0, system);
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

void add_obstacle(std::vector<BodyObstacle>& obstacles, const ObstacleSettings& settings,
                  double time, const MechanicalSystem& system) {
  BodyObstacle added{settings};
  added.start.time = time;
  added.start.stiffness = least_modulus(system);
  obstacles.push_back(std::move(added));
}

void change_obstacle(BodyObstacle& obstacle, const ObstacleSettings& settings, double time,
                     const std::vector<AmplitudeSettings>& amplitudes) {
  if (!has_same_motion(obstacle.settings, settings)) {
    ObstacleStart& start = obstacle.start;
    const ObstacleMotion motion =
        motion_of(obstacle.settings, start, shape_of(obstacle.settings), amplitudes);
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
                                            std::optional<BodyContact> between) {
  std::set<std::string> names;
  std::vector<Obstacle> obstacles;
  for (const BodyObstacle& each : all) {
    const ObstacleSettings& settings = each.settings;
    const std::string place = settings.where.empty() ? "" : settings.where + ": ";
    if (!each.removed && !names.insert(settings.name).second) {
      throw InputError(
          fmt::format("{}the name \"{}\" belongs to another obstacle already; each needs its own.",
                      place, settings.name));
    }
    try {
      obstacles.push_back(make_obstacle(settings, each.start, amplitudes, system));
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

namespace {

// The tetrahedron that contains a point, or −1. Edges of quadratic tetrahedra count as straight.
Index tetrahedron_at(const TetMesh& mesh, const Vector& position, const Vector3& point) {
  constexpr double kOnFace = 1e-9;  // so that points on faces are found
  for (Index e = 0; e < mesh.tetrahedron_count(); ++e) {
    const auto& corners = mesh.tetrahedra[static_cast<std::size_t>(e)];
    const Vector3 origin = vertex_block(position, corners[0]);
    Matrix3 edges;
    for (int k = 0; k < 3; ++k) {
      edges.col(k) = vertex_block(position, corners[static_cast<std::size_t>(k) + 1]) - origin;
    }
    const Vector3 seen = point - origin;
    // Cramer's rule; the volume has the sign of the orientation.
    const double volume = edges.determinant();
    const Vector3 weights(seen.dot(edges.col(1).cross(edges.col(2))),
                          edges.col(0).dot(seen.cross(edges.col(2))),
                          edges.col(0).dot(edges.col(1).cross(seen)));
    const double round_off = kOnFace * volume;
    if (volume > 0.0 && weights.minCoeff() >= -round_off && weights.sum() <= volume + round_off) {
      return e;
    }
  }
  return -1;
}

// Points of an obstacle that are all inside a body if the whole of it is. Empty for what has no end.
std::vector<Vector3> points_of(const ObstacleShape& shape) {
  if (const auto* mesh = std::get_if<MeshShape>(&shape)) return mesh->points;
  const auto* sphere = std::get_if<SphereShape>(&shape);
  if (sphere == nullptr || sphere->inside) return {};
  std::vector<Vector3> points;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      points.emplace_back(sphere->center + side * sphere->radius * Vector3::Unit(axis));
    }
  }
  return points;
}

// Nothing crosses the body's surface there, so that contact would keep the obstacle inside.
void refuse_obstacles_inside(const MechanicalSystem& system, const Vector& position, double time,
                             const std::string& what) {
  const Contact& contact = *system.contact();
  const TetMesh& mesh = system.mesh();
  for (std::size_t i = 0; i < contact.size(); ++i) {
    const Obstacle& obstacle = contact.obstacle(i);
    if (obstacle.removed) continue;
    const ObstacleFrame frame = frame_at(obstacle.motion, time);
    Index containing = -1;
    for (const Vector3& point : points_of(obstacle.shape)) {
      containing = tetrahedron_at(mesh, position, frame.to_world(point));
      if (containing < 0) break;
    }
    if (containing < 0) continue;
    throw InputError(
        fmt::format("{} contains the whole obstacle \"{}\", which is inside it at tetrahedron {}. "
                    "Move the body or the obstacle so that they are apart.",
                    what, obstacle.name, mesh.tetrahedron_id(containing)));
  }
}

}  // namespace

void refuse_penetration(const MechanicalSystem& system, const Vector& position, double time,
                        const std::string& what) {
  if (system.contact() == nullptr) return;
  const std::vector<Contact::Penetration> all =
      system.contact()->penetrations(system.force_point(position, time));
  if (all.empty()) {
    refuse_obstacles_inside(system, position, time, what);
    return;
  }
  constexpr std::size_t kNamed = 5;
  const Contact& contact = *system.contact();
  const std::size_t obstacle = all.front().obstacle;
  const bool is_body = obstacle == contact.size();
  std::string vertices;
  std::size_t count = 0;
  double deepest = 0.0;
  for (const Contact::Penetration& each : all) {
    if (each.obstacle != obstacle) continue;
    if (count < kNamed) {
      vertices += fmt::format("{}{}", count > 0 ? ", " : "", system.mesh().vertex_id(each.vertex));
    }
    ++count;
    if (std::isfinite(each.depth)) deepest = std::max(deepest, each.depth);
  }
  const std::string partner = contact.partner(obstacle);
  const std::string apart =
      is_body ? fmt::format(
                    "Move the bodies apart, by contact.thickness = {:.3g} m or a little "
                    "less, or leave this part of the surface out with contact.select.",
                    contact.thickness(obstacle))
              : "Move the body or the obstacle so that they are apart.";
  if (std::isnan(all.front().depth)) {
    throw InputError(fmt::format("{} has faces or edges that cross {}, the first at vertex {}. {}",
                                 what, partner, system.mesh().vertex_id(all.front().vertex),
                                 apart));
  }
  const std::string which = fmt::format("{} {} ({}{})", count, count == 1 ? "vertex" : "vertices",
                                        vertices, count > kNamed ? ", ..." : "");
  if (deepest == 0.0 && is_body) {
    throw InputError(
        fmt::format("{} has {} that touch{} {}: nearer than {:.3g} m, {:.0e} of the thickness of "
                    "the layer of contact. Contact needs a larger gap. {}",
                    what, which, count == 1 ? "es" : "", partner,
                    kTouchShare * contact.thickness(obstacle), kTouchShare, apart));
  }
  if (deepest == 0.0) {
    throw InputError(fmt::format(
        "{} has {} exactly on {}. Contact needs a gap: begin with the obstacle {:.3g} m away, "
        "where contact begins, or a little nearer.",
        what, which, partner, contact.thickness(obstacle)));
  }
  throw InputError(fmt::format("{} penetrates {}: {}, up to {:.3g} m deep. {}", what, partner,
                               which, deepest, apart));
}

void refuse_friction(const Scene& scene) {
  if (scene.contact.friction > 0.0) {
    throw InputError(fmt::format(
        "contact.friction = {}: the friction of an equilibrium depends on how it was reached. Take "
        "friction = 0, or compute the motion with damping.",
        scene.contact.friction));
  }
  for (const ObstacleSettings& obstacle : scene.obstacle) {
    if (!(obstacle.friction > 0.0)) continue;
    throw InputError(fmt::format(
        "{}{}the obstacle \"{}\" has friction = {}, but the friction of an equilibrium depends on "
        "how it was "
        "reached: take friction = 0, or compute the motion with damping.",
        obstacle.where, obstacle.where.empty() ? "" : ": ", obstacle.name, obstacle.friction));
  }
}

std::string small_obstacle_warning(const Scene& scene, const MechanicalSystem& system) {
  constexpr double kEdges = 5.0;
  for (std::size_t i = 0; i < scene.obstacle.size(); ++i) {
    const ObstacleSettings& settings = scene.obstacle[i];
    const bool is_round =
        settings.kind == ObstacleKind::kSphere || settings.kind == ObstacleKind::kCylinder;
    if (!is_round || settings.inside || system.contact() == nullptr) continue;
    const double edge = mean_edge(system.mesh(), system.contact()->obstacle(i).surface);
    if (settings.radius >= kEdges * edge) continue;
    return fmt::format(
        "the radius of the obstacle \"{}\", {:.3g} m, is {:.2g} edges of the body's surface "
        "({:.3g} m): only the "
        "vertices of the body touch it, so that it can sink into faces between them. Take a finer "
        "mesh: five "
        "edges or more are right",
        settings.name, settings.radius, settings.radius / edge, edge);
  }
  return {};
}

}  // namespace tetraction
