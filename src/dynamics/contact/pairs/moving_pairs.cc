#include "moving_pairs.h"

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

// Adds of(pair) for all pairs.
template <class Of>
void add_blocks(std::span<const MovingPair> pairs, bool convex, const Of& of,
                SurfaceBlocks& blocks) {
  const auto parts = parts_of<PairMatrix>(pairs, [&](const MovingPair& pair) {
    PairMatrix part = of(pair);
    if (!convex) return part;
    const int first = 3 * pair.first;
    const int size = 3 * pair.count;
    auto own = part.block(first, first, size, size);
    own = positive_semidefinite_part(Matrix(own));
    return part;
  });
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
  return distance(from) < reach || distance(to) < reach;
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
  add_blocks(
      pairs, convex,
      [&](const MovingPair& pair) { return pair_hessian(barrier, pair.pair, pair.points(x)); },
      blocks);
}

void add_mean_hessian_of(std::span<const MovingPair> pairs, const Barrier& barrier,
                         const Vector& from, const Vector& to, bool convex, SurfaceBlocks& blocks) {
  add_blocks(
      pairs, convex,
      [&](const MovingPair& pair) {
        return mean_pair_hessian(barrier, pair.pair, pair.points(from), pair.points(to));
      },
      blocks);
}

std::vector<double> free_parts_of(std::span<const MovingPair> pairs, const Vector& x,
                                  const Vector& d, double cap) {
  return parts_of<double>(pairs, [&](const MovingPair& pair) {
    return first_touch(pair.pair.kind, pair.points(x), pair.moves(d), cap);
  });
}

}  // namespace tetraction
