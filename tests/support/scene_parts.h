// Parts of scenes and meshes that several tests put together.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tetraction/mesh/tet_mesh.h"
#include "tetraction/simulation/scene.h"
#include "tetraction/simulation/scene_objects.h"

namespace tetraction::testing_support {

/// Parameters of a material with Young's modulus, Pa, and Poisson's ratio.
inline MaterialSettings elastic(double youngs_modulus, double poissons_ratio,
                                double density = 1000.0, const std::string& model = "neo-hookean") {
  MaterialSettings material;
  material.model = model;
  material.youngs_modulus = youngs_modulus;
  material.poissons_ratio = poissons_ratio;
  material.density = density;
  return material;
}

/// The same of the default density.
inline MaterialSettings elastic(double youngs_modulus, double poissons_ratio, const char* model) {
  return elastic(youngs_modulus, poissons_ratio, 1000.0, model);
}

inline TetMesh mesh_of(const Scene& scene) {
  return generate_mesh(*scene.mesh.generate);
}

/// A body of one material, whose mesh is given beside the scene.
inline Scene scene_of(const MaterialSettings& material) {
  Scene scene;
  scene.material = material;
  return scene;
}

/// A generated body of one material.
inline Scene scene_of(const GeneratorSettings& mesh, const MaterialSettings& material) {
  Scene scene;
  scene.mesh.generate = mesh;
  scene.material = material;
  return scene;
}

/// Gravity, m/s², in a unit direction.
inline EnvironmentSettings gravity(double strength, const Vector3& direction = {0.0, -1.0, 0.0}) {
  EnvironmentSettings environment;
  environment.kind = EnvironmentKind::kGravity;
  environment.strength = strength;
  environment.direction = direction;
  return environment;
}

inline FixSettings fix(Selection select, std::array<bool, 3> components = {true, true, true}) {
  FixSettings fix;
  fix.select = std::move(select);
  fix.components = components;
  return fix;
}

/// Holds vertices at a distance, m, from where they are.
inline FixSettings shifted(Selection select, const Vector3& offset,
                           std::array<bool, 3> components = {true, true, true}) {
  FixSettings shifted = fix(std::move(select), components);
  shifted.offset = offset;
  return shifted;
}

/// Drives vertices with a velocity, m/s.
inline FixSettings moving(Selection select, const Vector3& velocity) {
  FixSettings moving = fix(std::move(select));
  moving.velocity = velocity;
  return moving;
}

/// Holds vertices by penalty springs, N/m.
inline FixSettings springs(Selection select, double penalty) {
  FixSettings springs = fix(std::move(select));
  springs.is_penalty = true;
  springs.penalty = penalty;
  return springs;
}

/// A distance of two vertices, m; without a length the present one.
inline ConstraintSettings rod(std::int64_t from, std::int64_t to,
                              std::optional<double> length = std::nullopt) {
  ConstraintSettings rod;
  rod.vertices = {from, to};
  rod.length = length;
  return rod;
}

inline ConstraintSettings constraint_of(ConstraintKind kind, Selection select) {
  ConstraintSettings constraint;
  constraint.kind = kind;
  constraint.select = std::move(select);
  return constraint;
}

inline ConstraintSettings on_plane(Selection select, const Vector3& normal) {
  ConstraintSettings plane = constraint_of(ConstraintKind::kPlane, std::move(select));
  plane.direction = normal;
  return plane;
}

inline ConstraintSettings on_line(Selection select, const Vector3& direction) {
  ConstraintSettings line = constraint_of(ConstraintKind::kLine, std::move(select));
  line.direction = direction;
  return line;
}

/// A rigid handle, free to move.
inline ConstraintSettings rigid(Selection select) {
  return constraint_of(ConstraintKind::kRigid, std::move(select));
}

/// A rigid handle with given velocities, m/s and rad/s.
inline ConstraintSettings driven(Selection select, const std::optional<Vector3>& velocity,
                                 const std::optional<Vector3>& angular_velocity = std::nullopt) {
  ConstraintSettings handle = rigid(std::move(select));
  handle.velocity = velocity;
  handle.angular_velocity = angular_velocity;
  return handle;
}

/// A factor that is linear between these corners.
inline AmplitudeSettings corners(const std::string& name,
                                 std::vector<std::pair<double, double>> points) {
  AmplitudeSettings amplitude;
  amplitude.name = name;
  amplitude.points = std::move(points);
  return amplitude;
}

inline AmplitudeSettings sine(const std::string& name, double frequency, double offset = 0.0) {
  AmplitudeSettings amplitude;
  amplitude.name = name;
  amplitude.kind = AmplitudeKind::kSine;
  amplitude.frequency = frequency;
  amplitude.offset = offset;
  return amplitude;
}

inline ProbeSettings probe_of(const std::string& name, ProbeQuantity quantity,
                              Selection select = SelectAll{}, int every = 1) {
  ProbeSettings probe;
  probe.name = name;
  probe.select = std::move(select);
  probe.quantity = quantity;
  probe.every = every;
  return probe;
}

inline ProbeSettings probe_at(const std::string& name, ProbeQuantity quantity, const Vector3& point,
                              int every = 1) {
  ProbeSettings probe = probe_of(name, quantity, SelectAll{}, every);
  probe.point = point;
  return probe;
}

/// The force of an obstacle, or its moment about a point.
inline ProbeSettings probe_on(const std::string& name, const std::string& obstacle,
                              ProbeQuantity quantity = ProbeQuantity::kContactForce,
                              const Vector3& about = Vector3::Zero()) {
  ProbeSettings probe = probe_of(name, quantity);
  probe.obstacle = obstacle;
  probe.about = about;
  return probe;
}

/// A load with this vector, of the kind of the list that it is added to.
inline ForceSettings load(Selection select, const Vector3& vector,
                          LoadKind kind = LoadKind::kForce) {
  ForceSettings load;
  load.kind = kind;
  load.select = std::move(select);
  load.vector = vector;
  return load;
}

/// A force, N, that the selected vertices share.
inline ForceSettings total_load(Selection select, const Vector3& total) {
  ForceSettings load;
  load.select = std::move(select);
  load.total = total;
  return load;
}

inline ForceSettings traction(Selection select, const Vector3& vector) {
  return load(std::move(select), vector, LoadKind::kTraction);
}

inline ForceSettings moment(Selection select, const Vector3& vector) {
  return load(std::move(select), vector, LoadKind::kMoment);
}

inline ForceSettings body_force(const Vector3& vector, Selection select = SelectAll{}) {
  return load(std::move(select), vector, LoadKind::kBodyForce);
}

/// A body force as an acceleration, m/s².
inline ForceSettings body_acceleration(const Vector3& acceleration,
                                       Selection select = SelectAll{}) {
  ForceSettings load = body_force(Vector3::Zero(), std::move(select));
  load.acceleration = acceleration;
  return load;
}

inline ForceSettings pressure(Selection select, double value) {
  ForceSettings load;
  load.kind = LoadKind::kPressure;
  load.select = std::move(select);
  load.value = value;
  return load;
}

/// Adds a body of linear tetrahedra, moved by `shift`, to a mesh whose vertices and cells are numbered from 0.
inline void append_body(RawMesh& raw, const TetMesh& body, const Vector3& shift) {
  const auto first = static_cast<std::int64_t>(raw.vertices.size());
  for (const Vector3& x : body.vertices) {
    raw.vertex_ids.push_back(static_cast<std::int64_t>(raw.vertices.size()));
    raw.vertices.emplace_back(x + shift);
  }
  for (const auto t : body.tetrahedra) {
    RawCell cell;
    cell.type = CellType::kTetrahedron;
    cell.id = static_cast<std::int64_t>(raw.cells.size());
    cell.vertices = {first + t[0], first + t[1], first + t[2], first + t[3]};
    raw.cells.push_back(cell);
  }
}

}  // namespace tetraction::testing_support
