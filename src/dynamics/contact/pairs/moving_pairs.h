// Contact pairs with points that move with a surface.
#pragma once

#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "dynamics/contact/obstacle_contact.h"
#include "dynamics/contact/pairs/pair_potential.h"
#include "tetraction/core/parallel.h"

namespace tetraction {

/// A pair some of whose points, one after another, are vertices of a surface. The others are at rest.
struct MovingPair {
  ContactPair pair;
  std::array<Index, 4> vertices{};  ///< of the surface
  int count = 0;                    ///< of them
  int first = 0;                    ///< the place of the first of them among the points of the pair
  Index partner = -1;  ///< the item of an obstacle that has the other points, if it matters
  PairPoints at_rest = PairPoints::Zero();  ///< the other points, m

  /// The points where the surface has these positions.
  PairPoints points(const Vector& x) const { return with_vertices(at_rest, x); }
  /// Their velocities or displacements, where the surface has these: those at rest have none.
  PairPoints moves(const Vector& d) const { return with_vertices(PairPoints::Zero(), d); }
  /// The vertices that there are.
  std::span<const Index> own() const { return {vertices.data(), static_cast<std::size_t>(count)}; }
  /// The distance of the two sides, m.
  double distance(const Vector& x) const {
    return std::sqrt(pair_distance(pair.kind, points(x)).squared);
  }
  /// Whether the two sides are nearer to each other than `reach`, m, at one of two positions.
  bool is_within(double reach, const Vector& from, const Vector& to) const;

 private:
  PairPoints with_vertices(PairPoints p, const Vector& x) const {
    for (int k = 0; k < count; ++k) {
      p.col(first + k) = vertex_block(x, vertices[static_cast<std::size_t>(k)]);
    }
    return p;
  }
};

/// Those of the pairs of(0), …, of(count − 1) that are within reach (is_within()), in this order. On all threads.
template <class Of>
std::vector<MovingPair> pairs_within(double reach, const Vector& from, const Vector& to,
                                     std::size_t count, const Of& of) {
  std::vector<MovingPair> pairs(count);
  std::vector<char> is_near(count);
  parallel_for(static_cast<Index>(count), 64, [&](Index begin, Index end) {
    for (auto k = static_cast<std::size_t>(begin); k < static_cast<std::size_t>(end); ++k) {
      pairs[k] = of(k);
      is_near[k] = pairs[k].is_within(reach, from, to);
    }
  });
  std::size_t kept = 0;
  for (std::size_t k = 0; k < count; ++k) {
    if (is_near[k] != 0) pairs[kept++] = pairs[k];
  }
  pairs.resize(kept);
  return pairs;
}

/// Sums over pairs, on all threads, with the same bits for any number of them. x, from, to: positions of the surface,
/// 3 per vertex, m.
///
/// Σ U, J.
double energy_of(std::span<const MovingPair> pairs, const Barrier& barrier, const Vector& x);
/// gradient += ∂U/∂x, N.
void add_gradient_of(std::span<const MovingPair> pairs, const Barrier& barrier, const Vector& x,
                     Vector& gradient);
/// gradient += the discrete gradients (mean_pair()).
void add_mean_gradient_of(std::span<const MovingPair> pairs, const Barrier& barrier,
                          const Vector& from, const Vector& to, Vector& gradient);
/// blocks += ∂²U/∂x², N/m; with `convex` each pair's made positive semidefinite.
void add_hessian_of(std::span<const MovingPair> pairs, const Barrier& barrier, const Vector& x,
                    bool convex, SurfaceBlocks& blocks);
/// The same with mean_pair_hessian().
void add_mean_hessian_of(std::span<const MovingPair> pairs, const Barrier& barrier,
                         const Vector& from, const Vector& to, bool convex, SurfaceBlocks& blocks);
/// A part of the way from x to x + d for each pair, on which its sides do not touch (first_touch()). `cap`, m.
std::vector<double> free_parts_of(std::span<const MovingPair> pairs, const Vector& x,
                                  const Vector& d, double cap);

}  // namespace tetraction
