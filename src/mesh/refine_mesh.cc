// The uniform refinement of a mesh.
#include <array>
#include <utility>

#include "tetraction/mesh/edge_vertices.h"

namespace tetraction {

TetMesh refined_mesh(const TetMesh& mesh) {
  TetMesh fine = with_edge_vertices(mesh);
  const EdgeVertices edges(fine);
  std::vector<std::array<Index, 4>>& tetrahedra = fine.tetrahedra.own();
  const std::vector<std::array<Index, 4>> coarse = std::exchange(tetrahedra, {});
  tetrahedra.reserve(8 * coarse.size());
  for (std::size_t e = 0; e < coarse.size(); ++e) {
    const auto [a, b, c, d] = coarse[e];
    const auto [ab, bc, ac, ad, bd, cd] = fine.edge_vertices[e];
    // Four corners, and the octahedron between them, which its diagonal from ac to bd divides.
    tetrahedra.insert(tetrahedra.end(), {{a, ab, ac, ad},
                                         {ab, b, bc, bd},
                                         {ac, bc, c, cd},
                                         {ad, bd, cd, d},
                                         {ab, bc, ac, bd},
                                         {ac, bc, cd, bd},
                                         {ab, ac, ad, bd},
                                         {ac, cd, ad, bd}});
  }
  fine.edge_vertices.clear();
  fine.tetrahedron_ids.clear();
  fine.regions.clear();
  for (const int region : mesh.regions) fine.regions.insert(fine.regions.end(), 8, region);
  for (auto& [name, values] : fine.cell_arrays) {
    const Matrix of_coarse = values;
    values.resize(of_coarse.rows(), 8 * of_coarse.cols());
    for (Index e = 0; e < of_coarse.cols(); ++e) {
      values.middleCols(8 * e, 8).colwise() = of_coarse.col(e);
    }
  }
  for (Group& group : fine.groups) {
    group.triangles = edges.divide(group.triangles);
    for (const Index e : std::exchange(group.tetrahedra, {})) {
      for (Index k = 0; k < 8; ++k) group.tetrahedra.push_back(8 * e + k);
    }
    for (const auto& [a, b] : std::exchange(group.lines, {})) {
      const Index middle = edges.find(a, b);
      if (middle < 0) {
        group.lines.push_back({a, b});
      } else {
        group.lines.insert(group.lines.end(), {{a, middle}, {middle, b}});
      }
    }
  }
  return mesh.is_quadratic() ? with_edge_vertices(std::move(fine)) : fine;
}

}  // namespace tetraction
