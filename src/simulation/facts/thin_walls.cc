// Walls that are too thin for nodal volumes.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <vector>

#include "tetraction/simulation/warnings.h"

namespace tetraction {
namespace {

using MarkedVertices = std::vector<bool>;  // of vertices

std::size_t index(Index v) {
  return static_cast<std::size_t>(v);
}

// The vertices of all tetrahedra that satisfy a condition.
template <class Condition>
MarkedVertices vertices_of(const TetMesh& mesh, const Condition& condition) {
  MarkedVertices marks(mesh.vertices.size(), false);
  for (const auto& tetrahedron : mesh.tetrahedra) {
    if (!condition(tetrahedron)) continue;
    for (const Index v : tetrahedron) marks[index(v)] = true;
  }
  return marks;
}

// The share of the body's volume in walls that are one or two tetrahedra thick. Walls of three have tetrahedra
// between their two inner layers of vertices.
double share_of_thin_walls(const TetMesh& mesh) {
  MarkedVertices outside(mesh.vertices.size(), false);
  for (const auto& face : boundary_faces(mesh)) {
    for (const Index v : face) outside[index(v)] = true;
  }
  const auto touches = [](const std::array<Index, 4>& tetrahedron, const MarkedVertices& marks) {
    return std::any_of(tetrahedron.begin(), tetrahedron.end(),
                       [&](Index v) { return marks[index(v)]; });
  };
  const MarkedVertices core =
      vertices_of(mesh, [&](const auto& t) { return !touches(t, outside); });
  // At edges and corners of thick bodies tetrahedra are beside such that touch the core.
  const MarkedVertices thick = vertices_of(mesh, [&](const auto& t) { return touches(t, core); });
  double thin = 0.0;
  double total = 0.0;
  for (Index e = 0; e < mesh.tetrahedron_count(); ++e) {
    const double own = mesh.volume(e);
    total += own;
    if (!touches(mesh.tetrahedra[index(e)], thick)) thin += own;
  }
  return thin / total;
}

}  // namespace

std::string thin_wall_warning(const MechanicalSystem& system) {
  constexpr double kMuch = 0.1;
  if (system.nodal_volume() == nullptr) return {};
  const double share = share_of_thin_walls(system.mesh());
  if (share < kMuch) return {};
  return fmt::format(
      "{:.0f} % of the body's volume is in walls or rods that are one or two tetrahedra thick. "
      "With mesh.volume = \"nodal\" they are far too stiff in bending: a wall of two by about a "
      "half. Take mesh.element = \"quadratic\" without mesh.volume, or make the wall four "
      "tetrahedra thick or more",
      100.0 * share);
}

}  // namespace tetraction
