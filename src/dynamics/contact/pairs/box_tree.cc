#include "box_tree.h"

#include <algorithm>
#include <array>
#include <numeric>

#include "tetraction/core/parallel.h"

namespace tetraction {
namespace {

constexpr Index kItemsOfLeaf = 4;
constexpr Index kLeafGrain = 512;

std::size_t item_at(Index i) {
  return static_cast<std::size_t>(i);
}

}  // namespace

BoxTree::BoxTree(std::span<const Box> boxes) : items_(boxes.size()) {
  if (boxes.empty()) return;
  std::iota(items_.begin(), items_.end(), Index{0});
  while (leaf_count() * kItemsOfLeaf < size()) ++levels_;
  nodes_.resize(item_at(2 * leaf_count() - 1));
  sort(boxes, 0, 0);
  item_boxes_.resize(boxes.size());
  fit(boxes);
}

// Sorts the items of a node's leaves so that those of its first child have the smaller centres along the
// longest side of the box of all centres.
void BoxTree::sort(std::span<const Box> boxes, Index node, int level) {
  if (level == levels_) return;
  const Index first = (node + 1 - (Index{1} << level)) << (levels_ - level);
  const Index leaves = Index{1} << (levels_ - level);
  const auto begin = items_.begin() + begin_of_leaf(first);
  const auto middle = items_.begin() + begin_of_leaf(first + leaves / 2);
  const auto end = items_.begin() + begin_of_leaf(first + leaves);
  const auto centre = [&](Index i) {
    return Vector3(boxes[item_at(i)].lower + boxes[item_at(i)].upper);
  };
  Box centres;
  for (auto item = begin; item != end; ++item) centres.add(centre(*item));
  Index axis = 0;
  (centres.upper - centres.lower).maxCoeff(&axis);
  std::nth_element(begin, middle, end, [&](Index i, Index j) {
    const double a = centre(i)[axis];
    const double b = centre(j)[axis];
    return a < b || (a == b && i < j);
  });
  sort(boxes, 2 * node + 1, level + 1);
  sort(boxes, 2 * node + 2, level + 1);
}

// The boxes of the nodes, on all threads.
void BoxTree::fit(std::span<const Box> boxes) {
  const Index inner = leaf_count() - 1;
  parallel_for(leaf_count(), kLeafGrain, [&](Index begin, Index end) {
    for (Index leaf = begin; leaf < end; ++leaf) {
      Box box;
      for (Index i = begin_of_leaf(leaf); i < begin_of_leaf(leaf + 1); ++i) {
        item_boxes_[item_at(i)] = boxes[item_at(items_[item_at(i)])];
        box.add(item_boxes_[item_at(i)]);
      }
      nodes_[item_at(inner + leaf)] = box;
    }
  });
  for (int level = levels_ - 1; level >= 0; --level) {
    const Index offset = (Index{1} << level) - 1;
    parallel_for(offset + 1, 4 * kLeafGrain, [&](Index begin, Index end) {
      for (Index k = offset + begin; k < offset + end; ++k) {
        nodes_[item_at(k)] = nodes_[item_at(2 * k + 1)];
        nodes_[item_at(k)].add(nodes_[item_at(2 * k + 2)]);
      }
    });
  }
}

void BoxTree::query(const Box& box, std::vector<Index>& found) const {
  if (items_.empty()) return;
  const std::size_t before = found.size();
  const Index inner = leaf_count() - 1;
  // A node less for each level that the path to the next one goes down, and its sibling.
  std::array<Index, 128> stack;
  std::size_t count = 0;
  stack[count++] = 0;
  while (count > 0) {
    const Index node = stack[--count];
    if (!nodes_[item_at(node)].overlaps(box)) continue;
    if (node < inner) {
      stack[count++] = 2 * node + 2;
      stack[count++] = 2 * node + 1;
      continue;
    }
    for (Index i = begin_of_leaf(node - inner); i < begin_of_leaf(node - inner + 1); ++i) {
      if (item_boxes_[item_at(i)].overlaps(box)) found.push_back(items_[item_at(i)]);
    }
  }
  std::sort(found.begin() + static_cast<std::ptrdiff_t>(before), found.end());
}

}  // namespace tetraction
