// Contact of a deformed surface with itself: of bodies with each other, or of a body with itself.
#pragma once

#include <array>
#include <vector>

#include "dynamics/contact/box_tree.h"
#include "dynamics/contact/obstacle_contact.h"
#include "dynamics/contact/pair_potential.h"

namespace tetraction {

/// The potential of Li et al. (2023) over vertices x, triangles t, edges e and vertices v of one surface,
///
///     U = ½ Σ_x w_x [Σ_t U_b(d(x,t)) + Σ_e c_e U_b(d(x,e)) + Σ_v c_v U_b(d(x,v))] + 0.01 Σ w_ef U_b(d(e,f)) e(c),
///
/// with the areas w_x of the vertices. c_e = 1 − (number of triangles at the edge) and c_v = 1 − (number of
/// triangles at the vertex) − Σ c_e cancel what several triangles count twice, so that flat faces transmit −U_b′
/// exactly. Pairs of edges, with the mollifier of pair_potential.h, keep edges from passing through each other; w_ef is
/// the mean area of the four vertices. Features that share a vertex are no pairs.
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
  /// Springs between features that are nearer to each other than `reach` and ten times the thickness.
  void add_support(const Vector& x, double reach, SurfaceBlocks& blocks) const override;
  double smallest_gap(const Vector& x) const override;
  void vertex_gaps(const Vector& x, Vector& gaps) const override;
  void contact_points(const Vector& x, std::vector<ContactPoint>& points) const override;
  void mean_contact_points(const Vector& from, const Vector& to,
                           std::vector<ContactPoint>& points) const override;
  void approaching(const Vector& x, const Vector& v, double reach,
                   std::vector<Approach>& found) const override;

 private:
  struct Pair {
    ContactPair pair;
    std::array<Index, 4> vertices{};
    int size() const { return pair_size(pair.kind); }
    PairPoints points(const Vector& x) const;
  };
  // Numbers of a vertex and a triangle, or of two edges.
  using Candidates = std::vector<std::array<Index, 2>>;
  struct Near {
    Candidates vertex_faces;  // in the order of the vertices
    Candidates edge_edges;
  };
  // A way and the pairs near it; the last one is kept.
  struct Way {
    Vector from;
    Vector to;
    std::vector<Pair> pairs;
    bool checked = false;  // whether `penetrating` is known
    Index penetrating = -1;
  };

  bool may_touch(Index a, Index b) const;
  void refit(const Vector& from, const Vector& to) const;
  Near find_near(const Vector& from, const Vector& to, double reach) const;
  Pair vertex_face(Index vertex, Index triangle) const;
  Pair edge_edge(Index edge, Index other) const;
  void add_pairs_of(Index vertex, const std::array<Index, 2>* faces, std::size_t count,
                    const Vector& from, const Vector& to, std::vector<Pair>& pairs) const;
  const Way& state(const Vector& x) const;
  const Way& way(const Vector& from, const Vector& to) const;
  void prepare(Way& way, const Vector& from, const Vector& to) const;
  Index find_penetrating_vertex(const Vector& x) const;
  std::vector<Pair> pairs_on_way(const Vector& from, const Vector& to) const;
  // first_touch() of each pair on the way from x to x + d.
  std::vector<double> free_parts(const std::vector<Pair>& pairs, const Vector& x,
                                 const Vector& d) const;
  void add_blocks(const Way& way, bool convex, std::vector<PairMatrix>& parts,
                  SurfaceBlocks& blocks) const;

  ContactSurface surface_;
  std::vector<Index> body_of_;
  bool within_bodies_;
  Barrier barrier_;
  mutable BoxTree triangles_, edges_;
  mutable Way state_;
  mutable Way way_;
};

}  // namespace tetraction
