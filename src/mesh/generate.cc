#include "tetraction/mesh/generate.h"

#include <fmt/format.h>

#include <cmath>
#include <numeric>
#include <utility>

#include "tetraction/core/error.h"

namespace tetraction {
namespace {

// Completes a mesh that has its vertices and tetrahedra.
TetMesh finished(TetMesh mesh, const char* source) {
  if (!std::isnormal(mesh.volume(0))) {
    throw InputError(fmt::format(
        "A generated mesh of this size has tetrahedra of {} m³, which double precision does not "
        "hold: choose another size.",
        mesh.volume(0)));
  }
  mesh.source = source;
  mesh.vertex_ids.resize(mesh.vertices.size());
  std::iota(mesh.vertex_ids.begin(), mesh.vertex_ids.end(), 0);
  mesh.tetrahedron_ids.resize(mesh.tetrahedra.size());
  std::iota(mesh.tetrahedron_ids.begin(), mesh.tetrahedron_ids.end(), 0);
  mesh.regions.assign(mesh.tetrahedra.size(), 0);
  return mesh;
}

void check_size(double size) {
  if (!(size > 0.0) || !std::isfinite(size)) {
    throw InputError(
        fmt::format("The size of a generated mesh must be positive and finite, not {} m.", size));
  }
}

}  // namespace

TetMesh generate_box(const Vector3& size, const std::array<int, 3>& cells) {
  double vertices = 1.0;
  for (std::size_t i = 0; i < 3; ++i) {
    check_size(size[static_cast<Index>(i)]);
    if (cells[i] < 1) {
      throw InputError(
          fmt::format("A generated box needs at least 1 cell along each axis, not {}.", cells[i]));
    }
    vertices *= cells[i] + 1.0;
  }
  // Such a mesh needs about 6 GB. It is far larger than a mesh whose matrix can be factorised.
  constexpr double kMost = 2e7;
  if (vertices > kMost) {
    throw InputError(
        fmt::format("A box of {:.3g} vertices is too large (at most {:.3g}): ask for fewer cells.",
                    vertices, kMost));
  }

  TetMesh mesh;
  std::vector<Vector3>& positions = mesh.vertices.own();
  std::vector<std::array<Index, 4>>& tetrahedra = mesh.tetrahedra.own();
  const Index nx = cells[0];
  const Index ny = cells[1];
  const Index nz = cells[2];
  positions.reserve(static_cast<std::size_t>(vertices));
  tetrahedra.reserve(static_cast<std::size_t>(6 * nx * ny * nz));
  for (Index k = 0; k <= nz; ++k) {
    for (Index j = 0; j <= ny; ++j) {
      for (Index i = 0; i <= nx; ++i) {
        // i/n is computed first, so that the last face lies exactly at `size`.
        positions.emplace_back(size.x() * (static_cast<double>(i) / static_cast<double>(nx)),
                               size.y() * (static_cast<double>(j) / static_cast<double>(ny)),
                               size.z() * (static_cast<double>(k) / static_cast<double>(nz)));
      }
    }
  }
  const auto vertex = [&](Index i, Index j, Index k) { return i + (nx + 1) * (j + (ny + 1) * k); };
  // Each of the six paths along the axes from corner (0,0,0) to (1,1,1) gives one tetrahedron.
  constexpr std::array<std::array<std::size_t, 3>, 6> kPaths{
      {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {1, 0, 2}, {2, 1, 0}}};
  for (Index k = 0; k < nz; ++k) {
    for (Index j = 0; j < ny; ++j) {
      for (Index i = 0; i < nx; ++i) {
        for (std::size_t p = 0; p < kPaths.size(); ++p) {
          std::array<Index, 3> corner{i, j, k};
          std::array<Index, 4> tetrahedron{};
          tetrahedron[0] = vertex(i, j, k);
          for (std::size_t a = 0; a < 3; ++a) {
            ++corner[kPaths[p][a]];
            tetrahedron[a + 1] = vertex(corner[0], corner[1], corner[2]);
          }
          // The last three paths are odd permutations of the axes, so that their volume is negative.
          if (p >= 3) std::swap(tetrahedron[2], tetrahedron[3]);
          tetrahedra.push_back(tetrahedron);
        }
      }
    }
  }
  return finished(std::move(mesh), "generated box");
}

TetMesh generate_tetrahedron(double size) {
  check_size(size);
  TetMesh mesh;
  mesh.vertices.own() = {Vector3::Zero(), size * Vector3::UnitX(), size * Vector3::UnitY(),
                         size * Vector3::UnitZ()};
  mesh.tetrahedra.own() = {{0, 1, 2, 3}};
  return finished(std::move(mesh), "generated tetrahedron");
}

}  // namespace tetraction
