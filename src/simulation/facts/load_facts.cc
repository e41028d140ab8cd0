#include "load_facts.h"

#include <fmt/format.h>
#include <array>
#include <cstdlib>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "core/quoting.h"
#include "simulation/scene/body_loads.h"
#include "tetraction/dynamics/terms/consistent_loads.h"

namespace tetraction {
namespace {

// The edges of oriented triangles that have no opposite edge, in the direction of their triangles. A closed
// surface has none.
std::vector<std::array<Index, 2>> rim_edges(const std::vector<std::array<Index, 3>>& triangles) {
  // Directed edges from the smaller to the larger number, minus the others.
  std::map<std::array<Index, 2>, int> counts;
  for (const auto& triangle : triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const Index from = triangle[i];
      const Index to = triangle[(i + 1) % 3];
      counts[{std::min(from, to), std::max(from, to)}] += from < to ? 1 : -1;
    }
  }
  std::vector<std::array<Index, 2>> edges;
  for (const auto& [ends, count] : counts) {
    for (int i = 0; i < std::abs(count); ++i) {
      edges.push_back(count > 0 ? ends : std::array<Index, 2>{ends[1], ends[0]});
    }
  }
  return edges;
}

// How many directions of a vertex are held. Vertices of free handles move with the handle.
int held_directions(const FreeCoordinates& coordinates, Index vertex) {
  if (coordinates.set_of(vertex) >= 0) return 0;
  return 3 - coordinates.map(vertex).count;
}

void enter_rim(const MechanicalSystem& system, const std::vector<std::array<Index, 3>>& triangles,
               SurfaceFacts& facts) {
  for (const auto& [a, b] : rim_edges(triangles)) {
    ++facts.rim_edges;
    facts.rim_length += (system.rest().position(b) - system.rest().position(a)).norm();
    const int held = std::min(held_directions(system.coordinates(), a),
                              held_directions(system.coordinates(), b));
    if (held == 3) {
      ++facts.rim_held;
    } else if (held > 0) {
      ++facts.rim_guided;
    }
  }
}

SurfacePressure pressure_term(const PressureLoad& load, const MechanicalSystem& system) {
  return {{load}, system.mesh().rest_positions(), system.coordinates()};
}

// The volume of the cones from a point to the faces: the potential of a pressure of 1 Pa.
double enclosed_volume(const MechanicalSystem& system,
                       const std::vector<std::array<Index, 3>>& triangles) {
  PressureLoad load = pressure_on(system.mesh(), triangles);
  load.value = 1.0;
  const Vector x = system.mesh().rest_positions();
  return pressure_term(load, system).energy(system.force_point(x, 0.0));
}

// The forces of the term with the factor that it has at t = 0.
Vector forces_of(const ForceTerm& term, const MechanicalSystem& system, const Vector& x) {
  Vector forces = Vector::Zero(system.dof_count());
  const ForcePoint at = system.force_point(x, 0.0);
  if (term.has_potential()) term.add_gradient(at, forces);
  forces = -forces;
  if (term.has_load()) term.add_load(at, forces);
  return forces;
}

// The forces of load `index` of the dead ones or of the pressures, with the factor 1.
Vector forces_of_load(bool is_pressure, std::size_t index, const MechanicalSystem& system,
                      const Vector& x) {
  if (is_pressure) {
    PressureLoad pressure = system.pressures()[index];
    pressure.history = {};
    return forces_of(pressure_term(pressure, system), system, x);
  }
  ExternalForces forces;
  forces.list().push_back(system.forces()[index]);
  forces.list().back().history = {};
  return forces_of(forces, system, x);
}

void enter_region(const ForceSettings& load, const MechanicalSystem& system, LoadFacts& facts) {
  const LoadedRegion region = loaded_region(load, system);
  if (region.share == LoadShare::kSurface) facts.surface = surface_facts(system, region.triangles);
  facts.tetrahedra = static_cast<Index>(region.tetrahedra.size());
  for (const Index e : region.tetrahedra) {
    facts.volume += system.rest().volume(e);
    facts.mass += system.element_mass(e);
  }
}

}  // namespace

SurfaceFacts surface_facts(const MechanicalSystem& system,
                           const std::vector<std::array<Index, 3>>& triangles) {
  SurfaceFacts facts;
  facts.triangles = static_cast<Index>(triangles.size());
  facts.area = surface_distribution(system.mesh(), triangles).total();
  enter_rim(system, triangles, facts);
  if (facts.is_closed()) facts.volume = enclosed_volume(system, triangles);
  return facts;
}

