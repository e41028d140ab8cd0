// The pairs of a surface and a rigid mesh that are near each other.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "dynamics/contact/mesh/triangle_mesh.h"
#include "dynamics/contact/obstacle_contact.h"

namespace tetraction {

/// Pairs in ascending order of the surface's numbers.
struct MeshCandidates {
  std::vector<Index> vertices;         ///< of the surface, with triangles of the mesh nearby
  std::vector<std::size_t> starts{0};  ///< where the triangles of each begin, and the end
  std::vector<Index> triangles;
  std::vector<std::array<Index, 2>>
      vertex_faces;  ///< a vertex of the mesh and a triangle of the surface
  std::vector<std::array<Index, 2>> edge_edges;  ///< an edge of the surface and one of the mesh

  std::span<const Index> triangles_of(std::size_t k) const {
    return {triangles.data() + starts[k], starts[k + 1] - starts[k]};
  }
};

/// Which edges and vertices of the mesh are looked at.
enum class MeshFeatures { kAll, kSharp };

/// All pairs whose distance may be below `reach` somewhere on the straight way of the surface between two sets of
/// positions, found by the boxes of both ends. On all threads; the order does not depend on them.
MeshCandidates find_candidates(const TriangleMesh& mesh, const ContactSurface& surface,
                               const Vector& from, const Vector& to, double reach,
                               MeshFeatures features);

}  // namespace tetraction
