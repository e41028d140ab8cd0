// Contact of a surface with a rigid surface of triangles.
#pragma once

#include <vector>

#include "dynamics/contact/mesh/mesh_candidates.h"
#include "dynamics/contact/mesh/point_on_mesh.h"
#include "dynamics/contact/mesh/triangle_mesh.h"
#include "dynamics/contact/obstacle_contact.h"
#include "dynamics/contact/pairs/moving_pairs.h"

namespace tetraction {

/// The potential has three sums:
///
/// - the vertices of the surface, with their areas, against the mesh (PointOnMesh): in front of a flat part of the
///   mesh each has exactly its area times U_b of its distance,
/// - vertices of the mesh against triangles of the surface, and
/// - edges of the surface against edges of the mesh, with the mollifier of pair_potential.h.
///
/// The last two keep corners and edges of the mesh out of the surface between its vertices. Their weight is
/// 0.05 of the mean area of the vertices of the surface's triangle or edge. Edges and vertices inside flat parts
/// of the mesh take no part in them: a body cannot reach one before its own vertices or an edge of the flat part
/// stop it. On a flat part the pressure κ|β′| is therefore exact.
///
/// Something penetrates where an edge of the surface crosses a triangle of the mesh, an edge of the mesh crosses a
/// triangle of the surface, or two features touch. Both sides of the mesh act: a watertight mesh is a solid for
/// bodies outside and a container for those inside.
class MeshContact final : public ObstacleContact {
 public:
  MeshContact(TriangleMesh mesh, ContactSurface surface, const Barrier& barrier);

  const TriangleMesh& mesh() const { return mesh_; }

  bool couples_vertices() const override { return true; }
  double energy(const Vector& x) const override;
  void add_gradient(const Vector& x, Vector& gradient) const override;
  void add_hessian(const Vector& x, bool convex, SurfaceBlocks& blocks) const override;
  void add_discrete_gradient(const Vector& from, const Vector& to, Vector& gradient) const override;
  void add_discrete_hessian(const Vector& from, const Vector& to, bool convex,
                            SurfaceBlocks& blocks) const override;
  Index penetrating_vertex(const Vector& x) const override;
  double longest_step(const Vector& x, const Vector& d) const override;
  void clear_way(const Vector& from, Vector& x) const override;
  void add_support(const Vector& x, double reach, SurfaceBlocks& blocks) const override;
  double smallest_gap(const Vector& x) const override;
  void vertex_gaps(const Vector& x, Vector& gaps) const override;
  void contact_points(const Vector& x, std::vector<ContactPoint>& points) const override;
  void mean_contact_points(const Vector& from, const Vector& to,
                           std::vector<ContactPoint>& points) const override;
  void approaching(const Vector& x, const Vector& v, double reach,
                   std::vector<Approach>& found) const override;

 private:
  // A way and the pairs near it; the last one is kept.
  struct Way {
    Vector from;
    Vector to;
    MeshCandidates near;
    std::vector<MovingPair> pairs;
    bool checked = false;  // whether `penetrating` is known
    Index penetrating = -1;
  };

  // As vertex i feels it.
  Barrier layer(Index i) const { return surface_.layer(i, barrier_); }
  MovingPair vertex_face(Index vertex, Index triangle) const;
  MovingPair edge_edge(Index edge, Index other) const;
  // Of single positions: from == to.
  const Way& state(const Vector& x) const;
  const Way& way(const Vector& from, const Vector& to) const;
  void prepare(Way& way, const Vector& from, const Vector& to) const;
  Index find_penetrating_vertex(const Vector& x) const;
  std::vector<double> free_parts(const MeshCandidates& near, const Vector& x,
                                 const Vector& d) const;

  template <class Slope>
  void add_vertex_gradients(const Way& way, const Slope& slope, Vector& gradient) const;
  template <class Hessian>
  void add_vertex_blocks(const Way& way, bool convex, const Hessian& hessian,
                         SurfaceBlocks& blocks) const;

  TriangleMesh mesh_;
  ContactSurface surface_;
  Barrier barrier_;
  double mean_area_ = 0.0;
  mutable Way state_;
  mutable Way way_;
};

}  // namespace tetraction