ForceFacts force_facts(const MechanicalSystem& system, const Vector& positions,
                       const Vector& forces) {
  constexpr double kRoundOff = 1e-12;
  ForceFacts facts;
  double force_scale = 0.0;
  double moment_scale = 0.0;
  for (Index v = 0; v < system.vertex_count(); ++v) {
    const Vector3 force = vertex_block(forces, v);
    if (force.isZero(0.0)) continue;
    const Vector3 arm = vertex_block(positions, v);
    ++facts.vertices;
    facts.resultant += force;
    facts.moment += arm.cross(force);
    force_scale += force.norm();
    moment_scale += arm.norm() * force.norm();
    const int held = held_directions(system.coordinates(), v);
    if (held == 0) continue;
    if (held == 3) ++facts.held_vertices;
    const auto allowed = system.coordinates().map(v);
    facts.held += force - allowed.columns * (allowed.columns.transpose() * force).eval();
  }
  const auto clean = [](Vector3& sum, double scale) {
    for (double& entry : sum) {
      if (std::abs(entry) <= kRoundOff * scale) entry = 0.0;
    }
  };
  clean(facts.resultant, force_scale);
  clean(facts.held, force_scale);
  clean(facts.moment, moment_scale);
  return facts;
}

std::vector<LoadFacts> load_facts(const Scene& scene, const MechanicalSystem& system,
                                  const Vector& positions) {
  std::vector<LoadFacts> all;
  std::size_t dead = 0;  // the system has the dead loads in the order of their kinds
  for (const LoadKind kind : values_of<LoadKind>()) {
    const std::vector<ForceSettings>& list = scene.list(kind);
    for (std::size_t i = 0; i < list.size(); ++i) {
      const ForceSettings& load = list[i];
      const bool is_pressure = kind == LoadKind::kPressure;
      const LoadHistory& history =
          is_pressure ? system.pressures()[i].history : system.forces()[dead].history;
      LoadFacts facts;
      facts.key = fmt::format("{}.{}", to_string(kind), i);
      facts.kind = kind;
      facts.pressure = load.value;
      facts.amplitude = load.amplitude;
      facts.factor = history.value(0.0);
      facts.from = load.from;
      facts.until = load.until;
      enter_region(load, system, facts);
      facts.force =
          force_facts(system, positions,
                      forces_of_load(is_pressure, is_pressure ? i : dead, system, positions));
      if (!is_pressure) ++dead;
      all.push_back(std::move(facts));
    }
  }
  return all;
}

std::optional<ForceFacts> environment_facts(const Scene& scene, const MechanicalSystem& system,
                                            const Vector& positions) {
  if (scene.environment.kind == EnvironmentKind::kNone) return std::nullopt;
  Environment environment = system.environment();
  environment.set_amplitude(nullptr);
  return force_facts(system, positions, forces_of(environment, system, positions));
}

std::optional<ForceFacts> pull_facts(const Scene& scene, const MechanicalSystem& system,
                                     const Vector& positions) {
  if (scene.pull.vertices.empty()) return std::nullopt;
  return force_facts(system, positions,
                     forces_of(make_pull(scene.pull, system), system, positions));
}

std::string volume_group_warning(const ForceSettings& load, const MechanicalSystem& system) {
  if (load.kind != LoadKind::kPressure && load.kind != LoadKind::kTraction) return {};
  const TetMesh& mesh = system.mesh();
  const auto* selected = std::get_if<SelectGroup>(&without_name(load.select));
  if (selected == nullptr || mesh.part) return {};
  TetMesh own;  // only what boundary_faces() needs
  own.vertices = mesh.vertices;
  for (const Group& group : mesh.groups) {
    if (group.name != selected->name) continue;
    if (group.dimension != 3) return {};
    for (const Index e : group.tetrahedra) {
      own.tetrahedra.own().push_back(mesh.tetrahedra[static_cast<std::size_t>(e)]);
    }
  }
  const auto sorted_faces = [](const TetMesh& of) {
    auto faces = boundary_faces(of);
    for (auto& face : faces) std::sort(face.begin(), face.end());
    std::sort(faces.begin(), faces.end());
    return faces;
  };
  const auto outside = sorted_faces(mesh);
  Index inside = 0;
  for (const auto& face : sorted_faces(own)) {
    if (!std::binary_search(outside.begin(), outside.end(), face)) ++inside;
  }
  if (inside == 0) return {};
  return fmt::format(
      "{}{}the group {} consists of tetrahedra. The {} acts on the {} triangles of the body's "
      "boundary whose corners are all in the group, and not on the {} faces of the group inside "
      "the "
      "body. Select a group of triangles or {{ faces = ... }} to name the triangles themselves.",
      load.where, load.where.empty() ? "" : ": ", in_quotes(selected->name), to_string(load.kind),
      loaded_region(load, system).triangles.size(), inside);
}

}  // namespace tetraction
