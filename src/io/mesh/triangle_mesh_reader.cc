#include "triangle_mesh_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <filesystem>
#include <unordered_map>
#include <utility>

#include "core/quoting.h"
#include "io/mesh/polygon_readers.h"
#include "io/vtk/polygon_reader.h"
#include "tetraction/core/error.h"
#include "tetraction/io/mesh_reader.h"

namespace tetraction {
namespace {

// The triangles of a mesh of cells: the faces of one tetrahedron only, or else the cells that are triangles.
TriangleFile surface_of_cells(const std::string& path, const RawMesh& mesh, bool gmsh) {
  TriangleFile file;
  file.points = mesh.vertices;
  std::unordered_map<std::int64_t, Index> number;
  for (std::size_t i = 0; i < mesh.vertex_ids.size(); ++i) {
    number.emplace(mesh.vertex_ids[i], static_cast<Index>(i));
  }
  const auto vertex = [&](const RawCell& cell, std::size_t k) {
    const auto found = number.find(cell.vertices[k]);
    if (found == number.end()) {
      throw FileError(fmt::format("{}: a cell has the vertex {}, which the file does not have.",
                                  path, cell.vertices[k]));
    }
    return found->second;
  };
  // Sorted corners and corners as they are.
  std::vector<std::pair<std::array<Index, 3>, std::array<Index, 3>>> faces;
  for (const RawCell& cell : mesh.cells) {
    const bool tetrahedron =
        cell.type == CellType::kTetrahedron || cell.type == CellType::kQuadraticTetrahedron;
    if (!tetrahedron || cell.vertices.size() < 4) continue;
    static constexpr std::array<std::array<std::size_t, 3>, 4> kFaces{
        {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}};
    for (const auto& f : kFaces) {
      const std::array<Index, 3> corners{vertex(cell, f[0]), vertex(cell, f[1]),
                                         vertex(cell, f[2])};
      std::array<Index, 3> sorted = corners;
      std::sort(sorted.begin(), sorted.end());
      faces.emplace_back(sorted, corners);
    }
  }
  std::sort(faces.begin(), faces.end());
  for (std::size_t k = 0; k < faces.size();) {
    std::size_t end = k + 1;
    while (end < faces.size() && faces[end].first == faces[k].first) ++end;
    if (end == k + 1) file.triangles.push_back(faces[k].second);
    k = end;
  }
  if (!faces.empty()) return file;
  for (const RawCell& cell : mesh.cells) {
    if (cell.type != CellType::kTriangle) continue;
    if (cell.vertices.size() == 3) {
      file.triangles.push_back({vertex(cell, 0), vertex(cell, 1), vertex(cell, 2)});
    } else if (gmsh && cell.vertices.size() == 6) {
      static constexpr std::array<std::array<std::size_t, 3>, 4> kParts{
          {{0, 3, 5}, {3, 1, 4}, {5, 4, 2}, {3, 4, 5}}};
      for (const auto& p : kParts) {
        file.triangles.push_back({vertex(cell, p[0]), vertex(cell, p[1]), vertex(cell, p[2])});
      }
    } else {
      throw FileError(
          fmt::format("{}: cell {} is a triangle or a strip of {} points. Write the surface with "
                      "triangles of three points.",
                      path, cell.id, cell.vertices.size()));
    }
  }
  return file;
}

}  // namespace

TriangleFile read_triangle_file(const std::string& path) {
  std::string ending = std::filesystem::path(path).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  TriangleFile file;
  if (ending == ".stl") {
    file = read_stl(path);
  } else if (ending == ".obj") {
    file = read_obj(path);
  } else if (ending == ".vtp") {
    file = read_vtp(path);
  } else if (ending == ".msh" || ending == ".vtu" || ending == ".vtk") {
    file = surface_of_cells(path, read_raw_mesh(path), ending == ".msh");
  } else {
    throw InputError(fmt::format(
        "{}: {} Surfaces of triangles in .stl .obj .vtp .msh .vtu .vtk are read.", in_quotes(path),
        ending.empty() ? "a surface's file needs an ending that tells its format."
                       : "the ending " + in_quotes(ending) + " is not that of a surface."));
  }
  if (file.triangles.empty()) throw FileError(path + ": has no triangle.");
  for (std::size_t i = 0; i < file.points.size(); ++i) {
    if (!file.points[i].allFinite()) {
      throw FileError(fmt::format(
          "{}: the coordinates of point {} (counted from 0) are not finite numbers.", path, i));
    }
  }
  return file;
}

}  // namespace tetraction
