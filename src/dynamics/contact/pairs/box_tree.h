// A tree of boxes that finds the items near a place.
#pragma once

#include <limits>
#include <span>
#include <vector>

#include "tetraction/core/types.h"

namespace tetraction {

/// A box whose sides are parallel to the axes. A new one is empty.
struct Box {
  Vector3 lower = Vector3::Constant(std::numeric_limits<double>::infinity());
  Vector3 upper = Vector3::Constant(-std::numeric_limits<double>::infinity());

  void add(const Vector3& point) {
    lower = lower.cwiseMin(point);
    upper = upper.cwiseMax(point);
  }
  void add(const Box& other) {
    lower = lower.cwiseMin(other.lower);
    upper = upper.cwiseMax(other.upper);
  }
  /// Larger by `by` on each side, and by the round-off of its coordinates.
  Box widened(double by) const {
    constexpr double kRoundOff = 4.0 * std::numeric_limits<double>::epsilon();
    Box box;
    box.lower = lower.array() - by - kRoundOff * lower.array().abs();
    box.upper = upper.array() + by + kRoundOff * upper.array().abs();
    return box;
  }
  /// Whether they have a point in common.
  bool overlaps(const Box& other) const {
    return lower[0] <= other.upper[0] && other.lower[0] <= upper[0] && lower[1] <= other.upper[1] &&
           other.lower[1] <= upper[1] && lower[2] <= other.upper[2] && other.lower[2] <= upper[2];
  }
};

/// Finds the items whose boxes overlap a box. The tree is balanced: its shape depends on the number of items
/// only.
class BoxTree {
 public:
  BoxTree() = default;
  /// The items are numbered as their boxes. O(n log² n).
  explicit BoxTree(std::span<const Box> boxes);

  Index size() const { return static_cast<Index>(items_.size()); }
  /// The box of all items.
  Box bounds() const { return nodes_.empty() ? Box() : nodes_.front(); }
  /// Appends the numbers of all items whose boxes overlap `box`, in ascending order.
  void query(const Box& box, std::vector<Index>& found) const;

 private:
  void sort(std::span<const Box> boxes, Index node, int level);
  void fit(std::span<const Box> boxes);
  Index begin_of_leaf(Index leaf) const { return leaf * size() / leaf_count(); }
  Index leaf_count() const { return Index{1} << levels_; }

  // A complete binary tree: the children of node k are 2k + 1 and 2k + 2, the leaves are the last level.
  int levels_ = 0;
  std::vector<Box> nodes_;
  std::vector<Index> items_;     // in the order of the leaves
  std::vector<Box> item_boxes_;  // in the same order
};

}  // namespace tetraction
