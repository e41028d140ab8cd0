// Contact of a deformed surface with itself: of bodies with each other, or of a body with itself.
#pragma once

#include <array>
#include <span>
#include <utility>
#include <vector>

#include "dynamics/contact/near_features.h"
#include "dynamics/contact/obstacle_contact.h"
#include "dynamics/contact/pairs/moving_pairs.h"

namespace tetraction {

/// The potential of Li et al. (2023) over vertices x, triangles t, edges e and vertices v of one surface,
///
///     U = ½ Σ_x w_x [Σ_t U_b(d(x,t)) + Σ_e c_e U_b(d(x,e)) + Σ_v c_v U_b(d(x,v))] + Σ c_ef w_ef U_b(d(e,f)) e(c),
///
/// with the areas w_x of the vertices. c_e = 1 − (number of triangles at the edge) and c_v = 1 − (number of
/// triangles at the vertex) − Σ c_e cancel what several triangles count twice, so that flat faces transmit −U_b′
/// exactly. Pairs of edges, with the mollifier of pair_potential.h, keep edges from passing through each other; w_ef is
/// the mean area of the four vertices. c_ef = 0.01, because no weight is right for all pairs of meshes of flat faces, and
/// 0.5 for two edges that are sharp at rest, which meet in a single place. Features that share a vertex are no pairs.
///
/// Pairs of a vertex with the same closest feature are one. Forces over a step are the discrete gradients of single
/// pairs (mean_pair()), which keep the energy and both momenta of all bodies.
///
/// Something penetrates where an edge crosses a triangle, or where two features touch.
class SelfContact final : public ObstacleContact {
 public:
  /// `body_of` has the number of the body of each vertex. Only features of different bodies are pairs, unless
  /// `within_bodies`.
  SelfContact(ContactSurface surface, std::vector<Index> body_of, bool within_bodies,
              const Barrier& barrier);

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
  /// Springs between features that face each other, and are nearer than `reach` and ten times the thickness: nothing next
  /// to their closest points is nearer on either side, or one of them is a face and the other one a vertex before it.
  void add_support(const Vector& x, double reach, SurfaceBlocks& blocks) const override;
  double smallest_gap(const Vector& x) const override;
  void vertex_gaps(const Vector& x, Vector& gaps) const override;
  void contact_points(const Vector& x, std::vector<ContactPoint>& points) const override;
  void mean_contact_points(const Vector& from, const Vector& to,
                           std::vector<ContactPoint>& points) const override;
  void approaching(const Vector& x, const Vector& v, double reach,
                   std::vector<Approach>& found) const override;

 private:
  // Triangles, their sides and vertices are numbered together, in this order.
  struct Triangle {
    std::array<Index, 3> corners;  // ascending
    std::array<Index, 3> sides;    // the numbers of those opposite to them
  };
  // A way and the pairs near it; the last one is kept.
  struct Way {
    Vector from;
    Vector to;
    std::vector<MovingPair> pairs;
    bool checked = false;  // whether `penetrating` is known
    Index penetrating = -1;
  };

  void find_sharp_edges();
  void number_features();
  void find_carrying_areas();
  MovingPair vertex_face(Index vertex, Index triangle) const;
  MovingPair edge_edge(Index edge, Index other) const;
  std::vector<MovingPair> pairs_of(const NearFeatures::Found& near) const;
  MovingPair vertex_feature(Index vertex, Index feature, double coefficient) const;
  Index closest_feature(Index feature, const PairDistance& distance) const;
  void add_pairs_of(Index vertex, std::span<const std::array<Index, 2>> faces, const Vector& from,
                    const Vector& to, std::vector<MovingPair>& pairs) const;
  const Way& state(const Vector& x) const;
  const Way& way(const Vector& from, const Vector& to) const;
  void prepare(Way& way, const Vector& from, const Vector& to) const;
  // The surface around the closest place of a side of a pair, seen from the other side in this direction.
  struct SideShape {
    bool is_nearest = true;  // nothing next to it is nearer to the other side
    bool is_face = false;    // it is on a face across the direction
  };
  SideShape shape_of(std::span<const Index> side, const Vector& x, const Vector3& closest,
                     const Vector3& direction) const;
  bool supports(const MovingPair& moving, const PairDistance& distance, const Vector& x) const;
  Index find_penetrating_vertex(const Vector& x) const;
  std::vector<MovingPair> pairs_on_way(const Vector& from, const Vector& to) const;
  const std::array<Index, 3>& face_of(Index vertex, Index other) const;
  ContactPoint place_of(const MovingPair& pair, const PairWeights& weights,
                        const Vector3& difference, const Vector& x) const;
  template <class ForceOf>
  void append_places(const std::vector<MovingPair>& pairs, const Vector& x, const ForceOf& force_of,
                     std::vector<ContactPoint>& points) const;

  void add_approach(const MovingPair& moving, bool are_sharp_edges, const Vector& x,
                    const Vector& v, double reach, std::vector<Approach>& found) const;

  ContactSurface surface_;
  std::vector<double> carrying_areas_;  // of each vertex, see Approach
  Barrier barrier_;
  NearFeatures near_;
  std::vector<std::array<Index, 2>> sides_;  // of the triangles, each once
  std::vector<Triangle> features_of_;        // of each triangle
  // An edge, or a vertex twice, and each of the triangles that have it; sorted.
  std::vector<std::pair<std::array<Index, 2>, Index>> face_of_;
  std::vector<bool> is_sharp_;  // of each edge, at rest
  double longest_part_ = 0.0;   // of a way that is looked at as a whole, m
  mutable Way state_;
  mutable Way way_;
};

}  // namespace tetraction
