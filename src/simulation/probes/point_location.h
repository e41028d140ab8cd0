// Finds the tetrahedron that contains a point.
#pragma once

#include <array>
#include <vector>

#include "tetraction/mesh/tet_mesh.h"

namespace tetraction {

/// A point of a mesh: its tetrahedron, and its barycentric coordinates there. The point is Σ N_a X_a with
/// the shape functions N_a of the nodes X_a (shape_functions()).
struct PointInMesh {
  Index tetrahedron = -1;
  std::array<double, 4> weights{};
};

/// The shape functions of a tetrahedron with 4 or 10 nodes at barycentric coordinates.
std::vector<double> shape_functions(const std::array<double, 4>& weights, std::size_t nodes);

/// Finds the tetrahedron that contains the point in the rest configuration. If several contain it,
/// as on a common face, the one in whose inside it is deepest, and among equals (within round-off) the one
/// with the lowest tetrahedron_id(). Throws InputError if the point is not finite or not in the body. The
/// message has the distance from the nearest tetrahedron. Of a mesh in parts, the part that has this
/// tetrahedron finds it, and the others return tetrahedron −1; collective.
PointInMesh locate(const TetMesh& mesh, const Vector3& point);

/// All tetrahedra that contain the point, if it is deep in none: those with a common vertex, edge or
/// face. Throws InputError as locate(). Of a mesh in parts, those of the part; collective.
std::vector<PointInMesh> locate_all(const TetMesh& mesh, const Vector3& point);

/// Distance of a point from a triangle, m (Ericson 2005, Real-Time Collision Detection, 5.1.5).
double distance_to_triangle(const Vector3& point, const Vector3& a, const Vector3& b,
                            const Vector3& c);

}  // namespace tetraction
