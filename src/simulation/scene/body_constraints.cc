#include "body_constraints.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "body_loads.h"
#include "core/decompositions.h"
#include "tetraction/core/error.h"

namespace tetraction {
namespace {

Matrix positions_of(const std::vector<Index>& vertices, const Vector& q) {
  Matrix positions(3, static_cast<Index>(vertices.size()));
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    positions.col(static_cast<Index>(i)) = vertex_block(q, vertices[i]);
  }
  return positions;
}

Vector3 unit(const ConstraintSettings& constraint) {
  if (!constraint.direction.allFinite() || constraint.direction.isZero(0.0)) {
    throw InputError(fmt::format(
        "{}: the {} must not be zero.", constraint.where,
        constraint.kind == ConstraintKind::kPlane ? "normal of a plane" : "direction of a line"));
  }
  return constraint.direction.stableNormalized();
}

GuidedVertices make_guided(const ConstraintSettings& constraint, const TetMesh& mesh,
                           const Vector& q) {
  GuidedVertices guided;
  guided.name = constraint.where;
  guided.vertices = select_at(mesh, constraint.select, constraint.where);
  guided.points = positions_of(guided.vertices, q);
  if (constraint.point) guided.points.colwise() = *constraint.point;
  const Vector3 axis = unit(constraint);
  if (constraint.kind == ConstraintKind::kLine) {
    guided.directions = axis;
  } else {
    guided.directions.resize(3, 2);
    guided.directions.col(0) = axis.unitOrthogonal();
    guided.directions.col(1) = axis.cross(axis.unitOrthogonal());
  }
  return guided;
}

FixedDistance make_distance(const ConstraintSettings& constraint, const TetMesh& mesh,
                            const Vector& q) {
  FixedDistance distance;
  distance.name = constraint.where;
  distance.a = select_at(mesh, SelectVertices{{constraint.vertices[0]}}, constraint.where).front();
  distance.b = select_at(mesh, SelectVertices{{constraint.vertices[1]}}, constraint.where).front();
  distance.length = constraint.length.value_or(
      (vertex_block(q, distance.a) - vertex_block(q, distance.b)).norm());
  return distance;
}

// The point about which a driven handle turns if the scene names none: the centre of the areas of the faces whose
// vertices it holds, else that of the masses of its tetrahedra, else that of the lumped masses of its vertices.
Vector3 center_of_handle(const Selection& selection, const std::vector<Index>& vertices,
                         const MechanicalSystem& system, const Vector& q) {
  std::optional<LoadDistribution> shares;
  try {
    shares = faces_or_tetrahedra(selection, system);
  } catch (const InputError&) {  // a group of triangles inside the body
  }
  const std::vector<Index>& places = shares ? shares->vertices : vertices;
  Vector3 sum = Vector3::Zero();
  double total = 0.0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Index v = places[i];
    const double weight = shares ? shares->weights[static_cast<Index>(i)] : system.mass()[v];
    sum += weight * vertex_block(q, v);
    total += weight;
  }
  return sum / total;
}

ConstraintObject make_handle(const ConstraintSettings& constraint, const MechanicalSystem& system,
                             const Vector& q, double time,
                             const std::vector<AmplitudeSettings>& amplitudes) {
  const std::vector<Index> vertices = select_at(system.mesh(), constraint.select, constraint.where);
  const Matrix positions = positions_of(vertices, q);
  if (!constraint.is_driven()) return RigidHandle{vertices, positions, constraint.where};

  PrescribedVertices driven;
  driven.name = constraint.where;
  driven.vertices = vertices;
  driven.start = positions;
  driven.motion.since = time;
  driven.motion.velocity = constraint.velocity.value_or(Vector3::Zero());
  driven.motion.angular_velocity = constraint.angular_velocity.value_or(Vector3::Zero());
  driven.motion.velocity_amplitude =
      find_amplitude(amplitudes, constraint.amplitude, constraint.where);
  driven.motion.center =
      constraint.point.value_or(center_of_handle(constraint.select, vertices, system, q));
  if (!driven.motion.angular_velocity.isZero(0.0)) {
    constexpr double kCollinear = 1e-9;
    const Matrix arms = positions.colwise() - driven.motion.center;
    const Vector3 squared = symmetric_eigen(Matrix3(arms * arms.transpose())).values;
    if (vertices.size() < 3 ||
        !(std::sqrt(std::abs(squared[1])) > kCollinear * std::sqrt(std::abs(squared[2])))) {
      throw InputError(fmt::format(
          "{}: a handle that is turned needs three vertices or more that are not on one line; it "
          "has {}. Let it select more, or give a velocity only.",
          constraint.where,
          vertices.size() < 3 ? fmt::format("{}", vertices.size()) : "only some on a line"));
    }
  }
  return driven;
}

