// The tree of boxes against a search through all of them.
#include "dynamics/contact/pairs/box_tree.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "tetraction/core/parallel.h"

namespace tetraction {
namespace {

std::vector<Box> random_boxes(std::mt19937& random, int count) {
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::vector<Box> boxes(static_cast<std::size_t>(count));
  for (Box& box : boxes) {
    const Vector3 a(uniform(random), uniform(random), uniform(random));
    box.add(a);
    box.add(a + 0.1 * Vector3(uniform(random), uniform(random), uniform(random)));
  }
  return boxes;
}

void expect_all_found(const BoxTree& tree, const std::vector<Box>& boxes, std::mt19937& random) {
  for (const Box& place : random_boxes(random, 200)) {
    std::vector<Index> expected;
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      if (boxes[i].overlaps(place)) expected.push_back(static_cast<Index>(i));
    }
    std::vector<Index> found;
    tree.query(place, found);
    ASSERT_EQ(found, expected);
  }
}

TEST(BoxTree, FindsAllItemsInAscendingOrder) {
  std::mt19937 random(21);
  for (const int count : {0, 1, 2, 3, 4, 5, 8, 9, 17, 63, 64, 65, 1000, 3001}) {
    const std::vector<Box> boxes = random_boxes(random, count);
    expect_all_found(BoxTree(boxes), boxes, random);
  }
}

TEST(BoxTree, EqualBoxesAndBoundsThatTouch) {
  Box box;
  box.add(Vector3::Zero());
  box.add(Vector3::Ones());
  const std::vector<Box> boxes(50, box);
  const BoxTree tree(boxes);
  Box place;
  place.add(Vector3::Ones());
  std::vector<Index> found;
  tree.query(place, found);
  EXPECT_EQ(found.size(), 50U);
  found.clear();
  place = Box();
  place.add(Vector3(1.0 + 1e-15, 1, 1));
  tree.query(place, found);
  EXPECT_TRUE(found.empty());
  tree.query(place.widened(1e-14), found);
  EXPECT_EQ(found.size(), 50U);
}

TEST(BoxTree, DoesNotDependOnThreads) {
  std::mt19937 random(22);
  const std::vector<Box> boxes = random_boxes(random, 20000);
  set_thread_count(1);
  const BoxTree one(boxes);
  set_thread_count(8);
  const BoxTree many(boxes);
  set_thread_count(0);
  EXPECT_EQ(one.bounds().lower, many.bounds().lower);
  expect_all_found(one, boxes, random);
  expect_all_found(many, boxes, random);
}

}  // namespace
}  // namespace tetraction
