#include "mesh_candidates.h"

#include <algorithm>
#include <utility>

#include "dynamics/contact/pairs/surface_loops.h"

namespace tetraction {

MeshCandidates find_candidates(const TriangleMesh& mesh, const ContactSurface& surface,
                               const Vector& from, const Vector& to, double reach,
                               MeshFeatures features) {
  MeshCandidates candidates;
  const auto box_of = [&](std::span<const Index> corners) {
    return box_of_ways(corners, from, to).widened(reach);
  };
  const bool sharp = features == MeshFeatures::kSharp;
  const auto vertex_triangles =
      gather_pairs(from.size() / 3, [&](Index i, std::vector<Index>& found) {
        mesh.triangle_tree().query(box_of({&i, 1}), found);
      });
  for (const auto& [i, t] : vertex_triangles) {
    if (candidates.vertices.empty() || candidates.vertices.back() != i) {
      candidates.vertices.push_back(i);
      candidates.starts.push_back(candidates.triangles.size());
    }
    candidates.triangles.push_back(t);
    candidates.starts.back() = candidates.triangles.size();
  }
  const BoxTree& vertices = sharp ? mesh.sharp_vertex_tree() : mesh.vertex_tree();
  candidates.vertex_faces = gather_pairs(
      static_cast<Index>(surface.triangles.size()), [&](Index t, std::vector<Index>& found) {
        vertices.query(box_of(surface.triangles[static_cast<std::size_t>(t)]), found);
      });
  for (auto& [t, i] : candidates.vertex_faces) {
    std::swap(t, i);
    if (sharp) t = mesh.sharp_vertices()[static_cast<std::size_t>(t)];
  }
  const BoxTree& edges = sharp ? mesh.sharp_edge_tree() : mesh.edge_tree();
  candidates.edge_edges = gather_pairs(
      static_cast<Index>(surface.edges.size()), [&](Index e, std::vector<Index>& found) {
        edges.query(box_of(surface.edges[static_cast<std::size_t>(e)]), found);
      });
  if (sharp) {
    for (auto& pair : candidates.edge_edges) {
      pair[1] = mesh.sharp_edges()[static_cast<std::size_t>(pair[1])];
    }
  }
  return candidates;
}

}  // namespace tetraction