// Targets in the order of the fixed vertices, which are sorted.
Matrix own_targets(const FixSettings& fix, const TetMesh& mesh,
                   const std::vector<Index>& vertices) {
  const auto* select = std::get_if<SelectVertices>(&fix.select);
  const double own = static_cast<double>(
      mesh.part ? std::lower_bound(vertices.begin(), vertices.end(), mesh.part->owned_vertices) -
                      vertices.begin()
                : static_cast<std::ptrdiff_t>(vertices.size()));
  if (select == nullptr || select->ids.size() != fix.targets.size() ||
      sum_over_parts(mesh.part.get(), own) != static_cast<double>(fix.targets.size())) {
    throw InputError(
        fmt::format("{}{}targets needs select = {{ vertices = [...] }} with one target for each "
                    "vertex, and each vertex named once.",
                    fix.where, fix.where.empty() ? "" : ": "));
  }
  std::unordered_map<std::int64_t, std::size_t> place;
  for (std::size_t i = 0; i < select->ids.size(); ++i) place.emplace(select->ids[i], i);
  Matrix targets(3, static_cast<Index>(vertices.size()));
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    targets.col(static_cast<Index>(i)) = fix.targets[place.at(mesh.vertex_id(vertices[i]))];
  }
  return targets;
}

}  // namespace

std::vector<Index> select_at(const TetMesh& mesh, const Selection& selection,
                             const std::string& where) {
  try {
    return select_vertices(mesh, selection);
  } catch (const InputError& error) {
    throw InputError(where.empty() ? error.what() : where + ": " + error.what());
  }
}

std::vector<SharedDistance> shared_distances(const std::vector<ConstraintObject>& constraints) {
  using Key = std::tuple<Index, Index, double>;
  std::map<Key, SharedDistance> known;
  const auto key_of = [](const FixedDistance& distance) {
    return Key{std::min(distance.a, distance.b), std::max(distance.a, distance.b), distance.length};
  };
  for (const ConstraintObject& object : constraints) {
    const auto* distance = std::get_if<FixedDistance>(&object);
    if (distance == nullptr) continue;
    const std::size_t number = known.size();
    const auto [entry, is_new] = known.try_emplace(key_of(*distance), SharedDistance{number, 1});
    if (!is_new) ++entry->second.count;
  }
  std::vector<SharedDistance> shared;
  for (const ConstraintObject& object : constraints) {
    const auto* distance = std::get_if<FixedDistance>(&object);
    shared.push_back(distance == nullptr ? SharedDistance{0, 0} : known.at(key_of(*distance)));
  }
  return shared;
}

ConstraintList BodyConstraints::list() const {
  ConstraintList list;
  list.held = fixes;
  const std::vector<SharedDistance> shared = shared_distances(others);
  auto place = shared.begin();
  for (const ConstraintObject& object : others) {
    if (const auto* held = std::get_if<PrescribedVertices>(&object)) list.held.push_back(*held);
    if (const auto* guided = std::get_if<GuidedVertices>(&object)) list.guided.push_back(*guided);
    if (const auto* distance = std::get_if<FixedDistance>(&object)) {
      if (place->number == list.distances.size()) list.distances.push_back(*distance);
    }
    if (const auto* handle = std::get_if<RigidHandle>(&object)) list.handles.push_back(*handle);
    ++place;
  }
  return list;
}

