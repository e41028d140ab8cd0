// Meshes whose arrays belong to the caller.
#include <fmt/format.h>

#include <cstdint>
#include <span>
#include <vector>

#include "flat_tetrahedra.h"
#include "tetraction/core/error.h"
#include "tetraction/mesh/tet_mesh.h"

namespace tetraction {
namespace {

// Throws InputError for everything that build_mesh() would refuse, correct or leave out.
void check_view(const TetMesh& mesh) {
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    if (!mesh.vertices[static_cast<std::size_t>(v)].allFinite()) {
      throw InputError(fmt::format("Vertex {} has a coordinate that is not finite.", v));
    }
  }
  std::vector<bool> used(mesh.vertices.size(), false);
  for (Index e = 0; e < mesh.tetrahedron_count(); ++e) {
    for (const Index v : mesh.tetrahedra[static_cast<std::size_t>(e)]) {
      if (v < 0 || v >= mesh.vertex_count()) {
        throw InputError(
            fmt::format("Tetrahedron {} refers to vertex {}; there are {}, counted from 0.", e, v,
                        mesh.vertex_count()));
      }
      used[static_cast<std::size_t>(v)] = true;
    }
    const double volume = mesh.volume(e);
    if (volume < 0.0 || is_flat(volume, longest_edge(mesh, e))) {
      throw InputError(fmt::format(
          "Tetrahedron {} has a volume of {:.3g} m³, which must be positive. Exchange two of its "
          "vertices if it is negative; repair or remove it if it is 0 to round-off.",
          e, volume));
    }
  }
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    if (!used[static_cast<std::size_t>(v)]) {
      throw InputError(
          fmt::format("No tetrahedron uses vertex {}, which so has no mass: leave it out.", v));
    }
  }
}

template <class Number>
TetMesh checked_view(std::span<const double> positions, std::span<const Number> tetrahedra) {
  if (positions.empty() || positions.size() % 3 != 0 || tetrahedra.empty() ||
      tetrahedra.size() % 4 != 0) {
    throw InputError(fmt::format(
        "A mesh has three coordinates a vertex and four vertices a tetrahedron: {} and {} numbers "
        "are not that.",
        positions.size(), tetrahedra.size()));
  }
  TetMesh mesh;
  mesh.source = "arrays in memory";
  mesh.vertices = VertexArray(VertexView(positions));
  mesh.tetrahedra = TetrahedronArray(TetrahedronView(tetrahedra));
  check_view(mesh);
  return mesh;
}

}  // namespace

TetMesh view_mesh(std::span<const double> positions, std::span<const std::int32_t> tetrahedra) {
  return checked_view(positions, tetrahedra);
}

TetMesh view_mesh(std::span<const double> positions, std::span<const std::int64_t> tetrahedra) {
  return checked_view(positions, tetrahedra);
}

}  // namespace tetraction
