#include "obstacle_checks.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/quoting.h"
#include "core/spelling.h"
#include "dynamics/contact/touch_share.h"
#include "simulation/scene/body_obstacles.h"
#include "tetraction/core/error.h"
#include "tetraction/dynamics/contact/contact.h"

namespace tetraction {
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

namespace {

// Empty without a reason.
std::string stiffness_warning(const std::string& of, double stiffness, double modulus) {
  constexpr double kStiff = 1e4;  // times the modulus of the softest element
  constexpr double kSoft = 1e-3;
  if (stiffness > kStiff * modulus) {
    return fmt::format(
        "{} has stiffness = {:.3g} Pa, {:.2g} times Young's modulus of the body: the layer is then "
        "so steep that a body which touches it meets a hard wall, explicit steps become short, and "
        "implicit ones lose digits. The default is Young's modulus, {:.3g} Pa; for a smaller gap "
        "take a smaller thickness",
        of, stiffness, stiffness / modulus, modulus);
  }
  if (stiffness < kSoft * modulus) {
    return fmt::format(
        "{} has stiffness = {:.3g} Pa, {:.2g} times Young's modulus of the body: pressures above "
        "it "
        "press the layer to a small part of its thickness. The default is Young's modulus, {:.3g} "
        "Pa",
        of, stiffness, stiffness / modulus, modulus);
  }
  return {};
}

std::string small_obstacle_warning(const ObstacleSettings& settings, const Obstacle& obstacle,
                                   const TetMesh& mesh) {
  constexpr double kEdges = 5.0;
  const bool is_round =
      settings.kind == ObstacleKind::kSphere || settings.kind == ObstacleKind::kCylinder;
  if (!is_round || settings.inside) return {};
  const double edge = mean_edge(mesh, obstacle.surface);
  if (settings.radius >= kEdges * edge) return {};
  return fmt::format(
      "the radius of the obstacle \"{}\", {:.3g} m, is {:.2g} edges of the body's surface "
      "({:.3g} m): only the "
      "vertices of the body touch it, so that it can sink into faces between them. Take a finer "
      "mesh: five "
      "edges or more are right",
      settings.name, settings.radius, settings.radius / edge, edge);
}

}  // namespace

std::vector<std::string> obstacle_warnings(const Scene& scene, const MechanicalSystem& system) {
  std::vector<std::string> warnings;
  const Contact* contact = system.contact();
  if (contact == nullptr) return warnings;
  const double modulus = least_modulus(system);
  const auto add = [&](std::string warning) {
    if (!warning.empty()) warnings.push_back(std::move(warning));
  };
  for (std::size_t i = 0; i < scene.obstacle.size(); ++i) {
    const ObstacleSettings& settings = scene.obstacle[i];
    const Obstacle& obstacle = contact->obstacle(i);
    add(small_obstacle_warning(settings, obstacle, system.mesh()));
    add(stiffness_warning(fmt::format("the obstacle \"{}\"", settings.name), obstacle.stiffness,
                          modulus));
  }
  if (const BodyContact* between = contact->between(); between != nullptr) {
    add(stiffness_warning("[contact]", between->stiffness, modulus));
  }
  return warnings;
}

namespace {

// The names of obstacles that there are, by their numbers. Those of removed ones are free.
class ObstacleNames {
 public:
  void set(std::optional<std::size_t> number, const ObstacleSettings& settings) {
    if (!number) number = names_.size();
    names_.resize(std::max(names_.size(), *number + 1));
    for (std::size_t i = 0; i < names_.size(); ++i) {
      if (i != *number && names_[i] == settings.name) refuse_name(settings);
    }
    names_[*number] = settings.name;
    all_.push_back(settings.name);
  }
  void remove(std::size_t number, const std::string& where) {
    if (number >= names_.size()) return;  // the reader has refused it
    if (!names_[number]) {
      throw InputError(
          fmt::format("{}{}the obstacle number {} was removed already by an earlier "
                      "event.",
                      where, where.empty() ? "" : ": ", number));
    }
    names_[number].reset();
  }
  /// All that there ever were.
  const std::vector<std::string>& all() const { return all_; }

 private:
  std::vector<std::optional<std::string>> names_;
  std::vector<std::string> all_;
};

}  // namespace

void check_obstacle_names(const Scene& scene) {
  ObstacleNames names;
  for (const ObstacleSettings& settings : scene.obstacle) names.set(std::nullopt, settings);
  for (const EventSettings& event : scene.event) {
    for (const Edit& edit : event.edits) {
      if (const auto* change = std::get_if<SetObstacle>(&edit)) {
        names.set(change->index, change->entry);
      } else if (const auto* removal = std::get_if<RemoveObstacle>(&edit)) {
        names.remove(removal->index, event.where);
      }
    }
  }
  NameList known(names.all().begin(), names.all().end());
  std::sort(known.begin(), known.end());
  known.erase(std::unique(known.begin(), known.end()), known.end());
  for (const ProbeSettings& probe : scene.probe) {
    if (probe.obstacle.empty() || std::ranges::binary_search(known, probe.obstacle)) continue;
    const std::string_view near = nearest_name(probe.obstacle, known);
    throw InputError(fmt::format(
        "{}{}the probe {} is of the obstacle {}, but {}.", probe.where,
        probe.where.empty() ? "" : ": ", in_quotes(probe.name), in_quotes(probe.obstacle),
        known.empty() ? "the scene has no [[obstacle]]"
                      : fmt::format("{}the scene has {}",
                                    near.empty() ? "" : fmt::format("did you mean \"{}\"? ", near),
                                    listing(known))));
  }
}

}  // namespace tetraction