PrescribedVertices make_held(const FixSettings& fix, const TetMesh& mesh, const Vector& q,
                             double time, const std::vector<AmplitudeSettings>& amplitudes) {
  PrescribedVertices held;
  held.name = fix.where;
  held.vertices = select_at(mesh, fix.select, fix.where);
  held.components = fix.components;
  held.start = positions_of(held.vertices, q);
  if (fix.target) held.start.colwise() = *fix.target;
  held.motion.offset_amplitude = find_amplitude(amplitudes, fix.amplitude, fix.where);
  if (held.motion.offset_amplitude) {
    held.motion.offset = fix.offset.value_or(Vector3::Zero());
  } else if (fix.offset) {
    held.start.colwise() += *fix.offset;
  }
  if (!fix.targets.empty()) held.start = own_targets(fix, mesh, held.vertices);
  held.motion.since = time;
  for (Index i = 0; i < 3; ++i) {
    if (fix.components[static_cast<std::size_t>(i)]) held.motion.velocity[i] = fix.velocity[i];
  }
  if (fix.is_penalty) {
    if (!(fix.penalty > 0.0) || !std::isfinite(fix.penalty)) {
      throw InputError(fmt::format("{}: the penalty must be above 0 and finite.", fix.where));
    }
    held.penalty = fix.penalty;
  }
  return held;
}

bool keeps_place(const FixSettings& before, const FixSettings& after) {
  return before.select == after.select && before.components == after.components &&
         before.target == after.target && before.offset == after.offset &&
         before.targets == after.targets && before.amplitude == after.amplitude;
}

PrescribedVertices changed_held(const PrescribedVertices& held, const FixSettings& before,
                                const FixSettings& after, const TetMesh& mesh, const Vector& q,
                                double time, const std::vector<AmplitudeSettings>& amplitudes) {
  PrescribedVertices next = make_held(after, mesh, q, time, amplitudes);
  if (!keeps_place(before, after) || held.vertices.empty()) return next;
  next.vertices = held.vertices;  // without those that were released since
  next.start = held.start;
  PrescribedMotion steady = held.motion;  // the offset of an amplitude goes on as it is
  steady.offset_amplitude = nullptr;
  for (Index i = 0; i < held.start.cols(); ++i) {
    next.start.col(i) = steady.position(held.start.col(i), time);
  }
  return next;
}

ConstraintObject make_constraint(const ConstraintSettings& constraint,
                                 const MechanicalSystem& system, const Vector& q, double time,
                                 const std::vector<AmplitudeSettings>& amplitudes) {
  switch (constraint.kind) {
    case ConstraintKind::kDistance:
      return make_distance(constraint, system.mesh(), q);
    case ConstraintKind::kPlane:
    case ConstraintKind::kLine:
      return make_guided(constraint, system.mesh(), q);
    case ConstraintKind::kRigid:
      break;
  }
  return make_handle(constraint, system, q, time, amplitudes);
}

ConstraintSettings with_length(ConstraintSettings settings, const ConstraintObject& object) {
  if (const auto* distance = std::get_if<FixedDistance>(&object))
    settings.length = distance->length;
  return settings;
}

BodyConstraints make_body_constraints(const Scene& scene, const MechanicalSystem& system,
                                      Vector q) {
  BodyConstraints constraints;
  for (const FixSettings& fix : scene.fix) {
    constraints.fixes.push_back(make_held(fix, system.mesh(), q, 0.0, scene.amplitude));
    constraints.fix_settings.push_back(fix);
  }
  Constraints(constraints.list(), system.mesh(), system.mass()).prescribe(0.0, q);
  for (const ConstraintSettings& constraint : scene.constraint) {
    constraints.others.push_back(make_constraint(constraint, system, q, 0.0, scene.amplitude));
    constraints.other_settings.push_back(with_length(constraint, constraints.others.back()));
  }
  return constraints;
}

}  // namespace tetraction
