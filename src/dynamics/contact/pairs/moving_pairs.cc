#include "moving_pairs.h"

#include <Eigen/Geometry>

#include "additive_ccd.h"
#include "tetraction/core/parallel.h"
#include "tetraction/core/positive_semidefinite.h"

namespace tetraction {
namespace {

constexpr Index kMovingPairGrain = 64;

// of(pair) for all pairs, on all threads.
template <class Part, class Of>
std::vector<Part> parts_of(std::span<const MovingPair> pairs, const Of& of) {
  std::vector<Part> parts(pairs.size());
  parallel_for(static_cast<Index>(parts.size()), kMovingPairGrain, [&](Index begin, Index end) {
    for (auto k = static_cast<std::size_t>(begin); k < static_cast<std::size_t>(end); ++k) {
      parts[k] = of(pairs[k]);
    }
  });
  return parts;
}

void scatter(std::span<const MovingPair> pairs, const std::vector<PairVector>& parts,
             Vector& gradient) {
  for (std::size_t k = 0; k < parts.size(); ++k) {
    int place = 3 * pairs[k].first;
    for (const Index v : pairs[k].own()) {
      vertex_block(gradient, v) += parts[k].segment<3>(place);
      place += 3;
    }
  }
}

// Makes the block of the points that move positive semidefinite.
void make_semidefinite(const MovingPair& pair, PairMatrix& hessian) {
  const int first = 3 * pair.first;
  const int size = 3 * pair.count;
  auto own = hessian.block(first, first, size, size);
  own = positive_semidefinite_part(Matrix(own));
}

// The same for the Hessian of a pair whose edges are not nearly parallel. With the difference v of the closest points and
// their weights w, it acts only on motions of points along v, and on those of all points by w_i along a tangent: these are
// 6 directions at most, from squared_distance_gradient() and squared_distance_hessian().
void make_semidefinite_in_plane(const MovingPair& pair, const PairDistance& distance,
                                PairMatrix& hessian) {
  PairWeights weights = PairWeights::Zero();
  weights.segment(pair.first, pair.count) = distance.weights.segment(pair.first, pair.count);
  const double length = weights.norm();
  const Vector3 normal = distance.difference.normalized();
  const Vector3 tangent = normal.unitOrthogonal();
  Eigen::Matrix<double, 12, 6> basis = Eigen::Matrix<double, 12, 6>::Zero();
  for (int i = pair.first; i < pair.first + pair.count; ++i) {
    basis.block<3, 1>(3 * i, i) = normal;
    if (!(length > 0.0)) continue;
    basis.block<3, 1>(3 * i, 4) = weights[i] / length * tangent;
    basis.block<3, 1>(3 * i, 5) = weights[i] / length * normal.cross(tangent);
  }
  const Eigen::Matrix<double, 6, 6> small = basis.transpose() * hessian * basis;
  hessian.noalias() = basis * positive_semidefinite_part(small) * basis.transpose();
}

// Adds of(pair) for all pairs.
template <class Of>
void add_blocks(std::span<const MovingPair> pairs, const Of& of, SurfaceBlocks& blocks) {
  const auto parts = parts_of<PairMatrix>(pairs, of);
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const std::span<const Index> own = pairs[k].own();
    const PairMatrix& part = parts[k];
    const auto row = [&](std::size_t a) { return 3 * (pairs[k].first + static_cast<int>(a)); };
    const auto block = [&](std::size_t a, std::size_t b) -> Matrix3 {
      return part.block<3, 3>(row(a), row(b));
    };
    for (std::size_t a = 0; a < own.size(); ++a) {
      blocks.add(own[a], block(a, a));
      for (std::size_t b = a + 1; b < own.size(); ++b) blocks.add_pair(own[a], own[b], block(a, b));
    }
  }
}

}  // namespace

bool MovingPair::is_within(double reach, const Vector& from, const Vector& to) const {
  return distance(from) < reach || (&from != &to && distance(to) < reach);
}

double energy_of(std::span<const MovingPair> pairs, const Barrier& barrier, const Vector& x) {
  return parallel_sum(static_cast<Index>(pairs.size()), [&](Index begin, Index end) {
    double sum = 0.0;
    for (auto k = static_cast<std::size_t>(begin); k < static_cast<std::size_t>(end); ++k) {
      sum += pair_energy(barrier, pairs[k].pair, pairs[k].points(x));
    }
    return sum;
  });
}

void add_gradient_of(std::span<const MovingPair> pairs, const Barrier& barrier, const Vector& x,
                     Vector& gradient) {
  scatter(pairs,
          parts_of<PairVector>(pairs,
                               [&](const MovingPair& pair) {
                                 return pair_gradient(barrier, pair.pair, pair.points(x));
                               }),
          gradient);
}

void add_mean_gradient_of(std::span<const MovingPair> pairs, const Barrier& barrier,
                          const Vector& from, const Vector& to, Vector& gradient) {
  scatter(pairs,
          parts_of<PairVector>(
              pairs,
              [&](const MovingPair& pair) {
                return mean_pair(barrier, pair.pair, pair.points(from), pair.points(to)).gradient;
              }),
          gradient);
}

void add_hessian_of(std::span<const MovingPair> pairs, const Barrier& barrier, const Vector& x,
                    bool convex, SurfaceBlocks& blocks) {
  const auto of = [&](const MovingPair& moving) {
    const PairPoints points = moving.points(x);
    PairMatrix hessian = pair_hessian(barrier, moving.pair, points);
    if (!convex) return hessian;
    if (moving.pair.kind == PairKind::kEdgeEdge &&
        parallel_measure(points) < moving.pair.parallel) {
      make_semidefinite(moving, hessian);
    } else {
      make_semidefinite_in_plane(moving, pair_distance(moving.pair.kind, points), hessian);
    }
    return hessian;
  };
  add_blocks(pairs, of, blocks);
}

void add_mean_hessian_of(std::span<const MovingPair> pairs, const Barrier& barrier,
                         const Vector& from, const Vector& to, bool convex, SurfaceBlocks& blocks) {
  const auto of = [&](const MovingPair& moving) {
    PairMatrix hessian =
        mean_pair_hessian(barrier, moving.pair, moving.points(from), moving.points(to));
    if (convex) make_semidefinite(moving, hessian);
    return hessian;
  };
  add_blocks(pairs, of, blocks);
}

std::vector<double> free_parts_of(std::span<const MovingPair> pairs, const Vector& x,
                                  const Vector& d, double cap) {
  return parts_of<double>(pairs, [&](const MovingPair& pair) {
    return first_touch(pair.pair.kind, pair.points(x), pair.moves(d), cap);
  });
}

}  // namespace tetraction
