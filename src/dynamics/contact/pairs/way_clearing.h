// Ways of vertices that are cut where they would touch something.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "core/disjoint_sets.h"
#include "tetraction/core/types.h"

namespace tetraction {

/// Shortens the straight ways of vertices, in rounds, until nothing touches. Vertices that would touch something together
/// go a common part of their ways from then on.
class WayClearing {
 public:
  /// Rounds, after which all vertices go a common part of what is left.
  static constexpr int kRounds = 40;
  /// The part of the way to the first touch that is kept.
  static constexpr double kKept = 0.9;

  /// x: the ends of the ways, 3 per vertex, which change. Both must live longer. A vertex without a finite end stays.
  WayClearing(const Vector& from, Vector& x)
      : from_(from), x_(x), part_(Vector::Ones(x.size() / 3)), sets_(x.size() / 3) {
    for (Index i = 0; i < part_.size(); ++i) {
      if (!vertex_block(x_, i).allFinite()) vertex_block(x_, i) = vertex_block(from_, i);
    }
    whole_ = x_ - from_;
  }

  void begin_round() {
    allowed_.setOnes(part_.size());
    is_clear_ = true;
  }
  /// These vertices touch something after a part t of their present ways, if t < 1.
  void limit(std::span<const Index> vertices, double t) {
    if (t >= 1.0) return;
    is_clear_ = false;
    for (const Index i : vertices) {
      allowed_[i] = std::min(allowed_[i], kKept * t);
      sets_.join(vertices[0], i);
    }
  }
  /// Whether nothing touched in this round.
  bool is_clear() const { return is_clear_; }
  /// Ends a round: each set goes the shortest part of the way that one of its vertices may go.
  void shorten() {
    Index set_count = 0;
    const std::vector<Index> set = sets_.numbers(set_count);
    Vector of_set = Vector::Ones(set_count);
    for (Index i = 0; i < part_.size(); ++i) {
      double& least = of_set[set[static_cast<std::size_t>(i)]];
      least = std::min(least, part_[i] * allowed_[i]);
    }
    for (Index i = 0; i < part_.size(); ++i) {
      part_[i] = of_set[set[static_cast<std::size_t>(i)]];
      if (part_[i] < 1.0) {
        vertex_block(x_, i) = vertex_block(from_, i) + part_[i] * vertex_block(whole_, i);
      }
    }
  }

 private:
  const Vector& from_;
  Vector& x_;
  Vector whole_;    // the ways at the beginning
  Vector part_;     // that is left of them
  Vector allowed_;  // of the present ways
  DisjointSets sets_;
  bool is_clear_ = true;
};

}  // namespace tetraction
