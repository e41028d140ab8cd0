// Makes the loads of a body from the settings of a scene or an edit.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <vector>

#include "tetraction/dynamics/mechanical_system.h"
#include "tetraction/dynamics/terms/consistent_loads.h"
#include "tetraction/simulation/scene.h"

namespace tetraction {

using AmplitudeList = std::vector<AmplitudeSettings>;

/// The loads as a system has them: the dead ones in the order of their kinds and numbers, and the
/// pressures.
struct BodyLoads {
  std::vector<ExternalForce> forces;
  std::vector<PressureLoad> pressures;
};

/// The weights of LoadShare::kAuto for a load of the selection: the areas of its faces at rest, else the masses of
/// its tetrahedra. Nothing if it has neither. Throws InputError if it selects nothing, and for a group of triangles
/// that are not on the boundary.
std::optional<LoadDistribution> faces_or_tetrahedra(const Selection& selection,
                                                    const MechanicalSystem& system);

/// The region of a load: one of the three lists.
struct LoadedRegion {
  LoadShare share = LoadShare::kVertices;         ///< which of them; never kAuto
  std::vector<std::array<Index, 3>> triangles{};  ///< of the boundary, outward
  std::vector<Index> tetrahedra{};
  std::vector<Index> vertices{};
};

/// The region of a load. Throws InputError for selections that select nothing.
LoadedRegion loaded_region(const ForceSettings& load, const MechanicalSystem& system);

/// A selection without the names that it has in the scene (SelectNamed).
const Selection& without_name(const Selection& selection);

/// All loads of the lists. Throws InputError, with the place of the load in the scene, for
/// selections that select nothing, unknown amplitudes, and values that are missing or contradict
/// each other.
BodyLoads make_loads(const LoadLists& lists, const MechanicalSystem& system,
                     const AmplitudeList& amplitudes);

/// The spring of [pull]. Throws InputError if a vertex is not in the mesh, or comes twice.
VertexPull make_pull(const PullSettings& settings, const MechanicalSystem& system);

/// Throws InputError as make_loads() does.
void check_load(const ForceSettings& load, const MechanicalSystem& system,
                const AmplitudeList& amplitudes);

/// Adds a load to the lists and to the system, or replaces the one with that number of its kind. Returns a function that
/// undoes this, as long as nothing else was changed since. Throws InputError as make_loads() does; nothing has changed
/// then.
std::function<void()> set_load(const ForceSettings& load, std::optional<std::size_t> index,
                               LoadLists& lists, MechanicalSystem& system,
                               const AmplitudeList& amplitudes);

}  // namespace tetraction
