// The potential of a point near a rigid surface of triangles.
#pragma once

#include <span>
#include <vector>

#include "dynamics/contact/mesh/triangle_mesh.h"
#include "tetraction/dynamics/contact/barrier.h"

namespace tetraction {

/// The force of one feature of the surface on the point.
struct FeatureForce {
  Index feature = -1;
  Vector3 normal = Vector3::UnitX();  ///< from the surface to the point, of length 1
  double force = 0.0;                 ///< λ along the normal, per area of the point, Pa
  double stiffness = 0.0;             ///< −∂λ/∂d, Pa/m
};

/// The potential of a point per area, U = Σ c U_b(d) over the triangles, edges and vertices of a mesh with their
/// coefficients. Pairs with the same closest feature are one: their coefficients are added before anything is
/// computed, so that a point over a flat part has exactly U_b of its distance from the plane.
///
/// All functions take the triangles near the point: all those closer than the thickness of the layer, anywhere on
/// the way for functions of a step. Others change nothing. Objects keep memory between calls and are used by one
/// thread at a time.
class PointOnMesh {
 public:
  PointOnMesh(const TriangleMesh& mesh, const Barrier& barrier) : mesh_(mesh), barrier_(barrier) {}

  /// From now on the layer is this one.
  PointOnMesh& with(const Barrier& barrier) {
    barrier_ = barrier;
    return *this;
  }

  /// The distance from the nearest of the triangles; infinite if there is none.
  double distance(std::span<const Index> triangles, const Vector3& x) const;
  double energy(std::span<const Index> triangles, const Vector3& x);
  Vector3 gradient(std::span<const Index> triangles, const Vector3& x);
  Matrix3 hessian(std::span<const Index> triangles, const Vector3& x);
  /// The forces of all features, at x. Those of inner edges at reentrant corners are negative.
  void forces(std::span<const Index> triangles, const Vector3& x,
              std::vector<FeatureForce>& forces);

  /// A mean f̄ of the gradient over the straight way with f̄·(to − from) = ΔU up to round-off. The way is cut
  /// where the closest feature of a triangle or an edge changes. On each part, with the vectors m from a
  /// feature's plane, line or point,
  ///
  ///     f = Σ c (ΔU_b/ΔD)(m_from + m_to),   D = m·m,
  ///
  /// is exact, and f̄ is the sum of f times the share of the part. On a flat part of the surface it has the
  /// direction of the normal, whatever triangles the point slides over.
  Vector3 mean_gradient(std::span<const Index> triangles, const Vector3& from, const Vector3& to);
  /// The symmetric part of ∂f̄/∂(to).
  Matrix3 mean_hessian(std::span<const Index> triangles, const Vector3& from, const Vector3& to);
  /// The forces −f̄ of all features.
  void mean_forces(std::span<const Index> triangles, const Vector3& from, const Vector3& to,
                   std::vector<FeatureForce>& forces);

 private:
  struct Share {
    Index feature;
    double coefficient;
  };
  void collect_features(std::span<const Index> triangles);
  void find_shares(std::span<const Index> triangles, const Vector3& x);
  // The same of the features of these triangles.
  void find_shares_at(std::span<const Index> triangles, const Vector3& x);
  template <class Function>
  void for_each_part(std::span<const Index> triangles, const Vector3& from, const Vector3& to,
                     const Function& function);

  const TriangleMesh& mesh_;
  Barrier barrier_;
  std::vector<Index> edges_;     // of the triangles, with a coefficient
  std::vector<Index> vertices_;  // the same, as features
  std::vector<Share> shares_;
  std::vector<TriangleMesh::Crossing> crossings_;
};

}  // namespace tetraction
