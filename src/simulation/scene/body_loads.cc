#include "body_loads.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "body_constraints.h"
#include "mesh/named_groups.h"
#include "tetraction/core/error.h"
#include "tetraction/dynamics/terms/consistent_loads.h"

namespace tetraction {
namespace {

// Calls `make` and begins its messages with the place of the load.
template <class Make>
auto at_place(const ForceSettings& load, const Make& make) {
  try {
    return make();
  } catch (const InputError& error) {
    const std::string message = error.what();
    const bool placed = load.where.empty() || message.rfind(load.where, 0) == 0;
    throw InputError(placed ? message : load.where + ": " + message);
  }
}

LoadHistory make_history(const ForceSettings& load, const AmplitudeList& amplitudes) {
  return {load.from, load.until, find_amplitude(amplitudes, load.amplitude, load.where)};
}

const Group* find_group(const TetMesh& mesh, const Selection& selection) {
  const auto* by_name = std::get_if<SelectGroup>(&without_name(selection));
  if (by_name == nullptr) return nullptr;
  const std::vector<const Group*> groups = groups_named(mesh, by_name->name);
  return groups.empty() ? nullptr : groups.front();
}

// The result of `select`, or nothing if it selects nothing.
template <class Select>
auto any_of_selection(const Select& select) -> decltype(select()) {
  try {
    return select();
  } catch (const InputError&) {
    return {};
  }
}

LoadedRegion with_triangles(std::vector<std::array<Index, 3>> triangles) {
  LoadedRegion region;
  region.share = LoadShare::kSurface;
  region.triangles = std::move(triangles);
  return region;
}

LoadedRegion with_tetrahedra(std::vector<Index> tetrahedra) {
  LoadedRegion region;
  region.share = LoadShare::kVolume;
  region.tetrahedra = std::move(tetrahedra);
  return region;
}

LoadedRegion with_vertices(std::vector<Index> vertices) {
  LoadedRegion region;
  region.vertices = std::move(vertices);
  return region;
}

// The region over which LoadShare::kAuto shares a total force or a moment out.
LoadedRegion automatic_region(const Selection& selection, const TetMesh& mesh) {
  select_vertices(mesh, selection);  // throws if nothing at all is selected
  const Group* group = find_group(mesh, selection);
  if (group != nullptr && group->dimension == 2) {
    return with_triangles(select_triangles(mesh, selection));
  }
  const bool is_volume = std::holds_alternative<SelectAll>(without_name(selection)) ||
                         (group != nullptr && group->dimension == 3);
  if (!is_volume) {
    auto triangles = any_of_selection([&] { return select_triangles(mesh, selection); });
    if (anywhere(mesh.part.get(), !triangles.empty())) return with_triangles(std::move(triangles));
  }
  auto tetrahedra = any_of_selection([&] { return select_tetrahedra(mesh, selection); });
  if (anywhere(mesh.part.get(), !tetrahedra.empty())) return with_tetrahedra(std::move(tetrahedra));
  return with_vertices(select_vertices(mesh, selection));
}

// The region of a total force or of a moment.
LoadedRegion shared_region(const ForceSettings& load, const TetMesh& mesh) {
  switch (load.share) {
    case LoadShare::kSurface:
      return with_triangles(select_triangles(mesh, load.select));
    case LoadShare::kVolume:
      return with_tetrahedra(select_tetrahedra(mesh, load.select));
    case LoadShare::kVertices:
      return with_vertices(select_vertices(mesh, load.select));
    case LoadShare::kAuto:
      break;
  }
  return automatic_region(load.select, mesh);
}

LoadDistribution distribution_of(const ForceSettings& load, const MechanicalSystem& system) {
  const TetMesh& mesh = system.mesh();
  LoadedRegion region = shared_region(load, mesh);
  switch (region.share) {
    case LoadShare::kSurface:
      return surface_distribution(mesh, region.triangles);
    case LoadShare::kVolume:
      return mass_distribution(system, region.tetrahedra);
    case LoadShare::kVertices:
    case LoadShare::kAuto:
      break;
  }
  return equal_distribution(std::move(region.vertices), mesh.part);
}

ExternalForce make_dead_load(const ForceSettings& load, const MechanicalSystem& system,
                             const AmplitudeList& amplitudes) {
  const TetMesh& mesh = system.mesh();
  const auto make = [&]() -> ExternalForce {
    switch (load.kind) {
      case LoadKind::kMoment:
        return shared_moment(distribution_of(load, system), mesh, load.vector);
      case LoadKind::kTraction:
        return distributed_force(surface_distribution(mesh, select_triangles(mesh, load.select)),
                                 load.vector);
      case LoadKind::kBodyForce: {
        const std::vector<Index> tetrahedra = select_tetrahedra(mesh, load.select);
        return load.acceleration
                   ? distributed_force(mass_distribution(system, tetrahedra), *load.acceleration)
                   : distributed_force(volume_distribution(system, tetrahedra), load.vector);
      }
      case LoadKind::kForce:
      case LoadKind::kPressure:
        break;
    }
    if (load.total) return shared_force(distribution_of(load, system), *load.total);
    ExternalForce force;
    force.vertices = select_vertices(mesh, load.select);
    force.vector = load.vector;
    return force;
  };
  ExternalForce force = at_place(load, make);
  if (!force.vectors.allFinite()) {
    throw InputError(fmt::format(
        "{}{}its forces are too large for double precision: check the magnitude and the unit.",
        load.where, load.where.empty() ? "" : ": "));
  }
  force.history = make_history(load, amplitudes);
  return force;
}

PressureLoad make_pressure(const ForceSettings& load, const MechanicalSystem& system,
                           const AmplitudeList& amplitudes) {
  const auto faces = at_place(load, [&] { return select_triangles(system.mesh(), load.select); });
  PressureLoad pressure = pressure_on(system.mesh(), faces);
  pressure.value = load.value;
  pressure.history = make_history(load, amplitudes);
  return pressure;
}

void insert_force(MechanicalSystem& system, std::size_t place, ExternalForce force) {
  if (place ==
      system.forces().size()) {  // the usual case, whose cost does not grow with their number
    system.add_force(std::move(force));
    return;
  }
  std::vector<ExternalForce> forces = system.forces();
  forces.insert(forces.begin() + static_cast<std::ptrdiff_t>(place), std::move(force));
  system.set_forces(std::move(forces));
}

void remove_force(MechanicalSystem& system, std::size_t place) {
  std::vector<ExternalForce> forces = system.forces();
  forces.erase(forces.begin() + static_cast<std::ptrdiff_t>(place));
  system.set_forces(std::move(forces));
}

}  // namespace

std::optional<LoadDistribution> faces_or_tetrahedra(const Selection& selection,
                                                    const MechanicalSystem& system) {
  const LoadedRegion region = automatic_region(selection, system.mesh());
  if (region.share == LoadShare::kSurface) {
    return surface_distribution(system.mesh(), region.triangles);
  }
  if (region.share == LoadShare::kVolume) return mass_distribution(system, region.tetrahedra);
  return {};
}

const Selection& without_name(const Selection& selection) {
  const auto* named = std::get_if<SelectNamed>(&selection);
  return named == nullptr || named->of.size() != 1 ? selection
                                                   : without_name(named->of.front().selection);
}

LoadedRegion loaded_region(const ForceSettings& load, const MechanicalSystem& system) {
  const TetMesh& mesh = system.mesh();
  return at_place(load, [&]() -> LoadedRegion {
    switch (load.kind) {
      case LoadKind::kTraction:
      case LoadKind::kPressure:
        return with_triangles(select_triangles(mesh, load.select));
      case LoadKind::kBodyForce:
        return with_tetrahedra(select_tetrahedra(mesh, load.select));
      case LoadKind::kMoment:
        return shared_region(load, mesh);
      case LoadKind::kForce:
        break;
    }
    return load.total ? shared_region(load, mesh)
                      : with_vertices(select_vertices(mesh, load.select));
  });
}

BodyLoads make_loads(const LoadLists& lists, const MechanicalSystem& system,
                     const AmplitudeList& amplitudes) {
  BodyLoads loads;
  for (const LoadKind kind : values_of<LoadKind>()) {
    for (const ForceSettings& load : lists.list(kind)) {
      if (kind == LoadKind::kPressure) {
        loads.pressures.push_back(make_pressure(load, system, amplitudes));
      } else {
        loads.forces.push_back(make_dead_load(load, system, amplitudes));
      }
    }
  }
  return loads;
}

VertexPull make_pull(const PullSettings& settings, const MechanicalSystem& system) {
  std::vector<Index> vertices;
  if (!settings.vertices.empty()) {
    vertices = select_at(system.mesh(), SelectVertices{settings.vertices}, "pull.vertices");
  }
  if (vertices.size() != settings.vertices.size()) {
    throw InputError("pull.vertices: a vertex comes twice; give each once.");
  }
  return {std::move(vertices), system.mass(), settings.target, settings.stiffness,
          settings.damping};
}

void check_load(const ForceSettings& load, const MechanicalSystem& system,
                const AmplitudeList& amplitudes) {
  if (load.kind == LoadKind::kPressure) {
    make_pressure(load, system, amplitudes);
  } else {
    make_dead_load(load, system, amplitudes);
  }
}

std::function<void()> set_load(const ForceSettings& load, std::optional<std::size_t> index,
                               LoadLists& lists, MechanicalSystem& system,
                               const AmplitudeList& amplitudes) {
  std::vector<ForceSettings>& list = lists.list(load.kind);
  if (index && *index >= list.size()) {
    throw InputError(fmt::format("{} number {} does not exist: there are {}, counted from 0.",
                                 to_string(load.kind), *index, list.size()));
  }
  const std::size_t number = index.value_or(list.size());
  std::function<void()> undo_system;
  if (load.kind == LoadKind::kPressure) {
    std::vector<PressureLoad> pressures = system.pressures();
    pressures.resize(std::max(pressures.size(), number + 1));
    pressures[number] = make_pressure(load, system, amplitudes);
    undo_system = [&system, old = system.pressures()] { system.set_pressures(old); };
    system.set_pressures(std::move(pressures));
  } else {
    // The dead loads of a system are in the order of their kinds.
    std::size_t place = number;
    for (const LoadKind kind : values_of<LoadKind>()) {
      if (kind == load.kind) break;
      if (kind != LoadKind::kPressure) place += lists.list(kind).size();
    }
    ExternalForce force = make_dead_load(load, system, amplitudes);
    if (index) {
      undo_system = [&system, place, old = system.forces()[place]] {
        system.set_force(place, old);
      };
      system.set_force(place, std::move(force));
    } else {
      undo_system = [&system, place] { remove_force(system, place); };
      insert_force(system, place, std::move(force));
    }
  }
  if (!index) {
    list.push_back(load);
    return [undo_system, &list] {
      undo_system();
      list.pop_back();
    };
  }
  return [undo_system, &list, number, old = std::exchange(list[number], load)] {
    undo_system();
    list[number] = old;
  };
}

}  // namespace tetraction
