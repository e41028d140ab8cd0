// Scenes in which bodies touch each other, and a test of intersections that shares nothing with the library's own.
#pragma once

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "support/obstacles.h"
#include "support/runs.h"
#include "tetraction/mesh/mesh_copies.h"
#include "tetraction/mesh/tet_mesh.h"

namespace tetraction::testing_support {

/// The mesh of a scene with mesh.copies.
inline TetMesh mesh_of_bodies(const Scene& scene) {
  std::vector<MeshPlace> places;
  for (const MeshCopySettings& copy : scene.mesh.copies) places.push_back({copy.at, copy.turn});
  return with_copies(generate_mesh(*scene.mesh.generate), places);
}

/// Cubes of 0.2 m which collide obliquely and spin, in empty space. `unit` scales all lengths.
inline Scene colliding_cubes(Integrator rule, double step, double end, double unit = 1.0) {
  const double edge = 0.2 * unit;
  Scene scene = scene_of({GeneratorKind::kBox, {edge, edge, edge}, {2, 2, 2}}, elastic(5e4, 0.3));
  scene.time = {rule, step, false, end};
  scene.initial.velocity = {1.0, 0.1, 0.0};
  scene.initial.angular_velocity = Vector3(1.0, 0.5, 3.0) / unit;
  MeshCopySettings other;
  other.at = Vector3(0.26, 0.07, 0.04) * unit;
  other.turn = {10.0, 25.0, 15.0};
  other.velocity = {-1.0, -0.2, 0.1};
  other.angular_velocity = Vector3(-2.0, 1.0, 2.0) / unit;
  scene.mesh.copies = {other};
  scene.contact.between = ContactBetween::kBodies;
  return scene;
}

/// Whether a segment crosses a triangle in an inner point (Möller and Trumbore 1997).
inline bool segment_hits(const Vector3& a, const Vector3& b, const std::array<Vector3, 3>& t) {
  const Vector3 way = b - a;
  const Vector3 u = t[1] - t[0];
  const Vector3 v = t[2] - t[0];
  const Vector3 p = way.cross(v);
  const double det = u.dot(p);
  // An edge in the plane of a triangle of the same rigid body.
  if (std::abs(det) <= 1e-12 * way.norm() * u.norm() * v.norm()) return false;
  const Vector3 s = a - t[0];
  const double x = s.dot(p) / det;
  const Vector3 q = s.cross(u);
  const double y = way.dot(q) / det;
  const double along = v.dot(q) / det;
  return x >= 0.0 && y >= 0.0 && x + y <= 1.0 && along >= 0.0 && along <= 1.0;
}

/// Number of edges of the surface that cross one of its triangles without a common vertex, and of vertices that are
/// inside a tetrahedron which is not theirs, at positions x of a linear mesh. It compares all with all.
inline int count_intersections(const TetMesh& mesh, const Vector& x) {
  int count = 0;
  const auto at = [&](Index v) { return Vector3(vertex_block(x, v)); };
  const auto faces = boundary_faces(mesh);
  std::set<std::array<Index, 2>> edges;
  std::set<Index> vertices;
  for (const auto& face : faces) {
    for (std::size_t k = 0; k < 3; ++k) {
      edges.insert({std::min(face[k], face[(k + 1) % 3]), std::max(face[k], face[(k + 1) % 3])});
      vertices.insert(face[k]);
    }
  }
  for (const auto& face : faces) {
    const std::array<Vector3, 3> t{at(face[0]), at(face[1]), at(face[2])};
    const Vector3 low = t[0].cwiseMin(t[1]).cwiseMin(t[2]);
    const Vector3 high = t[0].cwiseMax(t[1]).cwiseMax(t[2]);
    for (const auto& [i, j] : edges) {
      if (std::ranges::count(face, i) + std::ranges::count(face, j) > 0) continue;
      const Vector3 a = at(i);
      const Vector3 b = at(j);
      if ((a.cwiseMax(b).array() < low.array()).any()) continue;
      if ((a.cwiseMin(b).array() > high.array()).any()) continue;
      count += segment_hits(a, b, t) ? 1 : 0;
    }
  }
  for (Index e = 0; e < mesh.tetrahedron_count(); ++e) {
    const auto& tet = mesh.tetrahedra[static_cast<std::size_t>(e)];
    const Vector3 origin = at(tet[0]);
    Matrix3 shape;
    for (int k = 0; k < 3; ++k) shape.col(k) = at(tet[static_cast<std::size_t>(k) + 1]) - origin;
    const Matrix3 inverse = shape.inverse();
    for (const Index v : vertices) {
      if (std::ranges::count(tet, v) > 0) continue;
      const Vector3 weights = inverse * (at(v) - origin);
      count += weights.minCoeff() > 0.0 && weights.sum() < 1.0 ? 1 : 0;
    }
  }
  return count;
}

/// Makes all steps of a run, and expects that nothing intersects at the end of any. Returns the smallest gap.
inline double run_apart(Session& session) {
  double least = present_gap(session);
  while (session.step()) {
    const double gap = present_gap(session);
    EXPECT_GT(gap, 0.0) << "step " << session.step_number();
    EXPECT_EQ(count_intersections(session.system().mesh(), session.present_state().position), 0)
        << "step " << session.step_number();
    least = std::min(least, gap);
  }
  EXPECT_EQ(session.status(), RunStatus::kFinished) << session.message();
  return least;
}

}  // namespace tetraction::testing_support
