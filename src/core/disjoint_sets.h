// Sets of numbered items that are joined.
#pragma once

#include <numeric>
#include <vector>

#include "tetraction/core/types.h"

namespace tetraction {

/// Items 0 to n − 1, each in a set of its own at first (union–find with halved paths).
class DisjointSets {
 public:
  explicit DisjointSets(Index count) : parent_(static_cast<std::size_t>(count)) {
    std::iota(parent_.begin(), parent_.end(), Index{0});
  }

  /// Makes one set of those of two items.
  void join(Index a, Index b) { at(root(a)) = root(b); }

  /// For each item the number of its set, in the order of the sets' first items. `count` ← the number of sets.
  std::vector<Index> numbers(Index& count) {
    std::vector<Index> of_root(parent_.size(), -1);
    std::vector<Index> numbers(parent_.size());
    count = 0;
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      Index& number = of_root[static_cast<std::size_t>(root(static_cast<Index>(i)))];
      if (number < 0) number = count++;
      numbers[i] = number;
    }
    return numbers;
  }

 private:
  Index& at(Index i) { return parent_[static_cast<std::size_t>(i)]; }
  Index root(Index i) {
    while (at(i) != i) {
      at(i) = at(at(i));
      i = at(i);
    }
    return i;
  }

  std::vector<Index> parent_;
};

}  // namespace tetraction
