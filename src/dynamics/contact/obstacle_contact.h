// Contact between the surface of a body and an obstacle, in the frame in which the obstacle is at rest.
#pragma once

#include <array>
#include <limits>
#include <vector>

#include "tetraction/core/types.h"
#include "tetraction/dynamics/contact/barrier.h"

namespace tetraction {

/// The part of a body's surface that may touch an obstacle. Its vertices have numbers of their own, from 0.
struct ContactSurface {
  std::vector<Index> vertices;                  ///< their numbers in the mesh, ascending
  std::vector<std::array<Index, 3>> triangles;  ///< outward, numbers of this surface
  std::vector<std::array<Index, 2>> edges;      ///< of the triangles, each once, lower number first
  std::vector<double> areas;  ///< of each vertex: its share of the rest areas, m²
  /// The share of a layer's thickness in which each vertex feels it; empty: the whole of it for all vertices.
  std::vector<double> reaches;
  Vector rest;  ///< rest positions, 3 per vertex, m

  double reach(Index i) const {
    return reaches.empty() ? 1.0 : reaches[static_cast<std::size_t>(i)];
  }
  /// The layer as vertex i feels it.
  Barrier layer(Index i, const Barrier& whole) const {
    return {reach(i) * whole.thickness, whole.stiffness};
  }
};

/// A sum of symmetric 3 × 3 blocks over the vertices of a surface.
class SurfaceBlocks {
 public:
  virtual ~SurfaceBlocks() = default;
  /// The block of vertex i with itself.
  virtual void add(Index i, const Matrix3& block) = 0;
  /// The block in the rows of vertex i and the columns of vertex j, and its transpose at (j, i).
  virtual void add_pair(Index i, Index j, const Matrix3& block) = 0;
};

/// A place of contact. Where the surface touches an obstacle it is the point Σ w_i x_i of some vertices, with Σ w_i = 1.
/// Where it touches itself, Σ w_i x_i is the difference of a point on the first side and one on the second side, and
/// Σ w_i = 0. In both cases the sides slip with the tangential part of
///
///     u = Σ (w_i + L_i) v_i,
///
/// and a force F on the first side in the direction of slip means the forces (w_i + L_i)ᵀ F on the vertices. The L_i take
/// from the velocity what comes from the rotation of both sides together (face_rotation()); they are zero for obstacles.
struct ContactPoint {
  static constexpr int kMost = 5;                 ///< vertices
  int count = 0;                                  ///< number of vertices
  std::array<Index, kMost> vertices{};            ///< numbers of the surface
  std::array<double, kMost> weights{};            ///< w_i
  bool has_turns = false;                         ///< whether any L_i is not zero
  std::array<Matrix3, kMost> turns = no_turns();  ///< L_i, if there are any
  Vector3 normal =
      Vector3::UnitX();    ///< of the obstacle or the second side, towards the first; length 1
  double force = 0.0;      ///< λ ≥ 0 along the normal, N
  double stiffness = 0.0;  ///< −∂λ/∂d ≥ 0 with the distance d, N/m

  static std::array<Matrix3, kMost> no_turns() {
    std::array<Matrix3, kMost> zero;
    zero.fill(Matrix3::Zero());
    return zero;
  }
  /// Σ (w_i + L_i) v_i, where vector_of(i) is that of the vertex i.
  template <class VectorOf>
  Vector3 slip(const VectorOf& vector_of) const {
    Vector3 sum = Vector3::Zero();
    for (std::size_t k = 0; k < static_cast<std::size_t>(count); ++k) {
      const Vector3 v = vector_of(vertices.at(k));
      sum += weights.at(k) * v;
      if (has_turns) sum += turns.at(k) * v;
    }
    return sum;
  }
  /// (w_k + L_k)ᵀ F: the part of a force F that the vertex in place k gets.
  Vector3 part(std::size_t k, const Vector3& total) const {
    Vector3 own = weights.at(k) * total;
    if (has_turns) own += turns.at(k).transpose() * total;
    return own;
  }
  /// (w_j + L_j)ᵀ B (w_k + L_k).
  Matrix3 block(std::size_t j, std::size_t k, const Matrix3& b) const {
    if (!has_turns) return weights.at(j) * weights.at(k) * b;
    const Matrix3 unit = Matrix3::Identity();
    return (weights.at(j) * unit + turns.at(j)).transpose() * b *
           (weights.at(k) * unit + turns.at(k));
  }
};

/// The place where one vertex touches an obstacle.
inline ContactPoint place_of_vertex(Index vertex, const Vector3& normal, double force,
                                    double stiffness) {
  ContactPoint place;
  place.count = 1;
  place.vertices[0] = vertex;
  place.weights[0] = 1.0;
  place.normal = normal;
  place.force = force;
  place.stiffness = stiffness;
  return place;
}

/// A vertex of a pair of surface and obstacle that is near the obstacle.
struct Approach {
  Index vertex = 0;       ///< number of the surface
  double weight = 0.0;    ///< area of the pair, m²
  double distance = 0.0;  ///< of the pair, m
  double speed = 0.0;     ///< at which the vertex comes nearer, m/s; negative where it goes away
  double reach = 1.0;     ///< share of the layer's thickness in which the pair feels it
  /// The area on which the layer stops the vertex, m²; 0 if it is `weight`. Of a pair that has only a small share of
  /// the area, the others near it stop the vertex.
  double carrying = 0.0;
};

/// Contact of a surface with a rigid obstacle at rest. Positions have 3 numbers for each vertex of the
/// surface, m.
///
/// The potential is U(x) = Σ w U_b(d) over pairs of the surface and the obstacle, with Barrier U_b. It
/// is finite where the two do not intersect.
class ObstacleContact {
 public:
  virtual ~ObstacleContact() = default;

