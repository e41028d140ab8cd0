// Vertices of groups in the middles of edges.
#pragma once

#include "tetraction/mesh/edge_vertices.h"
#include "tetraction/mesh/tet_mesh.h"

namespace tetraction {

/// Adds to the vertices of a group those in the middles of the edges of its tetrahedra, triangles or lines.
/// `edges` are those of the mesh.
void add_middles(const TetMesh& mesh, const EdgeVertices& edges, Group& group);

}  // namespace tetraction
