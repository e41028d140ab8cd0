// The scene with the edits of a session as if they held from its start.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "tetraction/mesh/tet_mesh.h"
#include "tetraction/simulation/scene.h"
#include "viewer/edits/edit_history.h"
#include "viewer/edits/numbering.h"

namespace tetraction::viewer {

struct EditedScene {
  Scene scene;
  /// The number in the session of each entry of the lists, in the order of the scene.
  ForEachList<std::vector<std::size_t>> numbers;
  /// The number of entries that the lists had without the edits.
  ForEachList<std::size_t> counts{};
  /// Entries that the edits have removed. They are still in the scene, because its events count them.
  ForEachList<std::vector<std::size_t>> removed;
};

/// `made` are edits that have not been undone. Those of positions and momenta are left out.
EditedScene edited_scene(const Scene& scene, const TetMesh& mesh,
                         const std::vector<MadeEdit>& made);

/// Whether read_scene_mesh() gives the same mesh for both.
bool has_same_mesh(const Scene& a, const Scene& b);

}  // namespace tetraction::viewer