  /// Whether add_hessian() has blocks of two different vertices.
  virtual bool couples_vertices() const = 0;

  /// U, J; infinite if the surface penetrates the obstacle.
  virtual double energy(const Vector& x) const = 0;
  /// gradient += ∂U/∂x, N. x must not penetrate, as in all functions below.
  virtual void add_gradient(const Vector& x, Vector& gradient) const = 0;
  /// blocks += ∂²U/∂x², N/m; with `convex` a positive semidefinite matrix near it.
  virtual void add_hessian(const Vector& x, bool convex, SurfaceBlocks& blocks) const = 0;

  /// gradient += a mean f̄ of ∂U/∂x over the way from `from` to `to`, with
  /// f̄·(to − from) = U(to) − U(from) up to round-off.
  virtual void add_discrete_gradient(const Vector& from, const Vector& to,
                                     Vector& gradient) const = 0;
  /// blocks += the symmetric part of ∂f̄/∂(to), or an approximation of it, N/m.
  virtual void add_discrete_hessian(const Vector& from, const Vector& to, bool convex,
                                    SurfaceBlocks& blocks) const = 0;

  /// The first vertex of the surface that penetrates the obstacle, or that belongs to a face or an edge
  /// which does; −1 if nothing penetrates.
  virtual Index penetrating_vertex(const Vector& x) const = 0;
  /// The largest t ≤ 1 such that nothing penetrates on the whole straight way from x to x + t d. The
  /// distances at x + t d may be as small as a hundredth of those at x.
  virtual double longest_step(const Vector& x, const Vector& d) const = 0;
  /// Moves vertices of `x` so that nothing penetrates on the straight way from `from` to x, changing as
  /// little as possible. `from` does not penetrate.
  virtual void clear_way(const Vector& from, Vector& x) const = 0;

  /// blocks += a stiffness, N/m, in the directions in which the obstacle supports the vertices of the surface that
  /// are nearer to it than `reach`, m. It tells which motions are free. `reach` is the thickness of the layer, or
  /// infinite.
  virtual void add_support(const Vector& x, double reach, SurfaceBlocks& blocks) const = 0;

  /// The smallest distance between surface and obstacle if it is below the thickness of the layer, m;
  /// otherwise infinity.
  virtual double smallest_gap(const Vector& x) const = 0;
  /// gaps ← the distance of every vertex of the surface to the obstacle where it is below the thickness,
  /// and infinity elsewhere, m.
  virtual void vertex_gaps(const Vector& x, Vector& gaps) const = 0;

  /// The places of contact with forces −∂U/∂x, for friction. Pairs with the same closest place are one.
  virtual void contact_points(const Vector& x, std::vector<ContactPoint>& points) const = 0;
  /// The same with the mean forces f̄ over the way from `from` to `to`.
  virtual void mean_contact_points(const Vector& from, const Vector& to,
                                   std::vector<ContactPoint>& points) const = 0;

  /// Appends what is nearer to the obstacle than `reach`, m, with the velocities v of the vertices, m/s. Explicit
  /// steps take their limit from it.
  virtual void approaching(const Vector& x, const Vector& v, double reach,
                           std::vector<Approach>& found) const = 0;
};

}  // namespace tetraction
